#include "fit/recover.hpp"

#include "fit/distribution_nodes.hpp"
#include "fit/minimise.hpp"
#include "fit/nonnegative.hpp"
#include "fit/samples.hpp"
#include "host/error.hpp"
#include "host/parallel.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

namespace brdfit {

namespace {

constexpr std::size_t most_samples = 50000; ///< that the descent looks at
/// Of the penalty: what a step of one in log p between neighbouring nodes costs, beside the
/// analytic distribution's, as a share of that distribution's squared error.
constexpr double smoothness = 3e-3;
/// Where p grows with theta_h though the analytic one does not, a step costs this much more.
constexpr double rising = 10;
/// Of the squared error beyond peak_theta, brought to the size of the whole.
constexpr double emphasis = 0.05;
/// Degrees about peak_theta in which that sets in: a step would leave a kink in the distribution.
constexpr double ramp = 10;
constexpr double infinity = std::numeric_limits<double>::infinity();

struct Sample {
    double weight; ///< w iz^2
    double p5;     ///< (1 - c)^5
    double beyond; ///< peak_theta: 0 to 1
    DistributionNodes::Place normal, wi, wo;
};

/// Half vectors (planes HX to HZ) of a sample.
Vector half(const Samples& samples, std::size_t k) {
    const Directions& d = *samples.directions;
    return {d.plane(Directions::HX)[k], d.plane(Directions::HY)[k], d.plane(Directions::HZ)[k]};
}

/// How far a half vector is beyond peak_theta: 0, 1 or between within the ramp.
double beyond_peak(double hz) {
    const double theta = std::acos(std::min(hz, 1.0)) / degree;
    const double x = std::clamp((theta - peak_theta + ramp) / (2 * ramp), 0.0, 1.0);
    return x * x * (3 - 2 * x);
}

/// The squared error of a distribution, kd, ks and f0 being solved for.
class Problem {
  public:
    Problem(const Samples& samples, const std::vector<std::uint32_t>& used)
        : nodes(samples.isotropic), source_(samples.source), channels_(samples.channels.size()) {
        const float* const iz = samples.directions->plane(Directions::WiZ);
        const float* const c = samples.directions->plane(Directions::C);
        double whole = 0;
        for (const std::uint32_t k : used) {
            Sample sample{};
            sample.weight =
                (samples.weights.empty() ? 1 : double{samples.weights[k]}) * iz[k] * iz[k];
            sample.p5 = std::pow(1 - c[k], 5);
            sample.beyond = beyond_peak(half(samples, k)[2]);
            sample.normal = nodes.place_of_normal(half(samples, k));
            const auto [wi, wo] = samples.directions->pair(k);
            sample.wi = nodes.place_of_area(wi);
            sample.wo = nodes.place_of_area(wo);
            samples_.push_back(sample);
            for (std::size_t ch = 0; ch < channels_; ++ch) {
                values_.push_back(samples.channel(ch)[k]);
                whole += sample.weight * std::pow(values_.back(), 2);
            }
        }
        if (!(whole > 0))
            throw InputError(
                fmt::format("{}: nothing is reflected; no distribution follows", source_));
    }

    const DistributionNodes nodes;
    double f0 = 0;
    std::vector<double> kd, ks;

    /// The squared error of log p = x, samples beyond the peak counting 1 + `outside` times, and
    /// its gradient by x, unless null.
    double error(const std::vector<double>& x, double outside, std::vector<double>* gradient) {
        std::vector<double> p(x.size());
        std::transform(x.begin(), x.end(), p.begin(), [](double v) { return std::exp(v); });
        see(p);
        const double error = solve_strengths(outside);
        if (gradient != nullptr)
            differentiate(p, outside, *gradient);
        return error;
    }

    /// Of that, with the strengths found last: all of it, and what is beyond the peak.
    struct Parts {
        double whole = 0, outside = 0;
    };
    Parts parts() const {
        Parts parts;
        for (std::size_t i = 0; i < samples_.size(); ++i) {
            const Sample& s = samples_[i];
            const double lobe = lobe_[i] * (f0 + (1 - f0) * s.p5);
            for (std::size_t ch = 0; ch < channels_; ++ch) {
                const double e = kd[ch] / pi + ks[ch] * lobe - values_[i * channels_ + ch];
                parts.whole += s.weight * e * e;
                parts.outside += s.beyond * s.weight * e * e;
            }
        }
        return parts;
    }

    /// Throws where the strengths found last leave the distribution no part in the reflectance.
    void check_reflects() const {
        if (!std::any_of(ks.begin(), ks.end(), [](double k) { return k > 0; }))
            throw InputError(
                fmt::format("{}: is diffuse; no distribution of normals follows", source_));
    }

