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
constexpr std::size_t most_floats_out = std::size_t{1} << 24;
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

/// Sums what kernels wrote for each block, [item][block][value], over the blocks.
void add_blocks(const std::vector<float>& partial, std::size_t blocks, std::size_t values,
                std::vector<double>& sums) {
    for (std::size_t i = 0; i < partial.size() / (blocks * values); ++i)
        for (std::size_t v = 0; v < values; ++v) {
            double sum = 0;
            for (std::size_t b = 0; b < blocks; ++b)
                sum += partial[(i * blocks + b) * values + v];
            sums.push_back(sum);
        }
}

/// Probabilities of a part's cells from its nodes' weights, [azimuth][row]. Every cell has some: p
/// may be positive where no node is.
SamplingCells cells_of(const DistributionPart& part, const PartNodes& nodes, std::size_t rows,
                       const float* height, const float* weight) {
    SamplingCells cells;
    const bool tabulated = part.shape == Shape::Tabulated;
    const bool image = part.table != nullptr && !tabulated;
    std::size_t bands = image ? 128 : 32;
    cells.columns = image ? 256 : 64;
    if (tabulated) {
        constexpr std::size_t most = 128;
        const double end = greatest_theta(part);
        cells.edges = {0};
        const std::vector<double>& thetas = part.table->thetas;
        const std::size_t step = (thetas.size() + most - 1) / most;
        for (std::size_t i = 0; i < thetas.size(); i += step)
            if (thetas[i] / end > cells.edges.back() + 1e-6 && thetas[i] < end * (1 - 1e-6))
                cells.edges.push_back(thetas[i] / end);
        cells.edges.push_back(1);
        bands = cells.edges.size() - 1;
        cells.columns = std::clamp<std::size_t>(part.table->width, 16, most);
    } else
        for (std::size_t i = 0; i <= bands; ++i)
            cells.edges.push_back(static_cast<double>(i) / static_cast<double>(bands));
    std::vector<double> mass(bands * cells.columns);
    double whole = 0;
    for (std::size_t j = 0; j < nodes.psis.size(); ++j) {
        const double turn = nodes.psis.x[j] / (2 * pi);
        const auto column = std::min(cells.columns - 1,
                                     static_cast<std::size_t>((turn - std::floor(turn)) *
                                                              static_cast<double>(cells.columns)));
        for (std::size_t i = 0; i < nodes.shares.size(); ++i) {
            if (!(height[j * rows + i] > 0)) // never a half vector of two directions above
                continue;
            const auto next =
                std::upper_bound(cells.edges.begin(), cells.edges.end(), nodes.shares.x[i]);
            const auto row = static_cast<std::size_t>(next - cells.edges.begin()) - 1;
            mass[column * bands + std::min(row, bands - 1)] += weight[j * rows + i];
            whole += weight[j * rows + i];
        }
    }
    const double least = 1e-4 * whole / static_cast<double>(mass.size());
    for (const double m : mass)
        cells.mass.push_back(static_cast<float>(std::max(m + least, 1e-30)));
    return cells;
}

} // namespace

Generator::Generator(const Device& device) : device_(device), program_(generator_program(device)) {}

Generator::DeviceNodes Generator::nodes_of_parts(const Distribution& distribution,
                                                 std::size_t fineness) const {
    const auto width = static_cast<std::size_t>(device_.form.vector_width);
    const auto local = static_cast<std::size_t>(device_.form.local_size);
    const cl::Buffer table = upload(device_, packed_areas(bare_table(distribution)));
    std::vector<PartNodes> of_parts;
    DeviceNodes nodes;
    std::size_t count = 0;
    for (const DistributionPart& part : distribution.parts) {
        of_parts.push_back(nodes_of(part, fineness));
        nodes.first.push_back(count);
        nodes.rows.push_back(padded(of_parts.back().shares.size(), width));
        nodes.columns.push_back(of_parts.back().psis.size());
        count += nodes.rows.back() * nodes.columns.back();
    }
    nodes.stride = padded(count, static_cast<std::size_t>(device_.form.block));
    nodes.planes = make_buffer(device_, NODE_PLANES * nodes.stride * sizeof(float));
    device_.queue.enqueueFillBuffer(nodes.planes, 0.0F, 0,
                                    NODE_PLANES * nodes.stride * sizeof(float));
    cl::Kernel kernel(program_, "nodes");
    for (std::size_t n = 0; n < of_parts.size(); ++n) {
        Quadrature shares = of_parts[n].shares;
        shares.x.resize(nodes.rows[n], 0.5);
        shares.w.resize(nodes.rows[n], 0);
        const cl::Buffer x = upload(device_, to_floats(shares.x));
        const cl::Buffer w = upload(device_, to_floats(shares.w));
        const cl::Buffer psis = upload(device_, to_floats(of_parts[n].psis.x));
        const cl::Buffer psi_weights = upload(device_, to_floats(of_parts[n].psis.w));
        kernel.setArg(0, table);
        kernel.setArg(1, static_cast<cl_int>(n));
        kernel.setArg(2, x);
        kernel.setArg(3, w);
        kernel.setArg(4, static_cast<cl_uint>(nodes.rows[n] / width));
        kernel.setArg(5, psis);
        kernel.setArg(6, psi_weights);
        kernel.setArg(7, static_cast<cl_uint>(nodes.columns[n]));
        kernel.setArg(8, static_cast<cl_uint>(nodes.first[n] / width));
        kernel.setArg(9, static_cast<cl_uint>(nodes.stride / width));
        kernel.setArg(10, nodes.planes);
        const std::size_t items = nodes.rows[n] / width * nodes.columns[n];
        device_.queue.enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(padded(items, local)),
                                           cl::NDRange(local));
        device_.queue.finish(); // the buffers go
    }
    return nodes;
}

