// What host/evaluate/rgl.cpp and warp.cl agree on: the whole numbers that describe an RGL file's
// tables.
enum warp_shape {
    PHI_NODES,
    THETA_NODES,
    ISOTROPIC, // 1: azimuths of h count from wi's
    REDUCTION, // 2: wi and -wi have one table; 4: mirrored at x and y too
    JACOBIAN,  // 0: the value is the table's alone
    NDF_WIDTH,
    NDF_HEIGHT,
    SIGMA_WIDTH,
    SIGMA_HEIGHT,
    VNDF_WIDTH,
    VNDF_HEIGHT,
    TABLE_WIDTH,
    TABLE_HEIGHT,
    CHANNELS,
    WARP_SHAPES
};