  private:
    static double at(const DistributionNodes::Place& place, const double* values) {
        double sum = 0;
        for (std::size_t b = 0; b < 4; ++b)
            sum += place.share[b] * values[place.at[b]];
        return sum;
    }

    // g of p, and at the samples p <h.n> / (4 g(wi) g(wo)): this does not change with p's scale.
    void see(const std::vector<double>& p) {
        g_ = nodes.areas() *
             Eigen::Map<const Eigen::VectorXd>(p.data(), static_cast<Eigen::Index>(p.size()));
        const double height = g_(g_.size() - 1);
        // g(k) >= (k.n) <h.n>, more than 0 but where numbers underflow.
        g_ = g_.cwiseMax(std::max(1e-9 * height, std::numeric_limits<double>::min()));
        visibility_.resize(samples_.size());
        lobe_.resize(samples_.size());
        parallel_pieces(samples_.size(), 8192, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const Sample& s = samples_[i];
                visibility_[i] = height / (4 * at(s.wi, g_.data()) * at(s.wo, g_.data()));
                lobe_[i] = visibility_[i] * at(s.normal, p.data());
            }
        });
    }

    void differentiate(const std::vector<double>& p, double outside,
                       std::vector<double>& gradient) const {
        const auto count = static_cast<Eigen::Index>(p.size());
        Eigen::VectorXd by_p = Eigen::VectorXd::Zero(count);
        Eigen::VectorXd by_g = Eigen::VectorXd::Zero(g_.size());
        for (std::size_t i = 0; i < samples_.size(); ++i) {
            const Sample& s = samples_[i];
            const double fresnel = f0 + (1 - f0) * s.p5, lobe = lobe_[i] * fresnel;
            double pull = 0;
            for (std::size_t ch = 0; ch < channels_; ++ch)
                pull += ks[ch] * (kd[ch] / pi + ks[ch] * lobe - values_[i * channels_ + ch]);
            pull *= 2 * s.weight * (1 + outside * s.beyond);
            for (std::size_t b = 0; b < 4; ++b)
                by_p(s.normal.at[b]) += pull * visibility_[i] * fresnel * s.normal.share[b];
            by_g(g_.size() - 1) += pull * lobe / g_(g_.size() - 1);
            for (const DistributionNodes::Place* k : {&s.wi, &s.wo}) {
                const double slope = -pull * lobe / at(*k, g_.data());
                for (std::size_t b = 0; b < 4; ++b)
                    by_g(k->at[b]) += slope * k->share[b];
            }
        }
        by_p += nodes.areas().transpose() * by_g;
        gradient.resize(p.size());
        for (std::size_t n = 0; n < p.size(); ++n)
            gradient[n] = by_p(static_cast<Eigen::Index>(n)) * p[n];
    }

    // kd and ks of each channel for the best f0; returns the squared error.
    double solve_strengths(double outside) {
        // Sums over {1 / pi, A, B}: the lobe is A + f0 B.
        Eigen::Matrix3d gram = Eigen::Matrix3d::Zero();
        Eigen::Matrix3Xd projected =
            Eigen::Matrix3Xd::Zero(3, static_cast<Eigen::Index>(channels_));
        std::vector<double> squared(channels_);
        for (std::size_t i = 0; i < samples_.size(); ++i) {
            const Sample& s = samples_[i];
            const double w = s.weight * (1 + outside * s.beyond);
            const Eigen::Vector3d b(1 / pi, s.p5 * lobe_[i], (1 - s.p5) * lobe_[i]);
            gram += w * b * b.transpose();
            for (std::size_t ch = 0; ch < channels_; ++ch) {
                const double y = values_[i * channels_ + ch];
                projected.col(static_cast<Eigen::Index>(ch)) += w * y * b;
                squared[ch] += w * y * y;
            }
        }
        double best = infinity;
        const auto tried = [&](double f) {
            SmallMatrix small(2, 2);
            small << gram(0, 0), gram(0, 1) + f * gram(0, 2), gram(0, 1) + f * gram(0, 2),
                gram(1, 1) + 2 * f * gram(1, 2) + f * f * gram(2, 2);
            double error = 0;
            std::vector<double> diffuse, specular;
            for (std::size_t ch = 0; ch < channels_; ++ch) {
                const auto column = projected.col(static_cast<Eigen::Index>(ch));
                SmallVector pull(2), zero = SmallVector::Zero(2);
                pull << column(0), column(1) + f * column(2);
                const NonNegativeSolution solution =
                    solve_nonnegative(small, pull, squared[ch], zero);
                error += solution.squared_error;
                diffuse.push_back(solution.a(0));
                specular.push_back(solution.a(1));
            }
            if (error < best) {
                best = error;
                f0 = f;
                kd = diffuse;
                ks = specular;
            }
        };
        for (int i = 0; i <= 50; ++i)
            tried(i / 50.0);
        for (double step = 0.01; step > 1e-6; step *= 0.5)
            for (const double sign : {-1.0, 1.0})
                tried(std::clamp(f0 + sign * step, 0.0, 1.0));
        return best;
    }

