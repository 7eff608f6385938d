#include "fit/python/material.hpp"

#include "fit/metric.hpp"
#include "fit/python/arrays.hpp"
#include "fit/python/module.hpp"
#include "fit/python/samples.hpp"
#include "fit/samples.hpp"
#include "host/albedo/material.hpp"
#include "host/error.hpp"
#include "host/evaluate/evaluate.hpp"
#include "host/evaluate/klems.hpp"
#include "host/evaluate/tabulate.hpp"
#include "host/files/json.hpp"
#include "host/measured/rgl.hpp"
#include "host/version.hpp"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>
#include <utility>

namespace brdfit::python {

namespace {

// What one call draws at most, as the command line does.
constexpr std::size_t most_directions = 100000000;

// Planes wi_x, wi_y, wi_z, pdf and one a channel, [plane][viewer][sample]; sample i of all is row i
// of the command's output.
std::vector<float> draw(const SharedMaterial& shared, const Device& device,
                        const std::vector<Vector>& viewers, std::size_t n, std::uint64_t seed,
                        Sequence sequence, const ProgressFunction& progress) {
    if (n == 0 || viewers.size() > most_directions / n)
        throw InputError(
            fmt::format("n: {} of each of {} viewers; expected at least 1, and at most "
                        "{} in all",
                        n, viewers.size(), most_directions));
    constexpr std::size_t fixed_planes = 4;
    const std::size_t channels = shared.material().channels.size();
    const std::size_t total = viewers.size() * n;
    std::vector<float> planes((fixed_planes + channels) * total);
    shared.with_sampler(device, [&](const Sampler& sampler) {
        std::size_t row = 0;
        for (const Vector& wo : viewers)
            for (std::size_t left = n; left > 0;) {
                const std::size_t count = std::min(left, sampler.samples_a_pass());
                const DirectionSamples drawn = sampler.sample(wo, count, seed, sequence, row);
                const auto put = [&](std::size_t plane, const float* values) {
                    std::copy_n(values, count, planes.data() + plane * total + row);
                };
                put(0, drawn.wi_x.data());
                put(1, drawn.wi_y.data());
                put(2, drawn.wi_z.data());
                put(3, drawn.pdf.data());
                for (std::size_t ch = 0; ch < channels; ++ch)
                    put(fixed_planes + ch, drawn.weight(ch));
                left -= count;
                row += count;
                tell(progress, static_cast<double>(row) / static_cast<double>(total));
            }
    });
    return planes;
}

void write_rgl(const SharedMaterial& shared, const Device& device, const std::string& path,
               const std::string& name, const ProgressFunction& progress) {
    const Material& material = shared.material();
    const RglChannels channels = rgl_channels(material.channels, false, name);
    const BrdfFunction function = [&](const Directions& directions) {
        return evaluate(device, material, directions);
    };
    Tabulated made =
        tabulate(device, function, channels, material.isotropic(), std::nullopt, {}, progress);
    made.tables.description = fmt::format("{}, by brdfit {}", name, version);
    rgl::write(made.tables, path);
}

void write_klems(const SharedMaterial& shared, const Device& device, const std::string& path,
                 const std::string& name, const ProgressFunction& progress) {
    const Material& material = shared.material();
    const BrdfFunction function = [&](const Directions& directions) {
        return evaluate(device, material, directions);
    };
    klems::write(
        klems::matrix(function, klems::luminance_weights(material.channels, name), progress),
        std::filesystem::path(name).stem().string(), path);
}

} // namespace

void add_material(nb::module_& module) {
    nb::class_<SharedMaterial>(module, "SharedMaterial")
        .def_static(
            "parse",
            [](const std::string& text, const std::string& source) {
                return std::make_unique<SharedMaterial>(parse_material(text, source));
            },
            nb::arg("text"), nb::arg("source"))
        .def_static(
            "read",
            [](const std::string& path) {
                return std::make_unique<SharedMaterial>(read_material(path));
            },
            nb::arg("path"))
        .def("json", [](const SharedMaterial& m) { return dumped(to_json(m.material())); })
        .def_prop_ro("channels", [](const SharedMaterial& m) { return m.material().channels; })
        .def_prop_ro("isotropic", [](const SharedMaterial& m) { return m.material().isotropic(); })
        .def(
            "save",
            [](const SharedMaterial& m, const std::string& path) {
                write_material(m.material(), path);
            },
            nb::arg("path"))
        .def(
            "write_rgl",
            [](const SharedMaterial& m, const std::string& path, const std::string& name,
               const std::string& device, const nb::object& progress) {
                run(progress,
                    [&](Call& call) { write_rgl(m, opened(device), path, name, call.progress()); });
            },
            nb::arg("path"), nb::arg("name"), nb::arg("device"), nb::arg("progress").none())
        .def(
            "write_klems",
            [](const SharedMaterial& m, const std::string& path, const std::string& name,
               const std::string& device, const nb::object& progress) {
                run(progress, [&](Call& call) {
                    write_klems(m, opened(device), path, name, call.progress());
                });
            },
            nb::arg("path"), nb::arg("name"), nb::arg("device"), nb::arg("progress").none())
        .def(
            "eval",
            [](const SharedMaterial& m, const nb::object& wi, const nb::object& wo,
               const Shape& shape, const std::string& device, const nb::object& progress) {
                const Rows lights(wi, "wi", 3), viewers(wo, "wo", 3);
                std::vector<float> values = run(progress, [&](Call& call) {
                    return m.evaluator(opened(device))
                        ->values(lights.count(), pairs_of(lights, viewers, shape), call.progress());
                });
                return to_array(std::move(values), {m.material().channels.size(), lights.count()});
            },
            nb::arg("wi"), nb::arg("wo"), nb::arg("shape"), nb::arg("device"),
            nb::arg("progress").none())
        .def(
            "pdf",
            [](const SharedMaterial& m, const nb::object& wi, const nb::object& wo,
               const Shape& shape, const std::string& device, const nb::object& progress) {
                const Rows lights(wi, "wi", 3), viewers(wo, "wo", 3);
                std::vector<float> values = run(progress, [&](Call& call) {
                    const Directions directions = directions_of(lights, viewers, shape);
                    return m.with_sampler(opened(device), [&](const Sampler& sampler) {
                        return sampler.density(directions, call.progress());
                    });
                });
                return to_array(std::move(values), {lights.count()});
            },
            nb::arg("wi"), nb::arg("wo"), nb::arg("shape"), nb::arg("device"),
            nb::arg("progress").none())
        .def(
            "sample",
            [](const SharedMaterial& m, const nb::object& wo, const Shape& shape, std::size_t n,
               std::uint64_t seed, bool sobol, const std::string& device,
               const nb::object& progress) {
                const Rows rows(wo, "wo", 3);
                std::vector<float> planes = run(progress, [&](Call& call) {
                    return draw(m, opened(device), viewers_of(rows, shape), n, seed,
                                sobol ? Sequence::Sobol : Sequence::Philox, call.progress());
                });
                return to_array(std::move(planes),
                                {4 + m.material().channels.size(), rows.count() * n});
            },
            nb::arg("wo"), nb::arg("shape"), nb::arg("n"), nb::arg("seed"), nb::arg("sobol"),
            nb::arg("device"), nb::arg("progress").none())
        .def(
            "albedo",
            [](const SharedMaterial& m, const std::vector<double>& theta,
               const std::vector<double>& phi, double tolerance, const std::string& device,
               const nb::object& progress) {
                const Albedo found = run(progress, [&](Call& call) {
                    return directional_albedo(opened(device), m.material(), theta, phi, tolerance,
                                              call.progress());
                });
                return std::pair(to_array(found.values, {theta.size()}),
                                 to_array(found.errors, {theta.size()}));
            },
            nb::arg("theta"), nb::arg("phi"), nb::arg("tolerance"), nb::arg("device"),
            nb::arg("progress").none())
        .def(
            "errors",
            [](const SharedMaterial& m, const SampleSet& set, double max_theta,
               const std::string& device, const nb::object& progress) {
                const MetricErrors errors = run(progress, [&](Call& call) {
                    const Samples& samples = set.samples();
                    if (samples.channels.size() != m.material().channels.size())
                        throw InputError(
                            fmt::format("samples: {} channels; expected {}, those of the material",
                                        samples.channels.size(), m.material().channels.size()));
                    const std::vector<std::uint32_t> used = used_samples(samples, max_theta);
                    return value_errors(samples, used,
                                        evaluate(opened(device), m.material(), *samples.directions,
                                                 call.progress()));
                });
                std::map<std::string, double> named;
                for (int i = 0; i < metric_count; ++i)
                    named[name_of(static_cast<Metric>(i))] = errors[static_cast<std::size_t>(i)];
                return named;
            },
            nb::arg("samples"), nb::arg("max_theta"), nb::arg("device"),
            nb::arg("progress").none());
}

} // namespace brdfit::python
