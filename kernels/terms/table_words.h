// The words of a packed microfacet table: float32, integers up to 2^24 among them. The host packs
// them (host/microfacet/table.cpp), the kernels read table[MEAN_X], part[AMPLITUDE]. Offsets count
// from the table's begin.
#ifdef __cplusplus
namespace brdfit {
#endif

enum table_word {
    CORRELATED,  // 1: correlated shadowing, Eq. 14
    MEAN_HEIGHT, // <h.n>
    MEAN_X,      // the integral of h p(h)
    MEAN_Y,
    MEAN_Z,
    ELEVATION_SCALE, // a of the grid's elevations, see grid_row
    ELEVATION_END,   // asinh(pi / (2 a))
    AZIMUTH_STRETCH,
    GRID_ROWS,
    GRID_COLUMNS,  // 1: isotropic
    GRID_SECTOR,   // a grid_sector
    BEHIND,        // offset of the plane of g(-k), or of log(g) where the normals lean
    REFLECTANCE_0, // of R at f0 = 0
    REFLECTANCE_1,
    DIFFUSE_SCALE, // c of Eq. 28
    METAL,
    PARTS,
    FIRST_PART, // offset
    FACETS,     // offset of the table of Lambertian facets
    FACET_ROWS,
    FACET_COLUMNS,
    LEANS,
    STEEP, // share of directions that are drawn blindly, below 1
    HEAD_WORDS
};

// Which azimuths the columns are over: all, or what is left where g is mirrored in y, or in x and
// in y.
enum grid_sector { WHOLE_TURN = 0, HALF_TURN = 2, QUARTER_TURN = 4 };
// Columns that a plane of a grid with more than one has besides: before the first, and in all.
enum { COLUMNS_BEFORE = 1, COLUMNS_BEYOND = 3 };

// A part: amplitude times a shape in a frame of its own, times an image.
enum part_word {
    KIND, // a part_kind
    AMPLITUDE,
    INVERSE_X2, // 1 / sigma_x^2, or velvet's 1 / sigma^2
    INVERSE_Y2,
    FRAME,             // nine words, the rows of the matrix that takes h to the part's frame
    IMAGE = FRAME + 9, // offset of the image's or tabulated values; 0: none
    IMAGE_WIDTH,       // or azimuths; 1: isotropic
    IMAGE_HEIGHT,      // or polar angles
    IMAGE_EXTENT,      // half the width of the disk's part that the image covers; 0: by angles
    // Sampling and quadrature: polar angles from a least one, azimuths by psi,
    // (cos phi, sin phi) ~ (stretch_x cos psi, stretch_y sin psi).
    LEAST_THETA,
    STRETCH_X,
    STRETCH_Y,
    PROBABILITY,
    CELL_ROWS,
    CELL_COLUMNS,
    CELL_EDGES,     // offset of CELL_ROWS + 1 shares of the range of polar angles
    MARGINAL,       // offset of CELL_COLUMNS + 1 cumulative probabilities
    CONDITIONAL,    // offset of those of the rows, a column after the other
    GREATEST_THETA, // of what is no Gaussian
    PART_WORDS
};

enum part_kind {
    GAUSSIAN, // exp(-(x/z)^2 / sigma_x^2 - (y/z)^2 / sigma_y^2), Eq. 34
    VELVET,   // exp(-cot^2 / sigma^2), Eq. 35
    TABULATED // bilinear over polar angle and azimuth
};

// Where a Gaussian counts as ended, in sigmas: exp(-36).
#define REACH 6.0f
// The least g, as a share of <h.n>.
#define LEAST_AREA 1e-9f

#ifdef __cplusplus
}
#endif
