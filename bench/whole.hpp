#pragma once

#include "bench/work.hpp"
#include "host/device/device.hpp"
#include "host/measured/samples.hpp"

#include <vector>

namespace brdfit::bench {

inline constexpr const char* fit_work = "fit";
inline constexpr const char* run_work = "run";
inline constexpr const char* run_models = "kurt,ggx,cook-torrance,ward,lafortune";
inline constexpr const char *run_by_log = "run", *run_by_fit = "fit"; ///< "models" of its rows
inline constexpr double run_fits = 10; ///< of those models with one and with two lobes
inline constexpr double fitted_bins = 90 * 90 * 180; ///< of a MERL file

/// The whole `kurt` fit, by this program run again on a MERL file of `data` (see data_of), kernels
/// compiled before: rows in bins a second from process start to exit, on all threads and, where
/// they can be limited, on one. Throws InputError where the fit's error is not that of float64.
std::vector<Result> measure_fit(const Device& device, const Samples& data);

/// A run of ten fits to that file, and `fit` of the same: rows in fits a second from process start
/// to exit, kernels compiled before, on all threads. They differ by what the run's log costs.
std::vector<Result> measure_run(const Device& device, const Samples& data);

/// How long the kernels of a `kurt` fit take to build, in processes of their own with an empty and
/// then filled folders for our cache and the driver's.
CompileTime measure_compile(const Device& device);
/// The part of measure_compile in such a process: seconds from building to results of each kernel.
double build_and_run_kernels(const Device& device);

} // namespace brdfit::bench
