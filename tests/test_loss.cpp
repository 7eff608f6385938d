// Fits of the metrics `log` and `cbrt`: kd and ks are solved for each theta as well as a minimiser
// that sees them finds them, and what made the data is recovered.

#include "fit/structures.hpp"
#include "tests/support/fits.hpp"
#include "tests/support/reference_models.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace brdfit {

namespace {

using test::compressed;
using test::device;
using test::fit;
using test::measured;
using test::programs;
using test::typical_material;

/// One channel's loss by its kd and ks in float64, all else given.
class HostChannel {
  public:
    HostChannel(const Samples& samples, const DeviceSamples& packed, const Structure& structure,
                const std::vector<double>& theta, std::size_t channel, Metric metric)
        : metric_(metric), columns_(static_cast<Eigen::Index>(packed.used.size()),
                                    static_cast<Eigen::Index>(structure.lobes.size()) + 1),
          y_(columns_.rows()), norm_(packed.norm()) {
        const StructureLayout layout = layout_of(structure);
        for (Eigen::Index i = 0; i < columns_.rows(); ++i) {
            const std::uint32_t k = packed.used[static_cast<std::size_t>(i)];
            const auto [wi, wo] = samples.directions->pair(k);
            columns_(i, 0) =
                wi[2] * reference_value(structure.diffuse->name, structure.isotropic, {}, wi, wo);
            for (std::size_t l = 0; l < structure.lobes.size(); ++l)
                columns_(i, static_cast<Eigen::Index>(l) + 1) =
                    wi[2] * reference_value(structure.lobes[l]->name, structure.isotropic,
                                            {theta.begin() + layout.lobe_begin[l],
                                             theta.begin() + layout.lobe_begin[l + 1]},
                                            wi, wo);
            y_[i] = compressed(metric, wi[2] * static_cast<double>(samples.channel(channel)[k]));
        }
    }

    double loss(const Eigen::VectorXd& a) const {
        const Eigen::VectorXd f = columns_ * a;
        double sum = 0;
        for (Eigen::Index i = 0; i < f.size(); ++i)
            sum += std::pow(compressed(metric_, f[i]) - y_[i], 2);
        return sum / norm_;
    }

    /// The least loss that NLopt finds from many starts, in cubic roots so that it sees all scales.
    double least() const {
        const auto n = static_cast<std::size_t>(columns_.cols());
        const Function function = [&](const std::vector<double>& x, std::vector<double>*) {
            Eigen::VectorXd a(columns_.cols());
            for (std::size_t j = 0; j < n; ++j)
                a[static_cast<Eigen::Index>(j)] = x[j] * x[j] * x[j];
            return loss(a);
        };
        MinimiseOptions options;
        options.algorithm = "LN_SBPLX";
        options.max_evaluations = 1000;
        std::mt19937_64 random(5);
        double least = std::numeric_limits<double>::infinity();
        for (int start = 0; start < 6; ++start) {
            std::vector<double> x;
            for (std::size_t j = 0; j < n; ++j)
                x.push_back(std::uniform_real_distribution<double>(0, 1.2)(random));
            least = std::min(least, minimise(function, x, std::vector<double>(n, 0.0),
                                             std::vector<double>(n, 5.0), options)
                                        .value);
        }
        return least;
    }

