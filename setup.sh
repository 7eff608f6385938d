#!/bin/sh
# Installs the packages brdfit needs (Debian 12, as root or with sudo), builds it in build/, and
#   sh setup.sh demo   synthesises three measured materials and fits all models to them, in demo/
#   sh setup.sh test   builds and runs the tests
set -eu
cd "$(dirname "$0")"

needed="cmake make g++ pkg-config
pocl-opencl-icd ocl-icd-opencl-dev opencl-headers opencl-clhpp-headers
libnlopt-dev libeigen3-dev libcli11-dev libspdlog-dev libfmt-dev nlohmann-json3-dev libssl-dev
libopenexr-dev libpng-dev"
needed_by_tests="libgtest-dev libbenchmark-dev oclgrind"

usage() {
    sed -n '2,4s/^# \{0,1\}//p' "$0" >&2
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

build() {
    cmake -S . -B build "$1"
    shift
    cmake --build build -j "$(nproc)" "$@"
    build/brdfit devices # fails where there is no OpenCL device
}

[ $# -eq 1 ] || usage
case "$1" in
demo)
    install_packages $needed
    build -DBUILD_TESTING=OFF
    build/brdfit demo -o demo
    ;;
test)
    install_packages $needed $needed_by_tests
    build -DBUILD_TESTING=ON
    ctest --test-dir build --output-on-failure --no-tests=error -j "$(nproc)"
    ;;
*)
    usage
    ;;
esac
