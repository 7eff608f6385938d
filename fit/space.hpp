#pragma once

#include "host/model/catalogue.hpp"

#include <Eigen/Dense>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace brdfit {

/// A wish about a parameter from the command line: `f0=0.04` or `alpha=0:1`. `m` and `n` mean both
/// roughnesses of an anisotropic form; a lobe number in front (`2.m=0.1:1`, from 1) means that
/// lobe.
struct ParameterRange {
    std::string name;
    int lobe = 0; ///< 0: every lobe
    double lower, upper;
    bool fixed; ///< lower == upper by --fix
};

/// Parses `--fix NAME=VALUE` and `--bound NAME=LOW:HIGH`. Throws UsageError saying what is wrong.
ParameterRange parse_fix(const std::string& text);
ParameterRange parse_bound(const std::string& text);
/// The range as these two read it.
std::string text_of(const ParameterRange& range);

/// The optimiser's coordinates x of the parameters theta that are free: logarithms of roughnesses
/// and exponents, the others as they are.
class Space {
  public:
    Space() = default;
    /// The parameters of lobe models `lobes` in one form, concatenated, in their catalogue ranges
    /// narrowed by `ranges`. Throws UsageError where these contradict each other or the catalogue.
    Space(const std::vector<const Model*>& lobes, bool isotropic,
          const std::vector<ParameterRange>& ranges);

    struct Dimension {
        Parameter parameter; ///< with the narrowed range
        int lobe;            ///< from 0
        bool fixed;          ///< lower == upper
    };
    const std::vector<Dimension>& dimensions() const { return dimensions_; }
    /// The part of the space that belongs to one lobe.
    Space of_lobe(int lobe) const;

    std::vector<double> to_x(const std::vector<double>& theta) const; ///< free parameters only
    std::vector<double> to_theta(const std::vector<double>& x) const;
    /// Derivatives by x from derivatives by theta.
    std::vector<double> gradient_by_x(const std::vector<double>& theta,
                                      const std::vector<double>& by_theta) const;
    /// Second derivatives by x from those by theta, but for the scales' own.
    Eigen::MatrixXd curvature_by_x(const std::vector<double>& theta,
                                   const Eigen::MatrixXd& by_theta) const;
    std::vector<double> lower() const; ///< of x
    std::vector<double> upper() const;
    /// theta moved into the ranges.
    std::vector<double> clamped(std::vector<double> theta) const;
    /// theta with what ended within rounding of the end of its range put there.
    std::vector<double> snapped(std::vector<double> theta) const;
    /// Start `number` of a sequence of random starts over all of the space, the same for one seed.
    std::vector<double> random(std::uint64_t seed, std::uint64_t number) const;

  private:
    std::vector<Dimension> dimensions_;
};

/// The scales' coordinate x of a parameter value, and back.
double to_scale(Scale scale, double value);
double from_scale(Scale scale, double x);
/// d value / d x there.
double slope_of_scale(Scale scale, double value);

/// Of one lobe's space, the first of two roughnesses, exponents or factors side by side that mean
/// the same along x and y and have the same range; nothing where bounds tell them apart.
std::optional<std::size_t> exchangeable(const Space& lobe);

/// Whether any of the models has a parameter that the range names, in either form.
bool names_parameter_of(const ParameterRange& range, const std::vector<const Model*>& models);

} // namespace brdfit