std::vector<double> Generator::areas(const DeviceNodes& nodes,
                                     const std::vector<Vector>& directions) const {
    const auto block = static_cast<std::size_t>(device_.form.block);
    const auto width = static_cast<std::size_t>(device_.form.vector_width);
    const auto local = static_cast<std::size_t>(device_.form.local_size);
    const std::size_t blocks = nodes.stride / block;
    const std::size_t most_tiles = std::max<std::size_t>(1, most_floats_out / (blocks * tile));
    cl::Kernel kernel(program_, "visible");
    std::vector<double> sums;
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
        add_blocks(download<float>(device_, out, tiles * tile * blocks), blocks, tile, sums);
        sums.resize(end);
    }
    return sums;
}

double Generator::mass(const DistributionPart& part) const {
    Distribution one;
    one.parts.push_back(part);
    one.parts[0].amplitude = 1;
    const DeviceNodes nodes = nodes_of_parts(one, fine);
    const std::vector<float> planes =
        download<float>(device_, nodes.planes, NODE_PLANES * nodes.stride);
    double sum = 0;
    for (std::size_t i = 0; i < nodes.stride; ++i)
        sum += planes[NODE_WEIGHT * nodes.stride + i];
    return sum;
}

Distribution Generator::weighted(Distribution distribution) const {
    std::vector<double> masses; // of the parts, once each
    if (!distribution.shares.empty())
        for (const DistributionPart& part : distribution.parts)
            masses.push_back(mass(part));
    for (const Share& share : distribution.shares) {
        double whole = share.normalised ? 0 : 1;
        for (std::size_t i = share.first; share.normalised && i < share.first + share.count; ++i)
            whole += distribution.parts[i].amplitude * masses[i];
        for (std::size_t i = share.first; i < share.first + share.count; ++i)
            distribution.parts[i].amplitude *= share.mass / whole;
    }
    distribution.shares.clear();
    return distribution;
}

void Generator::reflect(MicrofacetTable& table, std::size_t fineness) const {
    const auto block = static_cast<std::size_t>(device_.form.block);
    const auto width = static_cast<std::size_t>(device_.form.vector_width);
    const auto local = static_cast<std::size_t>(device_.form.local_size);
    MicrofacetTable inner = table;
    inner.grid = inner_grid(table.distribution, fineness);
    const std::vector<double> inner_areas =
        areas(nodes_of_parts(table.distribution, middle * fineness), directions_of(inner.grid));
    const DeviceNodes nodes = nodes_of_parts(table.distribution, coarse * fineness);
    inner.g.assign(inner_areas.begin(), inner_areas.end());
    const cl::Buffer words = upload(device_, packed_areas(refined(inner, 8)));
    const std::vector<Vector> directions = directions_of(table.grid);
    const std::size_t blocks = nodes.stride / block;
    const std::size_t most =
        std::max<std::size_t>(1, most_floats_out / (blocks * REFLECTANCE_SUMS));
    cl::Kernel kernel(program_, "reflect");
    std::vector<double> sums;
    for (std::size_t begin = 0; begin < directions.size(); begin += most) {
        const std::size_t count = std::min(most, directions.size() - begin);
        const auto first = directions.begin() + static_cast<std::ptrdiff_t>(begin);
        const cl::Buffer in =
            upload(device_, planes_of({first, first + static_cast<std::ptrdiff_t>(count)}, count));
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
                   REFLECTANCE_SUMS, sums);
    }
    for (const auto& [plane, k] : {std::pair(&table.r0, R0), std::pair(&table.r1, R1),
                                   std::pair(&table.r0_correlated, R0_CORRELATED),
                                   std::pair(&table.r1_correlated, R1_CORRELATED)}) {
        plane->resize(directions.size());
        for (std::size_t i = 0; i < directions.size(); ++i)
            (*plane)[i] = static_cast<float>(sums[REFLECTANCE_SUMS * i + k]);
    }
}

