#include "fit/recover.hpp"

#include "fit/minimise.hpp"
#include "fit/nonnegative.hpp"
#include "fit/samples.hpp"
#include "host/error.hpp"
#include "host/microfacet/nodes.hpp"
#include "host/parallel.hpp"
#include "host/quadrature.hpp"

#include <Eigen/Sparse>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

namespace brdfit {

namespace {

constexpr std::size_t most_samples = 50000; ///< that the alternation looks at
constexpr std::size_t few_samples = 10000;  ///< up to here every start is followed
constexpr std::size_t most_thetas = 91, azimuths = 36;
constexpr double samples_a_node = 2;
constexpr double smoothness = 1e-6; ///< of neighbouring nodes, relative to the data

/// A sample as the alternation needs it.
struct Sample {
    double weight;               ///< w iz^2
    double p5;                   ///< (1 - c)^5
    std::array<int, 4> node;     ///< of p, with
    std::array<double, 4> share; ///< their shares
    Vector wi, wo;
};

/// The alternation's state and steps.
class Alternation {
  public:
    Alternation(const Device& device, const Generator& generator, const Samples& samples,
                const RecoverOptions& options)
        : generator_(generator), source_(samples.source), channels_(samples.channels.size()) {
        const DeviceSamples packed = pack_samples(device, samples, options.max_theta, Metric::Ngan);
        const DeviceSamples thin =
            thin_samples(device, samples, packed, Metric::Ngan, most_samples);
        count = packed.count;
        choose_nodes(samples, thin.used);
        gather(samples, thin.used);
        grid_.sector = table_.width == 1 ? Sector::Isotropic : Sector::All;
        grid_.rows = table_.width == 1 ? 256 : 40;
        grid_.columns = table_.width == 1 ? 1 : 80;
        grid_.scale = 0.1;
        for (std::size_t r = 0; r < grid_.rows; ++r)
            for (std::size_t k = 0; k < grid_.columns; ++k)
                directions_.push_back(
                    grid_.direction(static_cast<double>(r), static_cast<double>(k)));
        place();
        if (table_.width == 1)
            map_areas();
    }

    /// Whether descend() is possible.
    bool isotropic() const { return table_.width == 1; }

    /// Minimises the squared error over log p itself, g's dependence on p included, from where the
    /// alternation ended: its fixed point is near the optimum, not at it. Returns how often the
    /// error was evaluated.
    int descend() {
        const double most = *std::max_element(p_.begin(), p_.end());
        std::vector<double> start, lower, upper;
        for (const double p : p_) {
            start.push_back(std::log(std::max(p / most, 1e-8)));
            lower.push_back(start.back() - 8);
            upper.push_back(start.back() + 8);
        }
        MinimiseOptions options;
        options.algorithm = "LD_LBFGS";
        options.max_evaluations = 2000;
        options.relative_tolerance = 1e-7;
        const auto error = [&](const std::vector<double>& x, std::vector<double>* gradient) {
            for (std::size_t i = 0; i < p_.size(); ++i)
                p_[i] = std::exp(x[i]);
            see();
            const double value = solve_strengths();
            return value + add_gradient(x, gradient);
        };
        const Minimum found = minimise(error, start, lower, upper, options);
        error(found.x, nullptr);
        return found.evaluations;
    }

    /// Starting points, Gaussians of several widths: the best, or all where there are few samples.
    std::vector<std::vector<double>> starts() {
        double best = std::numeric_limits<double>::infinity();
        std::vector<std::vector<double>> all, first;
        for (const double sigma : {0.003, 0.01, 0.02, 0.05, 0.1, 0.2, 0.4, 0.8}) {
            std::vector<double> p(p_count());
            for (std::size_t i = 0; i < p.size(); ++i) {
                const double t =
                    std::tan(std::min(table_.thetas[i / table_.width], pi / 2 - 1e-3)) / sigma;
                p[i] = std::exp(-t * t) + 1e-6;
            }
            all.push_back(p);
            if (const double error = set(p); error < best) {
                best = error;
                first = {p};
            }
        }
        return samples_.size() <= few_samples && table_.width == 1 ? all : first;
    }

    /// p given the areas and strengths, then the areas and strengths that it implies; returns the
    /// squared error. `step`: how far the logarithm of p goes towards its solution.
    double iterate(double step) {
        const std::vector<double> before = p_;
        solve_distribution();
        const double most = *std::max_element(p_.begin(), p_.end());
        for (std::size_t i = 0; i < p_.size(); ++i) {
            const double to = std::max(p_[i], 1e-9 * most);
            const double from = std::max(before[i], 1e-12 * most);
            p_[i] = std::exp((1 - step) * std::log(from) + step * std::log(to));
        }
        see();
        return solve_strengths();
    }

