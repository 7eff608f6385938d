#include "fit/runs/plan.hpp"

#include "fit/devices.hpp"
#include "fit/structures.hpp"
#include "host/error.hpp"
#include "host/files/file.hpp"
#include "host/files/json.hpp"
#include "host/model/material.hpp"
#include "host/version.hpp"

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <map>
#include <unordered_map>

namespace brdfit {

namespace {

constexpr int format_version = 1;
constexpr std::size_t most_bytes = std::size_t{1} << 30;
const std::string expected_plan = "a plan that brdfit plan wrote";

// Keys in alphabetical order, no white space, the shortest text of each number.
std::string canonical(const Json& json) {
    return dumped(Json(nlohmann::json(json)));
}

Json structure_json(const Structure& structure) {
    Json lobes = Json::array();
    for (const Model* lobe : structure.lobes)
        lobes.push_back(lobe->name);
    return {{"diffuse", diffuse_name_of(*structure.diffuse)}, {"lobes", std::move(lobes)}};
}

// Of the settings, those that say how a fit is made.
Json options_json(const FitRequest& settings) {
    const FitOptions& options = settings.options;
    Json ranges = Json::array();
    for (const ParameterRange& range : options.ranges)
        ranges.push_back(text_of(range));
    Json json = {{"max_theta", options.max_theta},
                 {"algorithm", options.algorithm},
                 {"max_evaluations", options.max_evaluations},
                 {"starts", options.random_starts},
                 {"seed", options.seed},
                 {"ranges", std::move(ranges)},
                 {"conserve", options.conserve},
                 {"start", nullptr},
                 {"isotropic", nullptr}};
    if (options.start) {
        Material start = *options.start;
        start.fit = nullptr; // where it comes from changes nothing
        json["start"] = to_json(start);
    }
    if (settings.isotropic)
        json["isotropic"] = *settings.isotropic;
    if (settings.orient) // absent otherwise, as in plans before there was a choice
        json["orient"] = true;
    return json;
}

std::string id_of(const PlannedFile& file, const Task& task, const Json& options) {
    return sha256(canonical({{"algorithm_version", algorithm_version},
                             {"file", file.sha256},
                             {"structure", structure_json(task.structure)},
                             {"metric", name_of(task.metric)},
                             {"options", options}}));
}

void require_utf8(const std::string& path) {
    if (!is_utf8(path))
        throw InputError(
            fmt::format("{}: its name is not UTF-8, which a plan's are; expected another name",
                        dumped(Json(path))));
}

PlannedFile planned(const std::string& path) {
    require_utf8(path);
    const MappedFile file(path);
    return {path, sha256(file.bytes()), file.bytes().size()};
}

// What the digest of a plan is taken of: everything else in it.
std::string digest_of(Json json) {
    json.erase("sha256");
    return sha256(canonical(json));
}

Json plan_json(const Plan& plan) {
    Json files = Json::array(), tasks = Json::array();
    for (const PlannedFile& file : plan.files)
        files.push_back({{"path", file.path}, {"sha256", file.sha256}, {"bytes", file.bytes}});
    for (const Task& task : plan.tasks) {
        Json json = {{"id", task.id}, {"file", task.file}};
        json.update(structure_json(task.structure));
        json["metric"] = name_of(task.metric);
        json["output"] = task.output;
        tasks.push_back(std::move(json));
    }
    Json json = {{"brdfit_plan", format_version},
                 {"algorithm_version", algorithm_version},
                 {"version", version},
                 {"folder", plan.folder},
                 {"settings", settings_json(plan)},
                 {"files", std::move(files)},
                 {"tasks", std::move(tasks)}};
    json["sha256"] = digest_of(json);
    return json;
}

std::string plan_path(const std::string& folder) {
    return (std::filesystem::path(folder) / "plan.json").string();
}

// Reads a plan whose digest is right, so that what is in it was checked when it was made; whatever
// it holds nevertheless ends in an InputError.
class Reader {
  public:
    Reader(const Json& json, const std::string& path) : json_(json), top_{path, ""} {}

    Plan plan() const {
        Plan plan;
        plan.folder = text(json_, top_, "folder");
        read_settings(plan);
        const Json& files = array(json_, top_, "files");
        for (std::size_t i = 0; i < files.size(); ++i) {
            const Place at = top_.member("files").element(i);
            plan.files.push_back({text(files[i], at, "path"), text(files[i], at, "sha256"),
                                  whole(files[i], at, "bytes", ~std::uint64_t{0})});
        }
        const Json& tasks = array(json_, top_, "tasks");
        for (std::size_t i = 0; i < tasks.size(); ++i)
            plan.tasks.push_back(task(tasks[i], top_.member("tasks").element(i), plan));
        return plan;
    }

