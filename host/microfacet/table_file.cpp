#include "host/microfacet/table_file.hpp"
#include "host/error.hpp"
#include "host/image/image.hpp"
#include "host/image/preview.hpp"
#include "host/version.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

// Microfacet tables as OpenEXR files: part `tables` with the planes over the grid of directions
// and, as attribute `microfacet`, JSON of all that is no plane; a part `sampling.N` for the cells
// of each part of the distribution, `values.N` for its image or tabulated values, `facets` for
// Eq. 33.

namespace brdfit {

namespace {

constexpr std::size_t most_nodes = std::size_t{1} << 20;
constexpr double most_number = std::numeric_limits<float>::max(), least_mean_height = 1e-30;

Image plane_image(const std::string& name, const std::string& channel, std::size_t width,
                  std::size_t height, std::vector<float> values, const std::string& quantity) {
    Image image;
    image.width = width;
    image.height = height;
    image.channels = {channel};
    image.planes = {std::move(values)};
    image.metadata = {{"name", name}, {"quantity", quantity}};
    return image;
}

const char* shape_name(Shape shape) {
    switch (shape) {
    case Shape::Velvet:
        return "velvet";
    case Shape::Tabulated:
        return "tabulated";
    case Shape::Gaussian:
        break;
    }
    return "gaussian";
}

Json sigma_json(double sigma) {
    return std::isinf(sigma) ? Json(nullptr) : Json(sigma);
}

Json part_json(const DistributionPart& part) {
    Json json = {{"shape", shape_name(part.shape)}, {"amplitude", part.amplitude}};
    if (part.shape != Shape::Tabulated) {
        json["sigma_x"] = sigma_json(part.sigma_x);
        json["sigma_y"] = sigma_json(part.sigma_y);
    }
    json["tilt"] = part.tilt;
    json["turn"] = part.turn;
    json["area_scale"] = part.area_scale;
    if (part.table != nullptr && part.table->tabulated()) {
        json["theta_h"] = part.table->thetas;
        json["phi_h"] = part.table->phis;
    } else if (part.table != nullptr)
        json["extent"] = part.table->extent;
    return json;
}

/// What a table needs of a file, with errors that name it.
class Reader {
  public:
    Reader(std::vector<Image> parts, const std::string& path)
        : path_(path), images_(std::move(parts)) {}

    std::shared_ptr<const MicrofacetTable> read() {
        const Image& tables = image("tables", "a table that brdfit generate made");
        const auto text = tables.metadata.find("microfacet");
        if (text == tables.metadata.end())
            fail("has no attribute microfacet; expected a table that brdfit generate made");
        const std::string source = path_ + ": microfacet";
        const Json json = parse_json(text->second, source, "JSON that describes the table");
        const Place top{source, ""};
        check_object(json, top, "an object");
        if (const Json& format = required(json, top, "version", "1"); format != 1)
            top.member("version").fail(format, "1");
        auto table = std::make_shared<MicrofacetTable>();
        const auto number = [&](const char* key, double lower, double upper) {
            return parse_number(required(json, top, key, "a number"), top.member(key), lower,
                                upper);
        };
        table->mean[0] = number("mean_x", -most_number, most_number);
        table->mean[1] = number("mean_y", -most_number, most_number);
        table->mean[2] = number("mean_z", -most_number, most_number);
        table->mean_height = number("mean_height", least_mean_height, most_number);
        table->steep = number("steep", 0, 1);
        table->grid.scale = number("elevation_scale", 1e-4, 10);
        table->grid.stretch = number("azimuth_stretch", 1e-3, 1e3);
        const double sector = number("sector", 0, 4);
        if (sector != 0 && sector != 1 && sector != 2 && sector != 4)
            top.member("sector").fail(json["sector"], "0, 1, 2 or 4");
        table->grid.sector = static_cast<Sector>(static_cast<int>(sector));
        table->grid.rows = tables.height;
        table->grid.columns = tables.width;
        const bool round = table->grid.sector == Sector::Isotropic;
        if (tables.height < 4 || (round ? tables.width != 1 : tables.width < 4))
            fail(fmt::format(
                "has a grid of {} rows and {} columns; expected at least 4 rows and {}",
                tables.height, tables.width, round ? "1 column, as it is isotropic" : "4 columns"));
        table->g = plane(tables, "g", true);
        table->r0 = plane(tables, "R0", true);
        table->r1 = plane(tables, "R1", true);
        table->r0_correlated = plane(tables, "R0_correlated", true);
        table->r1_correlated = plane(tables, "R1_correlated", true);
        table->distribution.sector = table->grid.sector;
        const Json& name = required(json, top, "distribution", "a text");
        if (!name.is_string())
            top.member("distribution").fail(name, "a text");
        table->distribution.name = name.get<std::string>();

        const std::string expected = fmt::format("an array of 1 to {} parts", max_parts);
        const Json& parts = required(json, top, "parts", expected);
        const Place here = top.member("parts");
        if (!parts.is_array() || parts.empty() || parts.size() > max_parts)
            here.fail(parts, expected);
        for (std::size_t n = 0; n < parts.size(); ++n) {
            table->distribution.parts.push_back(part(parts[n], here.element(n), n));
            table->cells.push_back(cells(n));
        }
        if (const Image* facets = find("facets")) {
            table->facets.columns = facets->width;
            table->facets.rows = static_cast<std::size_t>(std::lround(std::sqrt(facets->height)));
            if (facets->width < 4 || table->facets.rows < 4 ||
                table->facets.rows * table->facets.rows != facets->height)
                fail(fmt::format("part facets has {} x {} pixels; expected a square number of rows",
                                 facets->width, facets->height));
            table->facets.values = plane(*facets, "facets", true);
        }
        return table;
    }

