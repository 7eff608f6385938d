#!/bin/sh
# sh tests/fuzz/run.sh [RUNS]: builds the fuzzers in build-fuzz/ and gives them RUNS inputs together
# (1,000,000), on all cores. Stops at the first finding and prints how to see it again. What they
# found worth keeping stays in build-fuzz/corpus/ for the next time.
set -eu

# one NAME RUNS: a fuzzer's share. Exit status 255 stops xargs.
if [ "${1-}" = one ]; then
    name=$2 runs=$3
    mkdir -p "corpus/$name" findings
    begin=$(date +%s)
    # A finding is also: over 2 GB, over 10 seconds an input, memory that is not freed.
    "tests/fuzz/fuzz_$name" "corpus/$name" "seeds/$name" -runs="$runs" -max_len=8192 -dict="seeds/$name.dict" \
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

runs=${1:-1000000}
case "$runs" in
'' | *[!0-9]*)
    sed -n '2,4s/^# //p' "$0" >&2
    exit 2
    ;;
esac
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

# Names and shares, of ten thousand inputs: fewer of those that take long.
xargs -n 2 -P "$(nproc)" sh -c 'exec sh "$0" one "$1" $(('"$runs"' * $2 / 10000 + 1))' "$script" <<END
merl 2 table_description 198 table_file 400 exr 400 distribution 400 material 600
measured 800 rgl 800 scattered 800 astm 800 zemax 800 fred 800 alta 800 cornell 800 npy 800 npz 800 directions 800
tabulated 600 table_spec 800 png 600 tuning 500 bench_record 500 plan 500 shard_log 500
END
