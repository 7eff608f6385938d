#include "host/table/table.hpp"

#include "host/albedo/integrator.hpp"
#include "host/albedo/material.hpp"
#include "host/error.hpp"
#include "host/version.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <iterator>
#include <numeric>

namespace brdfit {

namespace {

/// A mirror: the least roughness float32 kernels take, below every model's range.
constexpr double mirror = 1e-8;
/// Nodes of an average: the first rule, and the last.
constexpr std::size_t fewest_nodes = 16, most_nodes = 512;
constexpr double least_average_cosine = 1e-8;

/// The parameter that roughness axes set: the first that is not spaced linearly.
const Parameter& roughness_of(const Model& model) {
    const auto found = std::find_if(model.isotropic.begin(), model.isotropic.end(),
                                    [](const Parameter& p) { return p.scale != Scale::Linear; });
    if (model.kind != Kind::Lobe || found == model.isotropic.end())
        throw UsageError(fmt::format("the model '{}' has no roughness to tabulate", model.name));
    return *found;
}

/// What the axes say of a lobe's shape.
struct LobeShape {
    double roughness = 0;
    std::map<std::string, double> parameters; ///< of axes of parameters

    std::string text() const {
        std::string all = fmt::format("roughness {:.6g}", roughness);
        for (const auto& [name, value] : parameters)
            all += fmt::format(", parameter:{} {:.6g}", name, value);
        return all;
    }
};

/// theta of the model, anisotropic form, at f0 = 1.
std::vector<double> theta_of(const TableSpec& spec, const LobeShape& shape) {
    const Model& model = *spec.model;
    const Parameter& roughness = roughness_of(model);
    Lobe lobe{&model, true, {}, {1}};
    for (const Parameter& p : model.isotropic) {
        double value = p.start;
        if (const auto set = spec.parameters.find(p.name); set != spec.parameters.end())
            value = set->second;
        if (const auto set = shape.parameters.find(p.name); set != shape.parameters.end())
            value = set->second;
        if (p.name == "f0")
            value = 1;
        if (p.name == roughness.name) {
            const double a = std::max(shape.roughness, mirror);
            value = p.scale == Scale::Log ? a : std::max(p.lower, 2 / (a * a) - 2);
        }
        lobe.theta.push_back(value);
    }
    return lobe.anisotropic_theta();
}

const Axis* axis_of(const TableSpec& spec, AxisKind kind) {
    const auto found = std::find_if(spec.axes.begin(), spec.axes.end(),
                                    [&](const Axis& axis) { return axis.kind == kind; });
    return found == spec.axes.end() ? nullptr : &*found;
}

/// Values of an axis, or the one that stands for it.
std::vector<double> values_of(const Axis* axis, double otherwise) {
    if (axis == nullptr)
        return {otherwise};
    std::vector<double> values;
    for (std::size_t i = 0; i < axis->size; ++i)
        values.push_back(axis->value(i));
    return values;
}

/// E_all and what weighs it (E_p5, or E for an index of refraction) with their error.
struct Pair {
    double all = 0, weighted = 0, error = 0;
};

/// The shapes of all axes but cos_theta, f0 and ior, in the order of the axes.
std::vector<LobeShape> shapes_of(const TableSpec& spec) {
    std::vector<LobeShape> shapes{{}};
    for (const Axis& axis : spec.axes) {
        if (axis.kind != AxisKind::Roughness && axis.kind != AxisKind::Parameter)
            continue;
        std::vector<LobeShape> next;
        for (std::size_t i = 0; i < axis.size; ++i)
            for (LobeShape shape : shapes) {
                (axis.kind == AxisKind::Roughness ? shape.roughness
                                                  : shape.parameters[axis.parameter]) =
                    axis.value(i);
                next.push_back(std::move(shape));
            }
        shapes = std::move(next);
    }
    return shapes;
}

/// The albedos at viewers of height mu[i], each to tolerance slack[i], for each shape. Throws
/// InputError for one that is infinite or out of reach.
std::vector<Pair> directional(AlbedoIntegrator& integrator, const TableSpec& spec,
                              const std::vector<double>& mus, const std::vector<double>& slack,
                              const std::vector<LobeShape>& shapes, double ior,
                              const ProgressFunction& progress) {
    std::vector<AlbedoTask> tasks;
    for (const LobeShape& shape : shapes) {
        const std::vector<double> theta = theta_of(spec, shape);
        for (std::size_t i = 0; i < mus.size(); ++i)
            tasks.push_back({{std::sqrt((1 - mus[i]) * (1 + mus[i])), 0, mus[i]},
                             theta,
                             spec.tolerance * slack[i],
                             ior});
    }
    std::vector<Pair> pairs;
    for (const AlbedoValue& v : integrator.integrate(tasks, progress)) {
        const std::string where =
            fmt::format("{}: the albedo of {} at cos_theta {:.6g}, {}", spec.name, spec.model->name,
                        mus[pairs.size() % mus.size()], shapes[pairs.size() / mus.size()].text());
        if (!std::isfinite(v.all))
            throw InputError(where + " is infinite");
        if (!v.reached)
            throw InputError(fmt::format("{} is {:.6g} +- {:.2g}; the tolerance {} is out of reach",
                                         where, v.all, v.error, spec.tolerance));
        pairs.push_back({v.all, v.weighted, v.error});
    }
    return pairs;
}

/// The averages over viewers for each shape, with nodes doubled where two rules disagree.
std::vector<Pair> averages(AlbedoIntegrator& integrator, const TableSpec& spec,
                           const std::vector<LobeShape>& shapes, double ior,
                           const ProgressFunction& progress) {
    std::vector<Pair> averages(shapes.size()), before(shapes.size());
    std::vector<std::size_t> open(shapes.size());
    std::iota(open.begin(), open.end(), std::size_t{0});
    double left = 1; // two rounds, as a rule
    for (std::size_t nodes = fewest_nodes; !open.empty() && nodes <= most_nodes; nodes *= 2) {
        const double share = nodes == fewest_nodes ? 0.3 : 0.7;
        const ProgressFunction round = part_of(progress, 1 - left, 1 - left * (1 - share));
        left *= 1 - share;
        // Below 1 the light is reflected totally up to an angle.
        const CosineRule rule(nodes, ior > 0 && ior < 1 ? std::sqrt(1 - ior * ior) : 0);
        std::vector<double> mus, slack;
        std::vector<LobeShape> chosen;
        for (std::size_t i = 0; i < nodes; ++i) {
            mus.push_back(std::max(rule.mu[i], least_average_cosine));
            slack.push_back(std::max(1.0, 1 / (rule.weight[i] * static_cast<double>(nodes))));
        }
        for (const std::size_t a : open)
            chosen.push_back(shapes[a]);
        const std::vector<Pair> pairs =
            directional(integrator, spec, mus, slack, chosen, ior, round);
        std::vector<std::size_t> next;
        for (std::size_t k = 0; k < open.size(); ++k) {
            Pair sum;
            for (std::size_t i = 0; i < nodes; ++i) {
                const Pair& pair = pairs[k * nodes + i];
                sum.all += rule.weight[i] * pair.all;
                sum.weighted += rule.weight[i] * pair.weighted;
                sum.error += rule.weight[i] * pair.error;
            }
            const Pair& old = before[open[k]];
            const double change =
                std::max(std::abs(sum.all - old.all), std::abs(sum.weighted - old.weighted));
            before[open[k]] = sum;
            sum.error += change;
            averages[open[k]] = sum;
            if (change > spec.tolerance)
                next.push_back(open[k]);
        }
        open = std::move(next);
    }
    if (!open.empty())
        throw InputError(fmt::format("{}: the average of {} at {} is {:.6g} +- {:.2g}; "
                                     "the tolerance {} is out of reach",
                                     spec.name, spec.model->name, shapes[open[0]].text(),
                                     averages[open[0]].all, averages[open[0]].error,
                                     spec.tolerance));
    return averages;
}

/// [ior][shape][cosine] of a table's axes; without a cosine, averages.
std::vector<Pair> integrate(const Device& device, const TableSpec& spec,
                            const std::vector<double>& cosines,
                            const std::vector<LobeShape>& shapes, const std::vector<double>& iors,
                            const ProgressFunction& progress) {
    AlbedoIntegrator integrator(device, {&model_named("lambert"), {spec.model}, false}, 1);
    const bool average = axis_of(spec, AxisKind::CosTheta) == nullptr;
    std::vector<Pair> pairs;
    std::size_t done = 0;
    const auto count = static_cast<double>(iors.size());
    for (const double ior : iors) {
        const ProgressFunction part = part_of(progress, static_cast<double>(done) / count,
                                              static_cast<double>(done + 1) / count);
        ++done;
        const std::vector<Pair> found =
            average ? averages(integrator, spec, shapes, ior, part)
                    : directional(integrator, spec, cosines, std::vector<double>(cosines.size(), 1),
                                  shapes, ior, part);
        pairs.insert(pairs.end(), found.begin(), found.end());
    }
    return pairs;
}

void note_above_one(AboveOne& above, std::size_t entry, double albedo, double error) {
    if (!(albedo - error > 1))
        return;
    ++above.count;
    if (albedo > above.largest) {
        above.largest = albedo;
        above.entry = entry;
    }
}

const char* quantity_text(Quantity quantity) {
    switch (quantity) {
    case Quantity::Albedo:
        return "albedo E";
    case Quantity::Complement:
        return "1 - E, E the albedo";
    case Quantity::ScaleBias:
        return "scale and bias: albedo E = F0 scale + F90 bias, Schlick's Fresnel term";
    case Quantity::MultipleScattering:
        return "x and y: albedo E = (1 - f0) x + f0 y, Schlick's Fresnel term";
    }
    return "";
}

} // namespace

double Axis::value(std::size_t i) const {
    const auto at = static_cast<double>(i), n = static_cast<double>(size);
    if (reciprocal) {
        const double half = n / 2;
        return at < half ? 1 / (1 + 1.5 * (half - 1 - at) / (half - 1))
                         : 1 + 1.5 * (at - half) / (half - 1);
    }
    const double x = nodes == Nodes::Corners   ? at / (n - 1)
                     : nodes == Nodes::Centres ? (at + 0.5) / n
                                               : std::min(1.0, (n - at + 0.5) / n);
    return lower + (upper - lower) * std::pow(std::max(x, least), power);
}

std::string Axis::name() const {
    switch (kind) {
    case AxisKind::CosTheta:
        return "cos_theta";
    case AxisKind::Roughness:
        return "roughness";
    case AxisKind::F0:
        return "f0";
    case AxisKind::Ior:
        return "ior";
    case AxisKind::Parameter:
        return "parameter:" + parameter;
    }
    return "";
}

std::string Axis::mapping() const {
    if (reciprocal)
        return fmt::format("i below {0}: 1 / (1 + 1.5 ({1} - i) / {1}); from {0}: 1 + 1.5 (i - "
                           "{0}) / {1}; corners",
                           size / 2, size / 2 - 1);
    const char* const x = nodes == Nodes::Corners   ? "i / (N - 1) (corners)"
                          : nodes == Nodes::Centres ? "(i + 0.5) / N (centres)"
                                                    : "min(1, (N - i + 0.5) / N)";
    std::string text = power == 1 ? "x" : fmt::format("x^{}", power);
    if (lower != 0 || upper != 1)
        text = fmt::format("{} + {} {}", lower, upper - lower, text);
    text += fmt::format(", x = {}, N = {}", x, size);
    return least > 0 ? text + fmt::format(", x at least {}", least) : text;
}

std::size_t TableSpec::values() const {
    return quantity == Quantity::Albedo || quantity == Quantity::Complement ? 1 : 2;
}

std::size_t TableSpec::entries() const {
    std::size_t count = 1;
    for (const Axis& axis : axes)
        count *= axis.size;
    return count;
}

std::vector<const Parameter*> own_parameters(const Model& model) {
    const Parameter& roughness = roughness_of(model);
    std::vector<const Parameter*> own;
    for (const Parameter& p : model.isotropic)
        if (p.name != roughness.name && p.name != "f0")
            own.push_back(&p);
    return own;
}

namespace {

/// Throws UsageError where the model has no such parameter of its own.
const Parameter& own_parameter(const Model& model, const std::string& name) {
    std::string known;
    for (const Parameter* p : own_parameters(model)) {
        if (p->name == name)
            return *p;
        known += (known.empty() ? "" : ", ") + p->name;
    }
    throw UsageError(fmt::format("{}: is no parameter of {} beside its roughness and f0; those "
                                 "are: {}",
                                 name, model.name, known.empty() ? "none" : known));
}

/// Throws UsageError where a parameter cannot have the value.
void require_in_range(const Parameter& p, double value) {
    if (!(value >= p.lower && value <= p.upper))
        throw UsageError(
            fmt::format("{}={}: expected a number in [{}, {}]", p.name, value, p.lower, p.upper));
}

} // namespace

std::string TableSpec::place(std::size_t entry) const {
    std::string text;
    for (const Axis& axis : axes) {
        text += fmt::format("{}{} {:.6g}", text.empty() ? "" : ", ", axis.name(),
                            axis.value(entry % axis.size));
        entry /= axis.size;
    }
    return text;
}

void set_model(TableSpec& spec, const Model& model) {
    roughness_of(model);
    for (const Axis& axis : spec.axes)
        if (axis.kind == AxisKind::Parameter)
            for (const double end : {axis.lower, axis.upper})
                require_in_range(own_parameter(model, axis.parameter), end);
    spec.model = &model;
    spec.parameters.clear();
}

void set_parameter(TableSpec& spec, const std::string& name, double value) {
    require_in_range(own_parameter(*spec.model, name), value);
    for (const Axis& axis : spec.axes)
        if (axis.parameter == name)
            throw UsageError(fmt::format("{}={}: the axis {} sets it", name, value, axis.name()));
    spec.parameters[name] = value;
}

void set_size(TableSpec& spec, std::size_t size) {
    if (size < 2 || size > largest_size)
        throw UsageError(fmt::format("--size {}: expected 2 to {}", size, largest_size));
    for (Axis& axis : spec.axes)
        if (axis.kind == AxisKind::CosTheta || axis.kind == AxisKind::Roughness)
            axis.size = size;
    if (spec.entries() > most_entries)
        throw UsageError(fmt::format("--size {}: makes {} entries; expected at most {}", size,
                                     spec.entries(), most_entries));
}

Table compute_table(const Device& device, const TableSpec& spec, const ProgressFunction& progress) {
    require_tolerance(spec.tolerance);
    const Axis* const cosine = axis_of(spec, AxisKind::CosTheta);
    const std::vector<double> cosines = values_of(cosine, 0),
                              f0s = values_of(axis_of(spec, AxisKind::F0), spec.f0),
                              iors = values_of(axis_of(spec, AxisKind::Ior), 0);
    const std::vector<LobeShape> shapes = shapes_of(spec);
    const std::vector<Pair> pairs = integrate(device, spec, cosines, shapes, iors, progress);
    Table table;
    table.spec = spec;
    table.values.assign(spec.values() + (spec.third_channel ? 1 : 0),
                        std::vector<double>(spec.entries()));
    for (std::size_t e = 0; e < spec.entries(); ++e) {
        // The axes' indices, fastest first.
        std::size_t rest = e, cosine_at = 0, shape_at = 0, shape_step = 1, f0_at = 0, ior_at = 0;
        for (const Axis& axis : spec.axes) {
            const std::size_t i = rest % axis.size;
            rest /= axis.size;
            switch (axis.kind) {
            case AxisKind::CosTheta:
                cosine_at = i;
                break;
            case AxisKind::F0:
                f0_at = i;
                break;
            case AxisKind::Ior:
                ior_at = i;
                break;
            case AxisKind::Roughness:
            case AxisKind::Parameter:
                shape_at += shape_step * i;
                shape_step *= axis.size;
                break;
            }
        }
        const Pair& pair = pairs[(ior_at * shapes.size() + shape_at) * cosines.size() + cosine_at];
        const double f0 = f0s[f0_at];
        const double albedo =
            iors[ior_at] > 0 ? pair.weighted : f0 * (pair.all - pair.weighted) + pair.weighted;
        note_above_one(table.above_one, e, spec.values() == 1 ? albedo : pair.all, pair.error);
        table.error = std::max(table.error, pair.error);
        switch (spec.quantity) {
        case Quantity::Albedo:
            table.values[0][e] = albedo;
            break;
        case Quantity::Complement:
            table.values[0][e] = 1 - albedo;
            break;
        case Quantity::ScaleBias:
            table.values[0][e] = pair.all - pair.weighted;
            table.values[1][e] = pair.weighted;
            break;
        case Quantity::MultipleScattering:
            table.values[0][e] = pair.weighted;
            table.values[1][e] = pair.all;
            break;
        }
    }
    return table;
}

std::vector<std::pair<std::string, std::string>> provenance(const Table& table) {
    const TableSpec& spec = table.spec;
    const Parameter& roughness = roughness_of(*spec.model);
    const bool average = axis_of(spec, AxisKind::CosTheta) == nullptr;
    std::vector<std::pair<std::string, std::string>> lines;
    lines.push_back({"table", spec.name + ": " + spec.description});
    std::string quantity = quantity_text(spec.quantity);
    if (average)
        quantity += "; averaged over viewers, 2 integral E mu dmu";
    if (spec.values() == 1) {
        if (axis_of(spec, AxisKind::Ior) != nullptr)
            quantity += "; exact Fresnel term of a dielectric";
        else if (axis_of(spec, AxisKind::F0) != nullptr)
            quantity += "; Schlick's Fresnel term";
        else
            quantity += fmt::format("; f0 = {}", spec.f0);
    }
    if (!spec.model->fresnel())
        quantity += "; the model has no Fresnel term, its shape is multiplied by it";
    lines.push_back({"quantity", quantity});
    std::string order;
    for (const Axis& axis : spec.axes) {
        lines.push_back({"axis_" + axis.name(), axis.name() + " = " + axis.mapping()});
        if (axis.kind == AxisKind::Roughness)
            lines.back().second +=
                roughness.scale == Scale::Log
                    ? fmt::format("; it is {} of {}", roughness.name, spec.model->name)
                    : fmt::format("; it says the exponent {} of {}", roughness.name,
                                  spec.model->name);
        order += (order.empty() ? "" : ", ") + fmt::format("{} ({})", axis.name(), axis.size);
    }
    lines.push_back({"order", order + "; fastest first"});
    lines.push_back({"encoding", spec.encoding == Encoding::Float  ? "float"
                                 : spec.encoding == Encoding::Half ? "half"
                                                                   : "unorm16, value / 65535"});
    std::string model = spec.model->name + ", ";
    model += roughness.scale == Scale::Log ? fmt::format("{} = roughness", roughness.name)
                                           : fmt::format("{} = max({}, 2 / roughness^2 - 2)",
                                                         roughness.name, roughness.lower);
    for (const Parameter* p : own_parameters(*spec.model)) {
        const auto set = spec.parameters.find(p->name);
        const bool axis = std::any_of(spec.axes.begin(), spec.axes.end(),
                                      [&](const Axis& a) { return a.parameter == p->name; });
        model += axis ? fmt::format(", {0} = parameter:{0}", p->name)
                      : fmt::format(", {} = {}", p->name,
                                    set == spec.parameters.end() ? p->start : set->second);
    }
    lines.push_back({"model", model + fmt::format("; roughness at least {}", mirror)});
    lines.push_back({"tolerance", fmt::format("{}; largest error estimated {:.2g}", spec.tolerance,
                                              table.error)});
    if (table.above_one.count > 0)
        lines.push_back(
            {"above_1", fmt::format("{} of {} albedos are above 1, the largest {:.6g} "
                                    "at {}",
                                    table.above_one.count, spec.entries(), table.above_one.largest,
                                    spec.place(table.above_one.entry))});
    lines.push_back({"software", fmt::format("brdfit {}", version)});
    return lines;
}

} // namespace brdfit
