#include "fit/runs/log.hpp"

#include "host/error.hpp"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <filesystem>
#include <fmt/format.h>
#include <memory>
#include <zlib.h>

namespace brdfit {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view crc_key = R"(,"crc32":")";
constexpr std::size_t crc_digits = 8;
constexpr std::string_view line_end = "\"}";
constexpr std::size_t id_digits = 64;
constexpr std::size_t longest_line = std::size_t{1} << 24; // longer ones are none of ours

std::string crc_of(std::string_view text) {
    const uLong crc =
        crc32_z(crc32_z(0, nullptr, 0), reinterpret_cast<const Bytef*>(text.data()), text.size());
    return fmt::format("{:08x}", crc);
}

// Removes `begin` from the front of a text; returns whether it stood there.
bool take(std::string_view& text, std::string_view begin) {
    if (text.substr(0, begin.size()) != begin)
        return false;
    text.remove_prefix(begin.size());
    return true;
}

// The shard that a log is of, by its name; none where it has another.
std::optional<Shard> shard_of(const fs::path& path) {
    if (path.extension() != ".jsonl")
        return std::nullopt;
    const std::string stem = path.stem().string();
    Shard shard;
    const char* const end = stem.data() + stem.size();
    const auto number = std::from_chars(stem.data(), end, shard.number);
    std::string_view rest(number.ptr, static_cast<std::size_t>(end - number.ptr));
    if (number.ec != std::errc{} || !take(rest, "-of-") ||
        std::from_chars(rest.data(), end, shard.count).ec != std::errc{} || shard.name() != stem)
        return std::nullopt;
    return shard;
}

struct CloseFile {
    void operator()(std::FILE* file) const { std::fclose(file); }
};
using FileHandle = std::unique_ptr<std::FILE, CloseFile>;

FileHandle open_log(const std::string& path) {
    FileHandle file(std::fopen(path.c_str(), "rbe"));
    if (!file)
        throw InputError(fmt::format("{}: cannot open: {}", path, std::strerror(errno)));
    return file;
}

// Takes a log's bytes piece by piece: another process may be writing to it or cutting it.
class LogReader {
  public:
    explicit LogReader(ShardLog& log) : log_(log) {}

    void take(std::string_view piece) {
        while (!piece.empty()) {
            const std::size_t end = piece.find('\n');
            const std::string_view part = piece.substr(0, end);
            bytes_ += part.size();
            if (bytes_ <= longest_line)
                text_.append(part);
            if (end == std::string_view::npos)
                return;
            end_line();
            piece.remove_prefix(end + 1);
        }
    }
    void end() { log_.torn = bytes_ > 0; }

  private:
    void end_line() {
        ++line_;
        std::optional<LoggedRow> row;
        if (bytes_ <= longest_line)
            row = parse_logged(text_);
        if (row) {
            row->line = line_;
            row->offset = log_.whole_bytes;
            log_.rows.push_back(std::move(*row));
        } else {
            log_.broken.push_back({log_.path, line_});
        }
        log_.whole_bytes += bytes_ + 1;
        bytes_ = 0;
        text_.clear();
    }

    ShardLog& log_;
    std::string text_;
    std::uint64_t bytes_ = 0; // of the line so far
    std::size_t line_ = 0;
};

} // namespace

std::string sealed(const Json& row) {
    std::string text = dumped(row);
    text.pop_back(); // the brace, which comes after the checksum
    return fmt::format("{}{}{}{}\n", text, crc_key, crc_of(text), line_end);
}