  private:
    static const Json& member(const Json& of, const Place& at, const std::string& key) {
        check_object(of, at, "an object");
        return required(of, at, key, expected_plan);
    }
    static std::string text(const Json& of, const Place& at, const std::string& key) {
        return parse_text(member(of, at, key), at.member(key), "a text");
    }
    static std::uint64_t whole(const Json& of, const Place& at, const std::string& key,
                               std::uint64_t most) {
        const Json& value = member(of, at, key);
        if (!value.is_number_unsigned() || value.get<std::uint64_t>() > most)
            at.member(key).fail(value, fmt::format("a whole number from 0 to {}", most));
        return value.get<std::uint64_t>();
    }
    static const Json& array(const Json& of, const Place& at, const std::string& key) {
        const Json& value = member(of, at, key);
        if (!value.is_array())
            at.member(key).fail(value, "an array");
        return value;
    }
    static std::vector<std::string> texts(const Json& of, const Place& at, const std::string& key) {
        std::vector<std::string> found;
        for (const Json& value : array(of, at, key))
            found.push_back(parse_text(value, at.member(key), "a text"));
        return found;
    }

    void read_settings(Plan& plan) const {
        const Place at = top_.member("settings");
        const Json& json = member(json_, top_, "settings");
        FitRequest& settings = plan.settings;
        FitOptions& options = settings.options;
        settings.models = texts(json, at, "model");
        for (const Json& lobes : array(json, at, "lobes"))
            settings.lobes.push_back(static_cast<int>(
                parse_number(lobes, at.member("lobes"), 1, static_cast<double>(max_lobes))));
        settings.diffuse = text(json, at, "diffuse");
        for (const std::string& name : texts(json, at, "metric"))
            plan.metrics.push_back(metric_named(name));
        options.max_theta =
            parse_number(member(json, at, "max_theta"), at.member("max_theta"), 1, 90);
        options.algorithm = algorithm_named(text(json, at, "algorithm"));
        options.max_evaluations = static_cast<int>(whole(json, at, "max_evaluations", 1000000));
        options.random_starts = static_cast<int>(whole(json, at, "starts", 100000));
        options.seed = whole(json, at, "seed", ~std::uint64_t{0});
        for (const std::string& range : texts(json, at, "ranges"))
            options.ranges.push_back(range.find(':') == std::string::npos ? parse_fix(range)
                                                                          : parse_bound(range));
        options.conserve = parse_bool(member(json, at, "conserve"), at.member("conserve"));
        if (const Json& start = member(json, at, "start"); !start.is_null())
            options.start = parse_material(dumped(start), top_.source + ": settings.start");
        if (const Json& isotropic = member(json, at, "isotropic"); !isotropic.is_null())
            settings.isotropic = parse_bool(isotropic, at.member("isotropic"));
        if (const Json* const orient = optional(json, "orient"))
            settings.orient = parse_bool(*orient, at.member("orient"));
    }

    static Task task(const Json& json, const Place& at, const Plan& plan) {
        Task task;
        task.id = text(json, at, "id");
        task.file = whole(json, at, "file", ~std::uint64_t{0});
        if (task.file >= plan.files.size())
            at.member("file").fail(json["file"], "the number of a file of the plan");
        task.structure.diffuse = find_diffuse(text(json, at, "diffuse"));
        if (task.structure.diffuse == nullptr)
            at.member("diffuse").fail(json["diffuse"], "the name of a diffuse shape");
        for (const std::string& name : texts(json, at, "lobes"))
            task.structure.lobes.push_back(&model_named(name));
        task.metric = metric_named(text(json, at, "metric"));
        task.output = text(json, at, "output");
        return task;
    }

