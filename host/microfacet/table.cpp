#include "host/microfacet/table.hpp"

#include "host/error.hpp"
#include "host/microfacet/nodes.hpp"
#include "host/parallel.hpp"
#include "host/quadrature.hpp"
#include "kernels/terms/table_words.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace brdfit {

namespace {

static_assert(static_cast<int>(Sector::All) == WHOLE_TURN &&
              static_cast<int>(Sector::Half) == HALF_TURN &&
              static_cast<int>(Sector::Quarter) == QUARTER_TURN);

/// Psi at both ends of the columns.
double psi_span(Sector sector) {
    return sector == Sector::All ? 2 * pi : 2 * pi / static_cast<double>(sector);
}

std::array<double, 4> cubic_weights(double x) {
    const double a = x - 1, b = x - 2, c = x - 3;
    return {-a * b * c / 6, x * b * c / 2, -x * a * c / 2, x * a * b / 6};
}

/// A plane with the columns beyond its sector that interpolation needs.
void append_plane(std::vector<float>& words, const Grid& grid, const std::vector<float>& plane) {
    for (std::size_t r = 0; r < grid.rows; ++r) {
        const float* const row = plane.data() + r * grid.columns;
        if (grid.columns == 1) {
            words.push_back(row[0]);
            continue;
        }
        for (std::size_t k = 0; k < grid.columns + COLUMNS_BEYOND; ++k)
            words.push_back(row[folded(grid, static_cast<std::ptrdiff_t>(k) - COLUMNS_BEFORE)]);
    }
}

void append_cumulative(std::vector<float>& words, const std::vector<double>& masses) {
    double whole = 0, sum = 0;
    for (const double mass : masses)
        whole += mass;
    words.push_back(0);
    for (const double mass : masses) {
        sum += mass;
        words.push_back(static_cast<float>(whole > 0 ? sum / whole : 0));
    }
    words.back() = 1;
}

} // namespace

double Grid::elevation(double row) const {
    const double last = static_cast<double>(rows - 1);
    return row >= last ? pi / 2 : scale * std::sinh(row / last * std::asinh(pi / 2 / scale));
}

double Grid::azimuth(double column) const {
    if (columns == 1)
        return 0;
    const double steps = static_cast<double>(sector == Sector::All ? columns : columns - 1);
    const double psi = psi_span(sector) * column / steps;
    const double phi = std::atan2(stretch * std::sin(psi), std::cos(psi));
    return phi + (psi - phi > pi ? 2 * pi : 0);
}

Vector Grid::direction(double row, double column) const {
    const double e = elevation(row), phi = azimuth(column);
    if (row >= static_cast<double>(rows - 1))
        return {0, 0, 1};
    return {std::cos(e) * std::cos(phi), std::cos(e) * std::sin(phi), std::sin(e)};
}

double Grid::row(double elevation) const {
    const double last = static_cast<double>(rows - 1);
    return std::min(last, last * std::asinh(elevation / scale) / std::asinh(pi / 2 / scale));
}

double Grid::column(double azimuth) const {
    if (columns == 1)
        return 0;
    const double x = stretch * std::cos(azimuth), y = std::sin(azimuth);
    const double psi = std::atan2(sector == Sector::All ? y : std::abs(y),
                                  sector == Sector::Quarter ? std::abs(x) : x);
    const auto count = static_cast<double>(columns);
    if (sector == Sector::All) {
        const double turn = psi / (2 * pi);
        return std::min((turn < 0 ? turn + 1 : turn) * count, count * (1 - 1e-12));
    }
    return psi / psi_span(sector) * (count - 1);
}

std::size_t folded(const Grid& grid, std::ptrdiff_t column) {
    const auto n = static_cast<std::ptrdiff_t>(grid.columns);
    if (n == 1)
        return 0;
    if (grid.sector == Sector::All)
        return static_cast<std::size_t>((column % n + n) % n);
    const std::ptrdiff_t period = 2 * (n - 1);
    const std::ptrdiff_t k = (column % period + period) % period;
    return static_cast<std::size_t>(k < n ? k : period - k);
}

std::pair<std::vector<float>, bool> interpolated_area(const MicrofacetTable& table) {
    const Grid& grid = table.grid;
    const Vector& mean = table.mean;
    const bool leans = std::hypot(mean[0], mean[1]) > 1e-3 * mean[2];
    std::vector<float> plane(grid.count());
    for (std::size_t r = 0; r < grid.rows; ++r)
        for (std::size_t k = 0; k < grid.columns; ++k) {
            const Vector d = grid.direction(static_cast<double>(r), static_cast<double>(k));
            const double facing = d[0] * mean[0] + d[1] * mean[1] + d[2] * mean[2];
            const double g = table.g[r * grid.columns + k];
            plane[r * grid.columns + k] = static_cast<float>(
                leans ? std::log(std::max(g, double{LEAST_AREA} * table.mean_height)) : g - facing);
        }
    return {plane, leans};
}

