// What host/evaluate/sample.cpp and sample.cl agree on.
enum {
    HEIGHTS = 32, // of the table of albedos that components are drawn by
    AZIMUTHS = 9
};
// The planes that a draw writes; from DRAWN_WEIGHTS on one a channel.
enum drawn_plane { DRAWN_WI_X, DRAWN_WI_Y, DRAWN_WI_Z, DRAWN_PDF, DRAWN_WEIGHTS };
