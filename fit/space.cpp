#include "fit/space.hpp"

#include "host/directions.hpp"
#include "host/error.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <random>

namespace brdfit {

namespace {

constexpr double about_one = 0.01; // where Scale::AboutOne turns from even spacing to logarithmic

double parse_number(const std::string& text, const std::string& whole) {
    double value = 0;
    const char* const end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, value);
    if (error != std::errc() || stop != end || !std::isfinite(value))
        throw UsageError(fmt::format("'{}': '{}' is not a finite number", whole, text));
    return value;
}

// Name and lobe in front of '='; the rest goes to `value`.
ParameterRange parse_name(const std::string& text, const char* form, std::string& value) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == text.size())
        throw UsageError(fmt::format("'{}': expected {}", text, form));
    ParameterRange range{text.substr(0, equals), 0, 0, 0, false};
    value = text.substr(equals + 1);
    const std::size_t dot = range.name.find('.');
    if (dot != std::string::npos) {
        const double lobe = parse_number(range.name.substr(0, dot), text);
        if (lobe != std::floor(lobe) || lobe < 1 || lobe > 4)
            throw UsageError(fmt::format("'{}': the lobe before the dot is 1 to 4", text));
        range.lobe = static_cast<int>(lobe);
        range.name = range.name.substr(dot + 1);
    }
    return range;
}

// Whether `name` on the command line means the parameter `parameter` of a model's form.
bool means(const std::string& name, const std::string& parameter) {
    return name == parameter || (name == "m" && (parameter == "mx" || parameter == "my")) ||
           (name == "n" &&
            (parameter == "nu" || parameter == "nv" || parameter == "nx" || parameter == "ny")) ||
           (name == "a" && (parameter == "ax" || parameter == "ay")) ||
           (name == "C" && (parameter == "Cx" || parameter == "Cy"));
}

} // namespace

ParameterRange parse_fix(const std::string& text) {
    std::string value;
    ParameterRange range = parse_name(text, "NAME=VALUE, for example f0=0.04", value);
    range.lower = range.upper = parse_number(value, text);
    range.fixed = true;
    return range;
}

ParameterRange parse_bound(const std::string& text) {
    std::string value;
    ParameterRange range = parse_name(text, "NAME=LOW:HIGH, for example alpha=0:1", value);
    const std::size_t colon = value.find(':');
    if (colon == std::string::npos)
        throw UsageError(fmt::format("'{}': expected NAME=LOW:HIGH, for example alpha=0:1", text));
    range.lower = parse_number(value.substr(0, colon), text);
    range.upper = parse_number(value.substr(colon + 1), text);
    if (range.lower > range.upper)
        throw UsageError(fmt::format("'{}': the lower bound is above the upper", text));
    return range;
}

std::string text_of(const ParameterRange& range) {
    const std::string name =
        range.lobe == 0 ? range.name : fmt::format("{}.{}", range.lobe, range.name);
    return range.fixed ? fmt::format("{}={}", name, range.lower)
                       : fmt::format("{}={}:{}", name, range.lower, range.upper);
}

double to_scale(Scale scale, double value) {
    switch (scale) {
    case Scale::Log:
        return std::log(value);
    case Scale::Log1p:
        return std::log1p(value);
    case Scale::AboutOne:
        return std::copysign(
            std::asinh((std::abs(value) - 1) / about_one) + std::asinh(1 / about_one), value);
    case Scale::Angle:
        return value * degree;
    case Scale::Linear:
        break;
    }
    return value;
}

double from_scale(Scale scale, double x) {
    switch (scale) {
    case Scale::Log:
        return std::exp(x);
    case Scale::Log1p:
        return std::expm1(x);
    case Scale::AboutOne:
        return std::copysign(1 + about_one * std::sinh(std::abs(x) - std::asinh(1 / about_one)), x);
    case Scale::Angle:
        return x / degree;
    case Scale::Linear:
        break;
    }
    return x;
}

double slope_of_scale(Scale scale, double value) {
    switch (scale) {
    case Scale::Log:
        return value;
    case Scale::Log1p:
        return 1 + value;
    case Scale::AboutOne:
        return std::hypot(about_one, std::abs(value) - 1);
    case Scale::Angle:
        return 1 / degree;
    case Scale::Linear:
        break;
    }
    return 1;
}

Space::Space(const std::vector<const Model*>& lobes, bool isotropic,
             const std::vector<ParameterRange>& ranges) {
    for (std::size_t l = 0; l < lobes.size(); ++l)
        for (Parameter parameter : lobes[l]->parameters(isotropic)) {
            const Parameter whole = parameter;
            for (const ParameterRange& range : ranges) {
                if (!means(range.name, whole.name) ||
                    (range.lobe != 0 && range.lobe != static_cast<int>(l) + 1))
                    continue;
                if (range.lower < whole.lower || range.upper > whole.upper)
                    throw UsageError(fmt::format("{} of {}: {} to {} is outside its range [{}, {}]",
                                                 range.name, lobes[l]->name, range.lower,
                                                 range.upper, whole.lower, whole.upper));
                parameter.lower = std::max(parameter.lower, range.lower);
                parameter.upper = std::min(parameter.upper, range.upper);
                if (parameter.lower > parameter.upper)
                    throw UsageError(
                        fmt::format("{} of {}: the bounds given leave nothing between them",
                                    range.name, lobes[l]->name));
            }
            parameter.start = std::clamp(parameter.start, parameter.lower, parameter.upper);
            dimensions_.push_back(
                {parameter, static_cast<int>(l), parameter.lower == parameter.upper});
        }
}

