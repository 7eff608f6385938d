#include "host/error.hpp"
#include "host/files/columns.hpp"
#include "host/measured/formats.hpp"
#include "host/measured/rows.hpp"

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <fmt/format.h>

namespace brdfit::zemax {

namespace {

bool same_word(std::string_view a, std::string_view b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](unsigned char x, unsigned char y) {
        return std::tolower(x) == std::tolower(y);
    });
}

/// What stands ahead of the data.
struct Header : Grid {
    std::vector<std::string> channels;
};

/// `count` ascending angles, on one line or more.
std::vector<double> read_angles(text::Lines& lines, std::string_view key, std::size_t count,
                                double least, double most) {
    if (count == 0)
        lines.fail(fmt::format("{}: no angles; expected at least one", key));
    std::vector<double> angles;
    std::vector<std::string_view> words;
    const std::string name(key);
    while (angles.size() < count && lines.next()) {
        text::split(lines.line(), ' ', words);
        for (const std::string_view word : words) {
            const double angle = text::number(lines, name, word);
            if (angle < least || angle > most)
                lines.fail(fmt::format("{}: {}; expected an angle in [{}, {}] degrees", name,
                                       text::quoted(word), least, most));
            if (!angles.empty() && angle * degree <= angles.back())
                lines.fail(
                    fmt::format("{}: {}; expected angles that ascend", name, text::quoted(word)));
            angles.push_back(angle * degree);
        }
    }
    if (angles.size() != count)
        lines.fail(fmt::format("{}: {} angles; expected {}", name, angles.size(), count));
    return angles;
}

void read_word(const text::Lines& lines, std::string_view key, std::string_view value,
               Header& header) {
    if (key == "Symmetry") {
        header.plane_symmetric = same_word(value, "PlaneSymmetrical");
        if (!header.plane_symmetric && !same_word(value, "Asymmetrical") &&
            !same_word(value, "Asymmetrical4D"))
            lines.fail(fmt::format("Symmetry: {}; expected PlaneSymmetrical, Asymmetrical or "
                                   "Asymmetrical4D",
                                   text::quoted(value)));
    } else if (key == "SpectralContent") {
        if (value != "Monochrome" && value != "XYZ")
            lines.fail(fmt::format("SpectralContent: {}; expected Monochrome or XYZ",
                                   text::quoted(value)));
        header.channels =
            value == "XYZ" ? std::vector<std::string>{"X", "Y", "Z"} : numbered_channels(1);
    } else if (key == "ScatterType") {
        if (value != "BRDF")
            lines.fail(
                fmt::format("ScatterType: {}; expected BRDF: reflection", text::quoted(value)));
    } else if (key != "Source") {
        lines.fail(fmt::format("{}; expected a keyword of the Zemax header", text::quoted(key)));
    }
}

/// Reads up to the line that heads the first channel's data.
Header read_header(text::Lines& lines) {
    Header header;
    std::vector<std::string_view> words;
    while (lines.next()) {
        text::split(lines.line(), ' ', words);
        if (words.size() == 1)
            break;
        if (words.size() != 2)
            lines.fail(fmt::format("{} words; expected a keyword and its value", words.size()));
        const std::string key(words[0]);
        const auto angles = [&](double least, double most) {
            return read_angles(lines, key, text::count(lines, key, words[1]), least, most);
        };
        if (key == "SampleRotation")
            header.rotations = angles(-360, 360);
        else if (key == "AngleOfIncidence")
            header.incidences = angles(0, 90);
        else if (key == "ScatterAzimuth")
            header.azimuths = angles(-360, 360);
        else if (key == "ScatterRadial")
            header.radials = angles(0, 180);
        else
            read_word(lines, key, words[1], header);
    }
    const std::pair<bool, const char*> parts[] = {{header.channels.empty(), "SpectralContent"},
                                                  {header.rotations.empty(), "SampleRotation"},
                                                  {header.incidences.empty(), "AngleOfIncidence"},
                                                  {header.azimuths.empty(), "ScatterAzimuth"},
                                                  {header.radials.empty(), "ScatterRadial"}};
    for (const auto& [missing, name] : parts)
        if (missing)
            lines.fail(fmt::format("the header ends without {}", name));
    return header;
}

