// The OpenMP baseline's data and answers; its loop is in native_simd.cpp, which is compiled for the
// machine it is built on.
#include "bench/native_tasks.hpp"

#include "bench/native/native_simd.hpp"

#include <array>
#include <memory>

namespace brdfit::bench {

#ifdef BRDFIT_SIMD_FLAGS
namespace {

constexpr std::size_t channels = 3, planes = 4;

// kurt_sums_simd's sums, taken about `reference`, as ScalarSums.
ScalarSums about_zero(const std::array<double, kurt_sum_count>& s,
                      const std::array<double, 2 * channels>& reference) {
    ScalarSums sums(s.begin(), s.end());
    double error = s[9];
    for (std::size_t ch = 0; ch < channels; ++ch) {
        const double kd = reference[2 * ch], ks = reference[2 * ch + 1];
        sums[3 + 2 * ch] += s[0] * kd + s[1] * ks;
        sums[4 + 2 * ch] += s[1] * kd + s[2] * ks;
        error += kd * (2 * s[3 + 2 * ch] + kd * s[0] + 2 * ks * s[1]) +
                 ks * (2 * s[4 + 2 * ch] + ks * s[2]);
        for (std::size_t e = 0; e < 3; ++e)
            sums[12 + 5 * e + ch] += kd * s[10 + 5 * e] + ks * s[11 + 5 * e];
    }
    sums[9] = error;
    return sums;
}

// Samples as planes, in the order of KurtPlanes.
struct Planes {
    std::vector<std::vector<float>> data;
    std::array<double, 2 * channels>
        reference; // kd, ks near the solution, as a fit's last ones are
    KurtPlanes view;
};

std::shared_ptr<const Planes> planes_of(const ScalarModel& model, const Problem& problem,
                                        const std::vector<ScalarSample>& samples) {
    const std::vector<double> rows = model.prepare(samples, planes);
    const std::size_t width = planes + channels + 1;
    auto result = std::make_shared<Planes>();
    result->data.assign(width, std::vector<float>(samples.size()));
    for (std::size_t k = 0; k < samples.size(); ++k)
        for (std::size_t p = 0; p < width; ++p)
            result->data[p][k] = static_cast<float>(rows[k * width + p]);
    for (float& x : result->data[2]) // -log(iz oz)
        x = -x;
    const auto& d = result->data;
    result->view = {d[0].data(),
                    d[1].data(),
                    d[2].data(),
                    d[3].data(),
                    {d[4].data(), d[5].data(), d[6].data()},
                    d[7].data(),
                    samples.size()};
    const std::vector<SmallVector> a =
        coefficients(model, model.sums(samples, problem.theta.data(), 3, Sums::Basis));
    for (std::size_t ch = 0; ch < channels; ++ch)
        for (int j = 0; j < 2; ++j)
            result->reference[2 * ch + static_cast<std::size_t>(j)] = a[ch][j];
    return result;
}

} // namespace
#endif

NativeBuild native_build() {
#ifdef BRDFIT_SIMD_FLAGS
    return {BRDFIT_COMPILER, BRDFIT_SCALAR_FLAGS, BRDFIT_SIMD_FLAGS};
#else
    return {BRDFIT_COMPILER, BRDFIT_SCALAR_FLAGS, nullptr};
#endif
}

std::vector<std::pair<Task, int>> simd_tasks(const Problem& problem,
                                             const std::vector<ScalarSample>& samples) {
    std::vector<std::pair<Task, int>> tasks;
#ifdef BRDFIT_SIMD_FLAGS
    if (problem.name() != "kurt")
        return tasks;
    const ScalarModel* const model = ScalarModel::find(problem.structure);
    const std::shared_ptr<const Planes> data = planes_of(*model, problem, samples);
    const std::size_t count = samples.size();
    std::vector<int> threads = {1};
    if (simd_threads() > 1)
        threads.push_back(simd_threads());
    for (const int n : threads)
        for (const bool gradient : {false, true}) {
            auto answer = std::make_shared<Answer>();
            Task task{
                gradient ? "error-gradient" : "error",
                problem.name(),
                [=] {
                    std::array<double, kurt_sum_count> sums;
                    kurt_sums_simd(data->view, problem.theta[0], problem.theta[1], problem.theta[2],
                                   data->reference.data(), gradient, n, sums.data());
                    *answer = solved(*model, about_zero(sums, data->reference), 3, gradient, count);
                },
                [answer] { return *answer; },
                static_cast<double>(count),
                static_cast<double>((planes + channels + 1) * sizeof(float))};
            tasks.emplace_back(std::move(task), n);
        }
#else
    static_cast<void>(problem);
    static_cast<void>(samples);
#endif
    return tasks;
}

} // namespace brdfit::bench
