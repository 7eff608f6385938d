#include "host/cli/command.hpp"
#include "host/cli/inputs.hpp"
#include "host/cli/isotropy.hpp"
#include "host/cli/progress.hpp"
#include "host/measured/read.hpp"
#include "host/measured/write.hpp"
#include "host/version.hpp"

#include <filesystem>
#include <fmt/format.h>
#include <spdlog/spdlog.h>

namespace brdfit::cli {

namespace {

struct Options {
    std::string in, out;
    Isotropy isotropy;
};

int convert(const Options& options, const Globals& globals) {
    require_samples_ending(options.out);
    Progress progress(2, globals.quiet);
    progress.show(0, options.in);
    const Samples samples = read_measurement(options.in, options.isotropy.choice());
    write_samples(samples, options.out,
                  {fmt::format("converted from {} by brdfit {}", samples.format, version),
                   fmt::format("source: {}", std::filesystem::path(options.in).filename().string()),
                   fmt::format("sha256: {}", samples.sha256)},
                  progress.step(1, options.out));
    progress.clear();
    spdlog::debug("{}: {} samples", options.out, samples.valid_count());
    return 0;
}

} // namespace

void add_convert(CLI::App& app, const Globals& globals, Action& action) {
    CLI::App* command =
        app.add_subcommand("convert", "Write measured reflectance in another format");
    auto options = std::make_shared<Options>();
    command->add_option("IN", options->in, "measured reflectance, in any known format")->required();
    command->add_option("OUT", options->out, "file to write: .binary (MERL), .csv or .npy")
        ->required();
    options->isotropy.add_to(*command);
    command->footer("Example:\n  brdfit convert garnet_red.brdf garnet_red.csv");
    command->callback([options, &globals, &action] {
        action = [options, &globals] { return convert(*options, globals); };
    });
}

} // namespace brdfit::cli
