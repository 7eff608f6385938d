#include "host/evaluate/klems.hpp"

#include "host/error.hpp"
#include "host/files/columns.hpp"
#include "host/image/svg.hpp"
#include "host/version.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace brdfit::klems {

namespace {

constexpr std::size_t side = 4, points = side * side; // of a patch, along theta and phi
constexpr std::size_t patches_a_pass = 16;

double squared_sine(double degrees) {
    const double sine = std::sin(degrees * degree);
    return sine * sine;
}

/// Directions in each patch, each of as much projected solid angle as the others.
std::vector<Vector> points_of_patches() {
    std::vector<Vector> made;
    for (const Ring& ring : rings)
        for (std::size_t patch = 0; patch < ring.patches; ++patch)
            for (std::size_t k = 0; k < points; ++k) {
                const double t = (static_cast<double>(k / side) + 0.5) / side,
                             p = (static_cast<double>(k % side) + 0.5) / side - 0.5;
                const double lower = squared_sine(ring.lower), upper = squared_sine(ring.upper);
                made.push_back(direction(std::asin(std::sqrt(lower + t * (upper - lower))),
                                         2 * pi * (static_cast<double>(patch) + p) /
                                             static_cast<double>(ring.patches)));
            }
    return made;
}

constexpr const char* head = R"(<?xml version="1.0" encoding="UTF-8"?>
<WindowElement xmlns="http://windows.lbl.gov" xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:schemaLocation="http://windows.lbl.gov/BSDF-v1.4.xsd">
<!-- written by brdfit {} -->
<WindowElementType>System</WindowElementType>
<FileType>BSDF</FileType>
<Optical>
<Layer>
<Material>
<Name>{}</Name>
<Manufacturer>unknown</Manufacturer>
<DeviceType>Other</DeviceType>
</Material>
<DataDefinition>
<IncidentDataStructure>Columns</IncidentDataStructure>
<AngleBasis>
<AngleBasisName>LBNL/Klems Full</AngleBasisName>
)";
constexpr const char* ring_text = R"(<AngleBasisBlock>
<Theta>{:g}</Theta>
<nPhis>{}</nPhis>
<ThetaBounds><LowerTheta>{:g}</LowerTheta><UpperTheta>{:g}</UpperTheta></ThetaBounds>
</AngleBasisBlock>
)";
constexpr const char* block_head = R"(<WavelengthData>
<LayerNumber>System</LayerNumber>
<Wavelength unit="Integral">Visible</Wavelength>
<SourceSpectrum>CIE Illuminant D65 1nm.ssp</SourceSpectrum>
<DetectorSpectrum>ASTM E308 1931 Y.dsp</DetectorSpectrum>
<WavelengthDataBlock>
<WavelengthDataDirection>Reflection {}</WavelengthDataDirection>
<ColumnAngleBasis>LBNL/Klems Full</ColumnAngleBasis>
<RowAngleBasis>LBNL/Klems Full</RowAngleBasis>
<ScatteringDataType>BRDF</ScatteringDataType>
<ScatteringData>
)";

} // namespace

std::vector<double> projected_solid_angles() {
    std::vector<double> made;
    for (const Ring& ring : rings)
        made.insert(made.end(), ring.patches,
                    pi * (squared_sine(ring.upper) - squared_sine(ring.lower)) /
                        static_cast<double>(ring.patches));
    return made;
}

std::vector<double> matrix(const BrdfFunction& brdf, const std::vector<double>& weights,
                           const ProgressFunction& progress) {
    const std::vector<Vector> at = points_of_patches();
    std::vector<double> made(patches * patches);
    for (std::size_t first = 0; first < patches; first += patches_a_pass) {
        const std::size_t last = std::min(first + patches_a_pass, patches);
        Directions directions((last - first) * points * at.size());
        std::size_t k = 0;
        for (std::size_t i = first * points; i < last * points; ++i)
            for (const Vector& wo : at)
                directions.set(k++, {-at[i][0], -at[i][1], at[i][2]}, wo);
        const std::vector<float> f = brdf(directions);
        for (k = 0; k < directions.count(); ++k) {
            const std::size_t in = first + k / at.size() / points, out = k % at.size() / points;
            for (std::size_t c = 0; c < weights.size(); ++c)
                made[out * patches + in] +=
                    weights[c] * f[c * directions.count() + k] / (points * points);
        }
        tell(progress, static_cast<double>(last) / patches);
    }
    return made;
}

std::vector<double> luminance_weights(const std::vector<std::string>& channels,
                                      const std::string& source) {
    if (channels.size() == 1)
        return {1};
    if (channels == std::vector<std::string>{"R", "G", "B"})
        return {0.2126, 0.7152, 0.0722};
    if (channels == std::vector<std::string>{"X", "Y", "Z"})
        return {0, 1, 0};
    throw InputError(fmt::format("{}: {} channels; expected one, R, G and B, or X, Y and Z: the "
                                 "file holds a luminance",
                                 source, channels.size()));
}

void write(const std::vector<double>& matrix, const std::string& name, const std::string& path) {
    RowWriter writer(path);
    writer.bytes(fmt::format(fmt::runtime(head), version, svg_escaped(name)));
    for (const Ring& ring : rings)
        writer.bytes(fmt::format(fmt::runtime(ring_text),
                                 ring.lower == 0 ? 0 : (ring.lower + ring.upper) / 2, ring.patches,
                                 ring.lower, ring.upper));
    writer.bytes("</AngleBasis>\n</DataDefinition>\n");
    for (const char* direction : {"Front", "Back"}) {
        writer.bytes(fmt::format(fmt::runtime(block_head), direction));
        for (std::size_t k = 0; k < matrix.size(); ++k)
            writer.bytes(fmt::format("{:.6g}{}", std::max(matrix[k], 0.0),
                                     (k + 1) % patches > 0 ? ",\t" : ",\n"));
        writer.bytes("</ScatteringData>\n</WavelengthDataBlock>\n</WavelengthData>\n");
    }
    writer.bytes("</Layer>\n</Optical>\n</WindowElement>\n");
    writer.commit();
}

} // namespace brdfit::klems
