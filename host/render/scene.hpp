#pragma once

#include "host/directions.hpp"
#include "host/render/environment.hpp"
#include "kernels/scene/scene_words.h"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace brdfit {

/// A shape, in units of the scene; z is up.
struct SceneShape {
    shape_kind kind = SPHERE;
    Vector at{};            ///< centre
    double radius = 1;      ///< > 0
    double half_length = 0; ///< of a cylinder
    brushing brushed = AROUND;
    bool ground = false; ///< Lambertian, not of the material
};

/// A light besides the environment.
struct SceneLight {
    light_kind kind = POINT;
    Vector at{};               ///< where it is; directional: unit direction to it
    Rgb rgb{};                 ///< W/sr, W/m2 or W/(m2 sr), see light_kind
    Vector half_u{}, half_v{}; ///< of a rectangle: from the centre to the middles of two sides
    Vector normal{};           ///< of a rectangle: unit, the side that shines
};

/// From where a scene is seen: from a direction, at the least distance from which all shapes but
/// the ground are in the picture.
struct View {
    double theta = 90 * degree, phi = -90 * degree; ///< of the camera from the scene's middle
    double angle = 25 * degree;                     ///< of the smaller side of the picture
    std::size_t width = 512, height = 512;          ///< pixels
};

inline constexpr std::size_t most_side = 8192;                   ///< of a picture, pixels
inline constexpr std::size_t most_pixels = std::size_t{1} << 24; ///< of all that are made at once

struct Scene {
    std::vector<SceneShape> shapes; ///< at least one
    std::vector<SceneLight> lights;
    std::optional<Environment> environment;
    double turn = 0; ///< of the environment about z, radians
    Rgb ground{0.5, 0.5, 0.5};
    std::optional<Rgb> backdrop; ///< what the camera sees behind; none: the environment, or black
    View view;
};

/// The shapes of a name: sphere, row:N, grid:COLUMNSxROWS (of spheres), cylinder, plane, ground (a
/// sphere on a plane). Throws UsageError for others, and for more than 64 spheres.
std::vector<SceneShape> shapes_named(const std::string& name, brushing brushed);

/// View::theta for the shapes of a name: `theta`, or what suits them. Throws UsageError where a
/// plane would not be seen from above.
double view_theta(const std::string& shape, std::optional<double> theta);

/// A light from text: point:X,Y,Z,I or directional:THETA,PHI,E (degrees) or
/// rectangle:X,Y,Z,WIDTH,HEIGHT,L, which faces the origin; I, E, L one number or three, R,G,B.
/// Throws UsageError for others.
SceneLight light_from(const std::string& text);

/// The words of kernels/scene/scene_words.h. Throws UsageError where there is no light.
std::vector<float> packed(const Scene& scene);

/// Where the camera is and the vectors from it, as in scene_words.h.
struct Camera {
    Vector at, corner, across, down;
};
Camera camera_of(const Scene& scene);

} // namespace brdfit
