// The passes of Objective for metrics that are not quadratic.
#include "fit/objective.hpp"

#include "host/device/buffer.hpp"
#include "kernels/passes/sums.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace brdfit {

namespace {

// Passes that solve kd and ks of a loss that is not quadratic, the first ones from nothing with
// secant curvatures and no coefficient below a share of the largest. They end when a step would
// gain less than loss_gain of the loss; channels where it would gain less than channel_gain rest.
constexpr int most_loss_passes = 30, cold_secant_passes = 4;
constexpr double lifted_share = 0.01, loss_gain = 1e-8, channel_gain = 1e-10;
// Damping of Newton's step, as a share of the diagonal, after a first step that failed.
constexpr double first_damping = 0.1, least_damping = 0.01;

} // namespace

// Fills compressed_ for the metric.
void Objective::compress(Metric metric) {
    if (compressed_for_ == metric)
        return;
    const auto width = static_cast<std::size_t>(device_.form.vector_width);
    if (!compressed_for_)
        compressed_ =
            make_buffer(device_, static_cast<std::size_t>(samples_.chunk * samples_.chunks) *
                                     samples_.stride * sizeof(float));
    cl::Kernel& k = kernel(metric == Metric::Log ? "log_compress" : "cbrt_compress");
    k.setArg(0, samples_.values);
    k.setArg(1, samples_.iz);
    k.setArg(2, static_cast<cl_uint>(samples_.stride / width));
    k.setArg(3, compressed_);
    const std::lock_guard<std::mutex> lock(program_->running);
    enqueue_runs(device_, k, samples_.stride / width);
    device_.queue.finish();
    compressed_for_ = metric;
}

Objective::LossSums Objective::loss_sums(Metric metric, const std::vector<double>& theta,
                                         const Coefficients& a, bool secant) {
    const int basis = layout().basis;
    const std::vector<DerivativeEntry>& entries = layout().entries;
    const int chunk = std::min(samples_.chunk, LARGEST_LOSS_CHUNK);
    compress(metric);
    const auto channel_sums = static_cast<std::size_t>(CHANNEL_SUMS(basis));
    const Reduced reduced = run(
        metric == Metric::Log ? "log_loss" : "cbrt_loss", theta, a,
        LOSS_SUMS(static_cast<std::size_t>(basis), static_cast<std::size_t>(chunk), entries.size()),
        (samples_.channels + chunk - 1) / chunk, true, secant);
    LossSums result;
    result.by_theta.assign(theta.size(), 0);
    for (std::size_t e = 0; e < entries.size(); ++e)
        result.by_theta[static_cast<std::size_t>(entries[e].parameter)] +=
            2 * reduced.sums.row(static_cast<Eigen::Index>(e)).sum();
    for (int ch = 0; ch < samples_.channels; ++ch) {
        const auto column = reduced.sums.col(ch / chunk);
        auto k = static_cast<Eigen::Index>(entries.size() +
                                           static_cast<std::size_t>(ch % chunk) * channel_sums);
        ChannelLoss channel{column(k++), SmallVector(basis), SmallMatrix(basis, basis)};
        for (int j = 0; j < basis; ++j)
            channel.pull[j] = -column(k++);
        for (int j = 0; j < basis; ++j)
            for (int l = 0; l <= j; ++l)
                channel.curve(j, l) = channel.curve(l, j) = column(k++);
        result.channels.push_back(channel);
    }
    return result;
}

double Objective::loss(Metric metric, const std::vector<double>& theta, const Coefficients& a,
                       std::vector<double>& by_theta, Coefficients& by_coefficients) {
    ++evaluations_;
    LossSums sums = loss_sums(metric, theta, a, false);
    by_theta = std::move(sums.by_theta);
    by_coefficients.resize(samples_.channels, layout().basis);
    double loss = 0;
    for (int ch = 0; ch < samples_.channels; ++ch) {
        const ChannelLoss& channel = sums.channels[static_cast<std::size_t>(ch)];
        loss += channel.loss;
        by_coefficients.row(ch) = -2 * channel.pull.transpose();
    }
    return loss;
}

// Moves each channel's coefficients by a damped Newton step where that is worth it; returns the
// gain it promises.
double Objective::newton_step(const std::vector<ChannelLoss>& at,
                              const std::vector<double>& damping, Coefficients& a) {
    double gain = 0;
    for (std::size_t ch = 0; ch < at.size(); ++ch) {
        const auto row = static_cast<Eigen::Index>(ch);
        SmallMatrix curve = at[ch].curve;
        curve.diagonal() *= 1 + damping[ch];
        const LimitedSolution step =
            solved(static_cast<int>(ch), curve, at[ch].pull, a.row(row).transpose());
        if (!(step.squared_error < -channel_gain * at[ch].loss))
            continue;
        gain -= step.squared_error;
        a.row(row) = step.a.transpose();
    }
    return gain;
}

// Each channel by its own damped Newton steps in its few non-negative unknowns; a pass over the
// samples tries a step of every channel.
double Objective::projected_loss(Metric metric, const std::vector<double>& theta, Coefficients& a,
                                 std::vector<double>* gradient) {
    ++evaluations_;
    const auto channels = static_cast<std::size_t>(samples_.channels);
    const bool cold = a.size() == 0;
    if (cold) {
        projected_error(theta);
        --evaluations_;
        // Samples below 0 make 0 a local minimum of cbrt: from within.
        a = coefficients_.cwiseMax(lifted_share * coefficients_.maxCoeff());
    } else {
        take_limit(theta);
    }
    if (limit_)
        a = scaled_below_1(a, albedos_);
    const auto total = [](const std::vector<ChannelLoss>& of) {
        double sum = 0;
        for (const ChannelLoss& channel : of)
            sum += channel.loss;
        return sum;
    };
    int secant_passes = cold ? cold_secant_passes : 0;
    LossSums sums = loss_sums(metric, theta, a, secant_passes > 0);
    std::vector<ChannelLoss> best = sums.channels;
    double error = total(best);
    std::vector<double> damping(channels, 0);
    bool by_theta_of_best = true;
    for (int pass = 0; pass < most_loss_passes && std::isfinite(error); ++pass) {
        Coefficients tried = a;
        if (!(newton_step(best, damping, tried) > loss_gain * error))
            break;
        sums = loss_sums(metric, theta, tried, --secant_passes > 0);
        by_theta_of_best = true;
        for (std::size_t ch = 0; ch < channels; ++ch) {
            const auto row = static_cast<Eigen::Index>(ch);
            if (sums.channels[ch].loss <= best[ch].loss) {
                best[ch] = sums.channels[ch];
                a.row(row) = tried.row(row);
                damping[ch] = damping[ch] < least_damping ? 0 : 0.1 * damping[ch];
            } else {
                by_theta_of_best = false;
                damping[ch] = std::max(10 * damping[ch], first_damping);
            }
        }
        error = total(best);
    }
    if (!std::isfinite(error)) {
        a.resize(0, 0);
        if (gradient != nullptr)
            gradient->assign(theta.size(), 0);
        return error;
    }
    if (gradient != nullptr) {
        if (!by_theta_of_best)
            sums = loss_sums(metric, theta, a, false);
        *gradient = sums.by_theta;
        add_limit_gradient(theta, a, *gradient);
    }
    return error;
}

} // namespace brdfit
