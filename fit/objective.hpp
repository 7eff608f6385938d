#pragma once

#include "fit/conserve.hpp"
#include "fit/metric.hpp"
#include "fit/nonnegative.hpp"
#include "fit/programs.hpp"
#include "fit/samples.hpp"

#include <Eigen/Dense>
#include <array>
#include <chrono>
#include <cstddef>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

namespace brdfit {

/// Thrown out of a fit that is given up; see FitOptions::abandon.
struct FitAbandoned : std::runtime_error {
    FitAbandoned() : std::runtime_error("the fit was given up") {}
};

/// kd and ks: [channel][diffuse, lobes...].
using Coefficients = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Sums a Gauss-Newton step or standard errors need, over the extended basis {b_j, d_e}; already
/// divided by the norm, so that they belong to the mean squared error.
struct NormalSums {
    Eigen::MatrixXd basis;          ///< W b_j b_k
    Eigen::MatrixXd entry_basis;    ///< W d_e b_j
    Eigen::MatrixXd entry_entry;    ///< W d_e d_f
    Eigen::MatrixXd entry_residual; ///< W d_e r_ch, [entry][channel]
    double squared_error = 0;
};

/// Inner products, divided by the norm, of a candidate's shape s and its slope t by f0 (0 where the
/// model has none) with themselves, the diffuse shape b and the channels y, with weights W.
struct ShapeSums {
    double ss, sb, st, tt, tb;
    std::vector<double> sy, ty;
};
/// The same of what no candidate changes: the diffuse shape (a coupled one at f0 = 0), the
/// channels.
struct FixedSums {
    double bb, yy; ///< yy: of all channels together
    std::vector<double> by;
};

/// The mean squared error of one structure on one set of packed samples, as OpenCL passes over
/// them.
///
/// With f = sum_j a_j b_j(theta), b_0 the diffuse shape and a_j = kd, ks >= 0, the error
///     E(theta, a) = sum over samples and channels of W (y - f)^2
/// is quadratic in a: for given theta the best a solves a small non-negative least-squares problem
/// in the Gram matrix W b_j b_k and W y b_j, whatever the number of samples (variable projection,
/// Golub and Pereyra 1973). The optimiser so sees E*(theta) = min over a of E alone, and since
/// dE/da vanishes at that minimum, or a stays at 0 there, the slope of E* is the partial one:
///     dE*/dtheta = dE/dtheta at the solved a = -2 sum W (y - f) a_j db_j/dtheta
/// (envelope theorem). Both need nothing but inner products, which a pass sums on the device.
/// With a limit on R, linear in a too, that slope gains lambda dR/dtheta for each constraint that
/// binds, lambda its multiplier.
class Objective {
  public:
    /// `like`: one on the same samples whose planes (same_planes) this one shares. `abandon`: see
    /// FitOptions.
    Objective(const Device& device, std::shared_ptr<const FitProgram> program,
              const DeviceSamples& samples, const Objective* like = nullptr,
              std::function<bool()> abandon = {});

    const StructureLayout& layout() const { return program_->layout; }
    const Structure& structure() const { return program_->structure; }
    const DeviceSamples& samples() const { return samples_; }

    /// Squared error at theta with the best non-negative kd and ks (variable projection).
    /// `gradient`, where given, receives its derivatives by theta (by the envelope theorem, partial
    /// derivatives at the solved kd and ks). May be non-finite where the model overflows.
    double projected_error(const std::vector<double>& theta,
                           std::vector<double>* gradient = nullptr);
    /// The same with its gradient and the sums a Gauss-Newton step needs, in one pass where the
    /// last solution is near; `sums.entry_residual` and `.squared_error` are left empty. Not with a
    /// limit on R, whose part of the curvature they lack.
    double projected_normal(const std::vector<double>& theta, std::vector<double>& gradient,
                            NormalSums& sums);
    /// kd and ks of the last projected_error or projected_normal.
    const Coefficients& coefficients() const { return coefficients_; }

    /// Squared error of metric `log` or `cbrt` at theta, a; `by_theta`, `by_coefficients` receive
    /// the derivatives.
    double loss(Metric metric, const std::vector<double>& theta, const Coefficients& a,
                std::vector<double>& by_theta, Coefficients& by_coefficients);
    /// Squared error of metric `log` or `cbrt` at theta with the best non-negative kd and ks near
    /// `a`, which receives them; where it comes in empty, near those that projected_error solves.
    /// `gradient`, where given, receives the derivatives by theta. May be non-finite where the
    /// model overflows.
    double projected_loss(Metric metric, const std::vector<double>& theta, Coefficients& a,
                          std::vector<double>* gradient = nullptr);

