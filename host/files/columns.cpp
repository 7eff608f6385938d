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

void write_columns(const std::string& path, const std::vector<std::string>& names,
                   const std::vector<std::vector<float>>& columns,
                   const std::vector<std::string>& provenance) {
    const std::string ending = std::filesystem::path(path).extension().string();
    const bool csv = ending == ".csv";
    if (!csv && ending != ".npy")
        throw UsageError(fmt::format("{}: unknown ending; expected .csv or .npy", path));
    const std::size_t rows = columns.empty() ? 0 : columns[0].size();
    if (csv)
        require_csv_names(path, names);
    RowWriter writer(path);
    writer.bytes(csv ? csv_head(names, provenance) : npy::header(rows, columns.size()));
    for (std::size_t row = 0; row < rows; ++row) {
        for (std::size_t i = 0; i < columns.size(); ++i) {
            if (csv)
                writer.text(columns[i][row], i + 1 < columns.size() ? ',' : '\n');
            else
                writer.raw(columns[i][row]);
        }
        writer.end_row();
    }
    writer.commit();
}

} // namespace brdfit
