#include "fit/runs/slurm.hpp"

#include "host/files/file.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>

namespace brdfit {

namespace {

constexpr double seconds_a_cost = 0.15; // a fit of one lobe to a full MERL file, on two cores
constexpr double element_seconds = 600;

// A word of the shell, whatever is in it.
std::string quoted(const std::string& text) {
    std::string word = "'";
    for (const char c : text)
        word += c == '\'' ? std::string(R"('\'')") : std::string(1, c);
    return word + "'";
}

// {0}: the folder as a word; {1}: shards; {2}: the last of them.
constexpr const char* array_script = R"(#!/bin/sh
# The shards of a run of brdfit as an array of jobs. submit.sh beside it submits this; options of sbatch
# given to that come first: --partition=..., --gres=gpu:1, --time=...
#SBATCH --job-name=brdfit
#SBATCH --array=0-{2}
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=2
#SBATCH --time=01:00:00
#SBATCH --requeue
#SBATCH --open-mode=append
# Before the limit, so that the task at work can finish.
#SBATCH --signal=B:TERM@120
run={0}
shard=${{SLURM_ARRAY_TASK_ID:?is for sbatch, see submit.sh beside it}}
"${{BRDFIT:-brdfit}}" run "$run" --shard "$shard/{1}" &
child=$!
trap 'kill -TERM "$child"' TERM
wait "$child"
status=$?
trap '' TERM
# Of an interrupted wait it is not the child's yet.
if kill -0 "$child" 2>/dev/null; then
    wait "$child"
    status=$?
fi
# Stopped before its end: the element goes on where it is.
if [ "$status" -eq 0 ] && [ ! -e "$run/shards/$shard-of-{1}.done" ]; then
    scontrol requeue "${{SLURM_ARRAY_JOB_ID}}_$shard"
fi
exit "$status"
)";

constexpr const char* submit_script = R"(#!/bin/sh
# Submits the shards of a run, and a job that collects the results once all have ended:
#   sh submit.sh [OPTION OF SBATCH...]
# Options go to both: --partition=..., --account=... What only the shards need (--gres=gpu:1) stands better in
# shards.sbatch. BRDFIT: the program, where it is not in PATH.
set -eu
run={0}
shards=$(sbatch --parsable --output="$run/slurm-%A_%a.out" "$@" "$run/shards.sbatch")
shards=${{shards%%;*}}
sbatch --job-name=brdfit-merge --output="$run/slurm-%j.out" --dependency=afterany:"$shards" "$@" <<'SCRIPT'
#!/bin/sh
run={0}
"${{BRDFIT:-brdfit}}" status "$run"
exec "${{BRDFIT:-brdfit}}" merge "$run" -o "$run/results.sqlite" --csv "$run/results.csv"
SCRIPT
)";

void write_script(const std::string& path, const std::string& text) {
    OutputFile file(path);
    file.write(text);
    file.commit(true);
}

} // namespace

std::size_t slurm_shards(const Plan& plan) {
    double cost = 0;
    for (const Task& task : plan.tasks)
        cost += task.cost();
    const double shards = std::ceil(cost * seconds_a_cost / element_seconds);
    return static_cast<std::size_t>(std::clamp(shards, 1.0, static_cast<double>(most_shards)));
}

std::string write_slurm(const std::string& folder, std::size_t shards) {
    const std::filesystem::path path = std::filesystem::absolute(folder).lexically_normal();
    const std::string word = quoted(path.string());
    write_script((path / "shards.sbatch").string(),
                 fmt::format(fmt::runtime(array_script), word, shards, shards - 1));
    const std::string submit = (path / "submit.sh").string();
    write_script(submit, fmt::format(fmt::runtime(submit_script), word));
    return submit;
}

} // namespace brdfit