/// Appends a channel's numbers, from the line that names it on:
/// [rotation][incidence][azimuth][radial].
void read_channel(text::Lines& lines, const Header& header, std::size_t channel,
                  std::vector<float>& values) {
    const std::string name =
        header.channels.size() == 1 ? "Monochrome" : "Tristimulus" + header.channels[channel];
    if (lines.line() != name)
        lines.fail(fmt::format("{}; expected {}", text::quoted(lines.line()), name));
    if (!lines.next() || lines.line() != "DataBegin")
        lines.fail("expected DataBegin");
    std::vector<std::string_view> words;
    const auto next = [&](const char* what) {
        if (!lines.next())
            lines.fail_file(fmt::format("the file ends within its data; expected {}", what));
        text::split(lines.line(), ' ', words);
    };
    for (std::size_t block = 0; block < header.blocks(); ++block) {
        for (std::size_t a = 0; a < header.azimuths.size(); ++a) {
            next("a row of values");
            if (a == 0 && words[0] == "TIS") {
                if (words.size() != 2)
                    lines.fail("expected TIS and its value");
                text::number(lines, "TIS", words[1]);
                next("a row of values");
            }
            if (words.size() != header.radials.size())
                lines.fail(fmt::format("{} values; expected {}, one for each ScatterRadial",
                                       words.size(), header.radials.size()));
            for (const std::string_view word : words) {
                const double value = text::number(lines, "value", word);
                if (std::abs(value) > FLT_MAX)
                    lines.fail(fmt::format("value: {} is too large", text::quoted(word)));
                values.push_back(static_cast<float>(value));
            }
        }
    }
    next("DataEnd");
    if (lines.line() != "DataEnd")
        lines.fail("more data than the header says; expected DataEnd");
}

/// The direction at radial and azimuth angle from the specular one of a light at polar angle
/// `incidence` above x: azimuth 0 points to the normal, angles run counter-clockwise.
Vector scattered_direction(double incidence, double azimuth, double radial) {
    const Vector local = direction(radial, azimuth);
    const double cosine = std::cos(incidence), sine = std::sin(incidence);
    return {cosine * local[0] - sine * local[2], local[1], sine * local[0] + cosine * local[2]};
}

Vector turned(const Vector& v, double angle) {
    const double cosine = std::cos(angle), sine = std::sin(angle);
    return {cosine * v[0] - sine * v[1], sine * v[0] + cosine * v[1], v[2]};
}

/// Solid angles of ranges of polar angles, a radian of azimuth each.
std::vector<double> polar_measures(const std::vector<double>& nodes, double end) {
    std::vector<double> measures;
    for (const auto& [least, most] : ranges_of(nodes, 0, end))
        measures.push_back(std::cos(least) - std::cos(most));
    return measures;
}

std::vector<double> azimuth_measures(const std::vector<double>& nodes) {
    std::vector<double> measures;
    for (const auto& [least, most] : ranges_of(nodes, nodes.front(), nodes.back()))
        measures.push_back(nodes.size() == 1 ? 2 * pi : most - least);
    return measures;
}

/// Calls body(wi, wo) for each pair of a grid in the order of directions_of.
template <typename Body>
void each_pair(const Grid& grid, Body body) {
    for (const double rotation : grid.rotations)
        for (const double incidence : grid.incidences)
            for (const double azimuth : grid.azimuths)
                for (const double radial : grid.radials)
                    body(direction(incidence, rotation),
                         turned(scattered_direction(incidence, azimuth, radial), rotation));
}

