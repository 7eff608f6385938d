#include "host/render/scene.hpp"

#include "host/error.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numeric>

namespace brdfit {

namespace {

constexpr double gap = 2.25;          // between the centres of spheres
constexpr double far = 200;           // radius of what stands for an endless plane
constexpr double least_choice = 0.05; // of a light, of an even share

Vector scaled(const Vector& a, double s) {
    return {a[0] * s, a[1] * s, a[2] * s};
}

Vector plus(const Vector& a, const Vector& b) {
    return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}

double dot(const Vector& a, const Vector& b) {
    return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

Vector crossed(const Vector& a, const Vector& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

double length(const Vector& a) {
    return std::sqrt(dot(a, a));
}

/// Right, up and forward of the camera.
struct Axes {
    Vector right, up, forward;
};

Axes axes_of(const View& view) {
    const Vector out = direction(view.theta, view.phi);
    Axes axes;
    axes.forward = scaled(out, -1);
    axes.right = {-std::sin(view.phi), std::cos(view.phi), 0};
    axes.up = crossed(axes.right, axes.forward);
    return axes;
}

/// What a light sends to the scene's middle, about: to draw strong lights more often.
double strength(const SceneLight& light) {
    const double mean = (light.rgb[0] + light.rgb[1] + light.rgb[2]) / 3;
    const double d2 = std::max(dot(light.at, light.at), 1e-6);
    switch (light.kind) {
    case POINT:
        return mean / d2;
    case RECTANGLE:
        return mean * 4 * length(light.half_u) * length(light.half_v) / d2;
    default:
        return mean;
    }
}

void put(std::vector<float>& words, std::size_t at, const Vector& v) {
    for (std::size_t k = 0; k < v.size(); ++k)
        words[at + k] = static_cast<float>(v[k]);
}

} // namespace

Camera camera_of(const Scene& scene) {
    const View& view = scene.view;
    const Axes axes = axes_of(view);
    const double smaller = static_cast<double>(std::min(view.width, view.height));
    const double step = 2 * std::tan(view.angle / 2) / smaller; // a pixel, at distance 1
    const double half_x = step * static_cast<double>(view.width) / 2;
    const double half_y = step * static_cast<double>(view.height) / 2;
    // Every shape's bounding sphere lies within the four sides of the view.
    constexpr double margin = 1.08;
    double distance = 0;
    for (const SceneShape& shape : scene.shapes) {
        if (shape.ground)
            continue;
        const double radius =
            margin * (shape.kind == CYLINDER ? std::hypot(shape.radius, shape.half_length)
                      : shape.radius < far   ? shape.radius
                                             : 1.0);
        const double ahead = dot(shape.at, axes.forward);
        for (const auto& [axis, half] :
             {std::pair{axes.right, half_x}, std::pair{axes.up, half_y}}) {
            const double side = std::abs(dot(shape.at, axis));
            distance = std::max(distance, (side + radius * std::hypot(1, half)) / half - ahead);
        }
    }
    Camera camera;
    camera.at = scaled(axes.forward, -distance);
    camera.across = scaled(axes.right, step);
    camera.down = scaled(axes.up, -step);
    camera.corner = plus(axes.forward, plus(scaled(axes.right, -half_x), scaled(axes.up, half_y)));
    return camera;
}

std::vector<SceneShape> shapes_named(const std::string& name, brushing brushed) {
    constexpr std::size_t most_spheres = 64;
    std::size_t columns = 0, rows = 1;
    char rest = 0;
    if (name == "sphere")
        columns = 1;
    else if (std::sscanf(name.c_str(), "row:%4zu%c", &columns, &rest) != 1 &&
             std::sscanf(name.c_str(), "grid:%4zux%4zu%c", &columns, &rows, &rest) != 2)
        columns = 0;
    std::vector<SceneShape> shapes;
    if (columns > 0 && rows > 0 && columns * rows <= most_spheres) {
        for (std::size_t row = 0; row < rows; ++row)
            for (std::size_t column = 0; column < columns; ++column) {
                SceneShape sphere;
                sphere.brushed = brushed;
                sphere.at = {
                    gap * (static_cast<double>(column) - 0.5 * static_cast<double>(columns - 1)), 0,
                    gap * (0.5 * static_cast<double>(rows - 1) - static_cast<double>(row))};
                shapes.push_back(sphere);
            }
        return shapes;
    }
    SceneShape shape;
    shape.brushed = brushed;
    if (name == "cylinder") {
        shape.kind = CYLINDER;
        shape.radius = 0.6;
        shape.half_length = 1;
    } else if (name == "plane") {
        shape.kind = DISC;
        shape.radius = far;
    } else if (name != "ground")
        throw UsageError(
            fmt::format("--shape {}: expected sphere, row:N or grid:COLUMNSxROWS of at "
                        "most {} spheres, cylinder, plane, or ground",
                        name, most_spheres));
    shapes.push_back(shape);
    if (name == "ground") {
        shape.kind = DISC;
        shape.at = {0, 0, -1};
        shape.radius = far;
        shape.ground = true;
        shapes.push_back(shape);
    }
    return shapes;
}

double view_theta(const std::string& shape, std::optional<double> theta) {
    const bool level = shape == "plane" || shape == "ground";
    const double chosen = theta.value_or((level ? 70 : 90) * degree);
    if (level && !(chosen < 89.99 * degree))
        throw UsageError(
            fmt::format("--view: a {} is seen from above; expected less than 90 degrees", shape));
    return chosen;
}

SceneLight light_from(const std::string& text) {
    const auto fail = [&] {
        return UsageError(fmt::format(
            "--light {}: expected point:X,Y,Z,INTENSITY, directional:THETA,PHI,IRRADIANCE or "
            "rectangle:X,Y,Z,WIDTH,HEIGHT,RADIANCE, the last of them one number or R,G,B",
            text));
    };
    const std::size_t colon = text.find(':');
    const std::string kind = text.substr(0, colon);
    const std::size_t places = kind == "point"         ? 3
                               : kind == "directional" ? 2
                               : kind == "rectangle"   ? 5
                                                       : 0;
    if (places == 0 || colon == std::string::npos)
        throw fail();
    std::vector<double> numbers;
    const char* at = text.c_str() + colon + 1;
    for (char* end = nullptr;; at = end + 1) {
        numbers.push_back(std::strtod(at, &end));
        if (end == at || !std::isfinite(numbers.back()))
            throw fail();
        if (*end == 0)
            break;
        if (*end != ',')
            throw fail();
    }
    if (numbers.size() != places + 1 && numbers.size() != places + 3)
        throw fail();
    SceneLight light;
    for (std::size_t ch = 0; ch < 3; ++ch)
        light.rgb[ch] = numbers[numbers.size() == places + 1 ? places : places + ch];
    if (std::any_of(light.rgb.begin(), light.rgb.end(), [](double x) { return x < 0; }) ||
        light.rgb == Rgb{})
        throw fail();
    if (kind == "directional") {
        light.kind = DIRECTIONAL;
        light.at = direction(numbers[0] * degree, numbers[1] * degree);
        return light;
    }
    light.kind = kind == "point" ? POINT : RECTANGLE;
    light.at = {numbers[0], numbers[1], numbers[2]};
    if (!(length(light.at) > 0) || (kind == "rectangle" && !(numbers[3] > 0 && numbers[4] > 0)))
        throw fail();
    if (kind == "rectangle") {
        light.normal = scaled(light.at, -1 / length(light.at));
        const Vector level{-light.at[1], light.at[0], 0};
        const Vector u = length(level) > 1e-9 * length(light.at) ? scaled(level, 1 / length(level))
                                                                 : Vector{1, 0, 0};
        light.half_u = scaled(u, numbers[3] / 2);
        light.half_v = scaled(crossed(light.normal, u), numbers[4] / 2);
    }
    return light;
}

std::vector<float> packed(const Scene& scene) {
    std::vector<double> strengths;
    if (scene.environment) {
        const Rgb flux = scene.environment->flux();
        strengths.push_back((flux[0] + flux[1] + flux[2]) / 12);
    }
    for (const SceneLight& light : scene.lights)
        strengths.push_back(strength(light));
    if (strengths.empty())
        throw UsageError("a scene without light; expected an environment or --light");
    const double even = 1 / static_cast<double>(strengths.size());
    const double sum = std::accumulate(strengths.begin(), strengths.end(), 0.0);
    for (double& x : strengths)
        x = (1 - least_choice) * x / sum + least_choice * even;

    std::vector<float> words(SCENE_WORDS + scene.shapes.size() * SHAPE_WORDS +
                             strengths.size() * LIGHT_WORDS);
    const Camera camera = camera_of(scene);
    put(words, CAMERA, camera.at);
    put(words, CORNER, camera.corner);
    put(words, ACROSS, camera.across);
    put(words, DOWN, camera.down);
    words[FILM_WIDTH] = static_cast<float>(scene.view.width);
    put(words, GROUND, scene.ground);
    put(words, BACKDROP, scene.backdrop.value_or(Rgb{}));
    words[SHOWS_ENVIRONMENT] = scene.backdrop ? 0 : 1;
    words[SHAPES] = static_cast<float>(scene.shapes.size());
    words[LIGHTS] = static_cast<float>(strengths.size());
    std::size_t at = SCENE_WORDS;
    for (const SceneShape& shape : scene.shapes) {
        words[at + SHAPE_KIND] = static_cast<float>(shape.kind);
        put(words, at + SHAPE_AT, shape.at);
        words[at + SHAPE_RADIUS] = static_cast<float>(shape.radius);
        words[at + SHAPE_HALF_LENGTH] = static_cast<float>(shape.half_length);
        words[at + SHAPE_BRUSHED] = static_cast<float>(shape.brushed);
        words[at + SHAPE_IS_GROUND] = shape.ground ? 1 : 0;
        at += SHAPE_WORDS;
    }
    std::size_t number = 0;
    if (scene.environment) {
        words[ENVIRONMENT_WIDTH] = static_cast<float>(scene.environment->width);
        words[ENVIRONMENT_HEIGHT] = static_cast<float>(scene.environment->height);
        words[ENVIRONMENT_TURN] = static_cast<float>(scene.turn / (2 * pi));
        words[ENVIRONMENT_CHOICE] = static_cast<float>(strengths[0]);
        words[at + LIGHT_KIND] = static_cast<float>(ENVIRONMENT);
        words[at + LIGHT_CHOICE] = words[ENVIRONMENT_CHOICE];
        at += LIGHT_WORDS;
        number = 1;
    }
    for (const SceneLight& light : scene.lights) {
        words[at + LIGHT_KIND] = static_cast<float>(light.kind);
        words[at + LIGHT_CHOICE] = static_cast<float>(strengths[number++]);
        put(words, at + LIGHT_AT, light.at);
        put(words, at + LIGHT_RGB, light.rgb);
        put(words, at + LIGHT_HALF_U, light.half_u);
        put(words, at + LIGHT_HALF_V, light.half_v);
        put(words, at + LIGHT_NORMAL, light.normal);
        at += LIGHT_WORDS;
    }
    return words;
}

} // namespace brdfit