std::optional<LoggedRow> parse_logged(std::string_view line) {
    constexpr std::size_t tail = crc_key.size() + crc_digits + line_end.size();
    if (line.size() < tail || line.substr(line.size() - line_end.size()) != line_end)
        return std::nullopt;
    const std::string_view content = line.substr(0, line.size() - tail);
    std::string_view end = line.substr(content.size());
    if (!take(end, crc_key) || end.substr(0, crc_digits) != crc_of(content))
        return std::nullopt;
    LoggedRow row{};
    std::string_view rest = content;
    if (!take(rest, R"({"id":")") || rest.size() < id_digits)
        return std::nullopt;
    row.id = rest.substr(0, id_digits);
    rest.remove_prefix(id_digits);
    if (take(rest, R"(","state":"done","finished":)"))
        row.state = RowState::Done;
    else if (take(rest, R"(","state":"failed","finished":)"))
        row.state = RowState::Failed;
    else
        return std::nullopt;
    if (std::from_chars(rest.data(), rest.data() + rest.size(), row.finished).ec != std::errc{})
        return std::nullopt;
    row.bytes = line.size();
    return row;
}

Json ShardLog::read(const LoggedRow& row) const {
    const FileHandle file = open_log(path);
    std::string text(row.bytes, '\0');
    if (fseeko(file.get(), static_cast<off_t>(row.offset), SEEK_SET) != 0 ||
        std::fread(text.data(), 1, text.size(), file.get()) != text.size() || !parse_logged(text))
        throw InputError(fmt::format("{}: has changed while it was read", place(row)));
    Json json = parse_json(text, place(row), "a row of a run");
    json.erase("crc32");
    return json;
}

std::string ShardLog::place(const LoggedRow& row) const {
    return fmt::format("{}:{}", path, row.line);
}

std::string log_path(const std::string& folder, const Shard& shard) {
    return (fs::path(folder) / "shards" / (shard.name() + ".jsonl")).string();
}

std::string done_path(const std::string& folder, const Shard& shard) {
    return (fs::path(folder) / "shards" / (shard.name() + ".done")).string();
}

ShardLog read_log(const std::string& folder, const Shard& shard) {
    ShardLog log;
    log.path = log_path(folder, shard);
    log.shard = shard;
    std::error_code unknown;
    if (!fs::exists(log.path, unknown))
        return log;
    const FileHandle file = open_log(log.path);
    LogReader reader(log);
    std::string piece(std::size_t{1} << 16, '\0');
    while (const std::size_t read = std::fread(piece.data(), 1, piece.size(), file.get()))
        reader.take(std::string_view(piece).substr(0, read));
    if (std::ferror(file.get()) != 0)
        throw InputError(fmt::format("{}: cannot read: {}", log.path, std::strerror(errno)));
    reader.end();
    return log;
}

bool RunLogs::done(const std::string& id) const {
    const auto found = tasks.find(id);
    return found != tasks.end() && !found->second.done.empty();
}

bool RunLogs::failed(const std::string& id) const {
    const auto found = tasks.find(id);
    return found != tasks.end() && found->second.done.empty();
}

std::vector<BrokenLine> RunLogs::broken() const {
    std::vector<BrokenLine> all;
    for (const ShardLog& log : logs)
        all.insert(all.end(), log.broken.begin(), log.broken.end());
    return all;
}

RunLogs read_logs(const std::string& folder) {
    std::vector<Shard> shards;
    std::error_code error;
    const fs::path below = fs::path(folder) / "shards";
    for (fs::directory_iterator entry(below, error), end; !error && entry != end;
         entry.increment(error))
        if (const std::optional<Shard> shard = shard_of(entry->path()))
            shards.push_back(*shard);
    if (error && error != std::errc::no_such_file_or_directory)
        throw InputError(
            fmt::format("{}: cannot read the folder: {}", below.string(), error.message()));
    std::sort(shards.begin(), shards.end(), [](const Shard& a, const Shard& b) {
        return std::pair(a.count, a.number) < std::pair(b.count, b.number);
    });
    RunLogs run;
    for (const Shard& shard : shards) {
        run.logs.push_back(read_log(folder, shard));
        const std::vector<LoggedRow>& rows = run.logs.back().rows;
        for (std::size_t r = 0; r < rows.size(); ++r) {
            const RowPlace place{run.logs.size() - 1, r};
            Finished& task = run.tasks[rows[r].id];
            if (rows[r].state == RowState::Done)
                task.done.push_back(place);
            else if (!task.failed || run.at(*task.failed).finished <= rows[r].finished)
                task.failed = place;
        }
    }
    return run;
}

} // namespace brdfit