void write_angles(RowWriter& writer, const char* key, const std::vector<double>& angles) {
    writer.bytes(fmt::format("{}\t{}\n", key, angles.size()));
    for (std::size_t i = 0; i < angles.size(); ++i)
        writer.text(std::round(angles[i] / degree * 1e6) / 1e6,
                    i + 1 < angles.size() ? '\t' : '\n');
}

/// Which nodes are samples: above the horizon, and not among the zeros at a row's end, which are
/// directions that were not measured.
std::vector<std::uint8_t> measured_nodes(const Header& header, const std::vector<float>& values) {
    const std::size_t count = values.size() / header.channels.size(),
                      columns = header.radials.size();
    std::vector<std::uint8_t> kept;
    kept.reserve(count);
    each_pair(header, [&](const Vector& wi, const Vector& wo) {
        kept.push_back(static_cast<float>(wi[2]) > 0 && static_cast<float>(wo[2]) > 0 ? 1 : 0);
    });
    for (std::size_t begin = 0; begin < count; begin += columns) {
        const auto zero = [&](std::size_t k) {
            for (std::size_t c = 0; c < header.channels.size(); ++c)
                if (values[c * count + k] != 0)
                    return false;
            return true;
        };
        for (std::size_t k = begin + columns; k-- > begin && zero(k);)
            kept[k] = 0;
    }
    return kept;
}

/// Drops the values, [channel][node], of nodes that are not kept, and the room that they had.
void keep(const std::vector<std::uint8_t>& kept, std::size_t channels, std::vector<float>& values) {
    std::size_t next = 0;
    for (std::size_t k = 0; k < channels * kept.size(); ++k)
        if (kept[k % kept.size()] != 0)
            values[next++] = values[k];
    values.resize(next);
    values.shrink_to_fit();
}

} // namespace

bool recognise(std::string_view bytes) {
    text::Lines lines(bytes);
    std::vector<std::string_view> words;
    for (int i = 0; i < 8 && lines.next(); ++i) {
        text::split(lines.line(), ' ', words);
        for (const char* key : {"ScatterType", "SampleRotation", "AngleOfIncidence"})
            if (words[0] == key)
                return true;
    }
    return false;
}

Samples read(const MappedFile& file, std::optional<bool> isotropic) {
    text::Lines lines(file);
    const Header header = read_header(lines);
    Samples samples;
    samples.format = fmt::format("Zemax BSDF text, {}",
                                 header.plane_symmetric ? "plane-symmetric" : "asymmetric");
    samples.channels = header.channels;
    samples.isotropic = isotropic.value_or(header.rotations.size() == 1);
    // No more than the text has room for, whatever the header says.
    samples.values.reserve(std::min(header.channels.size() * header.blocks() * header.block(),
                                    file.bytes().size() / 2));
    for (std::size_t c = 0; c < header.channels.size(); ++c) {
        if (c > 0 && !lines.next())
            lines.fail_file(
                fmt::format("the file ends after {} of {} channels", c, header.channels.size()));
        read_channel(lines, header, c, samples.values);
    }
    const std::vector<std::uint8_t> kept = measured_nodes(header, samples.values);
    keep(kept, header.channels.size(), samples.values);
    const std::size_t count = samples.values.size() / header.channels.size();
    if (count == 0)
        lines.fail_file("only zeros, or directions below the horizon; expected measured values");
    samples.left_out = kept.size() - count;
    samples.valid.assign(count, 1);
    samples.weights.reserve(count);
    const auto of_rotation = azimuth_measures(header.rotations),
               of_azimuth = azimuth_measures(header.azimuths),
               of_incidence = polar_measures(header.incidences, pi / 2),
               of_radial = polar_measures(header.radials, header.radials.back());
    std::size_t node = 0;
    for (const double rotation : of_rotation)
        for (const double incidence : of_incidence)
            for (const double azimuth : of_azimuth)
                for (const double radial : of_radial)
                    if (kept[node++] != 0)
                        samples.weights.push_back(
                            static_cast<float>(rotation * incidence * azimuth * radial));
    Directions directions = Directions::unfilled(count);
    std::size_t next = 0;
    node = 0;
    each_pair(header, [&](const Vector& wi, const Vector& wo) {
        if (kept[node++] != 0)
            directions.set(next++, wi, wo);
    });
    samples.directions = std::make_shared<const Directions>(std::move(directions));
    return samples;
}

