// The baselines, written from the papers' equations and sharing no code with what they are compared
// with: Kurt, Szirmay-Kalos, Krivanek 2010, Eq. 10, 11, 14, isotropic,
//     g = F D / (4 c (iz oz)^alpha),   F = f0 + (1 - f0) (1 - c)^5,
//     D = exp(-tan^2_h / m^2) / (pi m^2 hz^4),   f = kd / pi + ks g.
// This file is compiled like the rest of the project, native_simd.cpp for the machine it is built
// on.
#include "bench/native.hpp"

#include "bench/native_simd.hpp"

#include <array>
#include <cmath>

namespace brdfit::bench {

namespace {

constexpr double pi = 3.14159265358979323846;
constexpr std::size_t channels = 3;

using Sums = std::array<double, kurt_sum_count>;
using Strengths = std::array<double, 2 * channels>; // kd, ks of each channel

struct KurtTheta {
    double f0, m, alpha;
};

struct Sample {
    Vector wi, wo;
    std::array<double, channels> y;
    double weight; // solid angle (mean 1) times iz^2
};

// What depends on the directions alone.
struct Geometry {
    double tan2;      // of the half vector's polar angle
    double log_scale; // -log(4 pi c hz^4)
    double log_iz_oz;
    double p5; // (1 - c)^5
    std::array<double, channels> y;
    double weight;
};

// g and its derivatives by f0, m, alpha.
struct Value {
    double g, by_f0, by_m, by_alpha;
};

struct Half {
    double z, c;
};

double dot(const Vector& a, const Vector& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

Half half_vector(const Sample& s) {
    const Vector sum{s.wi[0] + s.wo[0], s.wi[1] + s.wo[1], s.wi[2] + s.wo[2]};
    const double length = std::sqrt(dot(sum, sum));
    return {sum[2] / length, dot(s.wi, sum) / length};
}

template <bool with_gradient>
Value kurt(const Sample& s, const KurtTheta& theta) {
    const Half h = half_vector(s);
    const double hz2 = h.z * h.z;
    const double tan2 = (1 - hz2) / hz2;
    const double m2 = theta.m * theta.m;
    const double x = 1 - h.c;
    const double p5 = x * x * x * x * x;
    const double fresnel = theta.f0 + (1 - theta.f0) * p5;
    const double d = std::exp(-tan2 / m2) / (pi * m2 * hz2 * hz2);
    const double iz_oz = s.wi[2] * s.wo[2];
    const double shape = d / (4 * h.c * std::pow(iz_oz, theta.alpha));
    const double g = fresnel * shape;
    if constexpr (with_gradient)
        return {g, (1 - p5) * shape, g * (2 / theta.m) * (tan2 / m2 - 1), -g * std::log(iz_oz)};
    else
        return {g, 0, 0, 0};
}

template <bool with_gradient>
Value kurt(const Geometry& s, const KurtTheta& theta) {
    const double inverse = 1 / theta.m;
    const double t = s.tan2 * (inverse * inverse);
    const double shape =
        std::exp(s.log_scale - theta.alpha * s.log_iz_oz - t) * (inverse * inverse);
    const double g = (theta.f0 + (1 - theta.f0) * s.p5) * shape;
    if constexpr (with_gradient)
        return {g, (1 - s.p5) * shape, g * (2 * inverse) * (t - 1), -g * s.log_iz_oz};
    else
        return {g, 0, 0, 0};
}

// With b = {1/pi, g} and d the derivatives of g, the weighted sums, in the order of
// native_simd.hpp.
template <bool with_gradient, typename Data>
Sums sums_of(const std::vector<Data>& samples, const KurtTheta& theta) {
    Sums sums{};
    const double b = 1 / pi;
    for (const Data& s : samples) {
        const Value v = kurt<with_gradient>(s, theta);
        const double wb = s.weight * b, wg = s.weight * v.g;
        sums[0] += wb * b;
        sums[1] += wg * b;
        sums[2] += wg * v.g;
        for (std::size_t ch = 0; ch < channels; ++ch) {
            sums[3 + 2 * ch] += wb * s.y[ch];
            sums[4 + 2 * ch] += wg * s.y[ch];
            sums[9] += s.weight * s.y[ch] * s.y[ch];
        }
        if constexpr (with_gradient) {
            const double d[] = {v.by_f0, v.by_m, v.by_alpha};
            for (std::size_t e = 0; e < 3; ++e) {
                const double wd = s.weight * d[e];
                sums[10 + 5 * e] += wd * b;
                sums[11 + 5 * e] += wd * v.g;
                for (std::size_t ch = 0; ch < channels; ++ch)
                    sums[12 + 5 * e + ch] += wd * s.y[ch];
            }
        }
    }
    return sums;
}

// kd and ks >= 0 of each channel that minimise the error, from sums about `reference`.
Strengths solve(const Sums& s, const Strengths& reference) {
    Strengths best{};
    for (std::size_t ch = 0; ch < channels; ++ch) {
        const double kd0 = reference[2 * ch], ks0 = reference[2 * ch + 1];
        const double by = s[3 + 2 * ch] + s[0] * kd0 + s[1] * ks0;
        const double gy = s[4 + 2 * ch] + s[1] * kd0 + s[2] * ks0;
        const double determinant = s[0] * s[2] - s[1] * s[1];
        double kd = (by * s[2] - gy * s[1]) / determinant;
        double ks = (gy * s[0] - by * s[1]) / determinant;
        if (!(kd >= 0 && ks >= 0)) { // the optimum is where one of them is 0
            const double kd_alone = std::max(by / s[0], 0.0), ks_alone = std::max(gy / s[2], 0.0);
            const bool diffuse = kd_alone * by > ks_alone * gy;
            kd = diffuse ? kd_alone : 0;
            ks = diffuse ? 0 : ks_alone;
        }
        best[2 * ch] = kd;
        best[2 * ch + 1] = ks;
    }
    return best;
}

// Error at the solution, and its partial derivatives there (the envelope theorem).
Answer answer_of(const Sums& s, const Strengths& reference, bool gradient, std::size_t count) {
    const Strengths solution = solve(s, reference);
    Answer answer{s[9], {}};
    if (gradient)
        answer.gradient.assign(3, 0);
    for (std::size_t ch = 0; ch < channels; ++ch) {
        const double kd = solution[2 * ch] - reference[2 * ch];
        const double ks = solution[2 * ch + 1] - reference[2 * ch + 1];
        answer.error += kd * (kd * s[0] + 2 * ks * s[1] - 2 * s[3 + 2 * ch]) +
                        ks * (ks * s[2] - 2 * s[4 + 2 * ch]);
        for (std::size_t e = 0; e < answer.gradient.size(); ++e)
            answer.gradient[e] -= 2 * solution[2 * ch + 1] *
                                  (s[12 + 5 * e + ch] - kd * s[10 + 5 * e] - ks * s[11 + 5 * e]);
    }
    const double norm = static_cast<double>(count * channels);
    answer.error /= norm;
    for (double& derivative : answer.gradient)
        derivative /= norm;
    return answer;
}

std::vector<Sample> samples_with_directions(const Samples& samples) {
    std::vector<Sample> all;
    double weights = 0;
    for (std::size_t k = 0; k < samples.count(); ++k) {
        if (samples.valid[k] == 0)
            continue;
        const Vector wi = samples.directions->wi(k);
        all.push_back({wi,
                       samples.directions->wo(k),
                       {samples.channel(0)[k], samples.channel(1)[k], samples.channel(2)[k]},
                       samples.weights[k] * wi[2] * wi[2]});
        weights += samples.weights[k];
    }
    for (Sample& s : all)
        s.weight *= static_cast<double>(all.size()) / weights;
    return all;
}

std::vector<Geometry> samples_with_geometry(const std::vector<Sample>& samples) {
    std::vector<Geometry> all;
    all.reserve(samples.size());
    for (const Sample& s : samples) {
        const Half h = half_vector(s);
        const double hz2 = h.z * h.z;
        all.push_back({(1 - hz2) / hz2, -std::log(4 * pi * h.c * hz2 * hz2),
                       std::log(s.wi[2] * s.wo[2]), std::pow(1 - h.c, 5), s.y, s.weight});
    }
    return all;
}

// Whether the baselines are of this problem's model.
bool is_known(const Problem& problem, const Samples& samples) {
    const Structure structure = structure_of(parse_material(problem.material, "problem"));
    return structure.name() == "kurt" && structure.lobes.size() == 1 && structure.isotropic &&
           structure.diffuse->name == "lambert" && samples.channels.size() == channels;
}

KurtTheta theta_of(const Problem& problem) {
    return {problem.theta[0], problem.theta[1], problem.theta[2]};
}

// A row of the table; `evaluate` computes the answer.
template <typename Evaluate>
Result measured(const char* name, const Work& work, int threads, std::size_t count,
                std::size_t bytes, Evaluate evaluate) {
    Result result;
    result.device = name;
    result.work = work.name;
    result.model = "kurt";
    result.threads = threads;
    result.bytes_per_sample = static_cast<double>(bytes);
    const Timing timing = time_runs([&] { result.answer = evaluate(); });
    result.samples_per_second = static_cast<double>(count) / timing.median;
    result.spread = timing.spread;
    return result;
}

template <typename Data>
Result measured_scalar(const char* name, const Work& work, const std::vector<Data>& samples,
                       const KurtTheta& theta) {
    return measured(name, work, 1, samples.size(), sizeof(Data), [&] {
        const Sums sums =
            work.gradient ? sums_of<true>(samples, theta) : sums_of<false>(samples, theta);
        return answer_of(sums, {}, work.gradient, samples.size());
    });
}

#ifdef BRDFIT_SIMD_FLAGS
// Samples as planes, in the order of KurtPlanes.
std::vector<std::vector<float>> planes_of(const std::vector<Geometry>& samples) {
    std::vector<std::vector<float>> planes(5 + channels);
    for (const Geometry& s : samples) {
        const double row[] = {s.tan2, s.log_scale, s.log_iz_oz, s.p5,
                              s.y[0], s.y[1],      s.y[2],      s.weight};
        for (std::size_t p = 0; p < planes.size(); ++p)
            planes[p].push_back(static_cast<float>(row[p]));
    }
    return planes;
}

std::vector<Result> measured_simd(const std::vector<Geometry>& samples, const KurtTheta& theta) {
    const std::vector<std::vector<float>> data = planes_of(samples);
    const KurtPlanes planes{data[0].data(),
                            data[1].data(),
                            data[2].data(),
                            data[3].data(),
                            {data[4].data(), data[5].data(), data[6].data()},
                            data[7].data(),
                            samples.size()};
    // Float sums need a nearby solution to be taken about, as a fit's previous one is.
    const Strengths reference = solve(sums_of<false>(samples, theta), {});
    std::vector<int> threads = {1};
    if (simd_threads() > 1)
        threads.push_back(simd_threads());
    std::vector<Result> results;
    for (const int n : threads)
        for (const Work& work : works)
            results.push_back(measured(
                "native openmp simd", work, n, samples.size(), data.size() * sizeof(float), [&] {
                    Sums sums;
                    kurt_sums_simd(planes, theta.f0, theta.m, theta.alpha, reference.data(),
                                   work.gradient, n, sums.data());
                    return answer_of(sums, reference, work.gradient, samples.size());
                }));
    return results;
}
#endif

} // namespace

NativeBuild native_build() {
#ifdef BRDFIT_SIMD_FLAGS
    return {BRDFIT_COMPILER, BRDFIT_SCALAR_FLAGS, BRDFIT_SIMD_FLAGS};
#else
    return {BRDFIT_COMPILER, BRDFIT_SCALAR_FLAGS, nullptr};
#endif
}

std::vector<Result> measure_scalar(const Problem& problem, const Samples& samples) {
    if (!is_known(problem, samples))
        return {};
    const std::vector<Sample> with_directions = samples_with_directions(samples);
    const std::vector<Geometry> with_geometry = samples_with_geometry(with_directions);
    std::vector<Result> results;
    for (const Work& work : works)
        results.push_back(measured_scalar(baseline, work, with_directions, theta_of(problem)));
    for (const Work& work : works)
        results.push_back(measured_scalar("native scalar float64 precomputed", work, with_geometry,
                                          theta_of(problem)));
    return results;
}

std::vector<Result> measure_simd(const Problem& problem, const Samples& samples) {
#ifdef BRDFIT_SIMD_FLAGS
    if (is_known(problem, samples))
        return measured_simd(samples_with_geometry(samples_with_directions(samples)),
                             theta_of(problem));
#else
    static_cast<void>(problem);
    static_cast<void>(samples);
#endif
    return {};
}

} // namespace brdfit::bench