    std::string source_;
    std::size_t channels_;
    std::vector<Sample> samples_;
    std::vector<double> values_; ///< [sample][channel]
    Eigen::VectorXd g_;
    std::vector<double> visibility_, lobe_; ///< [sample]
};

// Analytic distributions, log p at a normal: hz^-cosines (1 + t / b)^-b, with
// t = (x^2 / ax^2 + y^2 / ay^2) / hz^2 in axes turned about n. b = 2 is GGX, large b Beckmann;
// without the cosines, Gaussians as of Eq. 34.
struct Family {
    double cosines;

    // theta: log of the mean width, log b, then where anisotropic log(ax / ay) / 2 and the turn.
    std::vector<double> log_p(const DistributionNodes& nodes,
                              const std::vector<double>& theta) const {
        const double a = std::exp(theta[0]), b = std::exp(theta[1]);
        const double stretch = theta.size() > 2 ? std::exp(theta[2]) : 1;
        const double turn = theta.size() > 2 ? theta[3] : 0;
        std::vector<double> x(nodes.count());
        for (std::size_t n = 0; n < x.size(); ++n) {
            const double hz = std::cos(std::min(nodes.theta(n), pi / 2 - 1e-3));
            const double tan2 = 1 / (hz * hz) - 1, phi = nodes.phi(n) - turn;
            const double t =
                tan2 / (a * a) *
                (std::pow(std::cos(phi) / stretch, 2) + std::pow(std::sin(phi) * stretch, 2));
            x[n] = -std::min(cosines, 2 * b) * std::log(hz) - b * std::log1p(t / b);
            x[n] = std::max(x[n], least_log);
        }
        return x;
    }

    static constexpr double least_log = -30; ///< below, p is 0 to all purposes
};

struct Start {
    double error;
    Family family;
    std::vector<double> theta;
};

// The best few of the analytic distributions, each the optimum nearest to it.
std::vector<Start> analytic_starts(Problem& problem, int& evaluations,
                                   const std::function<void(double)>& progress) {
    const double least = std::log(1e-3), most = std::log(5.0);
    const bool isotropic = problem.nodes.isotropic();
    std::vector<Start> coarse;
    for (const double cosines : {0.0, 4.0})
        for (const double b : {1.1, 2.0, 4.0, 100.0})
            for (int i = 0; i <= 14; ++i) {
                const double width = std::log(0.003) + i * 0.4;
                std::vector<std::vector<double>> thetas;
                if (isotropic)
                    thetas = {{width, std::log(b)}};
                else
                    for (const auto& [stretch, turn] : {std::pair{0.0, 0.0},
                                                        {0.5, 0.0},
                                                        {0.5, pi / 4},
                                                        {0.5, pi / 2},
                                                        {0.5, 3 * pi / 4}})
                        thetas.push_back({width, std::log(b), stretch, turn});
                for (const auto& theta : thetas) {
                    const Family family{cosines};
                    coarse.push_back({problem.error(family.log_p(problem.nodes, theta), 0, nullptr),
                                      family, theta});
                    ++evaluations;
                }
            }
    progress(0.1);
    const auto better = [](const Start& a, const Start& b) { return a.error < b.error; };
    std::stable_sort(coarse.begin(), coarse.end(), better);
    // Of each shape (cosines, b) the best width alone.
    std::vector<Start> starts;
    for (const Start& start : coarse)
        if (starts.size() < 4 && std::none_of(starts.begin(), starts.end(), [&](const Start& s) {
                return s.family.cosines == start.family.cosines && s.theta[1] == start.theta[1];
            }))
            starts.push_back(start);
    MinimiseOptions options;
    options.algorithm = "LN_SBPLX";
    options.max_evaluations = isotropic ? 120 : 200;
    options.relative_tolerance = 1e-5;
    std::vector<double> lower{least, std::log(1.02)}, upper{most, std::log(1000.0)};
    if (!isotropic) {
        lower.insert(lower.end(), {-3, -pi});
        upper.insert(upper.end(), {3, 2 * pi});
    }
    for (Start& start : starts) {
        const Minimum found = minimise(
            [&](const std::vector<double>& theta, std::vector<double>*) {
                return problem.error(start.family.log_p(problem.nodes, theta), 0, nullptr);
            },
            start.theta, lower, upper, options);
        evaluations += found.evaluations;
        if (found.value < start.error) {
            start.error = found.value;
            start.theta = found.x;
        }
    }
    std::stable_sort(starts.begin(), starts.end(), better);
    return starts;
}

