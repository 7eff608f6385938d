#include "fit/cli/recover.hpp"
#include "host/cli/command.hpp"
#include "host/cli/inputs.hpp"
#include "host/cli/progress.hpp"
#include "host/error.hpp"
#include "host/evaluate/sample.hpp"
#include "host/files/json.hpp"
#include "host/image/preview.hpp"
#include "host/microfacet/generator.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>
#include <fmt/format.h>
#include <memory>
#include <spdlog/spdlog.h>

namespace brdfit::cli {

namespace {

constexpr double degrees = 180 / pi;

struct Options {
    std::string spec, out, preview;
    RecoverRequest recover;
    GeneratorOptions generator;
    std::string only_from; ///< an option given that --from alone takes
    bool json = false, ward = false;
};

/// f0 that the report says the diffuse constant for; any other follows from the table.
constexpr double reported_f0[] = {0, 0.05, 0.5, 0.9, 1};

Json energy_json(const MicrofacetTable& table, double f0, bool correlated) {
    const EnergyReport report = energy_report(table, f0, correlated);
    Json json = {{"f0", f0},
                 {"correlated", correlated},
                 {"most", report.most},
                 {"above_1", report.above},
                 {"directions", report.directions},
                 {"where", Json::array()}};
    for (const auto& at : report.where)
        json["where"].push_back(
            {{"theta", at[0] * degrees}, {"phi", at[1] * degrees}, {"R", at[2]}});
    return json;
}

/// null: none.
Json constant_json(const MicrofacetTable& table, const TableUse& use) {
    const double c = diffuse_constant(table, use);
    return c > 0 ? Json(c) : Json(nullptr);
}

Json report_json(const MicrofacetTable& table, double seconds) {
    Json json = {{"distribution", table.distribution.name},
                 {"points", table.grid.count()},
                 {"rows", table.grid.rows},
                 {"columns", table.grid.columns},
                 {"mean", table.mean},
                 {"mean_height", table.mean_height},
                 {"mean_is_normal", mean_is_normal(table)},
                 {"energy", Json::array()},
                 {"diffuse_constant", Json::array()},
                 {"seconds", seconds}};
    for (const bool correlated : {false, true})
        for (const double f0 : {0.0, 0.05, 1.0})
            json["energy"].push_back(energy_json(table, f0, correlated));
    for (const bool metal : {false, true})
        for (const double f0 : reported_f0)
            json["diffuse_constant"].push_back(
                {{"f0", f0}, {"metal", metal}, {"c", constant_json(table, {f0, false, metal})}});
    return json;
}

void print_report(const MicrofacetTable& table, const std::string& out, double seconds) {
    const Grid& grid = table.grid;
    const char* const sector = grid.sector == Sector::Isotropic ? "isotropic"
                               : grid.sector == Sector::Quarter ? "a quarter of the hemisphere"
                               : grid.sector == Sector::Half    ? "half of the hemisphere"
                                                                : "the hemisphere";
    fmt::print("{}: {}, {} points ({} elevations, {} azimuths, {}), {:.3f} s\n", out,
               table.distribution.name, grid.count(), grid.rows, grid.columns, sector, seconds);
    fmt::print("  <h.n>                {:.6g}\n", table.mean_height);
    fmt::print("  <h>                  ({:.6g}, {:.6g}, {:.6g}): {}\n", table.mean[0],
               table.mean[1], table.mean[2],
               mean_is_normal(table) ? "parallel to n, energy is conserved"
                                     : "not parallel to n or rescaled, R may exceed 1");
    for (const bool correlated : {false, true})
        for (const double f0 : {1.0, 0.05}) {
            const EnergyReport report = energy_report(table, f0, correlated);
            fmt::print("  R at f0 = {:<4} {} at most {:.5f}, above 1 in {} of {} directions\n", f0,
                       correlated ? "correlated" : "          ", report.most, report.above,
                       report.directions);
            constexpr std::size_t shown = 8;
            for (std::size_t i = 0; i < std::min(shown, report.where.size()); ++i)
                fmt::print("    theta {:5.1f} phi {:5.1f} degrees: R = {:.4f}\n",
                           report.where[i][0] * degrees, report.where[i][1] * degrees,
                           report.where[i][2]);
            if (report.where.size() > shown)
                fmt::print("    and {} more (--json lists them)\n", report.where.size() - shown);
        }
    bool none = false;
    for (const bool metal : {false, true}) {
        fmt::print("{}", metal ? "    of a metal        " : "  diffuse constant c  ");
        for (const double f0 : reported_f0) {
            const double c = diffuse_constant(table, {f0, false, metal});
            none |= c == 0;
            fmt::print(" {} (f0 {})", c > 0 ? fmt::format("{:.5f}", c) : "none", f0);
        }
        fmt::print("\n");
    }
    if (none)
        fmt::print(
            "    none: R takes all that is reflected (of a metal f0, otherwise 1), nothing is "
            "left to be diffuse\n");
}

/// Albedos of the generated BRDF at f0 = 1 and of Ward's model of the same widths, Fig. 6 of the
/// paper.
std::vector<std::array<double, 3>> beside_ward(const MicrofacetTable& table, const Device& device) {
    const DistributionPart& part = table.distribution.parts.front();
    Material ward;
    ward.channels = {"Y"};
    ward.diffuse = &model_named("lambert");
    ward.kd = {0};
    Lobe lobe;
    lobe.model = &model_named("ward");
    lobe.isotropic = false;
    lobe.theta = {part.sigma_x, part.sigma_y};
    lobe.ks = {1};
    ward.lobes = {lobe};
    const Sampler sampler(device, ward);
    std::vector<std::array<double, 3>> rows;
    for (const double theta : {0, 10, 20, 30, 40, 50, 60, 70, 75, 80, 85, 87, 89}) {
        constexpr std::size_t samples = std::size_t{1} << 16;
        const DirectionSamples drawn =
            sampler.sample(direction(theta / degrees, 0), samples, 1, Sequence::Sobol);
        double sum = 0;
        for (const float weight : drawn.weights)
            sum += weight;
        rows.push_back(
            {theta, interpolate(table.grid, table.r1, table.grid.row((90 - theta) / degrees), 0),
             sum / static_cast<double>(samples)});
    }
    return rows;
}

Distribution read_distribution_file(const std::string& path) {
    return reading(path, FileKind::Distribution, read_distribution);
}

void require_upright_gaussian(const Distribution& distribution, const std::string& source) {
    const DistributionPart& part = distribution.parts.front();
    if (distribution.parts.size() != 1 || part.shape != Shape::Gaussian || part.tilt != 0 ||
        part.turn != 0 || part.table != nullptr || std::max(part.sigma_x, part.sigma_y) > 10)
        throw UsageError(
            fmt::format("--ward: {} is no upright Gaussian with widths up to 10", source));
}

/// The ending of a microfacet table; a material of the name may lie beside it.
void require_table_ending(const std::string& path) {
    if (std::filesystem::path(path).extension() != ".exr")
        throw UsageError(fmt::format("{}: unknown ending; expected .exr", path));
}

int generate(const Options& options, const Globals& globals) {
    if (options.spec.empty() == options.recover.file.empty())
        throw UsageError("generate needs either SPEC or --from FILE");
    if (options.generator.points < least_points || options.generator.points > most_points)
        throw UsageError(fmt::format("--points {}: expected {} to {}", options.generator.points,
                                     least_points, most_points));
    require_table_ending(options.out);
    if (!options.preview.empty())
        require_preview_ending(options.preview);
    if (options.recover.file.empty()) {
        if (!options.only_from.empty())
            throw UsageError(fmt::format("{}: for --from only", options.only_from));
        if (options.ward)
            require_upright_gaussian(read_distribution_file(options.spec), options.spec);
    } else if (options.ward)
        throw UsageError("--ward: for a SPEC only");
    const Device device = open_device(globals.device);
    const Generator generator(device);
    const auto preview = [&](const MicrofacetTable& table) {
        if (!options.preview.empty())
            spdlog::info("{}: {}", options.preview, write_table_preview(table, options.preview));
    };
    if (!options.recover.file.empty()) {
        const int status = recover_from(options.recover, options.generator, generator, device,
                                        options.out, options.json, globals);
        preview(*read_table(options.out));
        return status;
    }
    const auto begin = std::chrono::steady_clock::now();
    const Distribution distribution = read_distribution_file(options.spec);
    const MicrofacetTable table = [&] {
        Progress progress(1, globals.quiet);
        return generator.generate(distribution, options.generator, options.spec,
                                  progress.step(0, distribution.name));
    }();
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    std::vector<std::array<double, 3>> compared;
    if (options.ward)
        compared = beside_ward(table, device);
    write_table(table, options.out);
    preview(table);
    if (options.json) {
        Json json = report_json(table, seconds);
        for (const auto& row : compared)
            json["beside_ward"].push_back(
                {{"theta", row[0]}, {"microfacet", row[1]}, {"ward", row[2]}});
        fmt::print("{}\n", dumped(json, 2));
        return 0;
    }
    print_report(table, options.out, seconds);
    if (!compared.empty())
        fmt::print("  theta  R at f0 = 1  ward (along x)\n");
    for (const auto& row : compared)
        fmt::print("  {:5.0f}  {:11.4f}  {:4.4f}\n", row[0], row[1], row[2]);
    return 0;
}

} // namespace

void add_generate(CLI::App& app, const Globals& globals, Action& action) {
    CLI::App* command = app.add_subcommand(
        "generate", "Generate a microfacet BRDF's tables from any distribution of normals");
    auto options = std::make_shared<Options>();
    command->add_option("SPEC", options->spec, "distribution (.json)");
    command->add_option("--from", options->recover.file,
                        "measured reflectance to recover the distribution from");
    command->add_option("-o,--output", options->out, "table (.exr) for lobes of model microfacet")
        ->required();
    command->add_option("--preview", options->preview,
                        "also a picture (.png) of g and the reflectances, rows from the horizon up "
                        "to the normal from top to bottom");
    command->add_option("--points", options->generator.points, "points of the grid, about")
        ->capture_default_str();
    command->add_flag("--lambertian", options->generator.facets,
                      "also tabulate Lambertian facets (microfacet-lambertian); isotropic "
                      "distributions only");
    command->add_flag(
        "--ward", options->ward,
        "of an upright Gaussian: also print the albedos beside those of Ward's model");
    add_recover_options(*command, options->recover);
    command->add_flag("--json", options->json, "print the report as JSON");
    command->footer("Examples:\n"
                    "  echo '{\"distribution\": \"gaussian\", \"sigma_x\": 0.1, \"sigma_y\": 0.2}' "
                    "> gauss.json\n"
                    "  brdfit generate gauss.json -o gauss.exr\n"
                    "  brdfit generate --from nickel.binary -o nickel.exr");
    command->callback([command, options, &globals, &action] {
        for (const char* name :
             {"--model", "--max-theta", "--isotropic", "--anisotropic", "--force"})
            if (command->count(name) > 0)
                options->only_from = name;
        action = [options, &globals] { return generate(*options, globals); };
    });
}

} // namespace brdfit::cli