  private:
    [[noreturn]] void fail(const std::string& problem) const {
        throw InputError(fmt::format("{}: {}", path_, problem));
    }

    const Image* find(const std::string& name) const {
        for (const Image& image : images_) {
            const auto found = image.metadata.find("name");
            if (found != image.metadata.end() && found->second == name)
                return &image;
        }
        return nullptr;
    }

    const Image& image(const std::string& name, const std::string& expected) const {
        const Image* const found = find(name);
        if (found == nullptr)
            fail(fmt::format("has no part {}; expected {}", name, expected));
        return *found;
    }

    std::vector<float> plane(const Image& image, const std::string& channel, bool finite) const {
        const std::vector<float>* const found = image.plane(channel);
        if (found == nullptr)
            fail(fmt::format("part {} has channels {}; {} is missing", image.metadata.at("name"),
                             fmt::join(image.channels, ", "), channel));
        for (std::size_t i = 0; finite && i < found->size(); ++i)
            if (!std::isfinite((*found)[i]) || (*found)[i] < 0)
                fail(fmt::format("channel {} is {} in row {}, column {}; expected finite values of "
                                 "at least 0",
                                 channel, (*found)[i], i / image.width, i % image.width));
        return *found;
    }

    DistributionPart part(const Json& json, const Place& at, std::size_t n) const {
        check_object(json, at, "an object that describes a part of the distribution");
        DistributionPart part;
        const std::string shapes = "gaussian, velvet or tabulated";
        const Json& shape = required(json, at, "shape", shapes);
        if (shape == "velvet")
            part.shape = Shape::Velvet;
        else if (shape == "tabulated")
            part.shape = Shape::Tabulated;
        else if (shape != "gaussian")
            at.member("shape").fail(shape, shapes);
        const auto number = [&](const char* key, double lower, double upper) {
            return parse_number(required(json, at, key, "a number"), at.member(key), lower, upper);
        };
        part.amplitude = number("amplitude", 0, most_number);
        part.tilt = number("tilt", -2 * pi, 2 * pi);
        part.turn = number("turn", -2 * pi, 2 * pi);
        part.area_scale = number("area_scale", 0, 1e6);
        const auto sigma = [&](const char* key) {
            const Json& value = required(json, at, key, "a width, or null");
            return value.is_null() ? std::numeric_limits<double>::infinity()
                                   : parse_number(value, at.member(key), 1e-4, 1e4);
        };
        if (part.shape != Shape::Tabulated) {
            part.sigma_x = sigma("sigma_x");
            part.sigma_y = sigma("sigma_y");
            if (!json.contains("extent"))
                return part;
        }
        const std::string name = fmt::format("values.{}", n);
        const Image& values = image(name, "the values of a distribution");
        auto table = std::make_shared<DirectionTable>();
        table->width = values.width;
        table->height = values.height;
        table->values = plane(values, "p", true);
        check_values(*table, fmt::format("{}: part {}", path_, name));
        if (part.shape == Shape::Tabulated) {
            table->thetas = angles(json, at, "theta_h", values.height, pi + 1e-5);
            table->phis = angles(json, at, "phi_h", values.width, 2 * pi);
            if (values.height < 2)
                fail(fmt::format("part {} has 1 row; expected at least 2", name));
        } else
            table->extent = number("extent", 0, 1);
        part.table = table;
        return part;
    }