// The penalty on log p = x beside the analytic `from`, of strength 1; adds its gradient times w.
double roughness(const DistributionNodes& nodes, const std::vector<double>& x,
                 const std::vector<double>& from, double w, std::vector<double>* gradient) {
    const std::size_t width = nodes.azimuths();
    double sum = 0;
    const auto add = [&](std::size_t a, std::size_t b, bool outwards) {
        const double step = (x[b] - from[b]) - (x[a] - from[a]);
        const double rise =
            outwards ? std::max(0.0, x[b] - x[a] - std::max(0.0, from[b] - from[a])) : 0;
        sum += step * step + rising * rise * rise;
        if (gradient != nullptr) {
            (*gradient)[a] -= 2 * w * (step + rising * rise);
            (*gradient)[b] += 2 * w * (step + rising * rise);
        }
    };
    for (std::size_t n = 0; n < x.size(); ++n) {
        if (n + width < x.size())
            add(n, n + width, true);
        if (width > 1)
            add(n, n / width * width + (n + 1) % width, false);
    }
    return w * sum;
}

// Descends from an analytic distribution, beside which it stays smooth (strength `w`). The problem
// is left at what was found.
Minimum descend(Problem& problem, const std::vector<double>& from, double outside, double w,
                int evaluations, const std::function<void(double)>& progress) {
    std::vector<double> lower(from), upper(from);
    for (std::size_t n = 0; n < from.size(); ++n) {
        lower[n] -= 12;
        upper[n] += 12;
    }
    int done = 0;
    const auto error = [&](const std::vector<double>& x, std::vector<double>* gradient) {
        progress(std::min(1.0, static_cast<double>(done++) / evaluations));
        const double value = problem.error(x, outside, gradient);
        return value + roughness(problem.nodes, x, from, w, gradient);
    };
    MinimiseOptions options;
    options.algorithm = "LD_LBFGS";
    options.max_evaluations = evaluations;
    options.relative_tolerance = 1e-6;
    const Minimum found = minimise(error, from, lower, upper, options);
    problem.error(found.x, outside, nullptr);
    return found;
}

} // namespace

Recovered recover(const Device& device, const Generator& generator, const Samples& samples,
                  const RecoverOptions& options) {
    const DeviceSamples packed = pack_samples(device, samples, options.max_theta, Metric::Ngan);
    const DeviceSamples thin = thin_samples(device, samples, packed, Metric::Ngan, most_samples);
    Problem problem(samples, thin.used);
    double told = 0;
    const auto progress = [&](double share) { // a descent may be done twice
        told = std::clamp(share, told, 1.0);
        if (options.progress)
            options.progress(told);
    };
    Recovered result;
    const std::vector<Start> starts = analytic_starts(problem, result.evaluations, progress);
    const std::vector<double> best_analytic =
        starts.front().family.log_p(problem.nodes, starts.front().theta);
    const double analytic = problem.error(best_analytic, 0, nullptr);
    problem.check_reflects();
    const Problem::Parts parts = problem.parts();
    const double outside = parts.outside > 0 ? emphasis * parts.whole / parts.outside : 0;

    std::vector<double> best_x = best_analytic;
    double best = infinity, best_outside = 0;
    const double first = 0.2, last = 0.95; // of the progress
    for (std::size_t s = 0; s < starts.size(); ++s) {
        const std::vector<double> from = starts[s].family.log_p(problem.nodes, starts[s].theta);
        // With the emphasis, and without it where that has cost what must not be exceeded.
        for (const double more : {outside, 0.0}) {
            const double width = (last - first) / static_cast<double>(starts.size());
            const double begin = first + width * static_cast<double>(s);
            const Minimum found =
                descend(problem, from, more, smoothness * analytic, options.evaluations,
                        [&](double share) { progress(begin + width * share); });
            result.evaluations += found.evaluations;
            const double plain = problem.parts().whole;
            const bool allowed = plain <= analytic * (1 + 1e-9);
            if (!allowed && more > 0)
                continue;
            // Compared with the emphasis, whatever was minimised.
            const double value = plain + outside * problem.parts().outside;
            if (allowed && value < best) {
                best = value;
                best_x = found.x;
                best_outside = more;
            }
            break;
        }
    }
    problem.error(best_x, best_outside, nullptr);
    std::vector<double> p;
    const double most = *std::max_element(best_x.begin(), best_x.end());
    for (const double x : best_x)
        p.push_back(std::exp(x - most));
    result.table = generator.generate(problem.nodes.distribution(p), options.generator,
                                      samples.source, part_of(progress, last, 1));
    result.f0 = problem.f0;
    result.kd = problem.kd;
    result.ks = problem.ks;
    result.samples = packed.count;
    progress(1);
    return result;
}

} // namespace brdfit
