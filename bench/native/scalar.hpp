#pragma once

#include "bench/native/calls.hpp"
#include "fit/nonnegative.hpp"
#include "host/measured/samples.hpp"
#include "host/model/structure.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace brdfit::bench {

/// Name of the rows all others are compared with: one thread, float64, one sample at a time, half
/// vector and all else from the two directions, as programs without a device do it. The models are
/// the kernels' own text compiled as C++ (tests hold that against references of its own), with the
/// flags that everything has.
inline constexpr const char* baseline = "native scalar float64";
/// The same reading from memory what depends on directions alone.
inline constexpr const char* precomputed_baseline = "native scalar float64 precomputed";

/// One sample as a plain program keeps it.
struct ScalarSample {
    Vector wi, wo;
    std::array<double, 3> y;
    double weight; ///< solid angle (mean 1) times iz^2
};

/// What a plain program sums over samples, b = {diffuse, lobe}, d its derivatives:
/// W b_j b_k (k <= j) | for each channel W y b_j | W y^2 | for each d: W d b_j, W d y_ch |
/// W d_e d_f (f <= e).
using ScalarSums = std::vector<double>;
enum class Sums { Basis, Gradient, Normal };

/// One structure as plain functions.
struct ScalarModel {
    /// Null where there is none: structures whose models need more than directions and parameters.
    static const ScalarModel* find(const Structure& structure);

    int basis;    ///< diffuse and lobe
    bool coupled; ///< the diffuse shape has a derivative by f0, the last
    using SumsOf = ScalarSums (*)(const std::vector<ScalarSample>&, const double* theta,
                                  int parameters, Sums);
    SumsOf sums;
    /// A row a sample: `planes` that depend on the directions alone, the channels, the weight.
    using Prepare = std::vector<double> (*)(const std::vector<ScalarSample>&, std::size_t planes);
    Prepare prepare;
    using RowSums = ScalarSums (*)(const std::vector<double>& rows, std::size_t planes,
                                   const double* theta, int parameters, Sums);
    RowSums row_sums;
    /// f of the channels [sample][channel]; a: kd, ks of each channel.
    using Evaluate = void (*)(const std::vector<ScalarSample>&, const double* theta,
                              const double* a, double* f);
    Evaluate evaluate;
    /// Sobol samples 0 to n-1 for wo, theta in the anisotropic form: wi.z, density and f iz / pdf
    /// of each; for a lobe of strength 1 alone, or the diffuse shape where there is no lobe.
    using Draw = void (*)(std::size_t n, const Vector& wo, const std::uint32_t* scrambles,
                          const double* theta, const double* full_theta, double* out);
    Draw draw;
    /// Mean calls a sample: of prepare, and of the model's value and derivatives.
    struct Counts {
        Calls prepare, value;
    };
    using Count = Counts (*)(const std::vector<ScalarSample>&, const double* theta);
    Count count;
    using CountDraw = Calls (*)(std::size_t n, const Vector& wo, const std::uint32_t* scrambles,
                                const double* theta, const double* full_theta);
    CountDraw count_draw;
};

/// The best kd and ks >= 0 of each channel, from sums.
std::vector<SmallVector> coefficients(const ScalarModel& model, const ScalarSums& sums);
/// Error with the best kd and ks >= 0, then its derivatives, from sums.
std::vector<double> solved(const ScalarModel& model, const ScalarSums& sums, int parameters,
                           bool gradient, std::size_t count);

std::vector<ScalarSample> scalar_samples(const Samples& samples);

} // namespace brdfit::bench