    static std::vector<double> angles(const Json& json, const Place& at, const std::string& key,
                                      std::size_t count, double upper) {
        const std::string expected = fmt::format("an array of {} ascending angles", count);
        const Json& list = required(json, at, key, expected);
        const Place here = at.member(key);
        if (!list.is_array() || list.size() != count || count > most_nodes)
            here.fail(list, expected);
        std::vector<double> nodes;
        for (std::size_t i = 0; i < count; ++i) {
            nodes.push_back(parse_number(list[i], here.element(i), 0, upper));
            if (i > 0 && !(nodes[i] > nodes[i - 1]))
                here.element(i).fail(list[i], "more than the angle before");
        }
        return nodes;
    }

    SamplingCells cells(std::size_t n) const {
        const std::string name = fmt::format("sampling.{}", n);
        const Image& image = this->image(name, "the cells that half vectors are drawn from");
        SamplingCells cells;
        cells.columns = image.height;
        cells.mass = plane(image, "mass", true);
        const std::vector<float> edges = plane(image, "edge", true);
        cells.edges = {0};
        for (std::size_t i = 0; i < image.width; ++i) {
            if (!(edges[i] > cells.edges.back()) || edges[i] > 1)
                fail(fmt::format("part {}: edge {} is {}; expected ascending shares up to 1", name,
                                 i, edges[i]));
            cells.edges.push_back(double{edges[i]});
        }
        double whole = 0;
        for (const float mass : cells.mass)
            whole += mass;
        if (cells.edges.back() != 1 || !(whole > 0))
            fail(fmt::format("part {}: expected cells up to 1 and a positive mass", name));
        return cells;
    }

