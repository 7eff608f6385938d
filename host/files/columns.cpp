#include "host/files/columns.hpp"

#include "host/error.hpp"
#include "host/files/channels.hpp"
#include "host/files/npy.hpp"

#include <algorithm>
#include <filesystem>
#include <unordered_set>

namespace brdfit {

std::string csv_head(const std::vector<std::string>& names,
                     const std::vector<std::string>& provenance) {
    std::string head;
    for (std::string line : provenance) {
        std::replace_if(
            line.begin(), line.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
        head += "# " + line + '\n';
    }
    return head + fmt::format("{}\n", fmt::join(names, ","));
}

void require_csv_names(const std::string& path, const std::vector<std::string>& names) {
    std::unordered_set<std::string> seen;
    for (const std::string& name : names) {
        if (!is_channel_name(name))
            throw InputError(fmt::format("{}: the channel name '{}' cannot head a column of a .csv",
                                         path, name));
        if (!seen.insert(name).second)
            throw InputError(fmt::format("{}: two columns would have the name '{}'", path, name));
    }
}

void require_columns_ending(const std::string& path) {
    const std::string ending = std::filesystem::path(path).extension().string();
    if (ending != ".csv" && ending != ".npy")
        throw UsageError(fmt::format("{}: unknown ending; expected .csv or .npy", path));
}

namespace {

// The path, once it and the names are known to do.
const std::string& checked(const std::string& path, const std::vector<std::string>& names) {
    require_columns_ending(path);
    if (std::filesystem::path(path).extension() == ".csv")
        require_csv_names(path, names);
    return path;
}

} // namespace

ColumnWriter::ColumnWriter(const std::string& path, const std::vector<std::string>& names,
                           std::size_t rows, const std::vector<std::string>& provenance)
    : csv_(std::filesystem::path(path).extension() == ".csv"), columns_(names.size()),
      writer_(checked(path, names)) {
    writer_.bytes(csv_ ? csv_head(names, provenance) : npy::header(rows, columns_));
}

void write_columns(const std::string& path, const std::vector<std::string>& names,
                   const std::vector<std::vector<float>>& columns,
                   const std::vector<std::string>& provenance, const ProgressFunction& progress) {
    const std::size_t rows = columns.empty() ? 0 : columns[0].size();
    ColumnWriter writer(path, names, rows, provenance);
    for (std::size_t row = 0; row < rows; ++row) {
        for (const std::vector<float>& column : columns)
            writer.value(column[row]);
        if (row % 65536 == 0)
            tell(progress, static_cast<double>(row) / static_cast<double>(rows));
    }
    writer.commit();
}

} // namespace brdfit
