#include "fit/fit.hpp"
#include "fit/structures.hpp"
#include "host/cli/command.hpp"
#include "host/cli/inputs.hpp"
#include "host/cli/progress.hpp"
#include "host/cli/within.hpp"
#include "host/error.hpp"
#include "host/files/file.hpp"
#include "host/image/difference.hpp"
#include "host/image/plot.hpp"
#include "host/render/picture.hpp"
#include "host/render/renderer.hpp"
#include "host/version.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <memory>
#include <numeric>
#include <optional>
#include <set>
#include <spdlog/spdlog.h>

namespace brdfit::cli {

namespace {

constexpr std::size_t most_panels = 256;

struct Options {
    std::vector<std::string> inputs, lights, labels;
    std::string out, shape = "sphere", environment, size = "512", backdrop, ground = "0.5",
                     proposal;
    RenderSettings settings;
    brushing brushed = AROUND;
    double turn = 0, phi = -90, angle = 25, exposure = 0;
    std::optional<double> theta, tolerance;
    std::size_t columns = 0; // 0: one row
    Tone tone = Tone::Reinhard;
    ExrPixel pixel = ExrPixel::Half;
    bool compare = false;
    double scale = 4;            // of a difference
    std::set<std::string> given; // names of options

    bool has(const char* option) const { return given.count(option) > 0; }
};

/// Throws UsageError for an option that would change nothing.
void refuse_unused(const Options& options) {
    const bool png = std::filesystem::path(options.out).extension() == ".png";
    const bool shown = png || options.compare; // what a screen shows is compared
    const bool ground = options.shape == "ground";
    const struct {
        const char* option;
        bool used;
        const char* expected;
    } uses[] = {
        {"--scale", options.compare, "it with --compare"},
        {"--labels", png, "an output that ends in .png"},
        {"--exposure", shown, "an output that ends in .png, or --compare"},
        {"--tone", shown, "an output that ends in .png, or --compare"},
        {"--pixel", !png, "an output that ends in .exr"},
        {"--ground", ground, "--shape ground"},
        {"--turn",
         options.environment != "none" && (!options.environment.empty() || options.lights.empty()),
         "an environment to turn"},
        {"--bounces", ground || options.shape.find(':') != std::string::npos,
         "several shapes: --shape ground, row or grid"},
        {"--proposal",
         options.proposal.empty() ||
             std::any_of(options.inputs.begin(), options.inputs.end(), is_measurement),
         "a measurement, whose directions it draws"}};
    for (const auto& use : uses)
        if (options.has(use.option) && !use.used)
            throw UsageError(
                fmt::format("{}: changes nothing here; expected {}", use.option, use.expected));
}

/// W or WxH in pixels.
void set_size(View& view, const std::string& text) {
    std::size_t width = 0, height = 0;
    char rest = 0;
    if (std::sscanf(text.c_str(), "%5zux%5zu%c", &width, &height, &rest) != 2) {
        if (std::sscanf(text.c_str(), "%5zu%c", &width, &rest) != 1)
            width = 0;
        height = width;
    }
    if (width < 1 || height < 1 || width > most_side || height > most_side)
        throw UsageError(fmt::format("--size {}: expected WIDTH or WIDTHxHEIGHT of 1 to {} pixels",
                                     text, most_side));
    view.width = width;
    view.height = height;
}

/// One number for all of red, green and blue, or three.
Rgb rgb_from(const std::string& option, const std::string& text, double most) {
    Rgb rgb{};
    char rest = 0;
    const int found =
        std::sscanf(text.c_str(), "%lf,%lf,%lf%c", rgb.data(), &rgb[1], &rgb[2], &rest);
    if (found == 1 && text.find(',') == std::string::npos &&
        std::sscanf(text.c_str(), "%lf%c", rgb.data(), &rest) == 1)
        rgb = {rgb[0], rgb[0], rgb[0]};
    else if (found != 3)
        rgb = {-1, -1, -1};
    if (!std::all_of(rgb.begin(), rgb.end(), [&](double x) { return x >= 0 && x <= most; }))
        throw UsageError(fmt::format("{} {}: expected one number from 0 to {:g}, or three, R,G,B",
                                     option, text, most));
    return rgb;
}

Scene scene_of(const Options& options) {
    Scene scene;
    scene.shapes = shapes_named(options.shape, options.brushed);
    for (const std::string& light : options.lights)
        scene.lights.push_back(light_from(light));
    scene.ground = rgb_from("--ground", options.ground, 1);
    if (!options.backdrop.empty())
        scene.backdrop = rgb_from("--backdrop", options.backdrop, 1e6);
    std::optional<double> theta;
    if (options.theta)
        theta = *options.theta * degree;
    scene.view.theta = view_theta(options.shape, theta);
    scene.view.phi = options.phi * degree;
    scene.view.angle = options.angle * degree;
    set_size(scene.view, options.size);
    scene.turn = options.turn * degree;
    const bool lit = options.environment.empty() && !options.lights.empty();
    if (!lit)
        scene.environment =
            environment_named(options.environment.empty() ? "softbox" : options.environment);
    return scene;
}

/// A material to draw a measurement's directions by: the given one, or a quick fit.
Material proposal_for(const Device& device, const Options& options, const MeasuredBrdf& measured) {
    if (!options.proposal.empty())
        return read_material_file(options.proposal);
    try {
        ProgramCache programs(device);
        FileFitter fitter(device, programs, measured.samples(), FitOptions{});
        return fitter.fit(structure_named("ggx", 1, "lambert", measured.isotropic())).material;
    } catch (const InputError& error) {
        spdlog::info("{}: no fit to draw directions by ({}); they are drawn by their cosine",
                     measured.samples().source, error.what());
        Material even;
        even.channels = {"Y"};
        even.diffuse = &model_named("lambert");
        even.kd = {1};
        return even;
    }
}

Renderer renderer_of(const Device& device, const Options& options, const std::string& path) {
    if (!is_measurement(path))
        return {device, read_material(path), path};
    auto measured = std::make_shared<const MeasuredBrdf>(path);
    const Material proposal = proposal_for(device, options, *measured);
    return {device, measured, proposal, path};
}

void write_picture(const Options& options, const std::vector<Panel>& panels, std::size_t columns,
                   std::map<std::string, std::string> attributes) {
    Image picture = side_by_side(panels, columns);
    if (std::filesystem::path(options.out).extension() == ".png") {
        write_png(labelled(toned(picture, options.exposure, options.tone), panels, columns),
                  options.out);
        return;
    }
    picture.metadata = std::move(attributes);
    write_exr(picture, options.out, options.pixel);
}

/// The difference of two pictures as a third panel, and what is said of it.
std::string compare(const Options& options, std::vector<Panel>& panels) {
    const Image &a = panels[0].image, &b = panels[1].image;
    const Image shown_a = toned(a, options.exposure, options.tone),
                shown_b = toned(b, options.exposure, options.tone);
    const Psnr ratio = psnr(shown_a, shown_b);
    const std::vector<float> seen = flip(shown_a, shown_b);
    const double mean =
        std::accumulate(seen.begin(), seen.end(), 0.0) / static_cast<double>(seen.size());
    panels.push_back(
        {fmt::format("difference x {:g}", options.scale), difference(a, b, options.scale)});
    return fmt::format(
        "PSNR {:.2f} dB (R {:.2f}, G {:.2f}, B {:.2f}), FLIP {:.4f} in the mean, {:.4f} "
        "at most",
        ratio.all, ratio.channels[0], ratio.channels[1], ratio.channels[2], mean,
        *std::max_element(seen.begin(), seen.end()));
}

int render(const Options& options, const Globals& globals) {
    const std::string ending = std::filesystem::path(options.out).extension().string();
    if (ending != ".png" && ending != ".exr")
        throw UsageError(fmt::format("{}: unknown ending; expected .exr or .png", options.out));
    if (options.inputs.size() > most_panels)
        throw UsageError(
            fmt::format("{} materials; expected at most {}", options.inputs.size(), most_panels));
    if (!options.labels.empty() && options.labels.size() != options.inputs.size())
        throw UsageError(fmt::format("--labels: {} for {} materials", options.labels.size(),
                                     options.inputs.size()));
    if (options.compare && options.inputs.size() != 2)
        throw UsageError(fmt::format("--compare: {} inputs; expected two", options.inputs.size()));
    refuse_unused(options);
    const Scene scene = scene_of(options);
    const std::size_t pixels = scene.view.width * scene.view.height;
    if (pixels * (options.inputs.size() + (options.compare ? 1 : 0)) > most_pixels)
        throw UsageError(
            fmt::format("--size {}: {} pictures of {} pixels; expected at most {} in all",
                        options.size, options.inputs.size(), pixels, most_pixels));
    RenderSettings settings = options.settings;
    settings.tolerance = options.tolerance;
    if (settings.tolerance && !options.has("--samples"))
        settings.samples = 65536;
    { const OutputFile probe(options.out); } // a path that cannot be written costs no time
    const Device device = open_device(globals.device);
    const std::vector<std::string> labels =
        options.labels.empty() ? distinct_names(options.inputs) : options.labels;
    std::map<std::string, std::string> attributes{
        {"software", fmt::format("brdfit {}", version)},
        {"quantity", "radiance in W/(m2 sr), linear; A: share of the pixel that shapes cover"},
        {"scene",
         fmt::format("{}, environment {}, lights {}", options.shape,
                     scene.environment ? scene.environment->name : "none",
                     options.lights.empty() ? "none"
                                            : fmt::format("{}", fmt::join(options.lights, " ")))},
        {"seed", fmt::format("{}", settings.seed)},
        {"bounces", fmt::format("{}", settings.bounces)}};
    std::vector<Panel> panels;
    std::vector<std::string> notes;
    {
        Progress progress(options.inputs.size(), globals.quiet);
        for (std::size_t k = 0; k < options.inputs.size(); ++k) {
            const ProgressFunction share = progress.step(k, labels[k]);
            const Film film =
                renderer_of(device, options, options.inputs[k]).render(scene, settings, share);
            panels.push_back({labels[k], image_of(film)});
            const std::string noise =
                film.batches() > 1
                    ? fmt::format("{:.3g} % of the mean radiance", 100 * film.noise())
                    : std::string("unknown from one sample");
            notes.push_back(fmt::format("{}: {} samples a pixel, noise {}", options.inputs[k],
                                        film.samples(), noise));
            attributes[fmt::format("panel {}", k + 1)] = notes.back();
            if (settings.tolerance && !(film.noise() <= *settings.tolerance))
                spdlog::warn("{}: --tolerance {} is not reached with {} samples a pixel",
                             options.inputs[k], *settings.tolerance, film.samples());
        }
    }
    if (options.compare) {
        notes.push_back(compare(options, panels));
        attributes["difference"] = fmt::format("times {:g}; {}", options.scale, notes.back());
    }
    write_picture(options, panels, options.columns == 0 ? panels.size() : options.columns,
                  std::move(attributes));
    for (const std::string& note : notes)
        fmt::print("{}\n", note);
    return 0;
}

} // namespace

void add_render(CLI::App& app, const Globals& globals, Action& action) {
    CLI::App* command =
        app.add_subcommand("render", "Pictures of materials and measurements on simple shapes");
    auto options = std::make_shared<Options>();
    command
        ->add_option("MATERIAL|FILE", options->inputs,
                     "material files (.json) and measured reflectance in any known format; several "
                     "stand side by side")
        ->required();
    command->add_option("-o,--output", options->out, ".exr (linear) or .png (toned, with labels)")
        ->required();
    command
        ->add_option("--shape", options->shape,
                     "sphere, row:N or grid:COLUMNSxROWS of spheres, cylinder, plane, or ground (a "
                     "sphere on a plane)")
        ->capture_default_str();
    command
        ->add_option("--brushed", options->brushed,
                     "which way the tangent runs: around the shape's axis, or along it")
        ->transform(CLI::CheckedTransformer(
            std::map<std::string, brushing>{{"around", AROUND}, {"along", ALONG}}))
        ->option_text("NAME");
    command->add_option("--environment", options->environment,
                        "softbox (the default without --light), sky, white, none, or a "
                        "latitude-longitude .exr");
    command->add_option("--turn", options->turn, "turn the environment about the vertical, degrees")
        ->check(within(-360, 360));
    command->add_option("--light", options->lights,
                        "point:X,Y,Z,INTENSITY, directional:THETA,PHI,IRRADIANCE (degrees) or "
                        "rectangle:X,Y,Z,WIDTH,HEIGHT,RADIANCE; several, each with its --light");
    command->add_option("--ground", options->ground, "albedo of the plane under a sphere")
        ->capture_default_str();
    command->add_option("--backdrop", options->backdrop,
                        "radiance behind the shapes, in place of the environment");
    command
        ->add_option("--view", options->theta,
                     "the camera's angle from straight above, degrees (default: 90, above "
                     "planes 70)")
        ->check(within(0.01, 179.99));
    command->add_option("--around", options->phi, "the camera's azimuth, degrees")
        ->capture_default_str()
        ->check(within(-360, 360));
    command->add_option("--angle", options->angle, "the picture's smaller angle of view, degrees")
        ->capture_default_str()
        ->check(within(1, 120));
    command->add_option("--size", options->size, "of each picture: WIDTH or WIDTHxHEIGHT pixels")
        ->capture_default_str();
    command->add_option("--samples", options->settings.samples, "a pixel")
        ->capture_default_str()
        ->check(CLI::Range(std::size_t{1}, most_render_samples));
    command
        ->add_option("--tolerance", options->tolerance,
                     "stop where the noise is at most this share of the mean radiance, or at "
                     "--samples (then 65536 by default)")
        ->check(within(1e-6, 1));
    add_seed(*command, options->settings.seed, "another seed, other noise")->capture_default_str();
    command->add_option("--bounces", options->settings.bounces, "of light between the shapes")
        ->capture_default_str()
        ->check(CLI::Range(0, most_bounces));
    command
        ->add_option("--sampling", options->settings.drawn,
                     "how directions are drawn: both (lights and material), lights, material, or "
                     "uniform; all tend to the same picture")
        ->transform(
            CLI::CheckedTransformer(std::map<std::string, strategy>{{"both", BOTH},
                                                                    {"lights", LIGHTS_ALONE},
                                                                    {"material", MATERIAL_ALONE},
                                                                    {"uniform", UNIFORM}}))
        ->option_text("NAME");
    command->add_option("--proposal", options->proposal,
                        "material by which a measurement's directions are drawn (default: a quick "
                        "fit); the picture tends to the same");
    command->add_option("--columns", options->columns, "of pictures (default: all in one row)")
        ->check(CLI::Range(std::size_t{1}, most_panels));
    command->add_option("--labels", options->labels, "names for the pictures, A,B,...")
        ->delimiter(',');
    command->add_flag("--compare", options->compare,
                      "of two: their difference as a third picture; PSNR and FLIP of what a screen "
                      "shows");
    command->add_option("--scale", options->scale, "of the difference")
        ->capture_default_str()
        ->check(within(1e-3, 1e6));
    command->add_option("--exposure", options->exposure, ".png: brighter by so many stops")
        ->check(within(-30, 30));
    command->add_option("--tone", options->tone, ".png: reinhard (highlights compressed) or clip")
        ->transform(CLI::CheckedTransformer(
            std::map<std::string, Tone>{{"reinhard", Tone::Reinhard}, {"clip", Tone::Clip}}))
        ->option_text("NAME");
    command->add_option("--pixel", options->pixel, ".exr: half or float")
        ->transform(CLI::CheckedTransformer(
            std::map<std::string, ExrPixel>{{"half", ExrPixel::Half}, {"float", ExrPixel::Float}}))
        ->option_text("NAME");
    command->footer(
        "Examples:\n  brdfit render paint.json -o paint.png\n"
        "  brdfit render nickel.binary nickel.kurt.1.json --environment sky -o nickel.exr\n"
        "  brdfit render brushed.json --shape cylinder --brushed along --light "
        "point:3,-4,5,60 -o cylinder.png");
    command->callback([command, options, &globals, &action] {
        for (const CLI::Option* const option : command->get_options())
            if (option->count() > 0)
                options->given.insert(option->get_name());
        action = [options, &globals] { return render(*options, globals); };
    });
}

} // namespace brdfit::cli
