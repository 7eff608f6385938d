#!/bin/sh
# sh tests/fuzz/run.sh [RUNS [NAME...]]: builds the fuzzers in build-fuzz/ and gives each, or those
# named, RUNS inputs (40,000), on all cores. Stops at the first finding and prints how to see it
# again. What they found worth keeping stays in build-fuzz/corpus/ for the next time.
set -eu

# one NAME LIMIT: a fuzzer, in the folder that it was built in, up to a limit as libFuzzer has it.
# Exit status 255 stops xargs.
if [ "${1-}" = one ]; then
    name=$2 limit=$3
    mkdir -p "corpus/$name" findings
    begin=$(date +%s)
    # A finding is also: over 2 GB, over 10 seconds an input, memory that is not freed.
    "tests/fuzz/fuzz_$name" "corpus/$name" "seeds/$name" "$limit" -max_len=8192 -dict="seeds/$name.dict" \
        -rss_limit_mb=2048 -timeout=10 -artifact_prefix="findings/$name-" >"findings/$name.log" 2>&1 || {
        sed -n '/ERROR\|as it should be\|runtime error\|terminate called/,$p' "findings/$name.log" | head -n 40
        file=$(sed -n 's/.*Test unit written to //p' "findings/$name.log" | tail -n 1)
        echo "fuzz_$name: a finding; again: $PWD/tests/fuzz/fuzz_$name $PWD/$file"
        exit 255
    }
    done=$(sed -n 's/^Done \([0-9]*\) runs.*/\1/p' "findings/$name.log")
    echo "fuzz_$name: $done inputs in $(($(date +%s) - begin)) s, $(ls "corpus/$name" | wc -l) kept"
    exit 0
fi

runs=${1:-40000}
case "$runs" in
'' | *[!0-9]*)
    sed -n '2,4s/^# //p' "$0" >&2
    exit 2
    ;;
esac
[ $# -eq 0 ] || shift
cd "$(dirname "$0")/../.."
cmake -S . -B build-fuzz -G Ninja -DCMAKE_CXX_COMPILER=clang++ -DBRDFIT_FUZZ=ON -DBUILD_TESTING=OFF \
    -DBRDFIT_BENCH=OFF >/dev/null
cmake --build build-fuzz --target fuzzers -j "$(nproc)"
script=$PWD/tests/fuzz/run.sh
cd build-fuzz

# In memory where there is a file system for that: some inputs are files among others.
TMPDIR=$(mktemp -d -p "$([ -w /dev/shm ] && echo /dev/shm || echo "${TMPDIR:-/tmp}")" brdfit-fuzz-XXXXXX)
export TMPDIR
trap 'rm -rf "$TMPDIR"' EXIT
trap 'exit 130' INT TERM
tests/fuzz/fuzz_seeds seeds

for name; do
    [ -x "tests/fuzz/fuzz_$name" ] || {
        echo "run.sh: $name: no such fuzzer" >&2
        exit 2
    }
done
[ $# -gt 0 ] || set -- $(ls ../tests/fuzz/fuzz_*.cpp | sed 's/.*fuzz_\(.*\).cpp/\1/')
printf '%s\n' "$@" | xargs -I NAME -P "$(nproc)" sh "$script" one NAME "-runs=$runs"
