#include "fit/objective.hpp"

#include "host/device/buffer.hpp"
#include "kernels/passes/sums.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <limits>

namespace brdfit {

namespace {

// Up to here one pass gathers error and gradient; beyond, accumulators spill and two passes are
// faster.
constexpr std::size_t most_fused_sums = 40;
// Where the reference explains this much less than the solution, the sums cancel: ask once more.
constexpr double stale_reference = 30;
constexpr int most_references = 4;
static_assert(METRIC_SUMS == metric_count);

std::size_t triangle(int n) {
    return static_cast<std::size_t>(TRIANGLE(n));
}

} // namespace

Objective::Objective(const Device& device, std::shared_ptr<const FitProgram> program,
                     const DeviceSamples& samples, const Objective* like,
                     std::function<bool()> abandon)
    : device_(device), program_(std::move(program)), samples_(samples),
      abandon_(std::move(abandon)), reference_error_(std::numeric_limits<double>::infinity()) {
    const StructureLayout& l = layout();
    const std::size_t all_channels = static_cast<std::size_t>(samples_.chunk * samples_.chunks);
    theta_ = make_buffer(device_, std::max<std::size_t>(l.parameters.size(), 1) * sizeof(float),
                         CL_MEM_READ_ONLY);
    coefficient_buffer_ =
        make_buffer(device_, all_channels * static_cast<std::size_t>(l.basis) * sizeof(float),
                    CL_MEM_READ_ONLY);
    reference_ = Coefficients::Zero(samples_.channels, l.basis);
    coefficients_ = reference_;

    if (like != nullptr)
        planes_ = like->planes_;
    else
        prepare();
}

void Objective::prepare() {
    planes_ = make_buffer(device_, static_cast<std::size_t>(layout().planes) * samples_.stride *
                                       sizeof(float));
    const auto width = static_cast<std::size_t>(device_.form.vector_width);
    const auto started = std::chrono::steady_clock::now();
    cl::Kernel& prepare = kernel("prepare");
    prepare.setArg(0, samples_.directions);
    prepare.setArg(1, static_cast<cl_uint>(samples_.pairs));
    prepare.setArg(2, samples_.index);
    prepare.setArg(3, planes_);
    prepare.setArg(4, static_cast<cl_uint>(samples_.stride / width));
    const std::lock_guard<std::mutex> lock(program_->running);
    enqueue_runs(device_, prepare, samples_.stride / width);
    device_.queue.finish();
    count_first_run(started);
}

cl::Kernel& Objective::kernel(const char* name, bool* fresh) {
    for (auto& entry : kernels_)
        if (std::strcmp(entry.first, name) == 0)
            return entry.second;
    if (fresh != nullptr)
        *fresh = true;
    kernels_.emplace_back(name, cl::Kernel(program_->program, name));
    return kernels_.back().second;
}

void Objective::upload_parameters(const std::vector<double>& theta, const Coefficients& a) {
    staged_theta_.assign(theta.begin(), theta.end());
    staged_coefficients_.assign(
        static_cast<std::size_t>(samples_.chunk * samples_.chunks * layout().basis), 0.0F);
    for (Eigen::Index i = 0; i < a.size(); ++i)
        staged_coefficients_[static_cast<std::size_t>(i)] = static_cast<float>(a.data()[i]);
    if (!staged_theta_.empty())
        device_.queue.enqueueWriteBuffer(theta_, CL_FALSE, 0, staged_theta_.size() * sizeof(float),
                                         staged_theta_.data());
    device_.queue.enqueueWriteBuffer(coefficient_buffer_, CL_FALSE, 0,
                                     staged_coefficients_.size() * sizeof(float),
                                     staged_coefficients_.data());
}

Objective::Reduced Objective::run(const char* name, const std::vector<double>& theta,
                                  const Coefficients& a, std::size_t sums, int chunk_count,
                                  bool raw_weights, std::optional<bool> secant) {
    if (abandon_ && abandon_())
        throw FitAbandoned();
    const auto started = std::chrono::steady_clock::now();
    const auto width = static_cast<std::size_t>(device_.form.vector_width);
    const auto local = static_cast<std::size_t>(device_.form.local_size);
    const auto chunks = static_cast<std::size_t>(chunk_count);
    const std::size_t outputs = samples_.groups * chunks * sums;
    if (outputs > out_size_) {
        out_ = make_buffer(device_, outputs * sizeof(float), CL_MEM_WRITE_ONLY);
        out_size_ = outputs;
    }
    upload_parameters(theta, a);
    bool fresh = false;
    cl::Kernel& k = kernel(name, &fresh);
    cl_uint argument = 0;
    k.setArg(argument++, planes_);
    k.setArg(argument++, secant ? compressed_ : samples_.values);
    if (raw_weights) {
        k.setArg(argument++, samples_.solid_angle);
        k.setArg(argument++, samples_.iz);
    } else {
        k.setArg(argument++, samples_.weights);
    }
    k.setArg(argument++, static_cast<cl_uint>(samples_.stride / width));
    k.setArg(argument++, theta_);
    k.setArg(argument++, coefficient_buffer_);
    k.setArg(argument++, out_);
    if (secant) // a loss pass
        k.setArg(argument++, static_cast<cl_int>(*secant));
    staged_out_.resize(outputs);
    {
        const std::lock_guard<std::mutex> lock(program_->running);
        device_.queue.enqueueNDRangeKernel(
            k, cl::NullRange, cl::NDRange(samples_.groups * local, chunks), cl::NDRange(local, 1));
        device_.queue.enqueueReadBuffer(out_, CL_TRUE, 0, outputs * sizeof(float),
                                        staged_out_.data());
    }

    Reduced reduced{
        Eigen::ArrayXXd::Zero(static_cast<Eigen::Index>(sums), static_cast<Eigen::Index>(chunks))};
    for (std::size_t chunk = 0; chunk < chunks; ++chunk)
        for (std::size_t group = 0; group < samples_.groups; ++group)
            reduced.sums.col(static_cast<Eigen::Index>(chunk)) +=
                Eigen::Map<const Eigen::ArrayXf>(staged_out_.data() +
                                                     (chunk * samples_.groups + group) * sums,
                                                 static_cast<Eigen::Index>(sums))
                    .cast<double>();
    reduced.sums /= samples_.norm();
    if (fresh) {
        count_first_run(started);
    } else {
        ++timed_passes_;
        seconds_ +=
            std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
    }
    return reduced;
}

// The first run of a kernel may compile it.
void Objective::count_first_run(std::chrono::steady_clock::time_point started) const {
    program_->build_seconds->add(
        std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count());
}

// Of one channel, within the limit.
LimitedSolution Objective::solved(int channel, const SmallMatrix& gram,
                                  const SmallVector& projected, const SmallVector& reference) {
    if (!limit_) {
        NonNegativeSolution free = solve_nonnegative(gram, projected, 0, reference);
        return {std::move(free.a), free.squared_error, {}};
    }
    LimitedSolution solution = solve_limited(gram, projected, 0, reference, albedos_);
    multipliers_.col(channel) = solution.multipliers;
    return solution;
}

// The limit's albedos at theta.
void Objective::take_limit(const std::vector<double>& theta) {
    if (!limit_)
        return;
    albedos_ = limit_->at(theta);
    multipliers_ = Eigen::MatrixXd::Zero(albedos_.rows(), samples_.channels);
}

// Adds lambda dR/dtheta of the constraints that bind.
void Objective::add_limit_gradient(const std::vector<double>& theta, const Coefficients& a,
                                   std::vector<double>& gradient) const {
    if (!limit_)
        return;
    std::vector<Vector> wo;
    std::vector<Eigen::Index> binding;
    for (Eigen::Index k = 0; k < multipliers_.rows(); ++k)
        if (multipliers_.row(k).maxCoeff() > 0) {
            wo.push_back(limit_->wo[static_cast<std::size_t>(k)]);
            binding.push_back(k);
        }
    if (wo.empty())
        return;
    const Eigen::MatrixXd slopes = limit_->albedos.smooth_by_theta(theta, wo, limit_->points);
    const std::vector<DerivativeEntry>& entries = layout().entries;
    for (std::size_t e = 0; e < entries.size(); ++e)
        for (std::size_t k = 0; k < binding.size(); ++k) {
            const double pull = multipliers_.row(binding[k]) * a.col(entries[e].basis);
            if (pull > 0)
                gradient[static_cast<std::size_t>(entries[e].parameter)] +=
                    pull * slopes(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(e));
        }
}

// Solves kd and ks of every channel from basis sums taken about reference_; returns the squared
// error.
double Objective::solve(const Eigen::ArrayXXd& sums, Coefficients& a) {
    const int basis = layout().basis;
    const auto gram_sums = static_cast<Eigen::Index>(triangle(basis));
    SmallMatrix gram(basis, basis);
    SmallVector projected(basis), reference(basis);
    for (int j = 0, k = 0; j < basis; ++j)
        for (int l = 0; l <= j; ++l, ++k)
            gram(j, l) = gram(l, j) = sums(k, 0);
    double error = 0;
    a.resize(samples_.channels, basis);
    for (int ch = 0; ch < samples_.channels; ++ch) {
        const Eigen::Index chunk = ch / samples_.chunk;
        const Eigen::Index first = gram_sums + (ch % samples_.chunk) * basis;
        for (int j = 0; j < basis; ++j) {
            projected[j] = sums(first + j, chunk);
            reference[j] = reference_(ch, j);
        }
        // r'r is summed over the chunk's channels by the kernel: added once below.
        const LimitedSolution solution = solved(ch, gram, projected, reference);
        error += solution.squared_error;
        a.row(ch) = solution.a.transpose();
    }
    return error + sums.row(gram_sums + samples_.chunk * basis).sum();
}

// Solves kd and ks at theta from sums about reference_, which is moved closer until nothing
// cancels; the sums are left in `reduced`. Returns the squared error.
double Objective::solve_at(const std::vector<double>& theta, const char* pass, std::size_t count,
                           Reduced& reduced) {
    const Eigen::Index residual_row = BASIS_SUMS(layout().basis, samples_.chunk) - 1;
    for (int passes = 1;; ++passes) {
        reduced = run(pass, theta, reference_, count, samples_.chunks, false);
        const double error = solve(reduced.sums, coefficients_);
        const double about_reference = reduced.sums.row(residual_row).sum();
        const bool about_nothing = reference_.isZero(0);
        if (about_nothing)
            data_error_ = about_reference;
        const bool stale = !(about_reference <= stale_reference * std::max(error, 0.0));
        if (!stale || passes == most_references || (about_nothing && !std::isfinite(error)))
            return error;
        // What suits another theta may be worse than nothing here.
        if (std::isfinite(error) && about_reference <= data_error_)
            reference_ = coefficients_;
        else
            reference_.setZero();
    }
}

// Adds -2 sum a W d_e r to the gradient, from sums of r about reference_.
void Objective::add_gradient(const Reduced& fused, std::vector<double>& gradient) const {
    const int basis = layout().basis, chunk = samples_.chunk;
    const std::vector<DerivativeEntry>& entries = layout().entries;
    const Eigen::Index basis_sums = BASIS_SUMS(basis, chunk);
    const Eigen::Index entry_sums = ENTRY_SUMS(basis, chunk);
    const Coefficients change = coefficients_ - reference_;
    for (std::size_t e = 0; e < entries.size(); ++e) {
        const Eigen::Index first = basis_sums + static_cast<Eigen::Index>(e) * entry_sums;
        double sum = 0; // over channels of a W d_e r
        for (int ch = 0; ch < samples_.channels; ++ch) {
            double residual = fused.sums(first + basis + ch % chunk, ch / chunk);
            for (int j = 0; j < basis; ++j)
                residual -= change(ch, j) * fused.sums(first + j, 0);
            sum += coefficients_(ch, entries[e].basis) * residual;
        }
        gradient[static_cast<std::size_t>(entries[e].parameter)] -= 2 * sum;
    }
}

double Objective::projected_error(const std::vector<double>& theta, std::vector<double>* gradient) {
    ++evaluations_;
    const int basis = layout().basis;
    const int chunk = samples_.chunk;
    const std::vector<DerivativeEntry>& entries = layout().entries;
    const auto basis_sums = static_cast<std::size_t>(BASIS_SUMS(basis, chunk));
    const auto gradient_sums =
        static_cast<std::size_t>(GRADIENT_SUMS(basis, chunk, static_cast<int>(entries.size())));
    const bool fused =
        gradient != nullptr && samples_.chunks == 1 && gradient_sums <= most_fused_sums;
    if (gradient != nullptr)
        gradient->assign(theta.size(), 0);
    take_limit(theta);

    Reduced reduced;
    double error = solve_at(theta, fused ? "gradient_sums" : "basis_sums",
                            fused ? gradient_sums : basis_sums, reduced);
    if (!std::isfinite(error)) {
        coefficients_.setZero();
        return error;
    }
    if (fused) {
        add_gradient(reduced, *gradient);
    } else if (gradient != nullptr && !entries.empty()) {
        const Reduced pulled =
            run("residual_gradient", theta, coefficients_, RESIDUAL_SUMS(entries.size()), 1, false);
        error = pulled.sums(0, 0);
        for (std::size_t e = 0; e < entries.size(); ++e)
            (*gradient)[static_cast<std::size_t>(entries[e].parameter)] +=
                2 * pulled.sums(static_cast<Eigen::Index>(1 + e), 0);
    }
    if (gradient != nullptr)
        add_limit_gradient(theta, coefficients_, *gradient);
    keep_reference(error);
    return error;
}

void Objective::start_near(const Coefficients& a) {
    reference_ = a;
    reference_error_ = data_error_ = std::numeric_limits<double>::infinity();
}

void Objective::keep_reference(double error) {
    if (error < reference_error_) {
        reference_error_ = error;
        reference_ = coefficients_;
    }
}

double Objective::projected_normal(const std::vector<double>& theta, std::vector<double>& gradient,
                                   NormalSums& sums) {
    ++evaluations_;
    gradient.assign(theta.size(), 0);
    const int entries = static_cast<int>(layout().entries.size());
    Reduced reduced;
    const double error = solve_at(
        theta, "normal_sums",
        static_cast<std::size_t>(NORMAL_SUMS(layout().basis, samples_.chunk, entries)), reduced);
    if (!std::isfinite(error)) {
        coefficients_.setZero();
        return error;
    }
    add_gradient(reduced, gradient);
    sums = normal_from(reduced.sums);
    keep_reference(error);
    return error;
}

MetricErrors Objective::metric_errors(const std::vector<double>& theta, const Coefficients& a) {
    const Reduced reduced = run("metric_sums", theta, a, METRIC_SUMS, 1, true);
    MetricErrors errors;
    for (int i = 0; i < metric_count; ++i)
        errors[static_cast<std::size_t>(i)] = std::sqrt(reduced.sums(i, 0));
    return errors;
}

NormalSums Objective::normal_sums(const std::vector<double>& theta, const Coefficients& a) {
    const int basis = layout().basis;
    const int chunk = samples_.chunk;
    const int entries = static_cast<int>(layout().entries.size());
    const Reduced reduced =
        run("normal_sums", theta, a, static_cast<std::size_t>(NORMAL_SUMS(basis, chunk, entries)),
            samples_.chunks, false);
    NormalSums normal = normal_from(reduced.sums);
    normal.squared_error = reduced.sums.row(BASIS_SUMS(basis, chunk) - 1).sum();
    normal.entry_residual.resize(entries, samples_.channels);
    for (int e = 0; e < entries; ++e)
        for (int ch = 0; ch < samples_.channels; ++ch)
            normal.entry_residual(e, ch) = reduced.sums(
                BASIS_SUMS(basis, chunk) + e * ENTRY_SUMS(basis, chunk) + basis + ch % chunk,
                ch / chunk);
    return normal;
}

// The sums that have nothing to do with the residuals.
NormalSums Objective::normal_from(const Eigen::ArrayXXd& sums) const {
    const int basis = layout().basis;
    const int chunk = samples_.chunk;
    const int entries = static_cast<int>(layout().entries.size());
    const Eigen::Index basis_sums = BASIS_SUMS(basis, chunk);
    const Eigen::Index gradient_sums = GRADIENT_SUMS(basis, chunk, entries);
    NormalSums normal;
    normal.basis.resize(basis, basis);
    for (int j = 0, k = 0; j < basis; ++j)
        for (int l = 0; l <= j; ++l, ++k)
            normal.basis(j, l) = normal.basis(l, j) = sums(k, 0);
    normal.entry_basis.resize(entries, basis);
    normal.entry_entry.resize(entries, entries);
    for (int e = 0, k = 0; e < entries; ++e) {
        for (int j = 0; j < basis; ++j)
            normal.entry_basis(e, j) = sums(basis_sums + e * ENTRY_SUMS(basis, chunk) + j, 0);
        for (int f = 0; f <= e; ++f, ++k)
            normal.entry_entry(e, f) = normal.entry_entry(f, e) = sums(gradient_sums + k, 0);
    }
    return normal;
}

} // namespace brdfit
