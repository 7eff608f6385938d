#include "fit/python/samples.hpp"

#include "fit/python/arrays.hpp"
#include "fit/python/call.hpp"
#include "fit/python/module.hpp"
#include "host/error.hpp"
#include "host/files/channels.hpp"
#include "host/measured/read.hpp"
#include "host/measured/rows.hpp"
#include "host/measured/write.hpp"
#include "host/parallel.hpp"
#include "host/version.hpp"

#include <algorithm>
#include <atomic>
#include <cfloat>
#include <cmath>
#include <fmt/format.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>
#include <set>

namespace brdfit::python {

namespace {

constexpr std::size_t piece = 1 << 14;
constexpr double horizon_tolerance = 1e-5; // what rounding may put below

// A unit vector on the horizon or above.
Vector upper_vector(const Rows& rows, std::size_t k, std::size_t count) {
    Vector v = unit_vector(rows, k, {count});
    if (v[2] < -horizon_tolerance)
        throw InputError(
            fmt::format("{}[{}] is below the horizon; expected z of 0 or more", rows.name(), k));
    v[2] = std::max(v[2], 0.0);
    return v;
}

float finite(const Rows& rows, std::size_t k, std::size_t column) {
    const double value = rows.at(k, column);
    if (!(std::abs(value) <= FLT_MAX))
        throw InputError(fmt::format(
            "{}[{}] is {}; expected a finite number", rows.name(),
            rows.columns() == 1 ? fmt::format("{}", k) : fmt::format("{}, {}", k, column), value));
    return static_cast<float>(value);
}

std::vector<std::string> checked_channels(const std::optional<std::vector<std::string>>& names,
                                          std::size_t count) {
    if (count == 0 || count > max_channels)
        throw InputError(fmt::format("values: {} channels; expected 1 to {}", count, max_channels));
    if (!names)
        return numbered_channels(count);
    if (names->size() != count)
        throw InputError(fmt::format("channels: {} names; expected {}, one a column of values",
                                     names->size(), count));
    for (const std::string& name : *names)
        if (!is_channel_name(name))
            throw InputError(
                fmt::format("channels: '{}'; expected {}", name, channel_name_expected));
    if (std::set<std::string>(names->begin(), names->end()).size() != count)
        throw InputError("channels: a name is given twice; expected different ones");
    return *names;
}

Samples samples_of(const Rows& wi, const Rows& wo, const Rows& values,
                   const std::optional<Rows>& weights,
                   const std::optional<std::vector<std::string>>& channels,
                   std::optional<bool> isotropic) {
    const std::size_t count = wi.count();
    if (count == 0)
        throw InputError("wi: no samples; expected at least one");
    for (const Rows* rows : {&wo, &values, weights ? &*weights : &wi})
        if (rows->count() != count)
            throw InputError(fmt::format("{}: {} rows; expected {}, one a row of wi", rows->name(),
                                         rows->count(), count));
    Samples samples;
    samples.source = "samples";
    samples.format = "arrays";
    samples.channels = checked_channels(channels, values.columns());
    samples.values.resize(count * values.columns());
    samples.weights.resize(weights ? count : 0);
    samples.valid.assign(count, 1);
    Directions directions = Directions::unfilled(count);
    std::atomic<bool> one_plane{true}; // what isotropic data may be turned into
    parallel_pieces(count, piece, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
            const Vector light = upper_vector(wi, k, count);
            directions.set(k, light, upper_vector(wo, k, count));
            if (!(light[1] == 0 && light[0] >= 0))
                one_plane = false;
            for (std::size_t c = 0; c < values.columns(); ++c)
                samples.values[c * count + k] = finite(values, k, c);
            if (!weights)
                continue;
            samples.weights[k] = finite(*weights, k, 0);
            if (samples.weights[k] < 0)
                throw InputError(
                    fmt::format("weights[{}] is {}; expected 0 or more", k, samples.weights[k]));
        }
    });
    samples.directions = std::make_shared<const Directions>(std::move(directions));
    samples.isotropic = isotropic.value_or(one_plane);
    return samples;
}

nb::ndarray<nb::numpy, const float> directions_view(const SampleSet& set, Directions::Plane first) {
    const Samples& samples = set.samples();
    return view_of(samples.directions->plane(first), {3, samples.count()}, samples.directions);
}

} // namespace

SampleSet::SampleSet(const std::string& path, std::optional<bool> isotropic)
    : samples_(std::make_shared<const Samples>(read_samples(path, isotropic))),
      isotropic_(isotropic) {}

