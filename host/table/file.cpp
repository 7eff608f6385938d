#include "host/table/table.hpp"

#include "host/error.hpp"
#include "host/files/file.hpp"
#include "host/files/npy.hpp"
#include "host/image/image.hpp"
#include "host/image/preview.hpp"

#include <Imath/half.h>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fmt/format.h>
#include <iterator>
#include <nlohmann/json.hpp>

namespace brdfit {

namespace {

enum class Ending { Exr, Source, Npy, Csv };

Ending ending_of(const std::string& path) {
    const std::string ending = std::filesystem::path(path).extension().string();
    if (ending == ".exr")
        return Ending::Exr;
    if (ending == ".h" || ending == ".hpp" || ending == ".inc")
        return Ending::Source;
    if (ending == ".npy")
        return Ending::Npy;
    if (ending == ".csv")
        return Ending::Csv;
    throw UsageError(
        fmt::format("{}: unknown ending; expected .exr, .h, .hpp, .inc, .npy or .csv", path));
}

std::uint16_t half_bits(double value) {
    return Imath::half(static_cast<float>(value)).bits();
}

std::uint16_t unorm16(double value) {
    return static_cast<std::uint16_t>(std::lround(std::clamp(value, 0.0, 1.0) * 65535));
}

/// The value that is left of another in the table's encoding.
double encoded(const TableSpec& spec, double value) {
    switch (spec.encoding) {
    case Encoding::Float:
        return static_cast<double>(static_cast<float>(value));
    case Encoding::Half:
        return static_cast<double>(static_cast<float>(Imath::half(static_cast<float>(value))));
    case Encoding::Unorm16:
        return unorm16(value) / 65535.0;
    }
    return value;
}

/// Throws InputError where a value is not finite in the table's encoding, and where unorm16 does
/// not hold one, unless it may be clamped. Returns how many will be.
std::size_t check_values(const Table& table, const std::string& path, bool clamp) {
    const TableSpec& spec = table.spec;
    std::size_t outside = 0, entry = 0, channel = 0;
    double most = 0, farthest = 0;
    // What is within the error of 0 or 1, or is rounded to it, is it.
    const double slack = std::max(0.5 / 65535, table.error);
    for (std::size_t v = 0; v < spec.values(); ++v)
        for (std::size_t e = 0; e < spec.entries(); ++e) {
            const double value = table.values[v][e];
            if (!std::isfinite(value) || !std::isfinite(encoded(spec, value)))
                throw InputError(fmt::format(
                    "{}: {} is {:.6g} at {}; expected numbers that {} holds", path,
                    spec.channels[v], value, spec.place(e),
                    spec.encoding == Encoding::Half ? "half precision" : "single precision"));
            const double distance = std::max(value - 1, -value);
            if (spec.encoding != Encoding::Unorm16 || distance <= slack)
                continue;
            ++outside;
            if (distance > farthest) {
                farthest = distance;
                most = value;
                entry = e;
                channel = v;
            }
        }
    if (outside > 0 && !clamp)
        throw InputError(fmt::format(
            "{}: unorm16 holds 0 to 1, but {} of {} values are outside, the farthest {} = {:.6g} "
            "at {}; --encoding half or float holds them, --clamp cuts them off",
            path, outside, spec.values() * spec.entries(), spec.channels[channel], most,
            spec.place(entry)));
    return outside;
}

std::size_t columns_of(const TableSpec& spec) {
    return spec.axes[0].size;
}

void write_exr_table(const Table& table, const std::string& path) {
    const TableSpec& spec = table.spec;
    Image image;
    image.width = columns_of(spec);
    image.height = spec.entries() / image.width;
    image.channels = spec.channels;
    for (const std::vector<double>& values : table.values) {
        std::vector<float> plane;
        for (const double value : values)
            plane.push_back(static_cast<float>(encoded(spec, value)));
        image.planes.push_back(std::move(plane));
    }
    for (const auto& [name, text] : provenance(table))
        image.metadata[name] = text;
    std::string channels;
    for (std::size_t c = 0; c < spec.channels.size(); ++c)
        channels += (c == 0 ? "" : ", ") + spec.channels[c] + " = " +
                    (c < spec.values() ? fmt::format("value {}", c + 1) : "0");
    image.metadata["channels_hold"] = channels;
    image.metadata["layout"] =
        "x: the first axis, y: the second from the top; slices of further axes "
        "below each other";
    write_exr(image, path, spec.encoding == Encoding::Half ? ExrPixel::Half : ExrPixel::Float);
}

std::string comment(const Table& table) {
    std::string text;
    for (const auto& [name, line] : provenance(table))
        text += fmt::format("// {}: {}\n", name, line);
    return text;
}

/// Filament's text: halves in hexadecimal, rows bottom up, four pixels a line; .inc leaves out the
/// declaration.
std::string cmgen_source(const Table& table, bool include) {
    const TableSpec& spec = table.spec;
    const std::size_t width = columns_of(spec), height = spec.entries() / width;
    std::string text =
        comment(table) +
        "// stored as an RG16F texture, in GL order: rows from the last to the first\n";
    if (!include)
        text += fmt::format("const uint16_t {}[] = {{", spec.name);
    for (std::size_t y = 0; y < height; ++y)
        for (std::size_t x = 0; x < width; ++x) {
            const std::size_t entry = (height - 1 - y) * width + x;
            text += x % 4 == 0 ? "\n    " : "";
            for (std::size_t v = 0; v < spec.values(); ++v)
                text += fmt::format("0x{:04x}, ", half_bits(table.values[v][entry]));
        }
    return text + (include ? "\n\n" : "\n};\n\n");
}

std::string source(const Table& table, bool include) {
    const TableSpec& spec = table.spec;
    if (spec.style == SourceStyle::Cmgen && spec.encoding == Encoding::Half)
        return cmgen_source(table, include);
    const bool fragment = include || spec.style == SourceStyle::Fragment;
    const std::size_t width = columns_of(spec), entries = spec.entries();
    std::string text = comment(table);
    if (spec.values() > 1)
        text += "// the values of an entry follow each other\n";
    if (!fragment)
        text += fmt::format("{}static const {} {}[{}] = {{\n",
                            spec.encoding == Encoding::Float ? "" : "#include <stdint.h>\n\n",
                            spec.encoding == Encoding::Float ? "float" : "uint16_t", spec.name,
                            entries * spec.values());
    for (std::size_t e = 0; e < entries; ++e) {
        if (e % width == 0) {
            if (e != 0 && spec.axes.size() > 2 && e % (width * spec.axes[1].size) == 0)
                text += '\n';
            text += "  ";
        }
        for (std::size_t v = 0; v < spec.values(); ++v) {
            const double value = table.values[v][e];
            text += spec.encoding == Encoding::Float  ? fmt::format("{:.6f}f", value)
                    : spec.encoding == Encoding::Half ? fmt::format("0x{:04x}", half_bits(value))
                                                      : fmt::format("{}", unorm16(value));
            const bool last = e + 1 == entries && v + 1 == spec.values();
            text += last && !fragment ? "" : ",";
            text += v + 1 < spec.values() || (e + 1) % width != 0 ? " " : "";
        }
        if ((e + 1) % width == 0)
            text += '\n';
    }
    return text + (fragment ? "" : "};\n");
}

/// Axes from the slowest to the fastest, then the values.
std::vector<std::size_t> shape_of(const TableSpec& spec) {
    std::vector<std::size_t> shape;
    for (auto axis = spec.axes.rbegin(); axis != spec.axes.rend(); ++axis)
        shape.push_back(axis->size);
    if (spec.values() > 1)
        shape.push_back(spec.values());
    return shape;
}

std::string npy_bytes(const Table& table) {
    const TableSpec& spec = table.spec;
    const char* const type = spec.encoding == Encoding::Float  ? "<f4"
                             : spec.encoding == Encoding::Half ? "<f2"
                                                               : "<u2";
    std::string bytes = npy::header(shape_of(spec), type);
    for (std::size_t e = 0; e < spec.entries(); ++e)
        for (std::size_t v = 0; v < spec.values(); ++v) {
            const double value = table.values[v][e];
            if (spec.encoding == Encoding::Float) {
                const auto number = static_cast<float>(value);
                bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
            } else {
                const std::uint16_t number =
                    spec.encoding == Encoding::Half ? half_bits(value) : unorm16(value);
                bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
            }
        }
    return bytes;
}

std::string provenance_json(const Table& table) {
    nlohmann::ordered_json json;
    for (const auto& [name, line] : provenance(table))
        json[name] = line;
    json["shape"] = shape_of(table.spec);
    return json.dump(2) + "\n";
}

std::string csv(const Table& table) {
    const TableSpec& spec = table.spec;
    std::string text;
    for (const auto& [name, line] : provenance(table))
        text += fmt::format("# {}: {}\n", name, line);
    for (const Axis& axis : spec.axes)
        text += axis.name() + ",";
    for (std::size_t v = 0; v < spec.values(); ++v)
        text += spec.channels[v] + (v + 1 < spec.values() ? "," : "\n");
    for (std::size_t e = 0; e < spec.entries(); ++e) {
        std::size_t rest = e;
        for (const Axis& axis : spec.axes) {
            text += fmt::format("{},", static_cast<float>(axis.value(rest % axis.size)));
            rest /= axis.size;
        }
        for (std::size_t v = 0; v < spec.values(); ++v)
            text += fmt::format("{}{}", static_cast<float>(encoded(spec, table.values[v][e])),
                                v + 1 < spec.values() ? ',' : '\n');
    }
    return text;
}

void write_text(const std::string& path, const std::string& text) {
    OutputFile file(path);
    file.write(text);
    file.commit();
}

} // namespace

std::string write_table_preview(const Table& table, const std::string& path) {
    std::vector<PreviewPanel> panels;
    for (std::size_t v = 0; v < table.spec.values(); ++v) {
        const std::vector<double>& values = table.values[v];
        const std::size_t width = columns_of(table.spec);
        panels.push_back({table.spec.channels[v],
                          width,
                          table.spec.entries() / width,
                          {values.begin(), values.end()}});
    }
    return write_preview(panels, path);
}

void require_table_ending(const std::string& path) {
    ending_of(path);
}

std::size_t write_table(const Table& table, const std::string& path, bool clamp) {
    const Ending ending = ending_of(path);
    const std::size_t clamped = check_values(table, path, clamp);
    switch (ending) {
    case Ending::Exr:
        write_exr_table(table, path);
        break;
    case Ending::Source:
        write_text(path, source(table, std::filesystem::path(path).extension().string() == ".inc"));
        break;
    case Ending::Npy: {
        OutputFile data(path), about(path + ".json");
        data.write(npy_bytes(table));
        about.write(provenance_json(table));
        data.commit();
        about.commit();
        break;
    }
    case Ending::Csv:
        write_text(path, csv(table));
        break;
    }
    return clamped;
}

} // namespace brdfit
