// What the device sums, held against float64 on the host: errors, gradients, the solution for kd
// and ks, for every structure a fit can have.

#include "fit/structures.hpp"
#include "host/device/buffer.hpp"
#include "tests/support/fits.hpp"
#include "tests/support/reference_models.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <future>
#include <gtest/gtest.h>
#include <random>
#include <tuple>

namespace brdfit {

namespace {

using test::compressed;
using test::device;
using test::identifier_of;
using test::programs;
using test::typical_material;

/// The samples once more for the host, as an objective weights them.
class Host {
  public:
    Host(const Samples& samples, const DeviceSamples& packed, const Structure& structure,
         Metric metric)
        : structure_(structure), layout_(layout_of(structure)), metric_(metric),
          channels_(static_cast<Eigen::Index>(samples.channels.size())) {
        double weights = 0;
        for (const std::uint32_t k : packed.used) {
            Sample sample;
            std::tie(sample.wi, sample.wo) = samples.directions->pair(k);
            sample.w = samples.weights.empty() ? 1.0 : samples.weights[k];
            sample.iz = samples.directions->plane(Directions::WiZ)[k];
            for (Eigen::Index ch = 0; ch < channels_; ++ch)
                sample.y.push_back(samples.channel(static_cast<std::size_t>(ch))[k]);
            weights += sample.w;
            samples_.push_back(sample);
        }
        for (Sample& sample : samples_)
            sample.w *= metric == Metric::L2 ? 1 / sample.w
                                             : static_cast<double>(samples_.size()) / weights;
    }

    /// The mean squared error with the best kd and ks.
    double projected(const std::vector<double>& theta, Coefficients* a = nullptr) const {
        const Eigen::Index basis = layout_.basis;
        Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(basis, basis);
        Eigen::MatrixXd right = Eigen::MatrixXd::Zero(basis, channels_);
        Eigen::VectorXd squared = Eigen::VectorXd::Zero(channels_);
        for (const Sample& sample : samples_) {
            const Eigen::VectorXd b = shapes(theta, sample);
            const double weight = sample.w * sample.iz * sample.iz;
            gram += weight * b * b.transpose();
            for (Eigen::Index ch = 0; ch < channels_; ++ch) {
                const double y = sample.y[static_cast<std::size_t>(ch)];
                right.col(ch) += weight * y * b;
                squared[ch] += weight * y * y;
            }
        }
        double error = 0;
        if (a != nullptr)
            a->resize(channels_, basis);
        for (Eigen::Index ch = 0; ch < channels_; ++ch) {
            const NonNegativeSolution solution =
                solve_nonnegative(gram, right.col(ch), squared[ch], SmallVector::Zero(basis));
            error += solution.squared_error;
            if (a != nullptr)
                a->row(ch) = solution.a.transpose();
        }
        return error / norm();
    }

    double loss(const std::vector<double>& theta, const Coefficients& a) const {
        double sum = 0;
        for (const Sample& sample : samples_) {
            const Eigen::VectorXd f = a * shapes(theta, sample);
            for (Eigen::Index ch = 0; ch < channels_; ++ch) {
                const double r =
                    compressed(metric_, sample.iz * f[ch]) -
                    compressed(metric_, sample.iz * sample.y[static_cast<std::size_t>(ch)]);
                sum += sample.w * r * r;
            }
        }
        return sum / norm();
    }

  private:
    struct Sample {
        Vector wi, wo;
        double w, iz;
        std::vector<double> y;
    };
    double norm() const { return static_cast<double>(samples_.size()) * double(channels_); }

    Eigen::VectorXd shapes(const std::vector<double>& theta, const Sample& sample) const {
        Eigen::VectorXd b(layout_.basis);
        std::vector<double> coupled;
        if (structure_.diffuse->kind == Kind::DiffuseAndLobe)
            coupled = {theta[0]};
        b[0] = reference_value(structure_.diffuse->name, true, coupled, sample.wi, sample.wo);
        for (std::size_t l = 0; l < structure_.lobes.size(); ++l)
            b[static_cast<Eigen::Index>(l) + 1] = reference_value(
                structure_.lobes[l]->name, structure_.isotropic,
                {theta.begin() + layout_.lobe_begin[l], theta.begin() + layout_.lobe_begin[l + 1]},
                sample.wi, sample.wo);
        return b;
    }

