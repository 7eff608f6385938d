#include "host/render/renderer.hpp"

#include "host/device/buffer.hpp"
#include "host/error.hpp"
#include "host/evaluate/tabulate.hpp"
#include "host/model/program.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fmt/format.h>

namespace brdfit {

namespace {

constexpr std::size_t samples_a_launch = std::size_t{1} << 23;
constexpr std::size_t paths_a_launch = std::size_t{1} << 18; // of a measured BRDF, with its planes
constexpr double least_even_part = 0.1;                      // of a proposal's strongest lobe

/// A material of three channels, red, green and blue.
Material in_rgb(const Material& material, const std::array<std::size_t, 3>& rgb) {
    Material made = material;
    made.channels = {"R", "G", "B"};
    made.kd.clear();
    for (const std::size_t ch : rgb)
        made.kd.push_back(material.kd[ch]);
    for (std::size_t l = 0; l < made.lobes.size(); ++l) {
        made.lobes[l].ks.clear();
        for (const std::size_t ch : rgb)
            made.lobes[l].ks.push_back(material.lobes[l].ks[ch]);
    }
    return made;
}

Material with_even_part(Material proposal) {
    double strongest = *std::max_element(proposal.kd.begin(), proposal.kd.end());
    for (const Lobe& lobe : proposal.lobes)
        strongest = std::max(strongest, *std::max_element(lobe.ks.begin(), lobe.ks.end()));
    for (double& kd : proposal.kd)
        kd = std::max(kd, strongest > 0 ? least_even_part * strongest : 1);
    return proposal;
}

/// Samples of each batch: enough batches to tell the noise, enough samples that they spread evenly.
std::size_t batch_size(const RenderSettings& settings) {
    constexpr std::size_t least = 16, of_tolerance = 32, most_batches = 8;
    if (settings.tolerance)
        return std::min(of_tolerance, settings.samples);
    const std::size_t batches = std::clamp<std::size_t>(settings.samples / least,
                                                        settings.samples > 1 ? 2 : 1, most_batches);
    return (settings.samples + batches - 1) / batches;
}

void check(const RenderSettings& settings) {
    if (settings.samples < 1 || settings.samples > most_render_samples)
        throw UsageError(fmt::format("{} samples a pixel; expected 1 to {}", settings.samples,
                                     most_render_samples));
    if (settings.bounces < 0 || settings.bounces > most_bounces)
        throw UsageError(
            fmt::format("{} bounces; expected 0 to {}", settings.bounces, most_bounces));
    if (settings.tolerance && !(*settings.tolerance > 0))
        throw UsageError(
            fmt::format("a tolerance of {}; expected a number above 0", *settings.tolerance));
}

} // namespace

/// A scene and how it is to be rendered, on the device.
struct Renderer::OnDevice {
    cl::Buffer words, texels;
    cl_uint4 keys{};
    const RenderSettings& settings;