Space Space::of_lobe(int lobe) const {
    Space part;
    for (Dimension dimension : dimensions_)
        if (dimension.lobe == lobe) {
            dimension.lobe = 0;
            part.dimensions_.push_back(dimension);
        }
    return part;
}

std::vector<double> Space::to_x(const std::vector<double>& theta) const {
    std::vector<double> x;
    for (std::size_t i = 0; i < dimensions_.size(); ++i)
        if (!dimensions_[i].fixed)
            x.push_back(to_scale(dimensions_[i].parameter.scale, theta[i]));
    return x;
}

std::vector<double> Space::to_theta(const std::vector<double>& x) const {
    std::vector<double> theta;
    std::size_t next = 0;
    for (const Dimension& dimension : dimensions_) {
        const Parameter& p = dimension.parameter;
        theta.push_back(
            dimension.fixed ? p.lower : std::clamp(from_scale(p.scale, x[next]), p.lower, p.upper));
        next += dimension.fixed ? 0 : 1;
    }
    return theta;
}

std::vector<double> Space::gradient_by_x(const std::vector<double>& theta,
                                         const std::vector<double>& by_theta) const {
    std::vector<double> gradient;
    for (std::size_t i = 0; i < dimensions_.size(); ++i) {
        if (dimensions_[i].fixed)
            continue;
        gradient.push_back(by_theta[i] * slope_of_scale(dimensions_[i].parameter.scale, theta[i]));
    }
    return gradient;
}

Eigen::MatrixXd Space::curvature_by_x(const std::vector<double>& theta,
                                      const Eigen::MatrixXd& by_theta) const {
    std::vector<Eigen::Index> free;
    for (std::size_t i = 0; i < dimensions_.size(); ++i)
        if (!dimensions_[i].fixed)
            free.push_back(static_cast<Eigen::Index>(i));
    const auto slope = [&](Eigen::Index i) {
        const auto at = static_cast<std::size_t>(i);
        return slope_of_scale(dimensions_[at].parameter.scale, theta[at]);
    };
    const auto n = static_cast<Eigen::Index>(free.size());
    Eigen::MatrixXd curvature(n, n);
    for (Eigen::Index i = 0; i < n; ++i)
        for (Eigen::Index k = 0; k < n; ++k) {
            const Eigen::Index row = free[static_cast<std::size_t>(i)];
            const Eigen::Index column = free[static_cast<std::size_t>(k)];
            curvature(i, k) = by_theta(row, column) * slope(row) * slope(column);
        }
    return curvature;
}

std::vector<double> Space::lower() const {
    std::vector<double> x;
    for (const Dimension& dimension : dimensions_)
        if (!dimension.fixed)
            x.push_back(to_scale(dimension.parameter.scale, dimension.parameter.lower));
    return x;
}

std::vector<double> Space::upper() const {
    std::vector<double> x;
    for (const Dimension& dimension : dimensions_)
        if (!dimension.fixed)
            x.push_back(to_scale(dimension.parameter.scale, dimension.parameter.upper));
    return x;
}

std::vector<double> Space::clamped(std::vector<double> theta) const {
    for (std::size_t i = 0; i < dimensions_.size(); ++i)
        theta[i] =
            std::clamp(theta[i], dimensions_[i].parameter.lower, dimensions_[i].parameter.upper);
    return theta;
}

std::vector<double> Space::snapped(std::vector<double> theta) const {
    for (std::size_t i = 0; i < dimensions_.size(); ++i) {
        const Parameter& p = dimensions_[i].parameter;
        const double low = to_scale(p.scale, p.lower), high = to_scale(p.scale, p.upper);
        const double x = to_scale(p.scale, theta[i]), margin = 1e-9 * (high - low);
        if (x - low <= margin)
            theta[i] = p.lower;
        else if (high - x <= margin)
            theta[i] = p.upper;
    }
    return theta;
}

std::vector<double> Space::random(std::uint64_t seed, std::uint64_t number) const {
    // seed_seq takes 32 bits of each.
    std::vector<std::uint64_t> words{seed, number};
    if (seed >> 32 != 0)
        words.push_back(seed >> 32);
    std::seed_seq sequence(words.begin(), words.end());
    std::mt19937_64 generator(sequence);
    const std::vector<double> low = lower(), high = upper();
    std::vector<double> x;
    for (std::size_t i = 0; i < low.size(); ++i)
        // Not uniform_real_distribution: its values differ between standard libraries.
        x.push_back(low[i] + (high[i] - low[i]) * static_cast<double>(generator() >> 11) * 0x1p-53);
    return to_theta(x);
}

std::optional<std::size_t> exchangeable(const Space& lobe) {
    const auto& d = lobe.dimensions();
    for (std::size_t i = 0; i + 1 < d.size(); ++i) {
        const Parameter &x = d[i].parameter, &y = d[i + 1].parameter;
        if (x.scale != Scale::Linear && x.scale == y.scale && x.name.back() != y.name.back() &&
            x.lower == y.lower && x.upper == y.upper)
            return i;
    }
    return std::nullopt;
}

bool names_parameter_of(const ParameterRange& range, const std::vector<const Model*>& models) {
    for (const Model* model : models)
        for (const bool isotropic : {true, false})
            for (const Parameter& parameter : model->parameters(isotropic))
                if (means(range.name, parameter.name))
                    return true;
    return false;
}

} // namespace brdfit