    DistributionPart part() const {
        DistributionPart part;
        part.shape = Shape::Tabulated;
        auto table = std::make_shared<DirectionTable>(table_);
        const double most = *std::max_element(p_.begin(), p_.end());
        for (const double p : p_)
            table->values.push_back(static_cast<float>(p / most));
        part.table = table;
        return part;
    }

    std::vector<double> p() const { return p_; }
    /// Returns the squared error with the best strengths.
    double set(const std::vector<double>& p) {
        p_ = p;
        see();
        return solve_strengths();
    }

    double f0 = 0.5;
    std::vector<double> kd, ks;
    std::size_t count = 0;

  private:
    static Vector half(const Samples& samples, std::size_t k) {
        const Directions& d = *samples.directions;
        return {d.plane(Directions::HX)[k], d.plane(Directions::HY)[k], d.plane(Directions::HZ)[k]};
    }
    static double theta_of(const Vector& h) { return std::atan2(std::hypot(h[0], h[1]), h[2]); }

    // Polar angles finer near the normal, as many as there are samples for.
    void choose_nodes(const Samples& samples, const std::vector<std::uint32_t>& used) {
        const std::size_t across = samples.isotropic ? 1 : azimuths;
        std::vector<double> thetas;
        for (const std::uint32_t k : used)
            thetas.push_back(theta_of(half(samples, k)));
        std::sort(thetas.begin(), thetas.end());
        const double least = samples_a_node * static_cast<double>(across);
        const std::size_t wanted = samples.isotropic ? most_thetas : 31;
        std::size_t last = 0;
        table_.thetas = {0};
        for (std::size_t i = 1; i + 1 < wanted; ++i) {
            const double share = static_cast<double>(i) / static_cast<double>(wanted - 1);
            const double theta = share * share * pi / 2;
            const auto below = static_cast<std::size_t>(
                std::lower_bound(thetas.begin(), thetas.end(), theta) - thetas.begin());
            if (static_cast<double>(below - last) < least)
                continue;
            table_.thetas.push_back(theta);
            last = below;
        }
        table_.thetas.push_back(pi / 2);
        for (std::size_t j = 0; j < across; ++j)
            table_.phis.push_back(2 * pi * static_cast<double>(j) / static_cast<double>(across));
        table_.height = table_.thetas.size();
        table_.width = across;
    }

    void gather(const Samples& samples, const std::vector<std::uint32_t>& used) {
        const float* const iz = samples.directions->plane(Directions::WiZ);
        const float* const c = samples.directions->plane(Directions::C);
        for (const std::uint32_t k : used) {
            Sample sample{};
            sample.weight =
                (samples.weights.empty() ? 1 : double{samples.weights[k]}) * iz[k] * iz[k];
            sample.p5 = std::pow(1 - c[k], 5);
            const Vector h = half(samples, k);
            const double theta = theta_of(h);
            const auto& nodes = table_.thetas;
            const auto next = std::upper_bound(nodes.begin() + 1, nodes.end() - 1, theta);
            const auto i = static_cast<int>(next - nodes.begin()) - 1;
            const auto low = static_cast<std::size_t>(i);
            const double s =
                std::clamp((theta - nodes[low]) / (nodes[low + 1] - nodes[low]), 0.0, 1.0);
            const int width = static_cast<int>(table_.width);
            double turn = std::atan2(h[1], h[0]) / (2 * pi);
            turn = (turn < 0 ? turn + 1 : turn) * width;
            const int j = width == 1 ? 0 : std::min(static_cast<int>(turn), width - 1);
            const double t = width == 1 ? 0 : turn - j;
            const int other = (j + 1) % width;
            sample.node = {i * width + j, i * width + other, (i + 1) * width + j,
                           (i + 1) * width + other};
            sample.share = {(1 - s) * (1 - t), (1 - s) * t, s * (1 - t), s * t};
            std::tie(sample.wi, sample.wo) = samples.directions->pair(k);
            samples_.push_back(sample);
            for (std::size_t ch = 0; ch < channels_; ++ch)
                values_.push_back(samples.channel(ch)[k]);
            for (std::size_t ch = 0; ch < channels_; ++ch)
                whole_ += sample.weight * std::pow(samples.channel(ch)[k], 2);
        }
    }

