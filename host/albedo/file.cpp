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

} // namespace

void write_albedo(const Albedo& albedo, const std::string& path, const std::string& source) {
    std::vector<std::string> names{"theta", "phi"};
    std::vector<std::vector<float>> columns{to_floats(albedo.theta), to_floats(albedo.phi)};
    for (std::size_t ch = 0; ch < albedo.channels.size(); ++ch) {
        names.push_back(albedo.channels[ch]);
        columns.push_back(to_floats(albedo.values[ch]));
    }
    for (std::size_t ch = 0; ch < albedo.channels.size(); ++ch) {
        names.push_back(albedo.channels[ch] + "_error");
        columns.push_back(to_floats(albedo.errors[ch]));
    }
    if (!albedo.measured.empty()) {
        names.emplace_back("measured");
        columns.push_back(to_floats(albedo.measured));
    }
    const std::string what = fmt::format(
        "directional albedo of {}: integral of f cos(theta_i) over light directions", source);
    const std::string by = fmt::format("brdfit {}", version);
    if (std::filesystem::path(path).extension() == ".csv") {
        std::vector<std::string> provenance{what + ", by " + by,
                                            "theta, phi: of the viewer, radians",
                                            "hemispherical albedo: " + averages(albedo)};
        provenance.insert(provenance.end(), albedo.notes.begin(), albedo.notes.end());
        return write_columns(path, names, columns, provenance);
    }
    if (std::filesystem::path(path).extension() != ".exr")
        throw UsageError(fmt::format("{}: unknown ending; expected .csv or .exr", path));
    Image image;
    image.width = albedo.columns == 0 ? albedo.count() : albedo.columns;
    image.height = albedo.count() / image.width;
    image.channels = names;
    image.planes = columns;
    image.metadata = {
        {"quantity", what},
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