SampleSet::SampleSet(Samples samples)
    : samples_(std::make_shared<const Samples>(std::move(samples))) {}

std::shared_ptr<const MeasuredBrdf> SampleSet::brdf() {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (brdf_)
        return brdf_;
    if (samples_->sha256.empty())
        return brdf_ = std::make_shared<MeasuredBrdf>(*samples_);
    auto file = std::make_shared<MeasuredBrdf>(samples_->source, isotropic_);
    if (file->samples().sha256 != samples_->sha256)
        throw InputError(fmt::format("{}: has changed since it was read; expected the same file, "
                                     "to evaluate it anywhere",
                                     samples_->source));
    return brdf_ = std::move(file);
}

void add_samples(nb::module_& module) {
    nb::class_<SampleSet>(module, "SampleSet")
        .def_static(
            "read",
            [](const std::string& path, std::optional<bool> isotropic) {
                return run(nb::none(),
                           [&](Call&) { return std::make_unique<SampleSet>(path, isotropic); });
            },
            nb::arg("path"), nb::arg("isotropic").none())
        .def_static(
            "of",
            [](const nb::object& wi, const nb::object& wo, const nb::object& values,
               const nb::object& weights, const std::optional<std::vector<std::string>>& channels,
               std::optional<bool> isotropic) {
                const Rows lights(wi, "wi", 3), viewers(wo, "wo", 3), rows(values, "values", 0);
                std::optional<Rows> column;
                if (!weights.is_none())
                    column.emplace(weights, "weights", 1);
                return run(nb::none(), [&](Call&) {
                    return std::make_unique<SampleSet>(
                        samples_of(lights, viewers, rows, column, channels, isotropic));
                });
            },
            nb::arg("wi"), nb::arg("wo"), nb::arg("values"), nb::arg("weights").none(),
            nb::arg("channels").none(), nb::arg("isotropic").none())
        .def_prop_ro("source", [](const SampleSet& set) { return set.samples().source; })
        .def_prop_ro("format", [](const SampleSet& set) { return set.samples().format; })
        .def_prop_ro("sha256", [](const SampleSet& set) { return set.samples().sha256; })
        .def_prop_ro("channels", [](const SampleSet& set) { return set.samples().channels; })
        .def_prop_ro("isotropic", [](const SampleSet& set) { return set.samples().isotropic; })
        .def_prop_ro("count", [](const SampleSet& set) { return set.samples().count(); })
        .def_prop_ro("valid_count",
                     [](const SampleSet& set) { return set.samples().valid_count(); })
        // Planes of what is stored, [coordinate or channel][sample].
        .def("wi", [](const SampleSet& set) { return directions_view(set, Directions::WiX); })
        .def("wo", [](const SampleSet& set) { return directions_view(set, Directions::WoX); })
        .def("values",
             [](const SampleSet& set) {
                 const Samples& samples = set.samples();
                 return view_of(samples.values.data(), {samples.channels.size(), samples.count()},
                                set.shared());
             })
        .def("weights",
             [](const SampleSet& set) -> std::optional<nb::ndarray<nb::numpy, const float>> {
                 const Samples& samples = set.samples();
                 if (samples.weights.empty())
                     return std::nullopt;
                 return view_of(samples.weights.data(), {samples.count()}, set.shared());
             })
        .def("valid",
             [](const SampleSet& set) {
                 const Samples& samples = set.samples();
                 return view_of(samples.valid.data(), {samples.count()}, set.shared());
             })
        .def(
            "save",
            [](const SampleSet& set, const std::string& path, const nb::object& progress) {
                run(progress, [&](Call& call) {
                    write_samples(set.samples(), path,
                                  {fmt::format("written by brdfit {}", version),
                                   fmt::format("source: {}", set.samples().source)},
                                  call.progress());
                });
            },
            nb::arg("path"), nb::arg("progress").none())
        .def(
            "eval",
            [](SampleSet& set, const nb::object& wi, const nb::object& wo, const Shape& shape,
               const std::string& device, const nb::object& progress) {
                const Rows lights(wi, "wi", 3), viewers(wo, "wo", 3);
                std::vector<float> values = run(progress, [&](Call& call) {
                    const Directions directions = directions_of(lights, viewers, shape);
                    return set.brdf()->evaluate(opened(device), directions, call.progress());
                });
                return to_array(std::move(values), {set.samples().channels.size(), lights.count()});
            },
            nb::arg("wi"), nb::arg("wo"), nb::arg("shape"), nb::arg("device"),
            nb::arg("progress").none());
}

} // namespace brdfit::python