    OnDevice(const Device& device, const Scene& scene, const RenderSettings& of)
        : words(upload(device, packed(scene))), settings(of) {
        const Environment none;
        const Environment& environment = scene.environment ? *scene.environment : none;
        const AliasTable table = scene.environment ? alias_table(environment) : AliasTable{};
        // As the texels of kernels/scene/lights.cl.
        std::vector<cl_uint8> packed_texels(environment.texels.size());
        const auto bits_of = [](double value) {
            const auto word = static_cast<float>(value);
            std::uint32_t bits;
            std::memcpy(&bits, &word, sizeof bits);
            return bits;
        };
        for (std::size_t i = 0; i < environment.texels.size(); ++i) {
            const Rgb& rgb = environment.texels[i];
            packed_texels[i] = {{bits_of(rgb[0]), bits_of(rgb[1]), bits_of(rgb[2]),
                                 bits_of(table.density[i]), table.own[i], table.other[i], 0, 0}};
        }
        const std::size_t bytes = packed_texels.size() * sizeof(cl_uint8);
        texels = make_buffer(device, bytes, CL_MEM_READ_ONLY);
        if (scene.environment) {
            prefer_large_pages(device, texels, bytes);
            device.queue.enqueueWriteBuffer(texels, CL_TRUE, 0, bytes, packed_texels.data());
        }
        const std::array<std::uint32_t, 4> of_seed = keys_of(of.seed, Sequence::Philox);
        keys.s[0] = of_seed[0];
        keys.s[1] = of_seed[1];
    }
};

std::array<std::size_t, 3> rgb_channels(const std::vector<std::string>& channels,
                                        const std::string& source) {
    RglChannels known;
    try {
        known = rgl_channels(channels, false, source);
    } catch (const InputError&) {
        throw InputError(fmt::format("{}: {} channels; expected one, three, or channels named by "
                                     "wavelengths in nm",
                                     source, channels.size()));
    }
    if (known.wavelengths.empty())
        return {known.source[0], known.source[1], known.source[2]};
    const auto nearest = [&](float wanted) {
        const auto at = std::min_element(
            known.wavelengths.begin(), known.wavelengths.end(),
            [&](float a, float b) { return std::abs(a - wanted) < std::abs(b - wanted); });
        return known.source[static_cast<std::size_t>(at - known.wavelengths.begin())];
    };
    return {nearest(620), nearest(545), nearest(465)};
}

Renderer::Renderer(const Device& device, const Material& material, const std::string& source)
    : device_(device), rgb_(rgb_channels(material.channels, source)),
      program_(build_render_program(device_, drawn_structure(material))),
      drawn_(device_, program_, in_rgb(material, rgb_)) {}

Renderer::Renderer(const Device& device, std::shared_ptr<const MeasuredBrdf> measured,
                   const Material& proposal, const std::string& source)
    : device_(device), rgb_(rgb_channels(measured->channels(), source)),
      measured_(std::move(measured)),
      program_(build_render_program(device_, drawn_structure(proposal))),
      drawn_(device_, program_, with_even_part(proposal)) {}

std::size_t Renderer::samples_at_once() const {
    if (!measured_)
        return samples_a_launch;
    // Values of all channels come at once.
    return paths_a_launch * 3 / std::max<std::size_t>(3, measured_->channels().size());
}

std::vector<float> Renderer::material_means(const OnDevice& scene, std::size_t first,
                                            std::size_t pixels, std::size_t count) const {
    const cl::Buffer out =
        make_buffer(device_, Film::planes * pixels * sizeof(float), CL_MEM_WRITE_ONLY);
    cl::Kernel kernel(program_, "render");
    cl_uint at = 0;
    for (const cl::Buffer* buffer : {&scene.words, &scene.texels, &drawn_.theta, &drawn_.table,
                                     &drawn_.strengths, &drawn_.coefficients})
        kernel.setArg(at++, *buffer);
    kernel.setArg(at++, scene.keys);
    kernel.setArg(at++, static_cast<cl_int>(scene.settings.drawn));
    kernel.setArg(at++, static_cast<cl_int>(scene.settings.bounces));
    kernel.setArg(at++, static_cast<cl_uint>(count));
    kernel.setArg(at++, static_cast<cl_uint>(first));
    kernel.setArg(at++, static_cast<cl_uint>(pixels));
    kernel.setArg(at++, out);
    enqueue_runs(device_, kernel, pixels);
    return download<float>(device_, out, Film::planes * pixels);
}

std::vector<float> Renderer::measured_means(const OnDevice& scene, std::size_t first,
                                            std::size_t pixels, std::size_t count) const {
    const auto width = static_cast<std::size_t>(device_.form.vector_width);
    const std::size_t groups = (count + width - 1) / width, vectors = pixels * groups;
    const std::size_t paths = vectors * width;
    const auto planes_of = [&](std::size_t planes) {
        return make_buffer(device_, planes * paths * sizeof(float));
    };
    const cl::Buffer state = planes_of(PATH_PLANES), pairs = planes_of(2 * DIRECTION_PLANES),
                     vertices = planes_of(VERTEX_PLANES), values = planes_of(6);
    const auto of_groups = static_cast<cl_uint>(groups), of_first = static_cast<cl_uint>(first),
               of_vectors = static_cast<cl_uint>(vectors);
    const auto run = [&](const char* name, std::size_t items, const auto&... arguments) {
        cl::Kernel kernel(program_, name);
        cl_uint at = 0;
        (kernel.setArg(at++, arguments), ...);
        enqueue_runs(device_, kernel, items);
    };
    run("begin_paths", vectors, scene.words, scene.keys, static_cast<cl_uint>(count), of_groups,
        of_first, of_vectors, state);
    Directions directions(2 * paths);
    std::vector<float> of_pairs(6 * paths);
    for (int n = 0; n <= scene.settings.bounces + 1; ++n) {
        const bool last = n > scene.settings.bounces;
        run("meet", vectors, scene.words, scene.texels, drawn_.theta, drawn_.table,
            drawn_.strengths, scene.keys, static_cast<cl_int>(scene.settings.drawn),
            static_cast<cl_int>(n), static_cast<cl_int>(last), of_groups, of_first, of_vectors,
            state, pairs, vertices);
        if (last)
            break;
        device_.queue.enqueueReadBuffer(pairs, CL_TRUE, 0,
                                        2 * DIRECTION_PLANES * paths * sizeof(float),
                                        directions.plane(Directions::WiX));
        const std::vector<float> f = measured_->evaluate(device_, directions);
        for (std::size_t ch = 0; ch < 3; ++ch)
            std::copy_n(f.begin() + static_cast<std::ptrdiff_t>(rgb_[ch] * 2 * paths), 2 * paths,
                        of_pairs.begin() + static_cast<std::ptrdiff_t>(ch * 2 * paths));
        device_.queue.enqueueWriteBuffer(values, CL_TRUE, 0, of_pairs.size() * sizeof(float),
                                         of_pairs.data());
        run("follow", vectors, scene.words, vertices, values, of_vectors, state);
    }
    const cl::Buffer out =
        make_buffer(device_, Film::planes * pixels * sizeof(float), CL_MEM_WRITE_ONLY);
    run("gather", pixels, state, static_cast<cl_uint>(count), of_groups,
        static_cast<cl_uint>(pixels), out);
    return download<float>(device_, out, Film::planes * pixels);
}

Film Renderer::render(const Scene& scene, const RenderSettings& settings,
                      const ProgressFunction& progress) const {
    constexpr std::size_t least_batches = 4; // that tell the noise well enough to stop by
    check(settings);
    OnDevice on_device(device_, scene, settings);
    Film film(scene.view.width, scene.view.height);
    const std::size_t size = batch_size(settings);
    const auto width = static_cast<std::size_t>(device_.form.vector_width);
    double done = 0;
    while (film.samples() < settings.samples) {
        const std::size_t count = std::min(size, settings.samples - film.samples());
        const double share = static_cast<double>(count) / static_cast<double>(settings.samples);
        const std::size_t piece =
            std::max<std::size_t>(1, samples_at_once() / padded(count, width));
        on_device.keys.s[2] = static_cast<cl_uint>(film.batches());
        for (std::size_t first = 0; first < film.pixels(); first += piece) {
            const std::size_t pixels = std::min(piece, film.pixels() - first);
            film.add(measured_ ? measured_means(on_device, first, pixels, count)
                               : material_means(on_device, first, pixels, count),
                     first, count);
            const double part =
                static_cast<double>(first + pixels) / static_cast<double>(film.pixels());
            if (!settings.tolerance)
                tell(progress, std::min(1.0, done + share * part));
        }
        film.end_batch(count);
        done += share;
        if (!settings.tolerance || film.batches() < least_batches)
            continue;
        const double left = film.noise() / *settings.tolerance; // falls as the root of samples
        tell(progress, std::min(1.0, std::max(done, 1 / std::max(1.0, left * left))));
        if (left <= 1)
            break;
    }
    return film;
}

} // namespace brdfit
