// The words of a packed scene, float32, which the host packs (host/render/scene.cpp) and the
// kernels read: a head, then shapes, then lights. Metres or any other unit of length, z up.
#ifdef __cplusplus
namespace brdfit {
#endif

enum scene_word {
    // The camera: where it is, and the ray's direction through the point (x, y) of the film, in
    // pixels
    // from the upper left corner: CORNER + x ACROSS + y DOWN.
    CAMERA,
    CORNER = CAMERA + 3,
    ACROSS = CORNER + 3,
    DOWN = ACROSS + 3,
    FILM_WIDTH = DOWN + 3,
    GROUND,                           // albedo of what is ground: red, green, blue
    BACKDROP = GROUND + 3,            // radiance that the camera sees where nothing is
    SHOWS_ENVIRONMENT = BACKDROP + 3, // 1: the environment instead
    ENVIRONMENT_WIDTH,                // in texels; 0: there is none
    ENVIRONMENT_HEIGHT,
    ENVIRONMENT_TURN,   // of its left edge about z, in turns
    ENVIRONMENT_CHOICE, // the environment's probability among the lights
    SHAPES,             // how many
    LIGHTS,
    SCENE_WORDS
};

enum shape_kind {
    SPHERE,
    CYLINDER, // along x, with its ends
    DISC      // horizontal, seen from above
};
enum shape_word {
    SHAPE_KIND,
    SHAPE_AT, // the centre: x, y, z
    SHAPE_RADIUS = SHAPE_AT + 3,
    SHAPE_HALF_LENGTH, // of a cylinder
    SHAPE_BRUSHED,     // a brushing
    SHAPE_IS_GROUND,   // 1: Lambertian of albedo GROUND in place of the material
    SHAPE_WORDS
};
// Which way the tangent runs: around the shape's axis (a sphere's and a disc's is z, a cylinder's
// x), or along it (a sphere's meridians, a disc's x).
enum brushing { AROUND, ALONG };

enum light_kind {
    ENVIRONMENT,
    POINT,       // radiant intensity, W/sr
    DIRECTIONAL, // irradiance on what faces it, W/m2
    RECTANGLE    // radiance of its front, W/(m2 sr)
};
enum light_word {
    LIGHT_KIND,
    LIGHT_CHOICE, // its probability among the lights
    LIGHT_AT,     // where it is; directional: the unit direction to it
    LIGHT_RGB = LIGHT_AT + 3,
    // Of a rectangle: from the centre to the middles of two sides, and the unit normal.
    LIGHT_HALF_U = LIGHT_RGB + 3,
    LIGHT_HALF_V = LIGHT_HALF_U + 3,
    LIGHT_NORMAL = LIGHT_HALF_V + 3,
    LIGHT_WORDS = LIGHT_NORMAL + 3
};

// By what directions are drawn: lights and the material's sampler together, one of them, or evenly
// over the hemisphere. Point and directional lights are always drawn.
enum strategy { BOTH, LIGHTS_ALONE, MATERIAL_ALONE, UNIFORM };

// The planes of a path's state where its vertices are handled one by one (measured BRDFs).
enum path_plane {
    PATH_AT,
    PATH_TO = PATH_AT + 3,
    PATH_THROUGH = PATH_TO + 3,
    PATH_RADIANCE = PATH_THROUGH + 3,
    PATH_DENSITY = PATH_RADIANCE + 3,
    PATH_SHAPE,
    PATH_ALIVE,
    PATH_COVERED,
    PATH_PLANES
};
// What a vertex hands to the host: two pairs of directions at which the BRDF is wanted, to the
// light and to where the path goes on, as the planes of direction_planes.h; then what each value is
// multiplied by.
enum vertex_plane {
    VERTEX_LIGHT_SCALE, // red, green, blue
    VERTEX_NEXT_SCALE = VERTEX_LIGHT_SCALE + 3,
    VERTEX_GROUND, // 1: the BRDF is the ground's
    VERTEX_PLANES
};

#ifdef __cplusplus
}
#endif
