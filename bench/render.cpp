#include "bench/render.hpp"

#include "bench/problem.hpp"
#include "host/render/renderer.hpp"

#include <algorithm>

namespace brdfit::bench {

Result measure_render(const Device& device, int threads) {
    Material metal = problems({"ggx"}).front().material();
    std::fill(metal.kd.begin(), metal.kd.end(), 0);
    const Renderer renderer(device, metal, "bench");
    Scene scene;
    scene.shapes = shapes_named("sphere", AROUND);
    scene.environment = soft_box_environment();
    const RenderSettings settings;
    const Film film = renderer.render(scene, settings);
    double covered = 0;
    for (std::size_t i = 0; i < film.pixels(); ++i)
        covered += film.mean(Film::Covered, i);
    Task task;
    task.work = render_work;
    task.model = "ggx";
    task.samples = covered * static_cast<double>(settings.samples);
    task.run = [&] { renderer.render(scene, settings); };
    return measure(task, device.name, threads);
}

} // namespace brdfit::bench
