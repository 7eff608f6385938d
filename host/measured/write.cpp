#include "host/measured/write.hpp"

#include "host/error.hpp"
#include "host/files/columns.hpp"
#include "host/files/npy.hpp"
#include "host/files/zip.hpp"
#include "host/measured/merl.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

namespace brdfit {

namespace {

enum class Ending { Merl, Csv, Astm, Npy, Npz };

Ending ending_of(const std::string& path) {
    const std::string ending = std::filesystem::path(path).extension().string();
    if (ending == ".csv")
        return Ending::Csv;
    if (ending == ".astm")
        return Ending::Astm;
    if (ending == ".npy")
        return Ending::Npy;
    if (ending == ".npz")
        return Ending::Npz;
    if (ending == ".binary")
        return Ending::Merl;
    throw UsageError(
        fmt::format("{}: unknown ending; expected .binary, .csv, .astm, .npy or .npz", path));
}

/// An angle without the digits that float32 directions do not have.
double rounded(double angle) {
    return std::round(angle * 1e9) / 1e9 + 0.0;
}

double polar(const Vector& v) {
    return std::atan2(std::hypot(v[0], v[1]), v[2]);
}
double azimuth(const Vector& v) {
    return std::atan2(v[1], v[0]);
}

void require_valid_samples(const Samples& samples, const std::string& path) {
    if (samples.valid_count() == 0)
        throw InputError(fmt::format("{}: nothing to write: {} has no valid samples", path,
                                     samples.source.empty() ? "the data" : samples.source));
}

/// Whether a column of weights says anything.
bool weighted(const Samples& samples) {
    for (std::size_t k = 0; k < samples.weights.size(); ++k)
        if (samples.valid[k] && samples.weights[k] != 1)
            return true;
    return false;
}

/// Writes the rows of a text, the angles, values and weights of which `weights` says whether there
/// are some.
void write_rows(const Samples& samples, bool weights, RowWriter& writer,
                const ProgressFunction& progress) {
    const std::size_t channels = samples.channels.size();
    for (std::size_t k = 0; k < samples.count(); ++k) {
        if (k % 65536 == 0)
            tell(progress, static_cast<double>(k) / static_cast<double>(samples.count()));
        if (!samples.valid[k])
            continue;
        const auto [wi, wo] = samples.directions->pair(k);
        // Isotropic data is turned so that phi_i = 0 everywhere, which tells a reader what it is.
        const double phi_i = samples.isotropic ? 0 : azimuth(wi);
        const double phi_o = samples.isotropic ? std::atan2(wi[0] * wo[1] - wi[1] * wo[0],
                                                            wi[0] * wo[0] + wi[1] * wo[1])
                                               : azimuth(wo);
        writer.text(rounded(polar(wi)), ',');
        writer.text(rounded(phi_i), ',');
        writer.text(rounded(polar(wo)), ',');
        writer.text(rounded(phi_o), ',');
        for (std::size_t c = 0; c < channels; ++c)
            writer.text(samples.channel(c)[k], c + 1 < channels || weights ? ',' : '\n');
        if (weights)
            writer.text(samples.weights[k], '\n');
        writer.end_row();
    }
}

/// The columns of a text: the angles, named so, and the channels.
std::vector<std::string> text_columns(const Samples& samples, const std::string& path,
                                      std::vector<std::string> names, bool weights) {
    names.insert(names.end(), samples.channels.begin(), samples.channels.end());
    names.push_back("weight"); // reserved even where it is not written
    require_csv_names(path, names);
    if (!weights)
        names.pop_back();
    return names;
}

void write_csv(const Samples& samples, const std::string& path,
               const std::vector<std::string>& provenance, const ProgressFunction& progress) {
    const bool weights = weighted(samples);
    const std::vector<std::string> names =
        text_columns(samples, path, {"theta_i", "phi_i", "theta_o", "phi_o"}, weights);
    RowWriter writer(path);
    writer.bytes(csv_head(names, provenance));
    write_rows(samples, weights, writer, progress);
    writer.commit();
}

void write_astm(const Samples& samples, const std::string& path,
                const std::vector<std::string>& provenance, const ProgressFunction& progress) {
    const bool weights = weighted(samples);
    const std::vector<std::string> names =
        text_columns(samples, path, {"theta_i", "phi_i", "theta_s", "phi_s"}, weights);
    RowWriter writer(path);
    for (const std::string& line : provenance)
        writer.bytes("LAB_COMMENTS " + line + "\n");
    writer.bytes(fmt::format("MEAS_NAME BRDF\nNUM_POINTS {}\nVARS {}\n\n", samples.valid_count(),
                             fmt::join(names, ",")));
    write_rows(samples, weights, writer, progress);
    writer.commit();
}

/// A pair of directions, of isotropic data turned so that wi has azimuth 0, which tells a reader
/// what the data is.
std::pair<Vector, Vector> written_pair(const Samples& samples, std::size_t k) {
    const auto [wi, wo] = samples.directions->pair(k);
    if (!samples.isotropic)
        return {wi, wo};
    const double phi_o = std::atan2(wi[0] * wo[1] - wi[1] * wo[0], wi[0] * wo[0] + wi[1] * wo[1]);
    const double sin_o = std::hypot(wo[0], wo[1]);
    return {{std::hypot(wi[0], wi[1]), 0, wi[2]},
            {sin_o * std::cos(phi_o), sin_o * std::sin(phi_o), wo[2]}};
}

void write_npy(const Samples& samples, const std::string& path, const ProgressFunction& progress) {
    const std::size_t channels = samples.channels.size();
    RowWriter writer(path);
    writer.bytes(npy::header(samples.valid_count(), 6 + channels + 1));
    for (std::size_t k = 0; k < samples.count(); ++k) {
        if (k % 65536 == 0)
            tell(progress, static_cast<double>(k) / static_cast<double>(samples.count()));
        if (!samples.valid[k])
            continue;
        const auto [wi, wo] = written_pair(samples, k);
        for (const Vector& v : {wi, wo})
            for (const double x : v)
                writer.raw(static_cast<float>(x));
        for (std::size_t c = 0; c < channels; ++c)
            writer.raw(samples.channel(c)[k]);
        writer.raw(samples.weights.empty() ? 1 : samples.weights[k]);
        writer.end_row();
    }
    writer.commit();
}

void write_npz(const Samples& samples, const std::string& path, const ProgressFunction& progress) {
    const std::size_t count = samples.valid_count(), channels = samples.channels.size();
    zip::Writer writer(path);
    // An array of `columns` values for each valid sample, which row(k, add) adds.
    const auto array = [&](const char* name, std::size_t columns, auto row) {
        std::vector<float> values;
        values.reserve(count * columns);
        for (std::size_t k = 0; k < samples.count(); ++k)
            if (samples.valid[k])
                row(k, [&](double x) { values.push_back(static_cast<float>(x)); });
        writer.add(name, npy::header(count, columns),
                   {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float)});
    };
    const auto vector = [&](const char* name, bool of_wo) {
        array(name, 3, [&](std::size_t k, auto add) {
            const auto [wi, wo] = written_pair(samples, k);
            for (const double x : of_wo ? wo : wi)
                add(x);
        });
    };
    vector("wi.npy", false);
    tell(progress, 0.3);
    vector("wo.npy", true);
    tell(progress, 0.6);
    array("values.npy", channels, [&](std::size_t k, auto add) {
        for (std::size_t c = 0; c < channels; ++c)
            add(samples.channel(c)[k]);
    });
    if (!samples.weights.empty())
        array("weights.npy", 1, [&](std::size_t k, auto add) { add(samples.weights[k]); });
    writer.add("channels.npy", npy::texts(samples.channels), {});
    writer.commit();
}

/// Weighted averages of scattered samples in the bins of the MERL grid; empty bins are invalid.
Samples average_in_bins(const Samples& samples) {
    Samples grid;
    grid.channels = samples.channels;
    grid.directions = merl::bin_directions();
    grid.values.resize(samples.channels.size() * merl::bins);
    std::vector<std::size_t> bin(samples.count());
    std::vector<double> weight(merl::bins), sum(merl::bins);
    for (std::size_t k = 0; k < samples.count(); ++k) {
        const auto [wi, wo] = samples.directions->pair(k);
        bin[k] = merl::bin_of(wi, wo);
        if (samples.valid[k])
            weight[bin[k]] += samples.weights.empty() ? 1 : samples.weights[k];
    }
    for (std::size_t c = 0; c < samples.channels.size(); ++c) {
        std::fill(sum.begin(), sum.end(), 0);
        for (std::size_t k = 0; k < samples.count(); ++k)
            if (samples.valid[k])
                sum[bin[k]] +=
                    (samples.weights.empty() ? 1.0 : samples.weights[k]) * samples.channel(c)[k];
        for (std::size_t b = 0; b < merl::bins; ++b)
            grid.channel(c)[b] = static_cast<float>(weight[b] > 0 ? sum[b] / weight[b] : 0);
    }
    grid.valid.resize(merl::bins);
    for (std::size_t b = 0; b < merl::bins; ++b)
        grid.valid[b] = weight[b] > 0;
    return grid;
}

void write_merl(const Samples& samples, const std::string& path) {
    require_merl(samples, path);
    if (samples.directions == merl::bin_directions())
        return merl::write(samples, path);
    const Samples grid = average_in_bins(samples);
    merl::write(grid, path);
    spdlog::info("{}: {} of {} bins hold samples", path, grid.valid_count(), merl::bins);
}

} // namespace

void require_samples_ending(const std::string& path) {
    ending_of(path);
}

void require_merl(const Samples& samples, const std::string& path) {
    if (!samples.isotropic)
        throw InputError(
            fmt::format("{}: the data is anisotropic; a MERL file holds isotropic data", path));
    if (samples.channels.size() != 3)
        throw InputError(fmt::format("{}: the data has {} channels; a MERL file holds 3", path,
                                     samples.channels.size()));
}

void write_samples(const Samples& samples, const std::string& path,
                   const std::vector<std::string>& provenance, const ProgressFunction& progress) {
    switch (ending_of(path)) {
    case Ending::Merl:
        return write_merl(samples, path);
    case Ending::Csv:
        require_valid_samples(samples, path);
        return write_csv(samples, path, provenance, progress);
    case Ending::Astm:
        require_valid_samples(samples, path);
        return write_astm(samples, path, provenance, progress);
    case Ending::Npy:
        require_valid_samples(samples, path);
        return write_npy(samples, path, progress);
    case Ending::Npz:
        require_valid_samples(samples, path);
        return write_npz(samples, path, progress);
    }
}

} // namespace brdfit
