#pragma once

#include "host/device/device.hpp"
#include "host/model/catalogue.hpp"
#include "host/progress.hpp"

#include <map>
#include <string>
#include <utility>
#include <vector>

namespace brdfit {

/// What an axis of a table counts.
enum class AxisKind {
    CosTheta,  ///< cosine of the viewer with the normal
    Roughness, ///< the model's (m, or a: GGX's alpha), or n = 2 / roughness^2 - 2 where it has an
               ///< exponent; renderers' roughness is often the root of it
    F0,        ///< of Schlick's Fresnel term
    Ior,       ///< of a dielectric's Fresnel term, exact
    Parameter  ///< another of the model's, see Axis::parameter
};

/// Where the nodes x of an axis of N lie in [0, 1]. Node i:
enum class Nodes {
    Corners,   ///< i / (N - 1)
    Centres,   ///< (i + 0.5) / N
    Descending ///< min(1, (N - i + 0.5) / N), Filament's
};

/// An axis of a table: value = lower + (upper - lower) x^power, x at least `least`.
struct Axis {
    AxisKind kind = AxisKind::CosTheta;
    std::size_t size = 0;
    Nodes nodes = Nodes::Corners;
    double power = 1, lower = 0, upper = 1, least = 0;
    /// OpenPBR's axis of refraction: 1/ior - 1 falls to 0 over the first half, ior - 1 grows from 0
    /// over the second, up to 1.5 at either end. Power and range do not count then.
    bool reciprocal = false;
    std::string parameter; ///< of AxisKind::Parameter: its name in the catalogue

    double value(std::size_t i) const;
    std::string name() const;    ///< cos_theta, roughness, f0, ior or parameter:NAME
    std::string mapping() const; ///< for people: how value comes from i
};

/// What the table holds, from E(f0) = f0 (E_all - E_p5) + E_p5, E_all the albedo at f0 = 1 and E_p5
/// that weighted by (1 - c)^5.
enum class Quantity {
    Albedo,            ///< E, at the f0 or ior of an axis, otherwise at the table's f0
    Complement,        ///< 1 - E
    ScaleBias,         ///< E_all - E_p5, E_p5: E = F0 scale + F90 bias
    MultipleScattering ///< E_p5, E_all: E = mix(first, second, f0)
};

enum class Encoding { Float, Half, Unorm16 };

/// How a table is written as C source.
enum class SourceStyle {
    Array,    ///< an array of a declared size
    Fragment, ///< values alone, to include between braces
    Cmgen     ///< as Filament's cmgen: halves in hexadecimal, rows bottom up
};

/// A table to compute. Axes are listed fastest first; without cos_theta it holds the average over
/// the hemisphere, 2 integral of E mu dmu.
struct TableSpec {
    std::string name;        ///< of the array in C source
    std::string description; ///< for people
    const Model* model = nullptr;
    std::map<std::string, double> parameters; ///< of the model, but for roughness and f0
    double f0 = 1;
    Quantity quantity = Quantity::Albedo;
    std::vector<Axis> axes;
    double tolerance = 1e-4;
    Encoding encoding = Encoding::Float;
    SourceStyle style = SourceStyle::Array;
    std::vector<std::string> channels; ///< names in EXR and CSV, one a value of the quantity
    bool third_channel = false;        ///< another channel of zeros, for RGB readers

    std::size_t values() const; ///< 1 or 2, of the quantity
    std::size_t entries() const;
    /// The axes' values of an entry, for people.
    std::string place(std::size_t entry) const;
};

/// Albedos of a table that are above 1 by more than their error.
struct AboveOne {
    std::size_t count = 0; ///< of entries; where they hold both terms of F, of f0 = 1
    double largest = 0;
    std::size_t entry = 0; ///< of the largest
};

/// A computed table, [channel][entry], entries in the order of the axes.
struct Table {
    TableSpec spec;
    std::vector<std::vector<double>> values;
    double error = 0; ///< the largest estimated
    AboveOne above_one;
};

/// A table that a renderer reads.
struct Preset {
    std::string name, renderer;
    TableSpec spec;
};
const std::vector<Preset>& presets();

/// The preset's table, or nullptr.
const TableSpec* find_preset(const std::string& name);

/// Parses a table's specification, JSON as README.md describes it. `source` names it in messages.
/// Throws InputError naming source, key and expectation for anything else.
TableSpec parse_table_spec(const std::string& text, const std::string& source);
TableSpec read_table_spec(const std::string& path);

/// Puts another model in the table's place of GGX. Throws UsageError where it has no lobe, or not
/// the parameter of an axis.
void set_model(TableSpec& spec, const Model& model);
/// Sets a parameter that no axis sets. Throws UsageError where the model has none of that name, or
/// the value is out of its range.
void set_parameter(TableSpec& spec, const std::string& name, double value);
/// Sets both axes of a table of cos_theta and roughness, or the axis of an average. Throws
/// UsageError for fewer than 2 or more than largest_size, and where that makes more than
/// most_entries.
void set_size(TableSpec& spec, std::size_t size);

/// The model's parameters that no other kind of axis and no Fresnel term sets.
std::vector<const Parameter*> own_parameters(const Model& model);

/// Nodes of an axis and entries of a table at most.
inline constexpr std::size_t largest_size = 4096, most_entries = std::size_t{1} << 22;
/// Axes of a table at most.
inline constexpr std::size_t most_axes = 4;

/// Computes a table. Throws UsageError for a tolerance out of reach, InputError where an entry is
/// infinite or does not reach the tolerance, naming it.
Table compute_table(const Device& device, const TableSpec& spec,
                    const ProgressFunction& progress = {});

/// What the table is, as names and texts: quantity, axes with mapping and nodes, order, encoding,
/// model, tolerance, error, software.
std::vector<std::pair<std::string, std::string>> provenance(const Table& table);

/// Writes `.exr` (half or float, slices below each other), `.h`, `.hpp` or `.inc` (C source),
/// `.npy` (with its provenance in a `.npy.json` beside it) or `.csv` (a row an entry). Throws
/// UsageError for another ending, and InputError where a value is not finite in the encoding, or
/// where unorm16 does not hold one by more than its error and `clamp` is false. Returns how many
/// such values it clamped.
std::size_t write_table(const Table& table, const std::string& path, bool clamp = false);
/// Writes a picture of the values, laid out as in .exr (see write_preview). Returns what is seen.
std::string write_table_preview(const Table& table, const std::string& path);
/// Throws UsageError unless the ending is one of these.
void require_table_ending(const std::string& path);

} // namespace brdfit
