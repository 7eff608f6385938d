// What is known of a pair of directions, in the order in which the host (host/directions.hpp) and
// the kernels keep it.
#ifdef __cplusplus
namespace brdfit {
#endif

// wi to the light, wo to the viewer, h = (wi + wo) / |wi + wo|: unit vectors; then wi.h = wo.h.
// clang-format off
enum direction_plane {
    WI_X, WI_Y, WI_Z,
    WO_X, WO_Y, WO_Z,
    H_X, H_Y, H_Z,
    HALF_COSINE,
    DIRECTION_PLANES
};
// clang-format on

#ifdef __cplusplus
}
#endif