double interpolate(const Grid& grid, const std::vector<float>& plane, double row, double column) {
    const auto last = static_cast<std::ptrdiff_t>(grid.rows) - 4;
    const std::ptrdiff_t i =
        std::clamp<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(row) - 1, 0, last);
    const std::array<double, 4> w = cubic_weights(row - static_cast<double>(i));
    const auto k = static_cast<std::ptrdiff_t>(column);
    const std::array<double, 4> v = cubic_weights(column - static_cast<double>(k) + 1);
    double sum = 0;
    for (std::size_t a = 0; a < 4; ++a) {
        const float* const at = plane.data() + (static_cast<std::size_t>(i) + a) * grid.columns;
        double along = at[0];
        if (grid.columns > 1) {
            along = 0;
            for (std::size_t b = 0; b < 4; ++b)
                along += v[b] * at[folded(grid, k - 1 + static_cast<std::ptrdiff_t>(b))];
        }
        sum += w[a] * along;
    }
    return sum;
}

MicrofacetTable refined(const MicrofacetTable& table, std::size_t factor) {
    const Grid& grid = table.grid;
    MicrofacetTable fine = table;
    fine.grid.rows = (grid.rows - 1) * factor + 1;
    if (grid.columns > 1)
        fine.grid.columns =
            grid.sector == Sector::All ? grid.columns * factor : (grid.columns - 1) * factor + 1;
    const std::pair<std::vector<float>, bool> area = interpolated_area(table);
    const std::vector<float>& plane = area.first;
    const bool leans = area.second;
    const auto step = 1 / static_cast<double>(factor);
    fine.g.resize(fine.grid.count());
    parallel_pieces(fine.grid.rows, 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t r = begin; r < end; ++r)
            for (std::size_t k = 0; k < fine.grid.columns; ++k) {
                const auto row = static_cast<double>(r), column = static_cast<double>(k);
                const Vector d = fine.grid.direction(row, column);
                const double value = interpolate(grid, plane, row * step, column * step);
                fine.g[r * fine.grid.columns + k] =
                    static_cast<float>(leans ? std::exp(value)
                                             : value + d[0] * table.mean[0] + d[1] * table.mean[1] +
                                                   d[2] * table.mean[2]);
            }
    });
    return fine;
}

double diffuse_constant(const MicrofacetTable& table, const TableUse& use) {
    const Grid& grid = table.grid;
    const Quadrature within = gauss_legendre(6);
    const std::size_t sectors =
        grid.sector == Sector::All || grid.columns == 1 ? 1 : static_cast<std::size_t>(grid.sector);
    const std::size_t intervals = grid.columns == 1            ? 1
                                  : grid.sector == Sector::All ? grid.columns
                                                               : grid.columns - 1;
    const double end = std::asinh(pi / 2 / grid.scale);
    const double row_step = end / static_cast<double>(grid.rows - 1);
    const double psi_step = psi_span(grid.sector) / static_cast<double>(intervals);
    double integral = 0;
    for (std::size_t i = 0; i + 1 < grid.rows; ++i)
        for (std::size_t a = 0; a < within.size(); ++a) {
            const double row = static_cast<double>(i) + within.x[a];
            const double e = grid.elevation(row);
            // kz cos(e) de
            const double height = std::sin(e) * std::cos(e) * grid.scale *
                                  std::cosh(row * row_step) * row_step * within.w[a];
            for (std::size_t k = 0; k < intervals; ++k)
                for (std::size_t b = 0; b < (grid.columns == 1 ? 1 : within.size()); ++b) {
                    const double column =
                        grid.columns == 1 ? 0 : static_cast<double>(k) + within.x[b];
                    double width = 2 * pi;
                    if (grid.columns > 1) {
                        const double c = std::cos(column * psi_step),
                                     s = grid.stretch * std::sin(column * psi_step);
                        width = grid.stretch / (c * c + s * s) * psi_step * within.w[b] *
                                static_cast<double>(sectors);
                    }
                    const auto at = [&](int which) {
                        return interpolate(grid, table.reflectance(which, use.correlated), row,
                                           column);
                    };
                    const double r = (1 - use.f0) * at(0) + use.f0 * at(1);
                    integral += std::max(0.0, (use.metal ? use.f0 : 1) - r) * height * width;
                }
        }
    return integral > pi * reflectance_error ? 1 / integral : 0;
}

