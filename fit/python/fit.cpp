#include "fit/fit_all.hpp"
#include "fit/jobs.hpp"
#include "fit/python/call.hpp"
#include "fit/python/material.hpp"
#include "fit/python/module.hpp"
#include "fit/python/samples.hpp"
#include "fit/report.hpp"
#include "host/device/errors.hpp"
#include "host/error.hpp"
#include "host/files/json.hpp"

#include <fmt/format.h>
#include <memory>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

namespace brdfit::python {

namespace {

/// What to fit, and how, as Python hands it over; see FitRequest.
struct Wishes {
    std::vector<std::string> models;
    std::vector<int> lobes;
    std::string diffuse, metric, algorithm;
    double max_theta = 80;
    std::vector<std::string> fixed, bounds; // texts of --fix and --bound
    int starts = 0, max_evaluations = 0;
    std::uint64_t seed = 0;
    bool conserve = false;
    const SharedMaterial* start = nullptr;
};

FitRequest request_of(const Wishes& wishes) {
    FitRequest request;
    request.models = wishes.models;
    request.lobes = wishes.lobes;
    request.diffuse = wishes.diffuse;
    FitOptions& options = request.options;
    options.metric = metric_named(wishes.metric);
    options.max_theta = wishes.max_theta;
    options.algorithm = algorithm_named(wishes.algorithm);
    options.max_evaluations = wishes.max_evaluations;
    options.random_starts = wishes.starts;
    options.seed = wishes.seed;
    options.conserve = wishes.conserve;
    for (const std::string& text : wishes.fixed)
        options.ranges.push_back(parse_fix(text));
    for (const std::string& text : wishes.bounds)
        options.ranges.push_back(parse_bound(text));
    if (wishes.start != nullptr)
        options.start = wishes.start->material();
    check(request);
    return request;
}

/// The fits of one call, as the command line would report them.
struct Report {
    FitRows rows;
    FitOptions options;

    /// Each fit as fit --json has it.
    std::vector<std::string> json() const {
        std::vector<std::string> texts;
        for (Json& row : fit_rows_json({rows.done, {}}, options))
            texts.push_back(dumped(row));
        return texts;
    }
};

Report fit_all(const Samples& samples, const FitRequest& request, const Device& device,
               Call& call) {
    std::vector<Structure> structures = structures_of(request, samples.isotropic);
    FitDevices devices({device});
    std::vector<std::optional<FitRow>> fitted(structures.size());
    Report report{{}, request.options};
    FitOptions options = request.options;
    options.abandon = [&call] { return call.stopped(); };
    std::size_t begun = 0;
    std::exception_ptr first_failure;
    const auto next = [&](std::size_t i) {
        const double count = static_cast<double>(structures.size());
        call.say(static_cast<double>(begun++) / count,
                 fmt::format("{} {}", structures[i].name(), structures[i].lobes.size()));
        return ProgressFunction{};
    };
    const auto done = [&](FitOutcome outcome) {
        try {
            if (outcome.failure)
                std::rethrow_exception(outcome.failure);
            FitRow row{samples.source, "", std::move(*outcome.result)};
            row.result.material.fit = fit_record(row.result, samples, request.options, device);
            fitted[outcome.index] = std::move(row);
        } catch (const std::exception& error) {
            if (!first_failure)
                first_failure = std::current_exception();
            const Structure& structure = structures[outcome.index];
            report.rows.failed.push_back(
                {samples.source, structure.name(), structure.lobes.size(), message_of(error)});
        }
    };
    const std::exception_ptr hindrance =
        brdfit::fit_all(devices, samples, options, structures, {}, {next, done, options.abandon});
    if (hindrance)
        std::rethrow_exception(hindrance);
    for (std::optional<FitRow>& row : fitted)
        if (row)
            report.rows.done.push_back(std::move(*row));
    if (report.rows.done.empty() && first_failure)
        std::rethrow_exception(first_failure);
    return report;
}

} // namespace

void add_fit(nb::module_& module) {
    nb::class_<Wishes>(module, "Wishes")
        .def(nb::init<>())
        .def_rw("models", &Wishes::models)
        .def_rw("lobes", &Wishes::lobes)
        .def_rw("diffuse", &Wishes::diffuse)
        .def_rw("metric", &Wishes::metric)
        .def_rw("algorithm", &Wishes::algorithm)
        .def_rw("max_theta", &Wishes::max_theta)
        .def_rw("fixed", &Wishes::fixed)
        .def_rw("bounds", &Wishes::bounds)
        .def_rw("starts", &Wishes::starts)
        .def_rw("max_evaluations", &Wishes::max_evaluations)
        .def_rw("seed", &Wishes::seed)
        .def_rw("conserve", &Wishes::conserve);
    nb::class_<Report>(module, "Report")
        .def("json", &Report::json)
        .def("materials",
             [](const Report& report) {
                 std::vector<std::unique_ptr<SharedMaterial>> materials;
                 for (const FitRow& row : report.rows.done)
                     materials.push_back(std::make_unique<SharedMaterial>(row.result.material));
                 return materials;
             })
        .def("failed",
             [](const Report& report) {
                 std::vector<std::tuple<std::string, std::size_t, std::string>> failed;
                 for (const FailedFit& fit : report.rows.failed)
                     failed.emplace_back(fit.model, fit.lobes, fit.reason);
                 return failed;
             })
        .def(
            "write_csv",
            [](const Report& report, const std::string& path) {
                write_fit_csv({report.rows.done, {}}, report.options, path);
            },
            nb::arg("path"));
    module.def(
        "fit",
        [](const SampleSet& set, Wishes wishes, const SharedMaterial* start,
           const std::string& device, const nb::object& progress) {
            wishes.start = start;
            return run(progress, [&](Call& call) {
                const FitRequest request = request_of(wishes);
                return std::make_unique<Report>(
                    fit_all(set.samples(), request, opened(device), call));
            });
        },
        nb::arg("samples"), nb::arg("wishes"), nb::arg("start").none(), nb::arg("device"),
        nb::arg("progress").none());
}

} // namespace brdfit::python
