// What is known of a pair of directions, in the order in which the host (host/directions.hpp) and the
// kernels keep it.
#ifdef __cplusplus
namespace brdfit {
#endif

enum direction_plane {
    WI_X, WI_Y, WI_Z, // unit, to the light
    WO_X, WO_Y, WO_Z, // unit, to the viewer
    H_X, H_Y, H_Z,    // unit, (wi + wo) / |wi + wo|
    HALF_COSINE,      // wi.h = wo.h
    DIRECTION_PLANES
};

#ifdef __cplusplus
}
#endif
