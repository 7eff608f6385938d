#include "host/cli/command.hpp"
#include "host/cli/inputs.hpp"
#include "host/cli/isotropy.hpp"
#include "host/error.hpp"
#include "host/measured/read.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

namespace brdfit::cli {

namespace {

struct Options {
    std::vector<std::string> files;
    bool json = false;
    Isotropy isotropy;
};

/// What a person wants to know of a measurement before fitting it.
struct Summary {
    std::size_t valid = 0;
    float lowest = 0, highest = 0; ///< over the channels of the valid samples
    double below_horizon = 0;      ///< percentage of all samples
};

Summary summarise(const Samples& samples) {
    Summary summary;
    summary.valid = samples.valid_count();
    bool first = true;
    for (std::size_t c = 0; c < samples.channels.size(); ++c)
        for (std::size_t k = 0; k < samples.count(); ++k)
            if (samples.valid[k]) {
                const float value = samples.channel(c)[k];
                summary.lowest = first ? value : std::min(summary.lowest, value);
                summary.highest = first ? value : std::max(summary.highest, value);
                first = false;
            }
    std::size_t below = 0;
    for (std::size_t k = 0; k < samples.count(); ++k)
        below += !samples.directions->above_horizon(k);
    summary.below_horizon = 100.0 * static_cast<double>(below) /
                            static_cast<double>(std::max<std::size_t>(samples.count(), 1));
    return summary;
}

nlohmann::ordered_json to_json(const Samples& samples, const Summary& summary) {
    nlohmann::ordered_json json{{"file", samples.source},
                                {"format", samples.format},
                                {"samples", samples.count()},
                                {"valid", summary.valid},
                                {"left_out", samples.left_out},
                                {"channels", samples.channels},
                                {"range", nullptr},
                                {"below_horizon_percent", summary.below_horizon},
                                {"isotropic", samples.isotropic},
                                {"sha256", samples.sha256}};
    if (summary.valid > 0)
        json["range"] = {summary.lowest, summary.highest};
    return json;
}

std::string to_text(const Samples& samples, const Summary& summary) {
    const std::string range =
        summary.valid > 0 ? fmt::format("{:.6g} to {:.6g} 1/sr", summary.lowest, summary.highest)
                          : "no valid samples";
    const std::string left_out =
        samples.left_out == 0 ? ""
                              : fmt::format("  left out       {} nodes, not measured or below the "
                                            "horizon\n",
                                            samples.left_out);
    return fmt::format("{}\n"
                       "  format         {}\n"
                       "  samples        {}\n"
                       "  valid          {}\n"
                       "{}"
                       "  channels       {}: {}\n"
                       "  range          {}\n"
                       "  below horizon  {:.1f} %\n"
                       "  isotropic      {}\n"
                       "  sha256         {}\n",
                       samples.source, samples.format, samples.count(), summary.valid, left_out,
                       samples.channels.size(), fmt::join(samples.channels, ", "), range,
                       summary.below_horizon, samples.isotropic ? "yes" : "no", samples.sha256);
}

int info(const Options& options) {
    nlohmann::ordered_json all = nlohmann::ordered_json::array();
    int status = 0;
    for (const std::string& file : options.files) {
        try {
            const Samples samples = read_measurement(file, options.isotropy.choice());
            const Summary summary = summarise(samples);
            if (options.json)
                all.push_back(to_json(samples, summary));
            else
                fmt::print("{}", to_text(samples, summary));
        } catch (const InputError& error) {
            spdlog::error("{}", error.what());
            status = 1;
        }
    }
    // Names of files and channels may hold bytes that are not UTF-8.
    const auto text = [](const nlohmann::ordered_json& json) {
        return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
    };
    if (options.json && options.files.size() > 1)
        fmt::print("{}\n", text(all));
    else if (!all.empty())
        fmt::print("{}\n", text(all[0]));
    return status;
}

} // namespace

void add_info(CLI::App& app, const Globals&, Action& action) {
    CLI::App* command = app.add_subcommand("info", "Describe files of measured reflectance");
    auto options = std::make_shared<Options>();
    command->add_option("FILE", options->files, "measured reflectance, in any known format")
        ->required();
    command->add_flag("--json", options->json, "print JSON: an object, an array for several files");
    options->isotropy.add_to(*command);
    command->footer("Example:\n  brdfit info nickel.binary garnet_red.astm");
    command->callback([options, &action] { action = [options] { return info(*options); }; });
}

} // namespace brdfit::cli