  private:
    Metric metric_;
    Eigen::MatrixXd columns_;
    Eigen::VectorXd y_;
    double norm_;
};

class Loss : public testing::TestWithParam<Metric> {
  protected:
    Objective objective(const Structure& structure, const DeviceSamples& packed) const {
        return {device(), programs().get(structure, packed.channels, packed.chunk), packed};
    }
};

INSTANTIATE_TEST_SUITE_P(Metrics, Loss, testing::Values(Metric::Log, Metric::Cbrt),
                         [](const auto& info) { return name_of(info.param); });

/// Theta of lobes that did not make the data, so that fits are poor and bounds are met.
const std::vector<std::vector<double>> strange_theta = {
    {0.3, 0.6}, {0.05, 0.9}, {0.02, 0.04}, {1.5, 3.0}};

/// Data of one Ward lobe with a black channel and one with samples below 0.
Samples with_odd_channels() {
    Samples samples = measured(typical_material(structure_named("ward", 1, "", true), 5), 300);
    for (std::size_t k = 0; k < samples.count(); ++k) {
        samples.channel(3)[k] = 0;
        if (k % 3 == 0)
            samples.channel(4)[k] *= -0.1F;
    }
    return samples;
}

TEST_P(Loss, is_solved_for_kd_and_ks_as_well_as_nlopt_does) {
    const Structure structure = structure_named("ward", 2, "", true);
    const Samples samples = with_odd_channels();
    const DeviceSamples packed = pack_samples(device(), samples, 80, GetParam());
    Objective objective = this->objective(structure, packed);
    for (const std::vector<double>& theta : strange_theta) {
        double least = 0;
        for (std::size_t ch = 0; ch < samples.channels.size(); ++ch)
            least += HostChannel(samples, packed, structure, theta, ch, GetParam()).least();
        Coefficients cold;
        const double from_nothing = objective.projected_loss(GetParam(), theta, cold);
        EXPECT_LT(from_nothing, 1.0002 * least);
        EXPECT_TRUE((cold.array() >= 0).all());
        // A warm start, even from 0 or far away, ends there too.
        for (const double value : {0.0, 1e-3, 10.0}) {
            Coefficients warm = Coefficients::Constant(cold.rows(), cold.cols(), value);
            const double loss = objective.projected_loss(GetParam(), theta, warm);
            EXPECT_LT(loss, 1.0002 * from_nothing) << "from " << value;
            EXPECT_TRUE((warm.array() >= 0).all());
        }
    }
}

TEST_P(Loss, at_solved_kd_and_ks_is_what_they_give) {
    const Structure structure = structure_named("kurt", 2, "", true);
    const Samples samples = measured(typical_material(structure, 6), 500);
    const DeviceSamples packed = pack_samples(device(), samples, 80, GetParam());
    Objective objective = this->objective(structure, packed);
    const std::vector<double> theta = {0.3, 0.3, 0.2, 0.1, 0.7, 0.4};
    Coefficients a, by_a;
    std::vector<double> gradient, by_theta;
    const double solved = objective.projected_loss(GetParam(), theta, a, &gradient);
    EXPECT_EQ(objective.loss(GetParam(), theta, a, by_theta, by_a), solved);
    EXPECT_EQ(by_theta, gradient);
    // Nothing is left to gain but in float32's noise.
    for (Eigen::Index i = 0; i < a.size(); ++i)
        EXPECT_GT(by_a.data()[i] * std::max(a.data()[i], 1e-3), -1e-3 * solved);
}

TEST_P(Loss, has_the_gradient_of_finite_differences_at_solved_kd_and_ks) {
    const Structure structure = structure_named("kurt", 2, "", true);
    const Samples samples = measured(typical_material(structure, 6), 500);
    const DeviceSamples packed = pack_samples(device(), samples, 80, GetParam());
    Objective objective = this->objective(structure, packed);
    const std::vector<double> theta = {0.3, 0.3, 0.2, 0.1, 0.7, 0.4};
    Coefficients a;
    std::vector<double> gradient, slopes;
    objective.projected_loss(GetParam(), theta, a, &gradient);
    double steepest = 0;
    for (std::size_t p = 0; p < theta.size(); ++p) {
        const double step = 2e-3 * theta[p];
        double value[2];
        for (int side = 0; side < 2; ++side) {
            std::vector<double> t = theta;
            t[p] += side == 0 ? -step : step;
            Coefficients warm = a;
            value[side] = objective.projected_loss(GetParam(), t, warm);
        }
        slopes.push_back((value[1] - value[0]) / (2 * step) * theta[p]);
        steepest = std::max(steepest, std::abs(slopes.back()));
    }
    for (std::size_t p = 0; p < theta.size(); ++p)
        EXPECT_NEAR(gradient[p] * theta[p], slopes[p], 0.01 * steepest) << "parameter " << p;
}

TEST_P(Loss, recovers_what_made_noisy_data) {
    const Structure structure = structure_named("kurt", 1, "", true);
    const Material truth = typical_material(structure);
    FitOptions options;
    options.metric = GetParam();
    const FitResult result = fit(measured(truth, 20000), structure, options);
    for (std::size_t i = 0; i < 2; ++i)
        EXPECT_NEAR(result.theta[i], truth.lobes[0].theta[i], 0.02 * truth.lobes[0].theta[i]);
    EXPECT_NEAR(result.theta[2], truth.lobes[0].theta[2], 0.02);
    for (std::size_t ch = 0; ch < 3; ++ch) {
        EXPECT_NEAR(result.material.kd[ch], truth.kd[ch], 0.02 * truth.kd[ch]);
        EXPECT_NEAR(result.material.lobes[0].ks[ch], truth.lobes[0].ks[ch],
                    0.02 * truth.lobes[0].ks[ch]);
    }
}

TEST_P(Loss, is_never_worse_with_a_second_lobe_or_a_free_parameter) {
    const Samples samples = with_odd_channels();
    FitOptions options;
    options.metric = GetParam();
    for (const char* model : {"kurt", "blinn-phong"}) {
        FileFitter fitter(device(), programs(), samples, options);
        const double one =
            test::error_of(fitter.fit(structure_named(model, 1, "", true)), GetParam());
        const double two =
            test::error_of(fitter.fit(structure_named(model, 2, "", true)), GetParam());
        EXPECT_LE(two, one * (1 + 1e-6)) << model;
    }
    const double free = test::error_of(fit(samples, "kurt", 1, options), GetParam());
    for (const char* fixed : {"f0=0.04", "alpha=0", "m=0.3"}) {
        FitOptions narrower = options;
        narrower.ranges = {parse_fix(fixed)};
        EXPECT_LE(free, test::error_of(fit(samples, "kurt", 1, narrower), GetParam()) * (1 + 1e-6))
            << fixed;
    }
}

} // namespace

} // namespace brdfit
