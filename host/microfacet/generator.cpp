#include "host/microfacet/generator.hpp"

#include "host/device/buffer.hpp"
#include "host/device/kernels.hpp"
#include "host/error.hpp"
#include "host/microfacet/nodes.hpp"
#include "kernels/passes/generate.h"
#include "kernels/terms/table_words.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

namespace brdfit {

namespace {

cl::Program generator_program(const Device& device) {
    return build_kernels(
        device,
        "#define TABLES\n#define ROUGHNESSES 2\n" +
            kernel_texts({"base/common.cl", "base/direction_planes.h", "base/geometry.cl",
                          "terms/schlick.cl", "terms/half_vectors.cl", "terms/table_words.h",
                          "terms/distribution.cl", "terms/grid.cl", "passes/generate.h",
                          "passes/generate.cl"}),
        "the generator");
}

constexpr std::size_t tile = VISIBLE_TILE;
/// Pairs of a node and a direction a launch, about: a second of two cores, after which progress is
/// told.
constexpr std::size_t most_pairs = std::size_t{1} << 30;
/// Nodes on the device at once, about: 32 MiB, whatever the distribution.
constexpr std::size_t most_nodes = std::size_t{1} << 21;
/// Of <h.n>: single precision holds products of two areas down to LEAST_AREA of it.
constexpr double least_height = 1e-10, most_height = 1e15;
/// Parts with less than this share of the normals do with `coarse` nodes for g within R.
constexpr double small_share = 0.125;
/// Nodes of g at the grid's points, of g within R, and of R (see nodes_of).
constexpr std::size_t fine = 4, middle = 2, coarse = 1;
constexpr std::size_t facet_rows = 24, facet_columns = 25;

/// The elevation over which g changes near the horizon: the width of what is sharpest there.
double elevation_scale(const Distribution& distribution) {
    double scale = 1;
    for (const DistributionPart& part : distribution.parts) {
        if (part.tilt != 0)
            continue;
        if (part.shape == Shape::Gaussian)
            scale = std::min({scale, part.sigma_x, part.sigma_y});
        if (part.shape == Shape::Tabulated && part.table->width == 1) {
            // Where the values have fallen to half.
            const std::vector<float>& p = part.table->values;
            const float most = *std::max_element(p.begin(), p.end());
            std::size_t i = 0;
            while (i + 1 < p.size() && p[i] >= 0.5F * most)
                ++i;
            scale = std::min(scale, std::max(part.table->thetas[i], 1e-3));
        }
    }
    return std::max(scale, 5e-3);
}

/// Near x or y g changes over azimuths of the ratio of the widths, near the other as its sine does:
/// the root of the ratio serves both.
double azimuth_ratio(const Distribution& distribution) {
    double ratio = 1;
    for (const DistributionPart& part : distribution.parts) {
        if (part.shape != Shape::Gaussian || part.table != nullptr || part.turn != 0)
            return 1;
        const std::array<double, 2> widths = azimuth_stretch(part);
        double own = std::sqrt(widths[0] / widths[1]);
        if (part.tilt != 0)
            own = distribution.sector == Sector::Half ? std::min(0.4, own) : 1;
        if (std::abs(std::log(own)) > std::abs(std::log(ratio)))
            ratio = own;
    }
    return ratio;
}

Grid grid_of(const Distribution& distribution, std::size_t points) {
    Grid grid;
    grid.sector = distribution.sector;
    grid.scale = elevation_scale(distribution);
    if (grid.sector == Sector::Isotropic) {
        grid.rows = points;
        return grid;
    }
    if (grid.sector != Sector::All)
        grid.stretch = azimuth_ratio(distribution);
    const double columns_a_row = grid.sector == Sector::Quarter ? 0.5
                                 : grid.sector == Sector::Half  ? 1
                                                                : 2;
    const double wanted = std::sqrt(static_cast<double>(points) * columns_a_row);
    grid.columns = std::max<std::size_t>(4, static_cast<std::size_t>(std::lround(wanted)));
    grid.rows = std::max<std::size_t>(
        4, static_cast<std::size_t>(
               std::lround(static_cast<double>(points) / static_cast<double>(grid.columns))));
    return grid;
}

/// The grid that R is computed with, fine enough for 1e-4.
Grid inner_grid(const Distribution& distribution, std::size_t fineness) {
    Grid grid = grid_of(distribution, least_points);
    grid.rows = grid.sector == Sector::Isotropic ? 512 : 96;
    const bool stretched = std::abs(std::log(grid.stretch)) > 0.7;
    if (grid.sector == Sector::Quarter)
        grid.columns = stretched ? 65 : 33;
    if (grid.sector == Sector::Half)
        grid.columns = stretched ? 129 : 65;
    if (grid.sector == Sector::All)
        grid.columns = 128;
    // Sharp and tilted: g has an edge across the hemisphere.
    const bool sharp = std::any_of(
        distribution.parts.begin(), distribution.parts.end(), [](const DistributionPart& part) {
            return part.tilt != 0 && std::min(part.sigma_x, part.sigma_y) < 0.08;
        });
    if (sharp && grid.sector != Sector::Isotropic) {
        grid.rows = 192;
        grid.columns = 2 * grid.columns - (grid.sector == Sector::All ? 0 : 1);
    }
    if (fineness > 1) {
        grid.rows *= fineness;
        grid.columns *= grid.columns > 1 ? fineness : 1;
    }
    return grid;
}

std::vector<Vector> directions_of(const Grid& grid) {
    std::vector<Vector> directions;
    for (std::size_t r = 0; r < grid.rows; ++r)
        for (std::size_t k = 0; k < grid.columns; ++k)
            directions.push_back(grid.direction(static_cast<double>(r), static_cast<double>(k)));
    return directions;
}

/// Planes x, y, z of `stride`, the rest repeating the last.
std::vector<float> planes_of(const std::vector<Vector>& directions, std::size_t stride) {
    std::vector<float> planes(3 * stride);
    for (std::size_t a = 0; a < 3; ++a)
        for (std::size_t i = 0; i < stride; ++i)
            planes[a * stride + i] =
                static_cast<float>(directions[std::min(i, directions.size() - 1)][a]);
    return planes;
}

/// The distribution as the kernels read it, with a grid that nothing reads.
MicrofacetTable bare_table(const Distribution& distribution) {
    MicrofacetTable table;
    table.distribution = distribution;
    table.g.resize(table.grid.count());
    return table;
}

std::vector<float> to_floats(const std::vector<double>& values) {
    return {values.begin(), values.end()};
}

/// Adds what kernels wrote for each block, [item][block][value], to the sums, [item][value].
void add_blocks(const std::vector<float>& partial, std::size_t blocks, std::size_t values,
                double* sums) {
    for (std::size_t i = 0; i < partial.size() / (blocks * values); ++i)
        for (std::size_t v = 0; v < values; ++v) {
            double sum = 0;
            for (std::size_t b = 0; b < blocks; ++b)
                sum += partial[(i * blocks + b) * values + v];
            *sums++ += sum;
        }
}

/// Collects the probabilities of a part's cells from its nodes' weights.
class CellSums {
  public:
    explicit CellSums(const DistributionPart& part) {
        const bool tabulated = part.shape == Shape::Tabulated;
        const bool image = part.table != nullptr && !tabulated;
        std::size_t bands = image ? 128 : 32;
        cells_.columns = image ? 256 : 64;
        cells_.edges = {0};
        if (tabulated) {
            constexpr std::size_t most = 128;
            const double end = greatest_theta(part);
            const std::vector<double>& thetas = part.table->thetas;
            const std::size_t step = (thetas.size() + most - 1) / most;
            for (std::size_t i = 0; i < thetas.size(); i += step)
                if (thetas[i] / end > cells_.edges.back() + 1e-6 && thetas[i] < end * (1 - 1e-6))
                    cells_.edges.push_back(thetas[i] / end);
            cells_.edges.push_back(1);
            bands = cells_.edges.size() - 1;
            cells_.columns = std::clamp<std::size_t>(part.table->width, 16, most);
        } else
            for (std::size_t i = 1; i <= bands; ++i)
                cells_.edges.push_back(static_cast<double>(i) / static_cast<double>(bands));
        mass_.resize(bands * cells_.columns);
    }