    /// Sums are taken about these kd and ks next: solutions near them lose no digits, and need no
    /// second pass. What was evaluated before has no influence from here on.
    void start_near(const Coefficients& a);

    /// From here on kd and ks are solved with the material's R at or below 1 for the limit's
    /// viewers, and gradients follow that; without one, freely.
    void limit_albedos(std::shared_ptr<const AlbedoLimit> limit) { limit_ = std::move(limit); }
    bool is_limited() const { return limit_ != nullptr; }

    /// All errors at theta, a, from the residuals themselves.
    MetricErrors metric_errors(const std::vector<double>& theta, const Coefficients& a);

    NormalSums normal_sums(const std::vector<double>& theta, const Coefficients& a);

    /// Sums for the global search over one lobe, of each candidate theta, in one batched pass.
    std::vector<ShapeSums> shape_sums(const std::vector<std::vector<double>>& candidates);
    FixedSums fixed_sums();

    /// Rows for the global search, each times sqrt(W): to rows[0..channels], the channels and the
    /// diffuse shape (a coupled one at f0 = 0).
    void write_fixed_rows(const cl::Buffer& rows);
    /// To rows[first..], the last lobe's shape at each candidate theta of that lobe.
    void write_shape_rows(const cl::Buffer& rows, std::size_t first,
                          const std::vector<std::vector<double>>& candidates);

    /// Calls of projected_error, projected_normal, projected_loss and loss so far.
    std::size_t evaluations() const { return evaluations_; }
    /// Passes over the samples that were timed (not the first of each kernel), and their seconds.
    std::size_t timed_passes() const { return timed_passes_; }
    double seconds() const { return seconds_; }

  private:
    struct Reduced {
        Eigen::ArrayXXd sums; ///< [sum][chunk]
    };
    // What a loss pass sums for one channel, and the loss and derivatives by theta of all.
    struct ChannelLoss {
        double loss = 0;
        SmallVector pull;  ///< minus half the gradient by a
        SmallMatrix curve; ///< half the Hessian by a, made positive
    };
    struct LossSums {
        std::vector<ChannelLoss> channels;
        std::vector<double> by_theta;
    };
    void prepare();
    cl::Kernel& kernel(const char* name, bool* fresh = nullptr);
    Reduced run(const char* name, const std::vector<double>& theta, const Coefficients& a,
                std::size_t sums, int chunks, bool raw_weights, std::optional<bool> secant = {});
    void count_first_run(std::chrono::steady_clock::time_point started) const;
    void compress(Metric metric);
    LossSums loss_sums(Metric metric, const std::vector<double>& theta, const Coefficients& a,
                       bool secant);
    std::size_t candidates_a_batch() const;
    void upload_parameters(const std::vector<double>& theta, const Coefficients& a);
    double solve(const Eigen::ArrayXXd& sums, Coefficients& a);
    double solve_at(const std::vector<double>& theta, const char* pass, std::size_t count,
                    Reduced& reduced);
    void add_gradient(const Reduced& fused, std::vector<double>& gradient) const;
    NormalSums normal_from(const Eigen::ArrayXXd& sums) const;
    void keep_reference(double error);
    double newton_step(const std::vector<ChannelLoss>& at, const std::vector<double>& damping,
                       Coefficients& a);
    LimitedSolution solved(int channel, const SmallMatrix& gram, const SmallVector& projected,
                           const SmallVector& reference);
    void take_limit(const std::vector<double>& theta);
    void add_limit_gradient(const std::vector<double>& theta, const Coefficients& a,
                            std::vector<double>& gradient) const;
    ShapeSums shape_of(const Eigen::ArrayXXd& sums, std::size_t candidate) const;

    const Device& device_;
    std::shared_ptr<const FitProgram> program_;
    DeviceSamples samples_;
    std::function<bool()> abandon_;
    cl::Buffer planes_, theta_, coefficient_buffer_, out_;
    std::size_t out_size_ = 0;
    cl::Buffer compressed_; // phi(iz y) of a metric that is not quadratic, as samples_.values
    std::optional<Metric> compressed_for_;
    std::vector<std::pair<const char*, cl::Kernel>> kernels_;
    std::vector<float> staged_theta_, staged_coefficients_, staged_out_;
    std::shared_ptr<const AlbedoLimit> limit_;
    Eigen::MatrixXd albedos_;     // of the limit at the last theta: [viewer][component]
    Eigen::MatrixXd multipliers_; // [viewer][channel], of the last solution
    Coefficients coefficients_, reference_;
    double reference_error_;
    double data_error_ = std::numeric_limits<double>::infinity(); // with kd = ks = 0
    std::size_t evaluations_ = 0, timed_passes_ = 0;
    double seconds_ = 0;
};

} // namespace brdfit
