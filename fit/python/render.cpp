#include "fit/python/arrays.hpp"
#include "fit/python/call.hpp"
#include "fit/python/material.hpp"
#include "fit/python/module.hpp"
#include "host/error.hpp"
#include "host/render/renderer.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>
#include <optional>
#include <spdlog/spdlog.h>
#include <utility>
#include <vector>

// Pictures of materials on simple shapes.

namespace brdfit::python {

namespace {

/// What to render, and how; see the options of brdfit render. Angles are radians.
struct RenderWishes {
    std::string shape, environment;
    std::vector<std::string> lights;
    std::vector<double> ground, backdrop; // three numbers; an empty backdrop: none
    bool along = false;                   // brushed
    std::optional<double> view, tolerance;
    double around = 0, angle = 0, turn = 0;
    std::size_t width = 0, height = 0, samples = 0;
    std::string sampling;
    std::uint64_t seed = 0;
    int bounces = 0;
};

Rgb rgb_of(const std::vector<double>& values) {
    Rgb rgb{};
    std::copy_n(values.begin(), rgb.size(), rgb.begin());
    return rgb;
}

Scene scene_of(const RenderWishes& wishes) {
    Scene scene;
    scene.shapes = shapes_named(wishes.shape, wishes.along ? ALONG : AROUND);
    for (const std::string& light : wishes.lights)
        scene.lights.push_back(light_from(light));
    scene.environment = environment_named(wishes.environment);
    scene.turn = wishes.turn;
    scene.ground = rgb_of(wishes.ground);
    if (!wishes.backdrop.empty())
        scene.backdrop = rgb_of(wishes.backdrop);
    scene.view.theta = view_theta(wishes.shape, wishes.view);
    scene.view.phi = wishes.around;
    scene.view.angle = wishes.angle;
    scene.view.width = wishes.width;
    scene.view.height = wishes.height;
    if (scene.view.width * scene.view.height > most_pixels)
        throw InputError(fmt::format("size: {} x {} pixels; expected at most {} in all",
                                     wishes.width, wishes.height, most_pixels));
    return scene;
}

RenderSettings settings_of(const RenderWishes& wishes) {
    RenderSettings settings;
    settings.samples = wishes.samples;
    settings.seed = wishes.seed;
    settings.tolerance = wishes.tolerance;
    settings.bounces = wishes.bounces;
    const std::pair<const char*, strategy> known[] = {{"both", BOTH},
                                                      {"lights", LIGHTS_ALONE},
                                                      {"material", MATERIAL_ALONE},
                                                      {"uniform", UNIFORM}};
    const auto* const found = std::find_if(std::begin(known), std::end(known), [&](const auto& k) {
        return wishes.sampling == k.first;
    });
    if (found == std::end(known))
        throw InputError(fmt::format("sampling: '{}'; expected both, lights, material or uniform",
                                     wishes.sampling));
    settings.drawn = found->second;
    return settings;
}

// Planes R, G, B, [plane][row][column].
std::vector<float> render(const SharedMaterial& shared, const RenderWishes& wishes,
                          const std::string& device, Call& call) {
    const Scene scene = scene_of(wishes);
    const RenderSettings settings = settings_of(wishes);
    const Film film = Renderer(opened(device), shared.material(), "material")
                          .render(scene, settings, call.progress());
    if (settings.tolerance && !(film.noise() <= *settings.tolerance))
        spdlog::warn("tolerance {} is not reached with {} samples a pixel", *settings.tolerance,
                     film.samples());
    std::vector<float> planes;
    planes.reserve(3 * film.pixels());
    for (const Film::Plane plane : {Film::Red, Film::Green, Film::Blue})
        for (std::size_t i = 0; i < film.pixels(); ++i)
            planes.push_back(static_cast<float>(film.mean(plane, i)));
    return planes;
}

} // namespace

void add_render(nb::module_& module) {
    nb::class_<RenderWishes>(module, "RenderWishes")
        .def(nb::init<>())
        .def_rw("shape", &RenderWishes::shape)
        .def_rw("environment", &RenderWishes::environment)
        .def_rw("lights", &RenderWishes::lights)
        .def_rw("ground", &RenderWishes::ground)
        .def_rw("backdrop", &RenderWishes::backdrop)
        .def_rw("along", &RenderWishes::along)
        .def_rw("view", &RenderWishes::view, nb::arg().none())
        .def_rw("around", &RenderWishes::around)
        .def_rw("angle", &RenderWishes::angle)
        .def_rw("turn", &RenderWishes::turn)
        .def_rw("width", &RenderWishes::width)
        .def_rw("height", &RenderWishes::height)
        .def_rw("samples", &RenderWishes::samples)
        .def_rw("tolerance", &RenderWishes::tolerance, nb::arg().none())
        .def_rw("sampling", &RenderWishes::sampling)
        .def_rw("seed", &RenderWishes::seed)
        .def_rw("bounces", &RenderWishes::bounces);
    module.def(
        "render",
        [](const SharedMaterial& material, const RenderWishes& wishes, const std::string& device,
           const nb::object& progress) {
            std::vector<float> planes =
                run(progress, [&](Call& call) { return render(material, wishes, device, call); });
            return to_array(std::move(planes), {3, wishes.height, wishes.width});
        },
        nb::arg("material"), nb::arg("wishes"), nb::arg("device"), nb::arg("progress").none());
}

} // namespace brdfit::python