    void add(double share, double psi, double weight) {
        const std::size_t bands = cells_.edges.size() - 1;
        const double turn = psi / (2 * pi);
        const auto column = std::min(cells_.columns - 1,
                                     static_cast<std::size_t>((turn - std::floor(turn)) *
                                                              static_cast<double>(cells_.columns)));
        const auto next = std::upper_bound(cells_.edges.begin(), cells_.edges.end(), share);
        const auto row = static_cast<std::size_t>(next - cells_.edges.begin()) - 1;
        mass_[column * bands + std::min(row, bands - 1)] += weight;
        whole_ += weight;
    }

    /// The cells of what was added, times a factor. Every cell has some: p may be positive where no
    /// node is.
    SamplingCells cells(double factor) const {
        SamplingCells cells = cells_;
        const double least = 1e-4 * whole_ / static_cast<double>(mass_.size());
        for (const double m : mass_)
            cells.mass.push_back(static_cast<float>(std::max(factor * (m + least), 1e-30)));
        return cells;
    }

  private:
    SamplingCells cells_;
    std::vector<double> mass_; // [azimuth][row]
    double whole_ = 0;
};

/// What the shares multiply the amplitudes by. `masses`: of the parts with their amplitudes.
std::vector<double> factors_of(const Distribution& distribution,
                               const std::vector<double>& masses) {
    std::vector<double> factors(distribution.parts.size(), 1);
    for (const Share& share : distribution.shares) {
        double whole = share.normalised ? 0 : 1;
        for (std::size_t i = share.first; share.normalised && i < share.first + share.count; ++i)
            whole += factors[i] * masses[i];
        for (std::size_t i = share.first; i < share.first + share.count; ++i)
            factors[i] *= share.mass / whole;
    }
    return factors;
}

} // namespace

Generator::Generator(const Device& device) : device_(device), program_(generator_program(device)) {}

void Generator::for_pieces(const Distribution& distribution,
                           const std::vector<std::size_t>& fineness,
                           const std::function<void(const Piece&)>& use) const {
    const auto width = static_cast<std::size_t>(device_.form.vector_width);
    const auto local = static_cast<std::size_t>(device_.form.local_size);
    const auto block = static_cast<std::size_t>(device_.form.block);
    const cl::Buffer table = upload(device_, packed_areas(bare_table(distribution)));
    cl::Kernel kernel(program_, "nodes");
    for (std::size_t n = 0; n < distribution.parts.size(); ++n) {
        const PartNodes nodes = nodes_of(distribution.parts[n], fineness[n]);
        Piece piece;
        piece.part = n;
        piece.shares = nodes.shares.x;
        Quadrature shares = nodes.shares;
        piece.rows = padded(shares.size(), width);
        shares.x.resize(piece.rows, 0.5);
        shares.w.resize(piece.rows, 0);
        const cl::Buffer x = upload(device_, to_floats(shares.x));
        const cl::Buffer w = upload(device_, to_floats(shares.w));
        const std::size_t most = std::max<std::size_t>(1, most_nodes / piece.rows);
        for (std::size_t begin = 0; begin < nodes.psis.size(); begin += most) {
            const std::size_t columns = std::min(most, nodes.psis.size() - begin);
            const auto some = [&](const std::vector<double>& values) {
                const auto first = values.begin() + static_cast<std::ptrdiff_t>(begin);
                return std::vector<double>(first, first + static_cast<std::ptrdiff_t>(columns));
            };
            if (columns != piece.psis.size()) {
                piece.stride = padded(piece.rows * columns, block);
                const std::size_t bytes = NODE_PLANES * piece.stride * sizeof(float);
                piece.planes = make_buffer(device_, bytes);
                device_.queue.enqueueFillBuffer(piece.planes, 0.0F, 0, bytes);
            }
            piece.psis = some(nodes.psis.x);
            const auto share_at = [&](std::size_t column) {
                return (static_cast<double>(n) +
                        static_cast<double>(column) / static_cast<double>(nodes.psis.size())) /
                       static_cast<double>(distribution.parts.size());
            };
            piece.from = share_at(begin);
            piece.to = share_at(begin + columns);
            const cl::Buffer psis = upload(device_, to_floats(piece.psis));
            const cl::Buffer psi_weights = upload(device_, to_floats(some(nodes.psis.w)));
            kernel.setArg(0, table);
            kernel.setArg(1, static_cast<cl_int>(n));
            kernel.setArg(2, x);
            kernel.setArg(3, w);
            kernel.setArg(4, static_cast<cl_uint>(piece.rows / width));
            kernel.setArg(5, psis);
            kernel.setArg(6, psi_weights);
            kernel.setArg(7, static_cast<cl_uint>(columns));
            kernel.setArg(8, cl_uint{0});
            kernel.setArg(9, static_cast<cl_uint>(piece.stride / width));
            kernel.setArg(10, piece.planes);
            const std::size_t items = piece.rows / width * columns;
            device_.queue.enqueueNDRangeKernel(
                kernel, cl::NullRange, cl::NDRange(padded(items, local)), cl::NDRange(local));
            device_.queue.finish(); // the buffers go
            use(piece);
        }
    }
}

std::vector<float> Generator::planes_on_host(const Piece& piece) const {
    return download<float>(device_, piece.planes, NODE_PLANES * piece.stride);
}

void Generator::add_areas(const Piece& nodes, const std::vector<Vector>& directions,
                          std::vector<double>& sums, const ProgressFunction& progress) const {
    const auto block = static_cast<std::size_t>(device_.form.block);
    const auto width = static_cast<std::size_t>(device_.form.vector_width);
    const auto local = static_cast<std::size_t>(device_.form.local_size);
    const std::size_t blocks = nodes.stride / block;
    const std::size_t most_tiles = std::max<std::size_t>(1, most_pairs / (nodes.stride * tile));
    cl::Kernel kernel(program_, "visible");
    for (std::size_t begin = 0; begin < directions.size(); begin += most_tiles * tile) {
        const std::size_t end = std::min(directions.size(), begin + most_tiles * tile);
        const std::size_t tiles = padded(end - begin, tile) / tile;
        const std::vector<Vector> some(directions.begin() + static_cast<std::ptrdiff_t>(begin),
                                       directions.begin() + static_cast<std::ptrdiff_t>(end));
        const cl::Buffer in = upload(device_, planes_of(some, tiles * tile));
        const cl::Buffer out = make_buffer(device_, tiles * tile * blocks * sizeof(float));
        kernel.setArg(0, nodes.planes);
        kernel.setArg(1, static_cast<cl_uint>(nodes.stride / width));
        kernel.setArg(2, in);
        kernel.setArg(3, static_cast<cl_uint>(tiles * tile));
        kernel.setArg(4, out);
        device_.queue.enqueueNDRangeKernel(
            kernel, cl::NullRange, cl::NDRange(blocks * local, tiles), cl::NDRange(local, 1));
        std::vector<double> found(tiles * tile);
        add_blocks(download<float>(device_, out, tiles * tile * blocks), blocks, tile,
                   found.data());
        for (std::size_t i = begin; i < end; ++i)
            sums[i] += found[i - begin];
        tell(part_of(progress, nodes.from, nodes.to),
             static_cast<double>(end) / static_cast<double>(directions.size()));
    }
}

std::vector<double> Generator::areas(const Distribution& distribution,
                                     const std::vector<std::size_t>& fineness,
                                     const std::vector<Vector>& directions,
                                     const ProgressFunction& progress) const {
    std::vector<double> sums(directions.size());
    for_pieces(distribution, fineness,
               [&](const Piece& piece) { add_areas(piece, directions, sums, progress); });
    return sums;
}

double Generator::mass(const DistributionPart& part) const {
    Distribution one;
    one.parts.push_back(part);
    one.parts[0].amplitude = 1;
    double sum = 0;
    for_pieces(one, {fine}, [&](const Piece& piece) {
        const std::vector<float> planes = planes_on_host(piece);
        for (std::size_t i = 0; i < piece.stride; ++i)
            sum += planes[NODE_WEIGHT * piece.stride + i];
    });
    return sum;
}

Distribution Generator::weighted(Distribution distribution) const {
    std::vector<double> masses; // of the parts, once each
    if (!distribution.shares.empty())
        for (const DistributionPart& part : distribution.parts)
            masses.push_back(part.amplitude * mass(part));
    const std::vector<double> factors = factors_of(distribution, masses);
    for (std::size_t n = 0; n < factors.size(); ++n)
        distribution.parts[n].amplitude *= factors[n];
    distribution.shares.clear();
    return distribution;
}

void Generator::reflect(MicrofacetTable& table, std::size_t fineness,
                        const std::vector<double>& part_shares,
                        const ProgressFunction& progress) const {
    const auto block = static_cast<std::size_t>(device_.form.block);
    const auto width = static_cast<std::size_t>(device_.form.vector_width);
    const auto local = static_cast<std::size_t>(device_.form.local_size);
    MicrofacetTable inner = table;
    inner.grid = inner_grid(table.distribution, fineness);
    std::vector<std::size_t> inner_fineness;
    for (const double share : part_shares)
        inner_fineness.push_back((share < small_share ? coarse : middle) * fineness);
    const std::vector<double> inner_areas = areas(
        table.distribution, inner_fineness, directions_of(inner.grid), part_of(progress, 0, 0.2));
    inner.g.assign(inner_areas.begin(), inner_areas.end());
    const cl::Buffer words = upload(device_, packed_areas(refined(inner, 8)));
    const std::vector<Vector> directions = directions_of(table.grid);
    cl::Kernel kernel(program_, "reflect");
    std::vector<double> sums(directions.size() * REFLECTANCE_SUMS);
    const std::vector<std::size_t> own_fineness(part_shares.size(), coarse * fineness);
    for_pieces(table.distribution, own_fineness, [&](const Piece& nodes) {
        const std::size_t blocks = nodes.stride / block;
        const std::size_t most = std::max<std::size_t>(1, most_pairs / nodes.stride);
        for (std::size_t begin = 0; begin < directions.size(); begin += most) {
            const std::size_t count = std::min(most, directions.size() - begin);
            const auto first = directions.begin() + static_cast<std::ptrdiff_t>(begin);
            const cl::Buffer in = upload(
                device_, planes_of({first, first + static_cast<std::ptrdiff_t>(count)}, count));
            const auto g = table.g.begin() + static_cast<std::ptrdiff_t>(begin);
            std::vector<float> own(g, g + static_cast<std::ptrdiff_t>(count));
            for (float& area : own)
                area = std::max(area, LEAST_AREA * static_cast<float>(table.mean_height));
            const cl::Buffer own_areas = upload(device_, own);
            const cl::Buffer out =
                make_buffer(device_, count * blocks * REFLECTANCE_SUMS * sizeof(float));
            kernel.setArg(0, words);
            kernel.setArg(1, nodes.planes);
            kernel.setArg(2, static_cast<cl_uint>(nodes.stride / width));
            kernel.setArg(3, in);
            kernel.setArg(4, static_cast<cl_uint>(count));
            kernel.setArg(5, own_areas);
            kernel.setArg(6, out);
            device_.queue.enqueueNDRangeKernel(
                kernel, cl::NullRange, cl::NDRange(blocks * local, count), cl::NDRange(local, 1));
            add_blocks(download<float>(device_, out, count * blocks * REFLECTANCE_SUMS), blocks,
                       REFLECTANCE_SUMS, sums.data() + REFLECTANCE_SUMS * begin);
            tell(part_of(part_of(progress, 0.2, 1), nodes.from, nodes.to),
                 static_cast<double>(begin + count) / static_cast<double>(directions.size()));
        }
    });
    for (const auto& [plane, k] : {std::pair(&table.r0, R0), std::pair(&table.r1, R1),
                                   std::pair(&table.r0_correlated, R0_CORRELATED),
                                   std::pair(&table.r1_correlated, R1_CORRELATED)}) {
        plane->resize(directions.size());
        for (std::size_t i = 0; i < directions.size(); ++i)
            (*plane)[i] = static_cast<float>(sums[REFLECTANCE_SUMS * i + k]);
    }
}

void Generator::tabulate_facets(MicrofacetTable& table, std::size_t fineness) const {
    const auto block = static_cast<std::size_t>(device_.form.block);
    const auto width = static_cast<std::size_t>(device_.form.vector_width);
    const auto local = static_cast<std::size_t>(device_.form.local_size);
    FacetTable& facets = table.facets;
    facets.rows = facet_rows;
    facets.columns = facet_columns;
    Grid grid = table.grid;
    grid.rows = facets.rows;
    const std::size_t count = facets.rows * facets.rows * facets.columns;
    std::vector<float> pairs(6 * count);
    for (std::size_t n = 0; n < count; ++n) {
        const double wi = grid.elevation(static_cast<double>(n / facets.columns / facets.rows));
        const double wo = grid.elevation(static_cast<double>(n / facets.columns % facets.rows));
        const double phi =
            pi * static_cast<double>(n % facets.columns) / static_cast<double>(facets.columns - 1);
        const Vector i = direction(pi / 2 - wi, 0), o = direction(pi / 2 - wo, phi);
        for (std::size_t a = 0; a < 3; ++a) {
            pairs[a * count + n] = static_cast<float>(i[a]);
            pairs[(3 + a) * count + n] = static_cast<float>(o[a]);
        }
    }
    const cl::Buffer in = upload(device_, pairs);
    cl::Kernel kernel(program_, "facets");
    std::vector<double> sums(count);
    const std::vector<std::size_t> each(table.distribution.parts.size(), middle * fineness);
    for_pieces(table.distribution, each, [&](const Piece& nodes) {
        const std::size_t blocks = nodes.stride / block;
        const cl::Buffer out = make_buffer(device_, count * blocks * sizeof(float));
        kernel.setArg(0, nodes.planes);
        kernel.setArg(1, static_cast<cl_uint>(nodes.stride / width));
        kernel.setArg(2, in);
        kernel.setArg(3, static_cast<cl_uint>(count));
        kernel.setArg(4, out);
        device_.queue.enqueueNDRangeKernel(
            kernel, cl::NullRange, cl::NDRange(blocks * local, count), cl::NDRange(local, 1));
        add_blocks(download<float>(device_, out, count * blocks), blocks, 1, sums.data());
    });
    facets.values.assign(sums.begin(), sums.end());
}

namespace {

/// What is known of a part alone, its amplitude as it was specified.
struct PartSums {
    explicit PartSums(const DistributionPart& part, std::size_t directions)
        : cells(part), areas(directions) {}