    // Rows and columns of wi and wo in the grid of g.
    void place() {
        for (const Sample& sample : samples_)
            for (const Vector& k : {sample.wi, sample.wo}) {
                rows_.push_back(grid_.row(std::atan2(k[2], std::hypot(k[0], k[1]))));
                columns_.push_back(grid_.column(std::atan2(k[1], k[0])));
            }
    }

    // The linear map from the nodes of an isotropic p to g at the grid's rows. Over azimuth,
    // (a cos phi + b)+ has a closed integral.
    void map_areas() {
        areas_ = Eigen::MatrixXd::Zero(static_cast<int>(grid_.rows), static_cast<int>(p_count()));
        const Quadrature rule = gauss_legendre(24);
        for (std::size_t r = 0; r < grid_.rows; ++r) {
            const double e = grid_.elevation(static_cast<double>(r));
            for (std::size_t n = 0; n + 1 < table_.height; ++n) {
                // The integrand's derivative is unbounded where its azimuths begin to be cut.
                std::vector<double> ends{table_.thetas[n], table_.thetas[n + 1]};
                if (e > ends[0] && e < ends[1])
                    ends.insert(ends.begin() + 1, e);
                for (std::size_t piece = 0; piece + 1 < ends.size(); ++piece)
                    for (std::size_t i = 0; i < rule.size(); ++i) {
                        const double width = ends[piece + 1] - ends[piece];
                        const double theta = ends[piece] + width * rule.x[i];
                        const double a = std::sin(theta) * std::cos(e);
                        const double b = std::cos(theta) * std::sin(e);
                        const double over = b >= a ? 2 * pi * b
                                                   : 2 * (b * std::acos(-b / a) +
                                                          std::sqrt(std::max(0.0, a * a - b * b)));
                        const double w = over * std::sin(theta) * width * rule.w[i];
                        const double t =
                            (theta - table_.thetas[n]) / (table_.thetas[n + 1] - table_.thetas[n]);
                        areas_(static_cast<int>(r), static_cast<int>(n)) += w * (1 - t);
                        areas_(static_cast<int>(r), static_cast<int>(n) + 1) += w * t;
                    }
            }
        }
    }

    std::size_t p_count() const { return table_.width * table_.height; }

    // g of p (its largest value taken as 1) at the grid's directions.
    std::vector<double> areas_of_p() const {
        if (table_.width == 1) {
            const Eigen::VectorXd g =
                areas_ * Eigen::Map<const Eigen::VectorXd>(p_.data(), areas_.cols()) * scale_;
            return {g.begin(), g.end()};
        }
        Distribution distribution;
        distribution.parts = {part()};
        distribution.sector = grid_.sector;
        return generator_.visible_areas(distribution, directions_);
    }

    // g of p at the samples, as <h.n> / (4 g(wi) g(wo)).
    void see() {
        scale_ = 1 / *std::max_element(p_.begin(), p_.end());
        const std::vector<double> g = areas_of_p();
        const double height =
            g[g.size() - grid_.columns]; // g(n) = <h.n>: all are above the horizon
        plane_.assign(g.begin(), g.end());
        visibility_.resize(samples_.size());
        parallel_pieces(samples_.size(), 4096, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                double product = 1;
                for (std::size_t k = 2 * i; k < 2 * i + 2; ++k)
                    product *=
                        std::max(interpolate(grid_, plane_, rows_[k], columns_[k]), 1e-9 * height);
                visibility_[i] = height / (4 * product);
            }
        });
    }

    double p_at(const Sample& sample) const {
        double p = 0;
        for (std::size_t b = 0; b < 4; ++b)
            p += sample.share[b] * p_[static_cast<std::size_t>(sample.node[b])];
        return p * scale_;
    }

