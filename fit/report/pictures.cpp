#include "fit/report/pictures.hpp"

#include "fit/report/html.hpp"
#include "host/albedo/material.hpp"
#include "host/albedo/measured.hpp"
#include "host/error.hpp"
#include "host/evaluate/evaluate.hpp"
#include "host/evaluate/lines.hpp"
#include "host/image/difference.hpp"
#include "host/image/jpeg.hpp"
#include "host/image/plot.hpp"
#include "host/render/picture.hpp"
#include "host/render/renderer.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numeric>
#include <optional>
#include <vector>

namespace brdfit {

namespace {

constexpr double difference_scale = 4, albedo_tolerance = 5e-3;
constexpr std::size_t albedo_angles = 19; // every five degrees
constexpr double incidences[] = {15, 45, 70};

/// One of what a card compares.
struct Shown {
    std::string what; ///< for people
    const MeasuredBrdf* data = nullptr;
    const Material* fit = nullptr;
    std::optional<Image> picture; ///< toned
};

Material even_material() {
    Material even;
    even.channels = {"Y"};
    even.diffuse = &model_named("lambert");
    even.kd = {1};
    return even;
}

std::string image_html(const Image& image, const std::string& alt, const std::string& caption) {
    return fmt::format("<figure><img loading=\"lazy\" width=\"{}\" height=\"{}\" alt=\"{}\" "
                       "src=\"data:image/jpeg;base64,{}\" /><figcaption>{}</figcaption></figure>\n",
                       image.width, image.height, html(alt), base64(jpeg_bytes(image)),
                       html(caption));
}

std::vector<double> mean_over_channels(const std::vector<float>& values, std::size_t count) {
    std::vector<double> mean(count);
    const std::size_t channels = values.size() / count;
    for (std::size_t i = 0; i < values.size(); ++i)
        mean[i % count] += static_cast<double>(values[i]) / static_cast<double>(channels);
    return mean;
}

/// All angles of incidence in one curve, broken between them.
Curve polar_curve(const Device& device, const Shown& shown) {
    Curve curve{shown.what, {}, {}};
    for (const double theta : incidences) {
        const Line line = incidence_line(theta, 2);
        const std::vector<double> values = mean_over_channels(
            shown.data != nullptr ? shown.data->evaluate(device, line.directions)
                                  : evaluate(device, *shown.fit, line.directions),
            line.x.size());
        for (std::size_t k = 0; k < values.size(); ++k) {
            curve.x.push_back(line.x[k]);
            curve.y.push_back(line.directions.above_horizon(k) ? values[k] : std::nan(""));
        }
        curve.x.push_back(90);
        curve.y.push_back(std::nan(""));
    }
    return curve;
}

Curve albedo_curve(const Device& device, const Shown& shown, std::mutex& of_albedo) {
    Curve curve{shown.what, {}, {}};
    AlbedoGrid grid;
    grid.thetas = albedo_angles;
    const Albedo known = [&] {
        if (shown.data != nullptr)
            return measured_albedo(shown.data->samples(), grid, albedo_tolerance);
        const std::lock_guard<std::mutex> turn(of_albedo);
        return albedo(device, *shown.fit, grid, albedo_tolerance);
    }();
    const std::size_t count = known.columns > 0 ? known.columns : known.count();
    for (std::size_t k = 0; k < count; ++k) {
        double sum = 0;
        for (const std::vector<double>& values : known.values)
            sum += values[k] / static_cast<double>(known.values.size());
        curve.x.push_back(known.theta[k] / degree);
        curve.y.push_back(sum);
    }
    return curve;
}

} // namespace

CardPictures::CardPictures(const Device& device, const ReportOptions& options, DeviceTurns& turns)
    : device_(device), options_(options), turns_(turns) {
    scene_.shapes = shapes_named("sphere", AROUND);
    scene_.environment = soft_box_environment();
    scene_.view.width = scene_.view.height = options.size;
}

std::string CardPictures::html_of(const std::string& name,
                                  const std::shared_ptr<const MeasuredBrdf>& data,
                                  const ReportedFit* best, const ReportedFit* chosen) const {
    std::vector<Shown> all;
    if (data)
        all.push_back({"data", data.get(), nullptr, {}});
    if (best != nullptr)
        all.push_back({"best: " + best->name(), nullptr, &best->result.material, {}});
    if (chosen != nullptr)
        all.push_back({chosen->name(), nullptr, &chosen->result.material, {}});
    RenderSettings settings;
    settings.samples = options_.samples;
    std::string spheres, plots, unknown, key = "<ul class=\"key\">";
    std::vector<Curve> polar, albedos;
    for (std::size_t i = 0; i < all.size(); ++i) {
        Shown& shown = all[i];
        const Renderer renderer =
            shown.data != nullptr
                ? Renderer(device_, data, best != nullptr ? best->result.material : even_material(),
                           name)
                : Renderer(device_, *shown.fit, name);
        const Film film = [&] {
            const std::lock_guard<std::mutex> turn(shown.data != nullptr ? turns_.of_data
                                                                         : turns_.of_material);
            return renderer.render(scene_, settings);
        }();
        shown.picture = toned(image_of(film), 0, Tone::Reinhard);
        std::string caption = shown.what;
        if (data && i == 0)
            caption += fmt::format("; the pictures' noise: {:.2g} %", 100 * film.noise());
        if (data && i > 0) {
            const std::vector<float> seen = flip(*all[0].picture, *shown.picture);
            caption += fmt::format(
                "; PSNR {:.1f} dB, FLIP {:.3f}", psnr(*all[0].picture, *shown.picture).all,
                std::accumulate(seen.begin(), seen.end(), 0.0) / static_cast<double>(seen.size()));
        }
        spheres +=
            image_html(*shown.picture, fmt::format("Sphere of {}, {}", name, caption), caption);
        if (data && i > 0) {
            const std::string what =
                fmt::format("difference from the data, times {:g}", difference_scale);
            spheres += image_html(difference(*all[0].picture, *shown.picture, difference_scale),
                                  fmt::format("{}: {}, of {}", name, what, shown.what), what);
        }
        polar.push_back(polar_curve(device_, shown));
        try {
            albedos.push_back(albedo_curve(device_, shown, turns_.of_albedo));
        } catch (const InputError& error) {                       // of few scattered samples, say
            albedos.push_back({shown.what, {0}, {std::nan("")}}); // the others keep their colours
            unknown += fmt::format("; {}: {}", shown.what, error.what());
        }
        key += fmt::format("<li>{}{}</li>", legend_mark(i), html(shown.what));
    }
    PlotOptions of_polar;
    of_polar.title = fmt::format("{} in the plane of incidence, light at 15, 45 and 70 degrees "
                                 "from the left",
                                 name);
    of_polar.y_title = "BRDF (1/sr)";
    plots += fmt::format("<figure>{}<figcaption>In the plane of incidence, light at 15, 45, 70 "
                         "degrees</figcaption></figure>\n",
                         polar_plot_element(polar, of_polar));
    PlotOptions of_albedo;
    of_albedo.title = fmt::format("Directional albedo of {}", name);
    of_albedo.y_title = "directional albedo";
    plots += fmt::format("<figure>{}<figcaption>Directional albedo{}</figcaption></figure>\n",
                         plot_element(albedos, of_albedo), html(unknown));
    return fmt::format("<div class=\"spheres\">\n{}</div>\n{}</ul>\n<div class=\"figures\">\n{}"
                       "</div>\n",
                       spheres, key, plots);
}

} // namespace brdfit