    /// `planes`: of the nodes [azimuth][row], `rows` of them padded; `stride` apart.
    void add(const std::vector<float>& planes, std::size_t stride, std::size_t rows,
             const std::vector<double>& shares, const std::vector<double>& psis) {
        const float* const weight = planes.data() + NODE_WEIGHT * stride;
        const float* const height = planes.data() + NODE_Z * stride;
        for (std::size_t i = 0; i < rows * psis.size(); ++i) {
            for (std::size_t a = 0; a < 3; ++a)
                mean[a] += double{planes[(NODE_X + a) * stride + i]} * weight[i];
            mass += weight[i];
            if (!(height[i] > 0)) // never a half vector of two directions above
                continue;
            above += weight[i];
            steep += height[i] < std::sqrt(0.5F) ? weight[i] : 0;
            if (i % rows < shares.size())
                cells.add(shares[i % rows], psis[i / rows], weight[i]);
        }
    }

    double mass = 0, above = 0, steep = 0;
    Vector mean{};
    CellSums cells;
    std::vector<double> areas; ///< g at the grid's directions
};

} // namespace

MicrofacetTable Generator::generate(const Distribution& specified, const GeneratorOptions& options,
                                    const std::string& source,
                                    const ProgressFunction& progress) const {
    if (options.points < least_points || options.points > most_points)
        throw UsageError(fmt::format("a grid of {} points; expected {} to {}", options.points,
                                     least_points, most_points));
    if (options.facets && specified.sector != Sector::Isotropic)
        throw UsageError(fmt::format("{}: is anisotropic; Lambertian facets need an isotropic "
                                     "distribution",
                                     source));
    MicrofacetTable table;
    table.grid = grid_of(specified, options.points);
    const std::vector<Vector> directions = directions_of(table.grid);
    // Part by part, each as it was specified: all is linear in the amplitudes.
    std::vector<PartSums> parts;
    for (const DistributionPart& part : specified.parts)
        parts.emplace_back(part, directions.size());
    const std::vector<std::size_t> each(parts.size(), fine * options.fineness);
    for_pieces(specified, each, [&](const Piece& piece) {
        PartSums& sums = parts[piece.part];
        sums.add(planes_on_host(piece), piece.stride, piece.rows, piece.shares, piece.psis);
        add_areas(piece, directions, sums.areas, part_of(progress, 0, 0.3));
    });
    std::vector<double> masses;
    for (const PartSums& sums : parts)
        masses.push_back(sums.mass);
    const std::vector<double> factors = factors_of(specified, masses);
    table.distribution = specified;
    table.distribution.shares.clear();
    double whole = 0, above = 0, steep = 0;
    std::vector<double> g(directions.size());
    for (std::size_t n = 0; n < parts.size(); ++n) {
        DistributionPart& part = table.distribution.parts[n];
        part.amplitude *= factors[n];
        masses[n] *= factors[n];
        whole += masses[n];
        above += factors[n] * parts[n].above;
        steep += factors[n] * parts[n].steep;
        for (std::size_t a = 0; a < 3; ++a)
            table.mean[a] += factors[n] * parts[n].mean[a];
        table.mean_height += part.area_scale * factors[n] * parts[n].mean[2];
        for (std::size_t i = 0; i < g.size(); ++i)
            g[i] += factors[n] * parts[n].areas[i];
        table.cells.push_back(parts[n].cells.cells(factors[n]));
    }
    if (whole <= 0 || std::isnan(whole))
        throw InputError(fmt::format("{}: p(h) is 0 everywhere; expected some normals", source));
    if (!std::isfinite(whole) || whole < least_height || whole > most_height)
        throw InputError(fmt::format("{}: the integral of p(h) is {:.6g}; expected {} to {}, for "
                                     "single precision: scale p(h), the BRDF stays the same",
                                     source, whole, least_height, most_height));
    if (!(table.mean_height > 1e-6 * whole) || !(table.mean[2] > 1e-6 * whole))
        throw InputError(fmt::format("{}: <h.n> is {:.6g} of the integral of p(h) {:.6g}: the "
                                     "normals are below the horizon; expected <h.n> above 0",
                                     source, table.mean[2], whole));
    table.steep = above > 0 ? steep / above : 0;
    // What symmetry makes 0 is 0.
    if (specified.sector != Sector::All)
        table.mean[1] = 0;
    if (specified.sector == Sector::Quarter || specified.sector == Sector::Isotropic)
        table.mean[0] = 0;
    table.g.assign(g.begin(), g.end());
    for (double& mass : masses)
        mass /= whole;
    reflect(table, options.fineness, masses, part_of(progress, 0.3, 1));
    if (options.facets)
        tabulate_facets(table, options.fineness);
    return table;
}

std::vector<double> Generator::visible_areas(const Distribution& distribution,
                                             const std::vector<Vector>& directions) const {
    return areas(weighted(distribution), std::vector<std::size_t>(distribution.parts.size(), fine),
                 directions);
}

EnergyReport energy_report(const MicrofacetTable& table, double f0, bool correlated) {
    constexpr double error = reflectance_error;
    EnergyReport report;
    const Grid& grid = table.grid;
    const auto thetas = static_cast<std::size_t>(
        std::lround(std::sqrt(static_cast<double>(std::max<std::size_t>(grid.count(), 200)) / 2)));
    const std::size_t phis = 2 * thetas;
    report.directions = thetas * phis;
    const auto mixed = [&](double r0, double r1) { return (1 - f0) * r0 + f0 * r1; };
    const std::vector<float>&r0 = table.reflectance(0, correlated),
          &r1 = table.reflectance(1, correlated);
    for (std::size_t i = 0; i < r0.size(); ++i)
        report.most = std::max(report.most, mixed(double{r0[i]}, double{r1[i]}));
    if (report.most <= 1 + error) // interpolation may pass 1 where no node does
        return report;
    // Even steps, so that the count does not depend on how the grid is spaced.
    for (std::size_t i = 0; i < thetas; ++i)
        for (std::size_t k = 0; k < phis; ++k) {
            const double theta =
                pi / 2 * (static_cast<double>(i) + 0.5) / static_cast<double>(thetas);
            const double phi = 2 * pi * static_cast<double>(k) / static_cast<double>(phis);
            const double row = grid.row(pi / 2 - theta), column = grid.column(phi);
            const double value =
                mixed(interpolate(grid, r0, row, column), interpolate(grid, r1, row, column));
            if (value > 1 + error)
                report.where.push_back({theta, phi, value});
        }
    report.above = report.where.size();
    return report;
}

bool mean_is_normal(const MicrofacetTable& table) {
    return std::hypot(table.mean[0], table.mean[1]) <= 1e-5 * table.mean[2] &&
           std::abs(table.mean_height - table.mean[2]) <= 1e-6 * table.mean[2];
}

} // namespace brdfit