    // The squared error's derivatives by log p at the solved strengths; returns what smoothness
    // adds to the error.
    double add_gradient(const std::vector<double>& x, std::vector<double>* gradient) const {
        double penalty = 0;
        if (gradient != nullptr)
            gradient->assign(x.size(), 0.0);
        for (std::size_t n = 0; n + 1 < x.size(); ++n) {
            const double step = x[n + 1] - x[n], w = smoothness * whole_;
            penalty += w * step * step;
            if (gradient != nullptr) {
                (*gradient)[n] -= 2 * w * step;
                (*gradient)[n + 1] += 2 * w * step;
            }
        }
        if (gradient == nullptr)
            return penalty;
        // By p, and by g at the grid's rows.
        Eigen::VectorXd by_p = Eigen::VectorXd::Zero(static_cast<int>(p_.size()));
        Eigen::VectorXd by_g = Eigen::VectorXd::Zero(static_cast<int>(grid_.rows));
        const auto last = static_cast<int>(grid_.rows) - 1;
        for (std::size_t i = 0; i < samples_.size(); ++i) {
            const Sample& s = samples_[i];
            const double shape = visibility_[i] * (f0 + (1 - f0) * s.p5);
            const double lobe = p_at(s) * shape;
            double pull = 0;
            for (std::size_t ch = 0; ch < channels_; ++ch)
                pull += 2 * s.weight * ks[ch] *
                        (kd[ch] / pi + ks[ch] * lobe - values_[i * channels_ + ch]);
            for (std::size_t b = 0; b < 4; ++b)
                by_p(s.node[b]) += pull * shape * s.share[b] * scale_;
            by_g(last) += pull * lobe / double{plane_.back()};
            for (std::size_t k = 2 * i; k < 2 * i + 2; ++k) {
                // Linear between rows: they are close.
                const int row = std::min(static_cast<int>(rows_[k]), last - 1);
                const double t = rows_[k] - row;
                const double slope = -pull * lobe / interpolate(grid_, plane_, rows_[k], 0);
                by_g(row) += slope * (1 - t);
                by_g(row + 1) += slope * t;
            }
        }
        by_p += scale_ * (areas_.transpose() * by_g);
        for (std::size_t n = 0; n < x.size(); ++n)
            (*gradient)[n] += by_p(static_cast<int>(n)) * p_[n];
        return penalty;
    }

