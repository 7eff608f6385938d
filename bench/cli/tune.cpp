#include "bench/tune.hpp"
#include "bench/problem.hpp"
#include "host/cli/command.hpp"
#include "host/cli/progress.hpp"
#include "host/device/tuning.hpp"
#include "host/error.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace brdfit::cli {

namespace {

struct Options {
    bool json = false;
    std::size_t samples = 0, forms = 0; // for tests: at most so many
};

std::string name_of(const Form& form) {
    return fmt::format("{},{},{},{}", form.vector_width, form.local_size, form.block,
                       form.candidates);
}

nlohmann::ordered_json to_json(const Device& device, const std::vector<bench::Tried>& tried) {
    nlohmann::ordered_json rows = nlohmann::ordered_json::array();
    for (const bench::Tried& t : tried) {
        nlohmann::ordered_json row = to_json(t.form);
        row.update({{"eval", t.eval},
                    {"error_gradient", t.gradient},
                    {"search", t.search},
                    {"time", t.slowness}});
        rows.push_back(row);
    }
    return {{"device", device.name}, {"driver", device.driver}, {"forms", rows}};
}

int tune(const Options& options, const Globals& globals) {
    nlohmann::ordered_json json = nlohmann::ordered_json::array();
    for (const Device& device : open_devices(globals.device)) {
        std::vector<Form> forms = bench::forms_for(device);
        if (options.forms > 0)
            forms.resize(std::min(options.forms, forms.size()));
        std::vector<bench::Tried> tried;
        {
            Progress progress(forms.size(), globals.quiet);
            tried = bench::try_forms(device, forms, bench::data_of(device, options.samples),
                                     [&](std::size_t i) { progress.show(i, name_of(forms[i])); });
        }
        const bench::Tried shipped = tried.front();
        std::stable_sort(
            tried.begin(), tried.end(),
            [](const bench::Tried& a, const bench::Tried& b) { return a.slowness < b.slowness; });
        store_tuned_form(device, tried.front().form);
        if (options.json) {
            json.push_back(to_json(device, tried));
            continue;
        }
        fmt::print(
            "{} ({}, driver {})\nvector width, local size, block, candidates a pass; million "
            "samples/s of kurt; time: of the three together, the shipped form's = 1\n\n"
            "{:<16} {:>7} {:>15} {:>7} {:>6}\n",
            device.name, device.platform, device.driver, "", "eval", "error-gradient", "search",
            "time");
        for (const bench::Tried& t : tried)
            fmt::print("{:<16} {:>7.1f} {:>15.1f} {:>7.1f} {:>6.2f}{}\n", name_of(t.form),
                       t.eval / 1e6, t.gradient / 1e6, t.search / 1e6, t.slowness,
                       t.form == shipped.form ? "  shipped" : "");
        fmt::print("\nshipped form: {:.2f} times the best one's time\n{} keeps {} for this device, "
                   "driver and these kernels\n",
                   shipped.slowness / tried.front().slowness, tuning_path(),
                   name_of(tried.front().form));
    }
    if (options.json)
        fmt::print("{}\n", json.dump(2));
    return 0;
}

} // namespace

void add_tune(CLI::App& app, const Globals& globals, Action& action) {
    CLI::App* command = app.add_subcommand(
        "tune", "Find the form of the kernels that is fastest on a device, and keep it");
    auto options = std::make_shared<Options>();
    command->add_flag("--json", options->json, "print what was tried as JSON");
    command->add_option("--samples", options->samples)->group("");
    command->add_option("--forms", options->forms)->group("");
    command->footer(
        "Kept in the file that BRDFIT_TUNING names, otherwise in brdfit/tuning.json in\n"
        "$XDG_CONFIG_HOME or ~/.config, and used until the device, its driver or the\n"
        "kernels change. --device all tunes every device.\n"
        "Example:\n  brdfit tune --device 0");
    command->callback([options, &globals, &action] {
        action = [options, &globals] { return tune(*options, globals); };
    });
}

} // namespace brdfit::cli
