#include "host/cli/command.hpp"
#include "host/cli/inputs.hpp"
#include "host/cli/progress.hpp"
#include "host/cli/within.hpp"
#include "host/error.hpp"
#include "host/evaluate/synthesise.hpp"
#include "host/files/directions.hpp"
#include "host/measured/write.hpp"
#include "host/version.hpp"

#include <charconv>
#include <filesystem>
#include <fmt/format.h>
#include <spdlog/spdlog.h>

namespace brdfit::cli {

namespace {

constexpr std::size_t default_directions = 100000;

struct Options {
    std::string material, out, directions;
    double noise = 0;
    std::uint64_t seed = 1;
    bool seed_given = false;
};

// The number that --directions is, or 0 where it names a file.
std::size_t direction_count(const std::string& text) {
    std::size_t count = 0;
    const char* const end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, count);
    if (error != std::errc() || stop != end)
        return 0;
    if (count == 0 || count > most_directions)
        throw UsageError(fmt::format("--directions {}: expected 1 to {}", text, most_directions));
    return count;
}

int synth(const Options& options, const Globals& globals) {
    require_samples_ending(options.out);
    const bool merl = std::filesystem::path(options.out).extension() == ".binary";
    if (merl && !options.directions.empty())
        throw UsageError("--directions: MERL's layout (.binary) has directions of its own");
    const std::size_t count =
        options.directions.empty() ? default_directions : direction_count(options.directions);
    const bool drawn = !merl && (options.directions.empty() || count > 0);
    if (options.seed_given && options.noise == 0 && !drawn)
        throw UsageError(
            "--seed: nothing is random; expected it with --noise or random directions");
    const Material material = read_material_file(options.material);
    Progress progress(2, globals.quiet);
    progress.show(0, std::filesystem::path(options.material).filename().string());
    const Device device = open_device(globals.device);
    Samples samples;
    if (merl) {
        samples = synthesise_merl(device, material, options.noise, options.seed, options.material);
    } else {
        auto directions =
            count > 0 ? random_directions(count, material.isotropic(), options.seed)
                      : std::make_shared<const Directions>(
                            reading(options.directions, FileKind::Directions, read_directions));
        samples = synthesise(device, material, directions, options.noise, options.seed);
    }
    write_samples(samples, options.out,
                  {fmt::format("synthesised by brdfit {} from {}", version,
                               std::filesystem::path(options.material).filename().string()),
                   fmt::format("noise: {}, seed: {}", options.noise, options.seed)},
                  progress.step(1, options.out));
    progress.clear();
    spdlog::debug("{}: {} samples", options.out, samples.valid_count());
    return 0;
}

} // namespace

void add_synth(CLI::App& app, const Globals& globals, Action& action) {
    CLI::App* command = app.add_subcommand("synth", "Write a material as if it had been measured");
    auto options = std::make_shared<Options>();
    add_material(*command, options->material);
    command
        ->add_option("OUT", options->out,
                     "file to write: .binary (MERL layout), .csv (scattered), .npy or .npz")
        ->required();
    command
        ->add_option("--noise", options->noise,
                     "standard deviation s of the noise, y (1 + s N(0,1))")
        ->check(within(0, 10))
        ->capture_default_str();
    const CLI::Option* const seed =
        add_seed(*command, options->seed, "of noise and directions")->capture_default_str();
    command->add_option("--directions", options->directions,
                        fmt::format("file of directions (.csv, .npy), or how many random ones "
                                    "(default: {})",
                                    default_directions));
    command->footer("Example:\n  brdfit synth paint.json paint.binary --noise 0.02 --seed 7");
    command->callback([options, seed, &globals, &action] {
        options->seed_given = seed->count() > 0;
        action = [options, &globals] { return synth(*options, globals); };
    });
}

} // namespace brdfit::cli