void Generator::tabulate_facets(MicrofacetTable& table, const DeviceNodes& nodes) const {
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
    const std::size_t blocks = nodes.stride / block;
    const cl::Buffer in = upload(device_, pairs);
    const cl::Buffer out = make_buffer(device_, count * blocks * sizeof(float));
    cl::Kernel kernel(program_, "facets");
    kernel.setArg(0, nodes.planes);
    kernel.setArg(1, static_cast<cl_uint>(nodes.stride / width));
    kernel.setArg(2, in);
    kernel.setArg(3, static_cast<cl_uint>(count));
    kernel.setArg(4, out);
    device_.queue.enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(blocks * local, count),
                                       cl::NDRange(local, 1));
    std::vector<double> sums;
    add_blocks(download<float>(device_, out, count * blocks), blocks, 1, sums);
    facets.values.assign(sums.begin(), sums.end());
}

MicrofacetTable Generator::generate(const Distribution& specified, const GeneratorOptions& options,
                                    const std::string& source) const {
    if (options.points < least_points || options.points > most_points)
        throw UsageError(fmt::format("a grid of {} points; expected {} to {}", options.points,
                                     least_points, most_points));
    if (options.facets && specified.sector != Sector::Isotropic)
        throw UsageError(fmt::format("{}: is anisotropic; Lambertian facets need an isotropic "
                                     "distribution",
                                     source));
    const Distribution distribution = weighted(specified);
    MicrofacetTable table;
    table.distribution = distribution;
    const DeviceNodes nodes = nodes_of_parts(distribution, fine * options.fineness);
    const std::vector<float> planes =
        download<float>(device_, nodes.planes, NODE_PLANES * nodes.stride);
    const float* const weight = planes.data() + NODE_WEIGHT * nodes.stride;
    const float* const height = planes.data() + NODE_Z * nodes.stride;
    double whole = 0, above = 0, steep = 0;
    for (std::size_t n = 0; n < distribution.parts.size(); ++n) {
        const DistributionPart& part = distribution.parts[n];
        Vector mean{};
        const std::size_t end = nodes.first[n] + nodes.rows[n] * nodes.columns[n];
        for (std::size_t i = nodes.first[n]; i < end; ++i) {
            for (std::size_t a = 0; a < 3; ++a)
                mean[a] += double{planes[(NODE_X + a) * nodes.stride + i]} * weight[i];
            whole += weight[i];
            const float z = height[i];
            above += z > 0 ? weight[i] : 0;
            steep += z > 0 && z < std::sqrt(0.5F) ? weight[i] : 0;
        }
        for (std::size_t a = 0; a < 3; ++a)
            table.mean[a] += mean[a];
        table.mean_height += part.area_scale * mean[2];
        table.cells.push_back(cells_of(part, nodes_of(part, fine * options.fineness), nodes.rows[n],
                                       height + nodes.first[n], weight + nodes.first[n]));
    }
    if (!(whole > 0) || !std::isfinite(whole))
        throw InputError(fmt::format("{}: p(h) is 0 everywhere; expected some normals", source));
    if (!(table.mean_height > 1e-6 * whole) || !(table.mean[2] > 1e-6 * whole))
        throw InputError(fmt::format("{}: <h.n> is {:.6g} of the integral of p(h) {:.6g}: the "
                                     "normals are below the horizon; expected <h.n> above 0",
                                     source, table.mean[2], whole));
    table.steep = above > 0 ? steep / above : 0;
    // What symmetry makes 0 is 0.
    if (distribution.sector != Sector::All)
        table.mean[1] = 0;
    if (distribution.sector == Sector::Quarter || distribution.sector == Sector::Isotropic)
        table.mean[0] = 0;
    table.grid = grid_of(distribution, options.points);
    const std::vector<double> g = areas(nodes, directions_of(table.grid));
    table.g.assign(g.begin(), g.end());
    reflect(table, options.fineness);
    if (options.facets)
        tabulate_facets(table, nodes_of_parts(distribution, middle * options.fineness));
    return table;
}

std::vector<double> Generator::visible_areas(const Distribution& distribution,
                                             const std::vector<Vector>& directions) const {
    return areas(nodes_of_parts(weighted(distribution), fine), directions);
}

EnergyReport energy_report(const MicrofacetTable& table, double f0, bool correlated) {
    constexpr double error = 1e-4;
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
