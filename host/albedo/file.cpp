#include "host/albedo/file.hpp"

#include "host/error.hpp"
#include "host/files/columns.hpp"
#include "host/files/file.hpp"
#include "host/image/image.hpp"
#include "host/version.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <iterator>

namespace brdfit {

namespace {

std::vector<float> to_floats(const std::vector<double>& values) {
    return {values.begin(), values.end()};
}

std::string averages(const Albedo& albedo) {
    std::string text;
    for (std::size_t ch = 0; ch < albedo.channels.size(); ++ch)
        text += fmt::format("{}{} {:.6g} +- {:.2g}", ch == 0 ? "" : ", ", albedo.channels[ch],
                            albedo.average[ch], albedo.average_error[ch]);
    return text;
}

struct AlbedoColumns {
    std::vector<std::string> names;
    std::vector<std::vector<float>> values; ///< [column][viewer]
};

AlbedoColumns columns_of(const Albedo& albedo) {
    AlbedoColumns columns{{"theta", "phi"}, {to_floats(albedo.theta), to_floats(albedo.phi)}};
    const auto add = [&](const std::string& name, const std::vector<double>& values) {
        columns.names.push_back(name);
        columns.values.push_back(to_floats(values));
    };
    for (std::size_t ch = 0; ch < albedo.channels.size(); ++ch)
        add(albedo.channels[ch], albedo.values[ch]);
    for (std::size_t ch = 0; ch < albedo.channels.size(); ++ch)
        add(albedo.channels[ch] + "_error", albedo.errors[ch]);
    if (!albedo.measured.empty())
        add("measured", albedo.measured);
    return columns;
}

std::string what_is(const std::string& source) {
    return fmt::format("directional albedo of {}: integral of f cos(theta_i) over light directions",
                       source);
}

const std::string by = fmt::format("brdfit {}", version);

std::vector<std::string> csv_provenance(const Albedo& albedo, const std::string& source) {
    std::vector<std::string> lines{what_is(source) + ", by " + by,
                                   "theta, phi: of the viewer, radians",
                                   "hemispherical albedo: " + averages(albedo)};
    lines.insert(lines.end(), albedo.notes.begin(), albedo.notes.end());
    return lines;
}

} // namespace

std::string albedo_csv(const Albedo& albedo, const std::string& source) {
    const AlbedoColumns columns = columns_of(albedo);
    require_csv_names(source, columns.names);
    std::string text = csv_head(columns.names, csv_provenance(albedo, source));
    for (std::size_t k = 0; k < albedo.count(); ++k)
        for (std::size_t c = 0; c < columns.values.size(); ++c)
            text += fmt::format("{}{}", columns.values[c][k],
                                c + 1 < columns.values.size() ? ',' : '\n');
    return text;
}

void write_albedo(const Albedo& albedo, const std::string& path, const std::string& source) {
    const auto [names, columns] = columns_of(albedo);
    if (std::filesystem::path(path).extension() == ".csv")
        return write_columns(path, names, columns, csv_provenance(albedo, source));
    if (std::filesystem::path(path).extension() != ".exr")
        throw UsageError(fmt::format("{}: unknown ending; expected .csv or .exr", path));
    Image image;
    image.width = albedo.columns == 0 ? albedo.count() : albedo.columns;
    image.height = albedo.count() / image.width;
    image.channels = names;
    image.planes = columns;
    image.metadata = {
        {"quantity", what_is(source)},
        {"software", by},
        {"source", source},
        {"axes", albedo.columns == 0
                     ? "x: the file's directions, see the channels theta and phi, radians"
                     : "x: theta from 0 to pi/2; y: phi from 0 in equal steps of 2 pi; radians, "
                       "also in the channels theta and phi"},
        {"nodes", albedo.columns == 0 ? "as measured" : "corners in theta, periodic in phi"},
        {"hemispherical", averages(albedo)},
        {"notes", fmt::format("{}", fmt::join(albedo.notes, "; "))}};
    write_exr(image, path, ExrPixel::Float);
}

} // namespace brdfit
