#pragma once

#include "fit/runs/plan.hpp"

#include <string>

// Slurm runs the shards of a plan as an array of jobs.

namespace brdfit {

/// How many shards make elements of about ten minutes, by what fits of full MERL files take on two
/// cores.
std::size_t slurm_shards(const Plan& plan);

/// Writes FOLDER/shards.sbatch, the array script, and FOLDER/submit.sh, which gives it to sbatch
/// and then, depending on it, a job for status and merge. Returns the path of the latter.
std::string write_slurm(const std::string& folder, std::size_t shards);

} // namespace brdfit