    Structure structure_;
    StructureLayout layout_;
    Metric metric_;
    Eigen::Index channels_;
    std::vector<Sample> samples_;
};

/// The derivative by the value that `at` moves, from four values of the function.
template <typename At>
double derivative(double value, double step, const At& at) {
    return (8 * (at(value + step) - at(value - step)) -
            (at(value + 2 * step) - at(value - 2 * step))) /
           (12 * step);
}

std::vector<double> theta_of(const Material& material) {
    std::vector<double> theta;
    for (const Lobe& lobe : material.lobes)
        theta.insert(theta.end(), lobe.theta.begin(), lobe.theta.end());
    return theta;
}

/// Somewhere else than where the data was made: every parameter off by up to 15 %.
std::vector<double> moved(std::vector<double> theta, std::mt19937_64& random) {
    for (double& t : theta)
        t *= 1 + 0.15 * std::uniform_real_distribution<double>(-1, 1)(random);
    return theta;
}

struct Case {
    std::string models;
    int lobes;
    bool isotropic;
    std::size_t channels;

    Structure structure() const { return structure_named(models, lobes, "", isotropic); }
    std::string name() const {
        return fmt::format("{}_{}_{}_{}_channels", identifier_of(models), lobes,
                           isotropic ? "isotropic" : "anisotropic", channels);
    }
};

void PrintTo(const Case& one, std::ostream* out) {
    *out << one.name();
}

/// Every model with one and two lobes in each of its forms and with few and many channels, and a
/// mixture.
std::vector<Case> cases() {
    std::vector<Case> all;
    std::vector<std::string> models = test::fitted_model_names();
    models.push_back("kurt+ashikhmin-shirley");
    for (const std::string& model : models)
        for (const int lobes : {1, 2})
            for (const bool isotropic : {true, false}) {
                // Chunks of channels and several lobes are tried together.
                const std::size_t channels = lobes == 1 ? 3 : 31;
                const Case one{model, lobes, isotropic, channels};
                const bool mixture = model.find('+') != std::string::npos;
                if ((mixture && lobes > 1) ||
                    (!isotropic && !test::has_anisotropic_form(one.structure())))
                    continue;
                all.push_back(one);
            }
    return all;
}

class EveryStructure : public testing::TestWithParam<Case> {
  protected:
    EveryStructure()
        : structure(GetParam().structure()),
          material(typical_material(structure, GetParam().channels)) {
        auto directions = random_directions(300, structure.isotropic, 5);
        samples = synthesise(device(), material, directions, 0.3, 6);
        samples.isotropic = structure.isotropic;
        for (std::size_t k = 0; k < samples.count(); ++k)
            samples.weights.push_back(0.5F + static_cast<float>(k % 7) / 4);
    }
    Objective objective(const DeviceSamples& packed) const {
        return {device(), programs().get(structure, packed.channels, packed.chunk), packed};
    }

