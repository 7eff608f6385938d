#!/bin/sh
# Installs the packages brdfit needs (Debian 12, as root or with sudo), builds it in build/, and
#   sh setup.sh demo   synthesises three measured materials and fits all models to them, in demo/
#   sh setup.sh test   builds and runs the tests
#   sh setup.sh check  whether the code is formatted and clang takes it too
#   sh setup.sh drivers  installs two more OpenCL drivers for CPUs, which tests then run on too
#   sh setup.sh package  makes a Debian package, in build-package/
set -eu
cd "$(dirname "$0")"

needed="cmake ninja-build g++ pkg-config
pocl-opencl-icd ocl-icd-opencl-dev opencl-headers opencl-clhpp-headers
libnlopt-dev libeigen3-dev libcli11-dev libspdlog-dev libfmt-dev nlohmann-json3-dev libssl-dev
libopenexr-dev libpng-dev zlib1g-dev libnanoflann-dev libsqlite3-dev"
needed_by_tests="libgtest-dev libbenchmark-dev oclgrind"
needed_by_python="python3-venv python3-dev"
needed_by_checks="clang clang-format"
needed_by_package="dpkg-dev file"

usage() {
    sed -n '2,7s/^# \{0,1\}//p' "$0" >&2
    exit 2
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
    as_root=""
    [ "$(id -u)" -eq 0 ] || as_root="sudo"
    $as_root apt-get update -q
    DEBIAN_FRONTEND=noninteractive $as_root apt-get install -q -y --no-install-recommends $missing
}

# configure FOLDER OPTION...: Ninja where the folder is new.
configure() {
    folder=$1
    shift
    generator="-G Ninja"
    [ ! -e "$folder/CMakeCache.txt" ] || generator=""
    cmake -S . -B "$folder" $generator "$@"
}

# Two more OpenCL drivers for CPUs, for the tests that tests/driver.sh chooses: Mesa's rusticl, which stays off
# where RUSTICL_ENABLE does not name it, and Intel's in build/intel-opencl, which only that script looks for.
install_drivers() {
    (install_packages mesa-opencl-icd) || echo "Mesa's rusticl cannot be installed: no tests on it"
    [ -z "$(find build/intel-opencl -name libintelocl.so 2>/dev/null)" ] || return 0
    (install_packages python3-venv) && python3 -m venv build/intel-opencl &&
        build/intel-opencl/bin/pip install -q --retries 1 --timeout 20 intel-opencl-rt intel-cmplr-lib-rt ||
        echo "Intel's CPU runtime cannot be installed: no tests on it"
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
}

build() {
    configure build "$@"
    cmake --build build -j "$(nproc)"
    build/brdfit devices # fails where there is no OpenCL device
}

# Every source of host and fit through clang, which does not make code of it.
clang_takes_it() {
    configure build-check -DBUILD_TESTING=OFF -DBRDFIT_BENCH=OFF >/dev/null
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
    prepare_python
    build -DBUILD_TESTING=ON -DBRDFIT_BENCH=ON $python_options
    ctest --test-dir build --output-on-failure --no-tests=error -j "$(nproc)"
    ;;
drivers)
    install_drivers
    ;;
check)
    install_packages $needed $needed_by_checks
    find kernels host fit bench tests \( -name '*.[ch]pp' -o -name '*.h' \) -print0 | xargs -0 clang-format --dry-run -Werror
    clang_takes_it
    echo "formatted, and clang takes it"
    ;;
package)
    install_packages $needed $needed_by_package
    # Nothing in it is for this machine's processor alone.
    configure build-package -DBUILD_TESTING=OFF -DBRDFIT_SIMD_BASELINE=OFF
    cmake --build build-package -j "$(nproc)"
    (cd build-package && cpack)
    ;;
*)
    usage
    ;;
esac