    const std::string& path_;
    std::vector<Image> images_;
};

} // namespace

// What read_table needs beside the planes.
static Json description_of(const MicrofacetTable& table) {
    const Grid& grid = table.grid;
    Json json = {{"version", 1},
                 {"distribution", table.distribution.name},
                 {"mean_x", table.mean[0]},
                 {"mean_y", table.mean[1]},
                 {"mean_z", table.mean[2]},
                 {"mean_height", table.mean_height},
                 {"steep", table.steep},
                 {"elevation_scale", grid.scale},
                 {"azimuth_stretch", grid.stretch},
                 {"sector", static_cast<int>(grid.sector)},
                 {"parts", Json::array()}};
    for (const DistributionPart& part : table.distribution.parts)
        json["parts"].push_back(part_json(part));
    return json;
}

// Throws where read_table would not take what is written.
static void require_readable(const MicrofacetTable& table, const std::string& path) {
    const auto number = [&](const std::string& name, double value, double lower) {
        if (!(value >= lower && value <= most_number))
            throw InputError(fmt::format("{}: {} of the table is {:.6g}; expected a number of at "
                                         "least {} in single precision",
                                         path, name, value, lower));
    };
    const auto plane = [&](const std::string& name, const std::vector<float>& values) {
        for (const float value : values)
            number(name, double{value}, 0);
    };
    number("mean_x", table.mean[0], -most_number);
    number("mean_y", table.mean[1], -most_number);
    number("mean_z", table.mean[2], -most_number);
    number("mean_height", table.mean_height, least_mean_height);
    number("steep", table.steep, 0);
    plane("g", table.g);
    plane("R0", table.r0);
    plane("R1", table.r1);
    plane("R0_correlated", table.r0_correlated);
    plane("R1_correlated", table.r1_correlated);
    plane("facets", table.facets.values);
    for (const DistributionPart& part : table.distribution.parts)
        number("amplitude", part.amplitude, 0);
    for (const SamplingCells& cells : table.cells)
        plane("the mass of cells", cells.mass);
}

void write_table(const MicrofacetTable& table, const std::string& path) {
    require_readable(table, path);
    const Grid& grid = table.grid;
    Image tables;
    tables.width = grid.columns;
    tables.height = grid.rows;
    tables.channels = {"g", "R0", "R1", "R0_correlated", "R1_correlated"};
    tables.planes = {table.g, table.r0, table.r1, table.r0_correlated, table.r1_correlated};
    const char* const sector = grid.sector == Sector::All       ? "0 to 2 pi, going round"
                               : grid.sector == Sector::Half    ? "0 to pi, mirrored in y"
                               : grid.sector == Sector::Quarter ? "0 to pi/2, mirrored in x and y"
                                                                : "one: isotropic";
    tables.metadata = {
        {"name", "tables"},
        {"microfacet", description_of(table).dump()},
        {"quantity", "g: integral of (h.k)+ p(h) dw; R0, R1: directional reflectance at f0 = 0 and "
                     "1, with independent and with correlated shadowing"},
        {"axes",
         fmt::format(
             "row r: elevation of k = a sinh(r / {} asinh(pi / (2 a))), a = {}, row 0 at the "
             "horizon; column: azimuth phi, tan phi = {} tan psi, psi in equal steps, {}",
             grid.rows - 1, grid.scale, grid.stretch, sector)},
        {"paper", "Ashikhmin, Premoze, Shirley 2000, Eq. 18, 26, 29"},
        {"software", fmt::format("brdfit {}", version)}};
    std::vector<Image> images{tables};
    for (std::size_t n = 0; n < table.cells.size(); ++n) {
        const SamplingCells& cells = table.cells[n];
        const std::size_t rows = cells.edges.size() - 1;
        Image image =
            plane_image(fmt::format("sampling.{}", n), "mass", rows, cells.columns, cells.mass,
                        "mass of p(h) above the horizon in cells of polar "
                        "angle (columns, up to `edge`) and azimuth (rows)");
        image.channels.emplace_back("edge");
        std::vector<float>& edges = image.planes.emplace_back();
        for (std::size_t i = 0; i < cells.mass.size(); ++i)
            edges.push_back(static_cast<float>(cells.edges[i % rows + 1]));
        images.push_back(std::move(image));
        const auto& values = table.distribution.parts[n].table;
        if (values != nullptr)
            images.push_back(plane_image(
                fmt::format("values.{}", n), "p", values->width, values->height, values->values,
                values->tabulated() ? "p(h), rows theta_h, columns phi_h" : "factor on p(h)"));
    }
    if (table.facets.rows > 0)
        images.push_back(plane_image(
            "facets", "facets", table.facets.columns, table.facets.rows * table.facets.rows,
            table.facets.values,
            "integral of (wi.h)+ (wo.h)+ p(h) dw: columns azimuth from 0 to pi, rows elevation of "
            "wi, then of wo, spaced as in tables"));
    write_exr_parts(images, path, ExrPixel::Float);
}

std::string write_table_preview(const MicrofacetTable& table, const std::string& path) {
    std::vector<PreviewPanel> panels;
    for (const auto& [name, plane] :
         {std::pair("g", &table.g), std::pair("R0", &table.r0), std::pair("R1", &table.r1),
          std::pair("R0_correlated", &table.r0_correlated),
          std::pair("R1_correlated", &table.r1_correlated)})
        panels.push_back({name, table.grid.columns, table.grid.rows, *plane});
    return write_preview(panels, path);
}

std::shared_ptr<const MicrofacetTable> read_table(const std::string& path) {
    return table_of(read_exr_parts(path), path);
}

std::shared_ptr<const MicrofacetTable> table_of(std::vector<Image> parts, const std::string& path) {
    return Reader(std::move(parts), path).read();
}

} // namespace brdfit