    const Json& json_;
    const Place top_;
};

} // namespace

Json settings_json(const Plan& plan) {
    Json settings = {{"model", plan.settings.models},
                     {"lobes", plan.settings.lobes},
                     {"diffuse", plan.settings.diffuse},
                     {"metric", Json::array()}};
    for (const Metric metric : plan.metrics)
        settings["metric"].push_back(name_of(metric));
    settings.update(options_json(plan.settings));
    return settings;
}

double Task::cost() const {
    return cost_of(structure, metric);
}

std::string Plan::path_of(const PlannedFile& file) const {
    return (std::filesystem::path(folder) / file.path).string(); // an absolute path stays
}

FitOptions Plan::options_of(const Task& task) const {
    FitOptions options = settings.options;
    options.metric = task.metric;
    return options;
}

Plan make_plan(const FitRequest& request, const std::vector<Metric>& metrics,
               const ProgressFunction& progress) {
    Plan plan;
    plan.settings = request;
    plan.metrics = metrics;
    plan.folder = std::filesystem::canonical(".").string();
    require_utf8(plan.folder);
    // Names do not depend on the form.
    std::vector<Structure> structures = structures_of(request, request.isotropic.value_or(true));
    // What larger structures contain comes first: a shard's fits share it.
    std::stable_sort(structures.begin(), structures.end(),
                     [](const auto& a, const auto& b) { return a.lobes.size() < b.lobes.size(); });
    const Json options = options_json(request);
    const std::vector<std::string> stems = distinct_stems(request.files);
    for (std::size_t f = 0; f < request.files.size(); ++f) {
        tell(progress, static_cast<double>(f) / static_cast<double>(request.files.size()));
        plan.files.push_back(planned(request.files[f]));
        for (const Metric metric : metrics)
            for (const Structure& structure : structures) {
                Task task{"", f, structure, metric, ""};
                task.id = id_of(plan.files.back(), task, options);
                task.output = fmt::format(
                    "{}.{}.{}{}.json", stems[f], structure.name(), structure.lobes.size(),
                    metrics.size() > 1 ? fmt::format(".{}", name_of(metric)) : "");
                plan.tasks.push_back(std::move(task));
            }
    }
    return plan;
}

void write_plan(const Plan& plan, const std::string& folder) {
    make_output_folder(folder);
    OutputFile file(plan_path(folder));
    file.write(pretty(plan_json(plan)) + "\n");
    file.commit(true);
}

Plan read_plan(const std::string& folder) {
    const std::string path = plan_path(folder);
    std::error_code unknown;
    if (!std::filesystem::exists(path, unknown))
        throw InputError(
            fmt::format("{}: has no plan.json; expected a folder of brdfit plan", folder));
    const Json json = read_json(path, expected_plan, most_bytes);
    const Place top{path, ""};
    check_object(json, top, expected_plan);
    if (const Json& format = required(json, top, "brdfit_plan", expected_plan);
        format != format_version)
        top.member("brdfit_plan")
            .fail(format,
                  fmt::format("{}, the version of plans that this brdfit reads", format_version));
    if (const Json& made = required(json, top, "algorithm_version", expected_plan);
        made != algorithm_version)
        top.member("algorithm_version")
            .fail(made, fmt::format("{}, that of this brdfit: its fits may end elsewhere; make the "
                                    "plan anew, in another folder",
                                    algorithm_version));
    if (required(json, top, "sha256", expected_plan) != digest_of(json))
        top.fail("is not as brdfit plan wrote it; make it anew, with --force");
    try {
        return Reader(json, path).plan();
    } catch (const UsageError& error) { // names and ranges that the command line would not take
        throw InputError(fmt::format("{}: {}", path, error.what()));
    }
}

std::string Shard::name() const {
    return fmt::format("{}-of-{}", number, count);
}

std::vector<std::size_t> tasks_of(const Plan& plan, const Shard& shard) {
    // Shards are cut from the line of all costs at equal distances, or at the end of a file where
    // there is one within this share of that distance.
    constexpr double slack = 0.1;
    std::unordered_map<std::string, std::size_t> group_of; // by digest
    std::vector<std::vector<std::size_t>> groups;
    for (std::size_t t = 0; t < plan.tasks.size(); ++t) {
        const std::string& digest = plan.files[plan.tasks[t].file].sha256;
        const std::size_t group = group_of.emplace(digest, groups.size()).first->second;
        if (group == groups.size())
            groups.emplace_back();
        groups[group].push_back(t);
    }
    std::vector<double> ends{0}; // of files, on the line
    for (const std::vector<std::size_t>& group : groups) {
        double end = ends.back();
        for (const std::size_t t : group)
            end += plan.tasks[t].cost();
        ends.push_back(end);
    }
    const double length = ends.back() / static_cast<double>(shard.count);
    const auto cut = [&](std::size_t number) {
        const double even = length * static_cast<double>(number);
        const auto after = std::lower_bound(ends.begin(), ends.end(), even);
        double nearest = after == ends.end() ? ends.back() : *after;
        if (after != ends.begin() && even - *std::prev(after) < nearest - even)
            nearest = *std::prev(after);
        return std::abs(nearest - even) <= slack * length ? nearest : even;
    };
    const double begin = cut(shard.number), end = cut(shard.number + 1);
    const bool last = shard.number + 1 == shard.count;
    std::vector<std::size_t> chosen;
    for (std::size_t g = 0; g < groups.size(); ++g) {
        double at = ends[g];
        for (const std::size_t t : groups[g]) {
            if (at >= begin && (at < end || last))
                chosen.push_back(t);
            at += plan.tasks[t].cost();
        }
    }
    return chosen;
}

} // namespace brdfit