    Structure structure;
    Material material;
    Samples samples;
};

INSTANTIATE_TEST_SUITE_P(Objective, EveryStructure, testing::ValuesIn(cases()),
                         [](const auto& info) { return info.param.name(); });

TEST_P(EveryStructure, error_coefficients_and_gradient_are_those_of_float64) {
    for (const Metric metric : {Metric::Ngan, Metric::L2}) {
        const DeviceSamples packed = pack_samples(device(), samples, 80, metric);
        Objective objective = this->objective(packed);
        const Host host(samples, packed, structure, metric);
        std::mt19937_64 random(7);
        for (int i = 0; i < 3; ++i) {
            const std::vector<double> theta = moved(theta_of(material), random);
            Coefficients a;
            const double expected = host.projected(theta, &a);
            std::vector<double> gradient;
            EXPECT_NEAR(objective.projected_error(theta, &gradient), expected, 1e-4 * expected);
            const double largest = a.maxCoeff();
            EXPECT_LT((objective.coefficients() - a).cwiseAbs().maxCoeff(), 1e-2 * largest);
            EXPECT_NEAR(objective.projected_error(theta), expected, 1e-4 * expected);

            std::vector<double> by_theta;
            double steepest = 0;
            for (std::size_t p = 0; p < theta.size(); ++p) {
                std::vector<double> t = theta;
                by_theta.push_back(derivative(theta[p], 1e-4 * theta[p], [&](double value) {
                    t[p] = value;
                    return host.projected(t);
                }));
                steepest = std::max(steepest, std::abs(by_theta[p] * theta[p]));
            }
            ASSERT_EQ(gradient.size(), theta.size());
            for (std::size_t p = 0; p < theta.size(); ++p)
                EXPECT_NEAR(gradient[p] * theta[p], by_theta[p] * theta[p], 3e-3 * steepest)
                    << name_of(metric) << ", parameter " << p;
        }
    }
}

// Whatever was evaluated before: lobes so narrow that no sample sees them ask for any strength, and
// the sums are taken about the last good one.
TEST_P(EveryStructure, error_does_not_depend_on_what_came_before) {
    const DeviceSamples packed = pack_samples(device(), samples, 80, Metric::Ngan);
    std::mt19937_64 random(8);
    const std::vector<double> theta = moved(theta_of(material), random);
    const double expected = objective(packed).projected_error(theta);
    const Space space(structure.lobes, structure.isotropic, {});
    for (std::uint64_t i = 0; i < 40; ++i) {
        Objective used = objective(packed);
        used.projected_error(space.random(1, i));
        EXPECT_NEAR(used.projected_error(theta), expected, 2e-5 * expected) << i;
    }
}

TEST_P(EveryStructure, losses_and_their_gradients_are_those_of_float64) {
    for (const Metric metric : {Metric::Log, Metric::Cbrt}) {
        const DeviceSamples packed = pack_samples(device(), samples, 80, metric);
        Objective objective = this->objective(packed);
        const Host host(samples, packed, structure, metric);
        std::mt19937_64 random(8);
        const std::vector<double> theta = moved(theta_of(material), random);
        Coefficients a(static_cast<Eigen::Index>(material.channels.size()),
                       objective.layout().basis);
        for (Eigen::Index i = 0; i < a.size(); ++i)
            a.data()[i] = std::uniform_real_distribution<double>(0.1, 0.6)(random);
        std::vector<double> by_theta;
        Coefficients by_a;
        const double expected = host.loss(theta, a);
        EXPECT_NEAR(objective.loss(metric, theta, a, by_theta, by_a), expected, 1e-4 * expected);
        ASSERT_EQ(by_theta.size(), theta.size());
        ASSERT_EQ(by_a.size(), a.size());

        std::vector<double> slopes;
        double steepest = 0;
        for (std::size_t p = 0; p < theta.size(); ++p) {
            std::vector<double> t = theta;
            slopes.push_back(derivative(theta[p], 1e-4 * theta[p], [&](double value) {
                t[p] = value;
                return host.loss(t, a);
            }));
            steepest = std::max(steepest, std::abs(slopes[p] * theta[p]));
        }
        for (std::size_t p = 0; p < theta.size(); ++p)
            EXPECT_NEAR(by_theta[p] * theta[p], slopes[p] * theta[p], 1e-3 * steepest)
                << name_of(metric) << ", parameter " << p;
        // The first, a middle and the last channel.
        for (const Eigen::Index ch : {Eigen::Index{0}, a.rows() / 2, a.rows() - 1}) {
            std::vector<double> by_coefficient;
            double scale = 0;
            for (Eigen::Index j = 0; j < a.cols(); ++j) {
                Coefficients c = a;
                by_coefficient.push_back(derivative(a(ch, j), 1e-4 * a(ch, j), [&](double value) {
                    c(ch, j) = value;
                    return host.loss(theta, c);
                }));
                scale = std::max(scale, std::abs(by_coefficient.back()));
            }
            for (Eigen::Index j = 0; j < a.cols(); ++j)
                EXPECT_NEAR(by_a(ch, j), by_coefficient[static_cast<std::size_t>(j)], 1e-3 * scale)
                    << name_of(metric) << ", channel " << ch << ", basis " << j;
        }
    }
}

TEST_P(EveryStructure, errors_of_all_metrics_are_those_of_float64) {
    const DeviceSamples packed = pack_samples(device(), samples, 70, Metric::Ngan);
    Objective objective = this->objective(packed);
    Coefficients a(static_cast<Eigen::Index>(material.channels.size()), objective.layout().basis);
    for (Eigen::Index ch = 0; ch < a.rows(); ++ch) {
        const auto c = static_cast<std::size_t>(ch);
        a(ch, 0) = material.kd[c];
        for (std::size_t l = 0; l < material.lobes.size(); ++l)
            a(ch, static_cast<Eigen::Index>(l) + 1) = material.lobes[l].ks[c];
    }
    const MetricErrors errors = objective.metric_errors(theta_of(material), a);
    const MetricErrors expected = test::reference_errors(material, samples, 70);
    for (int i = 0; i < metric_count; ++i) {
        const auto at = static_cast<std::size_t>(i);
        EXPECT_NEAR(errors[at], expected[at], 1e-4 * expected[at])
            << name_of(static_cast<Metric>(i));
    }
}

TEST(Loss, pulls_a_channel_up_from_black) {
    // The slope of max(f, 0) at f = 0 is that towards f > 0: coefficients cannot go the other way.
    const Structure structure = structure_named("ward", 1, "", true);
    const Samples samples = test::measured(typical_material(structure), 300);
    for (const Metric metric : {Metric::Log, Metric::Cbrt}) {
        const DeviceSamples packed = pack_samples(device(), samples, 80, metric);
        Objective objective(device(), programs().get(structure, packed.channels, packed.chunk),
                            packed);
        const Host host(samples, packed, structure, metric);
        Coefficients black = Coefficients::Zero(3, 2), a = black;
        std::vector<double> by_theta;
        Coefficients by_a;
        objective.loss(metric, {0.2}, black, by_theta, by_a);
        const double step = 1e-9;
        for (Eigen::Index i = 0; i < a.size(); ++i) {
            a.data()[i] = step;
            const double slope = (host.loss({0.2}, a) - host.loss({0.2}, black)) / step;
            a.data()[i] = 0;
            EXPECT_LT(slope, 0);
            EXPECT_NEAR(by_a.data()[i], slope, 1e-2 * std::abs(slope)) << name_of(metric);
        }
    }
}

// PoCL 3.1 aborts where three runs of one kernel overlap, the last of them the largest so far.
TEST(Objective, of_four_files_of_growing_sizes_at_once_is_as_alone) {
    constexpr std::size_t files = 4, sizes = 24;
    const Structure structure = structure_named("kurt-plausible", 1, "", true);
    const Material material = typical_material(structure);
    const std::vector<std::vector<double>> candidates(64, theta_of(material)); // for long runs
    std::array<Device, files> devices;
    for (Device& own : devices) {
        own = device();
        own.queue = cl::CommandQueue(own.context, own.handle);
    }
    Samples samples = test::measured(material, 100000);
    const auto packed = [&](std::size_t size) {
        for (std::size_t k = 0; k < samples.count(); ++k)
            samples.valid[k] = k % sizes < size ? 1 : 0;
        return pack_samples(device(), samples, 80, Metric::Ngan);
    };
    const auto sum = [&](const Device& own, const DeviceSamples& of) {
        Objective objective(own, programs().get(structure, of.channels, of.chunk), of);
        return objective.shape_sums(candidates).front().ss;
    };
    DeviceSamples small = packed(1);
    for (std::size_t size = 2; size <= sizes; ++size) {
        const DeviceSamples large = packed(size);
        const std::array<const DeviceSamples*, files> of{&small, &small, &small, &large};
        std::array<std::future<double>, files> at_once;
        for (std::size_t i = 0; i < files; ++i)
            at_once[i] =
                std::async(std::launch::async, sum, std::cref(devices[i]), std::cref(*of[i]));
        std::array<double, files> together{};
        for (std::size_t i = 0; i < files; ++i)
            together[i] = at_once[i].get();
        for (std::size_t i = 0; i < files; ++i)
            EXPECT_EQ(together[i], sum(devices[i], *of[i]));
        small = large;
    }
}

TEST(PackSamples, uses_the_valid_samples_within_the_angle) {
    const Structure structure = structure_named("kurt", 1, "", true);
    Samples samples = test::measured(typical_material(structure), 500);
    std::size_t within = 0;
    for (std::size_t k = 0; k < samples.count(); ++k) {
        samples.valid[k] = k % 3 == 0 ? 0 : 1;
        const double lowest = std::min(samples.directions->wi(k)[2], samples.directions->wo(k)[2]);
        within += k % 3 != 0 && std::acos(lowest) <= 50 * degree ? 1 : 0;
    }
    const DeviceSamples packed = pack_samples(device(), samples, 50, Metric::Ngan);
    EXPECT_EQ(packed.count, within);
    EXPECT_GT(within, 0U);
    EXPECT_LT(within, samples.count() / 2);
}

TEST(PackSamples, directions_larger_than_the_device_takes_are_refused) {
    Structure structure = structure_named("lambert", 0, "", true);
    Material material = typical_material(structure);
    Samples samples = test::measured(material, 2000);
    samples.channels.resize(1); // 8 KiB or more of values, 48 KB of directions
    Device small = device();
    small.max_allocation = 45000;
    const std::string message =
        test::complaint([&] { pack_samples(small, samples, 90, Metric::Ngan); });
    EXPECT_NE(message.find("its limit is"), std::string::npos) << message;
}

TEST(PackSamples, invalid_samples_and_those_beyond_the_angle_change_nothing) {
    const Structure structure = structure_named("kurt", 1, "", true);
    const Material material = typical_material(structure);
    const Samples samples = test::measured(material, 800);
    Samples broken = samples;
    for (std::size_t k = 0; k < broken.count(); ++k) {
        const bool beyond = std::min(broken.directions->wi(k)[2], broken.directions->wo(k)[2]) <
                            std::cos(80 * degree);
        if (k % 5 == 0)
            broken.valid[k] = 0;
        if (k % 5 == 0 || beyond)
            for (std::size_t ch = 0; ch < 3; ++ch)
                broken.channel(ch)[k] = -1e30F;
    }
    Samples without = samples;
    without.valid = broken.valid;
    const auto error = [&](const Samples& of) {
        const DeviceSamples packed = pack_samples(device(), of, 80, Metric::Ngan);
        Objective objective(device(), programs().get(structure, packed.channels, packed.chunk),
                            packed);
        return objective.projected_error({0.4, 0.3, 0.2});
    };
    EXPECT_EQ(error(broken), error(without));
    EXPECT_NE(error(broken), error(samples));
}

TEST(PackedSamples, for_another_metric_share_all_but_the_weights) {
    Samples samples = test::measured(typical_material(structure_named("kurt", 1, "", true)), 3000);
    samples.weights.assign(samples.count(), 1);
    for (std::size_t k = 0; k < samples.count(); k += 3)
        samples.weights[k] = 2.5F;
    const DeviceSamples first = pack_samples(device(), samples, 80, Metric::Ngan);
    for (const Metric metric : {Metric::L2, Metric::Log, Metric::Cbrt, Metric::Ngan}) {
        const DeviceSamples other = packed_for(metric, device(), samples, first);
        const DeviceSamples anew = pack_samples(device(), samples, 80, metric);
        EXPECT_EQ(other.values(), first.values());
        EXPECT_EQ(other.directions(), first.directions());
        EXPECT_EQ(other.solid_angle(), first.solid_angle());
        EXPECT_NE(other.weights(), first.weights());
        EXPECT_EQ(download<float>(device(), other.weights, other.stride),
                  download<float>(device(), anew.weights, anew.stride))
            << name_of(metric);
    }
}

TEST(ThinSamples, takes_one_of_each_run_and_all_where_there_are_few) {
    const Structure structure = structure_named("kurt", 1, "", true);
    const Samples samples = test::measured(typical_material(structure), 3000);
    const DeviceSamples packed = pack_samples(device(), samples, 80, Metric::Ngan);
    const DeviceSamples thin = thin_samples(device(), samples, packed, Metric::Ngan, 100);
    ASSERT_EQ(thin.used.size(), 100U);
    const double run = static_cast<double>(packed.count) / 100;
    for (std::size_t i = 0; i < thin.used.size(); ++i) {
        const auto found = std::lower_bound(packed.used.begin(), packed.used.end(), thin.used[i]);
        ASSERT_NE(found, packed.used.end());
        EXPECT_EQ(*found, thin.used[i]);
        const auto place = static_cast<double>(found - packed.used.begin());
        EXPECT_GE(place, std::floor(static_cast<double>(i) * run));
        EXPECT_LE(place, static_cast<double>(i + 1) * run);
    }
    EXPECT_EQ(thin_samples(device(), samples, packed, Metric::Ngan, 3000).used, packed.used);
}

} // namespace

} // namespace brdfit
