#include "fit/runs/log.hpp"
#include "host/files/json.hpp"
#include "tests/fuzz/fuzz.hpp"

#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <zlib.h>

using namespace brdfit;

namespace {

// A log with a checksum at each line that has none.
std::string summed(const std::string& text) {
    std::string log;
    for (std::size_t begin = 0; begin < text.size();) {
        const std::size_t end = std::min(text.find('\n', begin), text.size());
        std::string line = text.substr(begin, end - begin);
        if (line.find("crc32") == std::string::npos)
            line +=
                fmt::format(R"(,"crc32":"{:08x}"}})",
                            crc32_z(0, reinterpret_cast<const Bytef*>(line.data()), line.size()));
        log += line + (end < text.size() ? "\n" : "");
        begin = end + 1;
    }
    return log;
}

} // namespace

// What shards of a run write: broken and torn lines are told, whole ones read.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const std::string path = [] {
        const std::string log = log_path(fuzz::folder(), {0, 2});
        std::filesystem::create_directories(std::filesystem::path(log).parent_path());
        return log;
    }();
    std::ofstream(path, std::ios::binary) << summed({reinterpret_cast<const char*>(data), size});
    const RunLogs logs = read_logs(fuzz::folder());
    fuzz::require(logs.logs.size() == 1, "a log that was not found");
    const ShardLog& log = logs.logs[0];
    fuzz::require(log.whole_bytes <= std::filesystem::file_size(path), "more lines than there are");
    for (const LoggedRow& row : log.rows)
        fuzz::reads(log.place(row),
                    [&] { fuzz::require(log.read(row).is_object(), "a row that is none"); });
    return 0;
}
