#include "bench/portability.hpp"

#include "bench/native/scalar.hpp"
#include "bench/native_tasks.hpp"
#include "bench/opencl.hpp"
#include "bench/report.hpp"
#include "bench/whole.hpp"
#include "host/albedo/integrator.hpp"
#include "host/evaluate/evaluate.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

namespace brdfit::bench {

namespace {

constexpr std::size_t compared_samples = 20000;
constexpr std::size_t bytes_read = std::size_t{1} << 28;
constexpr double value_tolerance = 1e-4, albedo_tolerance = 1e-4;
constexpr const char* timed_models[] = {"kurt", "ggx"};
constexpr const char* timed_works[] = {"eval", "error-gradient", "search"};

template <typename Names>
bool among(const Names& names, const std::string& name) {
    return std::find(std::begin(names), std::end(names), name) != std::end(names);
}

// f of one channel at each sample, against float64's.
double value_difference(const Device& device, const Problem& problem, const Samples& data,
                        const std::vector<ScalarSample>& samples) {
    const Material material = problem.material();
    std::vector<double> a, expected(3 * samples.size());
    for (std::size_t ch = 0; ch < 3; ++ch)
        a.insert(a.end(), {material.kd[ch], material.lobes.empty() ? 0 : material.lobes[0].ks[ch]});
    ScalarModel::find(problem.structure)
        ->evaluate(samples, problem.theta.data(), a.data(), expected.data());
    const std::vector<float> all = evaluate(device, material, *data.directions);
    double most = 0, largest = 0;
    for (const double f : expected)
        most = std::max(most, std::abs(f));
    for (std::size_t k = 0, n = 0; k < data.count(); ++k) {
        if (data.valid[k] == 0)
            continue;
        const double reference = expected[3 * n++];
        const double off =
            std::abs(all[k] - reference) / std::max(std::abs(reference), 1e-6 * most);
        largest =
            std::isfinite(off) ? std::max(largest, off) : std::numeric_limits<double>::infinity();
    }
    return largest;
}

// Adds what every kernel of a model computes.
void compare_model(const Device& device, const Problem& problem, const Samples& data,
                   const std::vector<ScalarSample>& samples, Portability& into) {
    into.agreements.push_back({problem.name(), "values",
                               value_difference(device, problem, data, samples), value_tolerance});
    const std::vector<Task> references = scalar_tasks(problem, samples);
    for (const Task& task : device_tasks(device, problem, data))
        for (const Task& reference : references)
            if (reference.work == task.work) {
                task.run();
                reference.run();
                into.agreements.push_back({problem.name(), task.work,
                                           difference(task.answer(), reference.answer()),
                                           find_work(task.work)->tolerance});
            }
    const Model* const model = find_model(problem.name());
    if (model == nullptr || model->kind != Kind::Lobe)
        return;
    Structure structure = problem.structure;
    structure.isotropic = false;
    AlbedoTask task;
    task.wo = direction(viewer_angle, 0);
    task.theta = problem.material().lobes.at(0).anisotropic_theta();
    into.albedos.emplace_back(problem.name(),
                              AlbedoIntegrator(device, structure, 1).integrate({task})[0].all);
}

// The largest difference of a device's rows that `wanted` holds for, with the other name of its
// row; "-" where there is none.
template <typename Wanted, typename Name>
std::string largest(const Portability& device, Wanted wanted, Name name) {
    const Agreement* worst = nullptr;
    for (const Agreement& a : device.agreements)
        if (wanted(a) && (worst == nullptr || !(a.difference <= worst->difference)))
            worst = &a;
    return worst == nullptr ? "-"
                            : fmt::format("{:.1e} {}{}", worst->difference, name(*worst),
                                          worst->wrong() ? ", WRONG" : "");
}

std::vector<std::string> names_in(const std::vector<Portability>& devices,
                                  std::string Agreement::*const name) {
    std::vector<std::string> names;
    for (const Portability& device : devices)
        for (const Agreement& a : device.agreements)
            if (!among(names, a.*name))
                names.push_back(a.*name);
    return names;
}

// Speed, its ratio to the first device's and what binds.
std::string speed_cell(const std::vector<Portability>& devices, const Portability& device,
                       const std::string& work, const std::string& model) {
    const auto row = [&](const Portability& of) {
        return find_result(of.measured.results, of.device, work, model, of.threads);
    };
    const Result* const result = row(device);
    if (result == nullptr)
        return "-";
    std::string cell = fmt::format("{:.1f}", result->samples_per_second / 1e6);
    const Result* const first = row(devices.front());
    if (&device != &devices.front() && first != nullptr)
        cell += fmt::format(" ({:.2f})", result->samples_per_second / first->samples_per_second);
    if (!device.measured.peaks.empty())
        cell += fmt::format(" {}", device.measured.peaks.front().binds(*result));
    return cell;
}

} // namespace

Portability measure_portability(const Device& device, const std::vector<Problem>& problems,
                                std::size_t most) {
    const Form& form = device.form;
    Portability found;
    found.device = device.name;
    found.platform = device.platform;
    found.driver = device.driver;
    found.threads = static_cast<int>(device.compute_units);
    found.form = fmt::format("{} x {}", form.vector_width, form.local_size);
    const Samples data = data_of(device, compared_samples);
    const std::vector<ScalarSample> samples = scalar_samples(data);
    for (const Problem& problem : problems)
        compare_model(device, problem, data, samples, found);
    const Samples whole = data_of(device, most);
    for (const Problem& problem : problems)
        if (among(timed_models, problem.name()))
            for (const Task& task : device_tasks(device, problem, whole))
                if (among(timed_works, task.work))
                    found.measured.results.push_back(measure(task, device.name, found.threads));
    found.measured.peaks.push_back(measure_peaks(device, bytes_read));
    const CompileTime compile = measure_compile(device);
    found.cold = compile.cold.median;
    found.cached = compile.warm.median;
    return found;
}

nlohmann::ordered_json to_json(const Portability& p) {
    nlohmann::ordered_json differences = nlohmann::ordered_json::array();
    for (const Agreement& a : p.agreements)
        differences.push_back({{"model", a.model},
                               {"kernel", a.kernel},
                               {"difference", a.difference},
                               {"tolerance", a.tolerance},
                               {"wrong", a.wrong()}});
    return {{"device", p.device},     {"platform", p.platform},     {"driver", p.driver},
            {"form", p.form},         {"failure", p.failure},       {"threads", p.threads},
            {"cold_seconds", p.cold}, {"cached_seconds", p.cached}, {"differences", differences}};
}

nlohmann::ordered_json portability_message(const Portability& p) {
    nlohmann::ordered_json rows = nlohmann::ordered_json::array(),
                           albedos = nlohmann::ordered_json::array();
    for (const Agreement& a : p.agreements) // JSON has no infinity
        rows.push_back({a.model, a.kernel,
                        std::min(a.difference, std::numeric_limits<double>::max()), a.tolerance});
    for (const auto& [model, value] : p.albedos)
        albedos.push_back({model, value});
    return {{"device", p.device},   {"platform", p.platform},
            {"driver", p.driver},   {"form", p.form},
            {"threads", p.threads}, {"cold", p.cold},
            {"cached", p.cached},   {"rows", rows},
            {"albedos", albedos},   {"measured", to_message(p.measured)}};
}

Portability portability_from_message(const nlohmann::ordered_json& json) {
    Portability p;
    p.device = json.at("device");
    p.platform = json.at("platform");
    p.driver = json.at("driver");
    p.form = json.at("form");
    p.threads = json.at("threads");
    p.cold = json.at("cold");
    p.cached = json.at("cached");
    for (const auto& row : json.at("rows"))
        p.agreements.push_back({row.at(0), row.at(1), row.at(2), row.at(3)});
    for (const auto& row : json.at("albedos"))
        p.albedos.emplace_back(row.at(0), row.at(1).is_number() ? row.at(1).get<double>() : NAN);
    p.measured = measured_from_message(json.at("measured"));
    return p;
}

void compare_albedos(std::vector<Portability>& devices) {
    const auto first = std::find_if(devices.begin(), devices.end(),
                                    [](const Portability& p) { return !p.albedos.empty(); });
    for (Portability& device : devices)
        for (std::size_t i = 0; i < device.albedos.size() && i < first->albedos.size(); ++i)
            if (&device != &*first)
                device.agreements.push_back(
                    {device.albedos[i].first, "albedo",
                     difference({device.albedos[i].second}, {first->albedos[i].second}),
                     albedo_tolerance});
}

std::string portability_table(const std::vector<Portability>& devices) {
    std::string table;
    const auto row = [&](const std::string& name, const auto& cell) {
        table += fmt::format("| {} |", name);
        for (const Portability& device : devices)
            table += fmt::format(" {} |", cell(device));
        table += "\n";
    };
    row("", [](const Portability& p) { return p.platform; });
    table += "|---|";
    for (std::size_t i = 0; i < devices.size(); ++i)
        table += "---|";
    table += "\n";
    row("device", [](const Portability& p) { return p.device; });
    row("driver", [](const Portability& p) { return p.driver; });
    row("threads", [](const Portability& p) { return std::to_string(p.threads); });
    row("vector width x local size", [](const Portability& p) { return p.form; });
    const auto failed = [](const Portability& p) { return !p.failure.empty(); };
    if (std::any_of(devices.begin(), devices.end(), failed))
        row("failed", [](const Portability& p) { return p.failure; });
    row("kernels of a kurt fit: built, cached, s", [](const Portability& p) {
        return p.failure.empty() ? fmt::format("{:.2f}, {:.3f}", p.cold, p.cached) : "-";
    });
    for (const std::string& kernel : names_in(devices, &Agreement::kernel))
        row("largest difference, " + kernel, [&](const Portability& p) {
            return largest(
                p, [&](const Agreement& a) { return a.kernel == kernel; },
                [](const Agreement& a) { return a.model; });
        });
    for (const std::string& model : names_in(devices, &Agreement::model))
        row("largest difference, " + model, [&](const Portability& p) {
            return largest(
                p, [&](const Agreement& a) { return a.model == model; },
                [](const Agreement& a) { return a.kernel; });
        });
    for (const char* work : timed_works)
        for (const char* model : timed_models)
            row(fmt::format("{}, {}, million/s", work, model),
                [&](const Portability& p) { return speed_cell(devices, p, work, model); });
    return table;
}

} // namespace brdfit::bench