Grid written_grid(bool isotropic) {
    // From one angle to another in degrees.
    const auto steps = [](std::vector<double>& angles, double first, double step, double last) {
        for (int k = 0; first + k * step <= last; ++k)
            angles.push_back((first + k * step) * degree);
    };
    Grid grid;
    grid.plane_symmetric = isotropic;
    steps(grid.rotations, 0, 10, isotropic ? 0 : 360);
    steps(grid.incidences, 0, 5, 85);
    steps(grid.azimuths, 0, 10, isotropic ? 180 : 360);
    steps(grid.radials, 0, 0.5, 4);
    steps(grid.radials, 5, 1, 10);
    steps(grid.radials, 12.5, 2.5, 20);
    steps(grid.radials, 25, 5, 60);
    steps(grid.radials, 70, 10, 180);
    return grid;
}

Directions directions_of(const Grid& grid) {
    Directions directions(grid.blocks() * grid.block());
    std::size_t k = 0;
    each_pair(grid, [&](const Vector& wi, const Vector& wo) { directions.set(k++, wi, wo); });
    return directions;
}

void write(const Grid& grid, std::size_t channels, const std::vector<float>& values,
           const std::string& path, const std::vector<std::string>& provenance) {
    RowWriter writer(path);
    for (const std::string& line : provenance)
        writer.bytes("# " + line + "\n");
    writer.bytes(fmt::format("Source\tMeasured\nSymmetry\t{}\nSpectralContent\t{}\n"
                             "ScatterType\tBRDF\n",
                             grid.plane_symmetric ? "PlaneSymmetrical" : "Asymmetrical4D",
                             channels == 1 ? "Monochrome" : "XYZ"));
    write_angles(writer, "SampleRotation", grid.rotations);
    write_angles(writer, "AngleOfIncidence", grid.incidences);
    write_angles(writer, "ScatterAzimuth", grid.azimuths);
    write_angles(writer, "ScatterRadial", grid.radials);
    std::vector<float> cosines; // of wo
    each_pair(grid, [&](const Vector&, const Vector& wo) {
        cosines.push_back(static_cast<float>(std::max(wo[2], 0.0)));
    });
    const std::vector<double> of_azimuth = azimuth_measures(grid.azimuths),
                              of_radial = polar_measures(grid.radials, grid.radials.back());
    const std::size_t columns = grid.radials.size(), pairs = cosines.size();
    for (std::size_t channel = 0; channel < channels; ++channel) {
        writer.bytes(channels == 1 ? "\nMonochrome\nDataBegin\n"
                                   : fmt::format("\nTristimulus{}\nDataBegin\n", "XYZ"[channel]));
        const float* const f = values.data() + channel * pairs;
        for (std::size_t begin = 0; begin < pairs; begin += grid.block()) {
            double scatter = 0;
            for (std::size_t k = 0; k < grid.block(); ++k)
                scatter += (grid.plane_symmetric ? 2 : 1) * of_azimuth[k / columns] *
                           of_radial[k % columns] * f[begin + k] * cosines[begin + k];
            writer.bytes(fmt::format("TIS\t{:.6g}\n", scatter));
            for (std::size_t k = 0; k < grid.block(); ++k)
                writer.text(f[begin + k], (k + 1) % columns > 0 ? '\t' : '\n');
            writer.end_row();
        }
        writer.bytes("DataEnd\n");
    }
    writer.commit();
}

} // namespace brdfit::zemax