    // kd and ks of each channel for the best f0; returns the squared error.
    double solve_strengths() {
        // Sums over {1 / pi, A, B}: the lobe is A + f0 B.
        Eigen::Matrix3d gram = Eigen::Matrix3d::Zero();
        Eigen::Matrix3Xd projected = Eigen::Matrix3Xd::Zero(3, static_cast<int>(channels_));
        std::vector<double> squared(channels_);
        for (std::size_t i = 0; i < samples_.size(); ++i) {
            const Sample& s = samples_[i];
            const double g = p_at(s) * visibility_[i];
            const Eigen::Vector3d b(1 / pi, s.p5 * g, (1 - s.p5) * g);
            gram += s.weight * b * b.transpose();
            for (std::size_t ch = 0; ch < channels_; ++ch) {
                const double y = values_[i * channels_ + ch];
                projected.col(static_cast<int>(ch)) += s.weight * y * b;
                squared[ch] += s.weight * y * y;
            }
        }
        double best = std::numeric_limits<double>::infinity();
        const auto tried = [&](double f) {
            SmallMatrix small(2, 2);
            small << gram(0, 0), gram(0, 1) + f * gram(0, 2), gram(0, 1) + f * gram(0, 2),
                gram(1, 1) + 2 * f * gram(1, 2) + f * f * gram(2, 2);
            double error = 0;
            std::vector<double> diffuse, specular;
            for (std::size_t ch = 0; ch < channels_; ++ch) {
                const auto column = projected.col(static_cast<int>(ch));
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
        for (double step = 0.01; step > 1e-4; step *= 0.5)
            for (const double sign : {-1.0, 1.0})
                tried(std::clamp(f0 + sign * step, 0.0, 1.0));
        return best;
    }

    // The nodes of p that fit best with everything else as it is.
    void solve_distribution() {
        const auto n = static_cast<int>(p_.size());
        double strength = 0;
        for (const double k : ks)
            strength += k * k;
        std::vector<Eigen::Triplet<double>> entries;
        Eigen::VectorXd right = Eigen::VectorXd::Zero(n);
        // Dense blocks of 4 x 4 a sample, added up by diagonals: neighbours only.
        std::vector<std::array<double, 16>> cells(p_.size());
        for (std::size_t i = 0; i < samples_.size(); ++i) {
            const Sample& s = samples_[i];
            const double shape = visibility_[i] * (f0 + (1 - f0) * s.p5) * scale_;
            double pull = 0;
            for (std::size_t ch = 0; ch < channels_; ++ch) {
                const double y = values_[i * channels_ + ch];
                pull += ks[ch] * (y - kd[ch] / pi);
            }
            const double own = s.weight * shape * shape * strength;
            for (std::size_t a = 0; a < 4; ++a) {
                right(s.node[a]) += s.weight * shape * pull * s.share[a];
                for (std::size_t b = 0; b < 4; ++b)
                    cells[static_cast<std::size_t>(s.node[0])][a * 4 + b] +=
                        own * s.share[a] * s.share[b];
            }
        }
        const int width = static_cast<int>(table_.width);
        const auto neighbours = [&](int first) {
            const int i = first / width, j = first % width, other = (j + 1) % width;
            return std::array<int, 4>{first, i * width + other, first + width,
                                      (i + 1) * width + other};
        };
        const auto add_smooth = [&](int a, int b) {
            const double pa = p_[static_cast<std::size_t>(a)], pb = p_[static_cast<std::size_t>(b)];
            const double w = smoothness * whole_ / (pa * pa + pb * pb + 1e-18 / scale_ / scale_);
            entries.emplace_back(a, a, w);
            entries.emplace_back(b, b, w);
            entries.emplace_back(a, b, -w);
            entries.emplace_back(b, a, -w);
        };
        for (int first = 0; first < n; ++first) {
            if (first + width < n) {
                const std::array<int, 4> at = neighbours(first);
                for (std::size_t a = 0; a < 4; ++a)
                    for (std::size_t b = 0; b < 4; ++b)
                        if (const double x = cells[static_cast<std::size_t>(first)][a * 4 + b];
                            x != 0)
                            entries.emplace_back(at[a], at[b], x);
                add_smooth(first, first + width);
            }
            if (width > 1)
                add_smooth(first, first / width * width + (first + 1) % width);
        }
        Eigen::SparseMatrix<double> normal(n, n);
        normal.setFromTriplets(entries.begin(), entries.end());
        const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(normal);
        if (solver.info() != Eigen::Success)
            throw InputError(fmt::format(
                "{}: nothing is reflected at some angles; no distribution follows", source_));
        const Eigen::VectorXd solution = solver.solve(right);
        for (int i = 0; i < n; ++i)
            p_[static_cast<std::size_t>(i)] =
                std::isfinite(solution(i)) ? std::max(solution(i), 0.0) : 0;
        if (!(*std::max_element(p_.begin(), p_.end()) > 0))
            throw InputError(
                fmt::format("{}: is diffuse; no distribution of normals follows", source_));
    }

    const Generator& generator_;
    std::string source_;
    std::size_t channels_;
    DirectionTable table_; ///< nodes; values are in p_
    std::vector<double> p_;
    double scale_ = 1; ///< 1 / the largest p
    double whole_ = 0; ///< of W y^2
    std::vector<Sample> samples_;
    std::vector<double> values_; ///< [sample][channel]
    Grid grid_;
    std::vector<Vector> directions_;
    std::vector<double> rows_, columns_; ///< [sample][wi, wo]
    std::vector<float> plane_;           ///< g
    std::vector<double> visibility_;
    Eigen::MatrixXd areas_; ///< isotropic: g at the rows, of each node of p
};

} // namespace

Recovered recover(const Device& device, const Generator& generator, const Samples& samples,
                  const RecoverOptions& options) {
    Alternation state(device, generator, samples, options);
    Recovered result;
    double best = std::numeric_limits<double>::infinity();
    std::vector<double> best_p;
    for (const std::vector<double>& start : state.starts()) {
        double error = state.set(start), step = 1;
        std::vector<double> p = start;
        for (int i = 0, idle = 0; i < options.iterations && idle < 4; ++i) {
            const double next = state.iterate(step);
            ++result.iterations;
            idle = next < error * (1 - 1e-5) ? 0 : idle + 1;
            if (next < error) {
                error = next;
                p = state.p();
            } else {
                state.set(p);
                step *= 0.5;
            }
        }
        state.set(p);
        if (state.isotropic()) {
            result.iterations += state.descend();
            p = state.p();
            error = state.set(p);
        }
        if (error < best) {
            best = error;
            best_p = p;
        }
    }
    state.set(best_p);
    Distribution distribution;
    distribution.parts = {state.part()};
    distribution.sector = samples.isotropic ? Sector::Isotropic : Sector::All;
    distribution.name = "recovered from measurements";
    result.table = generator.generate(distribution, options.generator, samples.source);
    result.f0 = state.f0;
    result.kd = state.kd;
    result.ks = state.ks;
    result.samples = state.count;
    return result;
}

} // namespace brdfit
