#include "host/table/table.hpp"
#include "host/cli/command.hpp"
#include "host/cli/inputs.hpp"
#include "host/cli/progress.hpp"
#include "host/error.hpp"
#include "host/image/preview.hpp"

#include <chrono>
#include <filesystem>
#include <fmt/format.h>
#include <optional>
#include <spdlog/spdlog.h>

namespace brdfit::cli {

namespace {

struct Options {
    std::string what, model, out, encoding, preview;
    std::vector<std::string> fixes;
    std::size_t size = 0;
    double tolerance = 0;
    bool tolerance_given = false, list = false, more_than_list = false, clamp = false;
};

constexpr const char* axis_names =
    "cos_theta, roughness, f0, ior, and parameter:NAME for a model's own (see brdfit models), for "
    "example parameter:alpha of kurt";

std::string preset_names() {
    std::string names;
    for (const Preset& preset : presets())
        names += (names.empty() ? "" : ", ") + preset.name;
    return names;
}

TableSpec spec_of(const Options& options) {
    if (const TableSpec* preset = find_preset(options.what))
        return *preset;
    if (std::filesystem::path(options.what).extension() != ".json")
        throw UsageError(fmt::format("'{}' is neither a preset nor a specification (.json); "
                                     "presets: {}",
                                     options.what, preset_names()));
    return reading(options.what, FileKind::TableSpec, read_table_spec);
}

// --fix NAME=VALUE.
void fix_parameter(TableSpec& spec, const std::string& text) {
    const std::size_t equals = text.find('=');
    double value = 0;
    if (equals == std::string::npos || equals == 0 ||
        !CLI::detail::lexical_cast(text.substr(equals + 1), value))
        throw UsageError(fmt::format("--fix {}: expected NAME=VALUE, for example alpha=0.2", text));
    try {
        set_parameter(spec, text.substr(0, equals), value);
    } catch (const UsageError& error) {
        throw UsageError(fmt::format("--fix {}", error.what()));
    }
}

int list_presets() {
    for (const Preset& preset : presets()) {
        std::string axes;
        for (const Axis& axis : preset.spec.axes)
            axes += fmt::format("{}{} {}", axes.empty() ? "" : " x ", axis.name(), axis.size);
        fmt::print("{:<27} {:<66} {}\n", preset.name, preset.renderer, axes);
    }
    fmt::print(
        "\nroughness: the model's (GGX's alpha), often renderers' roughness squared.\nAxes of a "
        "specification (.json): {}.\n",
        axis_names);
    return 0;
}

int table(const Options& options, const Globals& globals) {
    if (options.list && options.more_than_list)
        throw UsageError("--list: expected alone");
    if (options.list)
        return list_presets();
    if (options.what.empty() || options.out.empty())
        throw UsageError("expected PRESET|SPEC.json and -o OUT, or --list");
    require_table_ending(options.out);
    if (!options.preview.empty())
        require_preview_ending(options.preview);
    TableSpec spec = spec_of(options);
    if (!options.model.empty())
        set_model(spec, model_named(options.model));
    for (const std::string& fix : options.fixes)
        fix_parameter(spec, fix);
    if (options.size > 0)
        set_size(spec, options.size);
    if (options.tolerance_given)
        spec.tolerance = options.tolerance;
    if (options.encoding == "float")
        spec.encoding = Encoding::Float;
    else if (options.encoding == "half")
        spec.encoding = Encoding::Half;
    else if (options.encoding == "unorm16")
        spec.encoding = Encoding::Unorm16;
    if (options.clamp && spec.encoding != Encoding::Unorm16)
        throw UsageError("--clamp: for the encoding unorm16 only");
    const Device device = open_device(globals.device);
    const auto start = std::chrono::steady_clock::now();
    const Table computed = [&] {
        Progress progress(1, globals.quiet);
        return compute_table(device, spec, progress.step(0, spec.name));
    }();
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (const AboveOne& above = computed.above_one; above.count > 0)
        spdlog::warn("{}: {} of {} albedos of {} are above 1, the largest {:.6g} at {}",
                     options.out, above.count, spec.entries(), spec.model->name, above.largest,
                     spec.place(above.entry));
    if (const std::size_t clamped = write_table(computed, options.out, options.clamp); clamped > 0)
        spdlog::warn("{}: {} of {} values were outside of 0 to 1 and are clamped", options.out,
                     clamped, spec.entries() * spec.values());
    if (!options.preview.empty())
        spdlog::info("{}: {}", options.preview, write_table_preview(computed, options.preview));
    spdlog::info("{}: {} entries in {:.2f} s, largest error estimated {:.2g}", options.out,
                 spec.entries(), seconds, computed.error);
    return 0;
}

} // namespace

void add_table(CLI::App& app, const Globals& globals, Action& action) {
    CLI::App* command =
        app.add_subcommand("table", "Albedo tables that renderers read, over cos theta, roughness "
                                    "and f0 or index of refraction");
    auto options = std::make_shared<Options>();
    command->add_option("PRESET|SPEC.json", options->what,
                        "a renderer's table (see --list) or a specification of one's own");
    command->add_flag("--list", options->list, "list the presets");
    command->add_option("-m,--model", options->model, "another model in the place of ggx");
    command
        ->add_option("--fix", options->fixes,
                     "a parameter of the model that no axis sets: alpha=0.2")
        ->allow_extra_args(false);
    command->add_option("--size", options->size, "nodes of the axes cos_theta and roughness")
        ->check(CLI::Range(2, 4096));
    auto* tolerance = command->add_option("--tolerance", options->tolerance,
                                          "absolute error of the albedos (default: the preset's)");
    command->add_option("--encoding", options->encoding, "float, half or unorm16")
        ->check(CLI::IsMember({"float", "half", "unorm16"}));
    command->add_flag("--clamp", options->clamp,
                      "of unorm16: cut off values outside of 0 to 1 in place of refusing them");
    command->add_option("-o,--output", options->out,
                        ".exr, .h, .hpp, .inc (C source), .npy or .csv");
    command->add_option("--preview", options->preview,
                        "also a picture (.png) of the values, laid out as in .exr");
    command->footer("Axes of a specification: " + std::string(axis_names) +
                    ".\nExamples:\n  brdfit table cycles -o ggx_E.h\n"
                    "  brdfit table filament -m kurt --fix alpha=0 -o dfg.exr");
    command->callback([command, tolerance, options, &globals, &action] {
        options->tolerance_given = tolerance->count() > 0;
        for (const CLI::Option* option : command->get_options())
            options->more_than_list |= option->count() > 0 && option->get_name() != "--list";
        action = [options, &globals] { return table(*options, globals); };
    });
}

} // namespace brdfit::cli