namespace {

float number(double x) {
    return static_cast<float>(x);
}
float number(std::size_t x) {
    return static_cast<float>(x);
}

/// The words of an image or of tabulated values, and what its part says of them.
void append_image(std::vector<float>& words, const DirectionTable& image, float* part) {
    part[IMAGE] = number(words.size());
    part[IMAGE_WIDTH] = number(image.width);
    part[IMAGE_HEIGHT] = number(image.height);
    part[IMAGE_EXTENT] = number(image.extent);
    for (const auto* nodes : {&image.thetas, &image.phis})
        words.insert(words.end(), nodes->begin(), nodes->end());
    words.insert(words.end(), image.values.begin(), image.values.end());
}

/// The words of a part's cells, whose masses add up to `whole` over all parts.
void append_cells(std::vector<float>& words, const SamplingCells& cells, double whole,
                  float* part) {
    const std::size_t rows = cells.edges.size() - 1;
    std::vector<double> columns(cells.columns);
    for (std::size_t i = 0; i < cells.mass.size(); ++i)
        columns[i / rows] += cells.mass[i];
    double sum = 0;
    for (const double mass : columns)
        sum += mass;
    part[PROBABILITY] = number(sum / whole);
    part[CELL_ROWS] = number(rows);
    part[CELL_COLUMNS] = number(cells.columns);
    part[CELL_EDGES] = number(words.size());
    words.insert(words.end(), cells.edges.begin(), cells.edges.end());
    part[MARGINAL] = number(words.size());
    append_cumulative(words, columns);
    part[CONDITIONAL] = number(words.size());
    for (std::size_t k = 0; k < cells.columns; ++k) {
        const auto first = cells.mass.begin() + static_cast<std::ptrdiff_t>(k * rows);
        append_cumulative(words, {first, first + static_cast<std::ptrdiff_t>(rows)});
    }
}

/// The word of a shape's kind.
part_kind kind_of(Shape shape) {
    return shape == Shape::Gaussian ? GAUSSIAN : shape == Shape::Velvet ? VELVET : TABULATED;
}

/// The table for a use, with reflectances only where one is given.
std::vector<float> packed(const MicrofacetTable& table, const TableUse* use) {
    const Grid& grid = table.grid;
    std::vector<float> words(HEAD_WORDS + PART_WORDS * table.distribution.parts.size());
    const auto place = [&](const std::vector<float>& plane) {
        const std::size_t offset = words.size();
        append_plane(words, grid, plane);
        return number(offset);
    };
    std::array<float, HEAD_WORDS> head{};
    head[MEAN_HEIGHT] = number(table.mean_height);
    head[MEAN_X] = number(table.mean[0]);
    head[MEAN_Y] = number(table.mean[1]);
    head[MEAN_Z] = number(table.mean[2]);
    head[ELEVATION_SCALE] = number(grid.scale);
    head[ELEVATION_END] = number(std::asinh(pi / 2 / grid.scale));
    head[AZIMUTH_STRETCH] = number(grid.stretch);
    head[GRID_ROWS] = number(grid.rows);
    head[GRID_COLUMNS] = number(grid.columns);
    head[GRID_SECTOR] = static_cast<float>(grid.sector);
    const auto [behind, leans] = interpolated_area(table);
    head[BEHIND] = place(behind);
    head[LEANS] = leans ? 1 : 0;
    if (use != nullptr) {
        head[CORRELATED] = use->correlated ? 1 : 0;
        head[METAL] = use->metal ? 1 : 0;
        head[REFLECTANCE_0] = place(table.reflectance(0, use->correlated));
        head[REFLECTANCE_1] = place(table.reflectance(1, use->correlated));
        head[DIFFUSE_SCALE] = number(diffuse_constant(table, *use));
    }
    head[PARTS] = number(table.distribution.parts.size());
    head[FIRST_PART] = HEAD_WORDS;
    head[FACETS] = number(words.size());
    head[FACET_ROWS] = number(table.facets.rows);
    head[FACET_COLUMNS] = number(table.facets.columns);
    head[STEEP] = number(0.9 * table.steep);
    std::copy(head.begin(), head.end(), words.begin());
    words.insert(words.end(), table.facets.values.begin(), table.facets.values.end());

    double whole = 0;
    for (const SamplingCells& cells : table.cells)
        for (const float mass : cells.mass)
            whole += mass;
    for (std::size_t n = 0; n < table.distribution.parts.size(); ++n) {
        const DistributionPart& part = table.distribution.parts[n];
        std::array<float, PART_WORDS> own{};
        own[KIND] = static_cast<float>(kind_of(part.shape));
        own[AMPLITUDE] = number(part.amplitude);
        own[INVERSE_X2] = number(1 / (part.sigma_x * part.sigma_x));
        own[INVERSE_Y2] = number(1 / (part.sigma_y * part.sigma_y));
        const std::array<double, 9> frame = part.frame();
        std::transform(frame.begin(), frame.end(), own.begin() + FRAME,
                       [](double x) { return number(x); });
        if (part.table != nullptr)
            append_image(words, *part.table, own.data());
        own[LEAST_THETA] = number(least_theta(part));
        const std::array<double, 2> stretch = azimuth_stretch(part);
        own[STRETCH_X] = number(stretch[0]);
        own[STRETCH_Y] = number(stretch[1]);
        own[GREATEST_THETA] = number(greatest_theta(part));
        if (n < table.cells.size())
            append_cells(words, table.cells[n], whole, own.data());
        std::copy(own.begin(), own.end(),
                  words.begin() + static_cast<std::ptrdiff_t>(HEAD_WORDS + n * PART_WORDS));
    }
    if (words.size() > most_table_words)
        throw InputError(fmt::format("a microfacet table of {} values; expected at most {}",
                                     words.size(), most_table_words));
    return words;
}

} // namespace

std::vector<float> packed_for_lobe(const MicrofacetTable& table, const TableUse& use) {
    return packed(table, &use);
}

std::vector<float> packed_areas(const MicrofacetTable& table) {
    return packed(table, nullptr);
}

} // namespace brdfit
