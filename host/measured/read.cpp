#include "host/measured/read.hpp"

#include "host/error.hpp"
#include "host/files/npy.hpp"
#include "host/measured/formats.hpp"
#include "host/measured/merl.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <fmt/format.h>
#include <future>

namespace brdfit {

namespace {

Samples read_merl(const MappedFile& file, std::optional<bool> isotropic) {
    if (isotropic == false)
        throw UsageError(
            fmt::format("{}: MERL data is isotropic; expected no --anisotropic", file.path()));
    return merl::read(file);
}

struct Format {
    bool (*recognise)(std::string_view head);
    Samples (*read)(const MappedFile& file, std::optional<bool> isotropic);
};

constexpr Format formats[] = {{scattered::recognise, scattered::read},
                              {astm::recognise, astm::read},
                              {cornell::recognise, cornell::read}};
constexpr const char* known_formats =
    "MERL .binary, ASTM E1392 text, Cornell spectral text, "
    "CSV with the columns theta_i,phi_i,theta_o,phi_o and one for each channel";

// The format's reader. Throws InputError where none knows the file.
Samples (*reader_of(const MappedFile& file))(const MappedFile&, std::optional<bool>) {
    // Text formats show in their first lines; what follows them may be long.
    const std::string_view head = file.bytes().substr(0, 1 << 16);
    for (const Format& format : formats)
        if (format.recognise(head))
            return format.read;
    if (merl::recognise(file.bytes()))
        return read_merl;
    throw InputError(fmt::format("{}: unknown format; known: {}", file.path(), known_formats));
}

// The digest of a large file takes as long as reading it: it is computed meanwhile, and given up
// where reading fails.
class Digest {
  public:
    explicit Digest(std::string_view bytes)
        : digest_(std::async(bytes.size() > 1 << 20 ? std::launch::async | std::launch::deferred
                                                    : std::launch::deferred,
                             sha256, bytes, &stop_)) {}
    ~Digest() { stop_ = true; }
    Digest(const Digest&) = delete;
    Digest& operator=(const Digest&) = delete;
    std::string get() { return digest_.get(); }

  private:
    std::atomic<bool> stop_{false};
    std::future<std::string> digest_; // the first to go: waits for its thread
};

} // namespace

Samples read_samples(const std::string& path, std::optional<bool> isotropic) {
    const MappedFile file(path);
    const auto read = reader_of(file);
    Digest digest(file.bytes());
    Samples samples = read(file, isotropic);
    samples.source = path;
    samples.sha256 = digest.get();
    return samples;
}

} // namespace brdfit
