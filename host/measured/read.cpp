#include "host/measured/read.hpp"

#include "host/error.hpp"
#include "host/files/npy.hpp"
#include "host/measured/formats.hpp"
#include "host/measured/merl.hpp"
#include "host/measured/rgl.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <filesystem>
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
    const char* name;
    bool (*recognise)(std::string_view head);
    Samples (*read)(const MappedFile& file, std::optional<bool> isotropic);
};

constexpr Format formats[] = {{"scattered CSV", scattered::recognise, scattered::read},
                              {"ASTM E1392 text", astm::recognise, astm::read},
                              {"Cornell spectral text", cornell::recognise, cornell::read},
                              {"RGL tensor file", rgl::recognise, rgl::read},
                              {"NumPy array", npy_samples::recognise, npy_samples::read}};
constexpr const char* known_formats =
    "MERL .binary, RGL .bsdf, ASTM E1392 text, Cornell spectral text, "
    "CSV with the columns theta_i,phi_i,theta_o,phi_o and one for each channel, "
    ".npy that brdfit convert writes";

// What a file is that measurements are published as, or nullptr.
const char* not_yet_read(const std::string& path, std::string_view head) {
    const auto begins = [&](std::string_view with) { return head.substr(0, with.size()) == with; };
    const auto has = [&](const char* text) { return head.find(text) != std::string_view::npos; };
    if (begins("type bsdf_data"))
        return "FRED's BSDF text";
    if (begins("\x76\x2f\x31\x01"))
        return "an OpenEXR file (a table or an image)";
    if (has("#DIM ") || has("#PARAM_IN"))
        return "ALTA text";
    if (has("ScatterType") || has("SampleRotation"))
        return "Zemax BSDF text";
    if (std::filesystem::path(path).extension() == ".bin")
        return "a .bin file, as UTIA's";
    return nullptr;
}

// The format's reader. Throws InputError where none knows the file.
Samples (*reader_of(const MappedFile& file))(const MappedFile&, std::optional<bool>) {
    // Text formats show in their first lines; what follows them may be long.
    const std::string_view head = file.bytes().substr(0, 1 << 16);
    for (const Format& format : formats)
        if (format.recognise(head))
            return format.read;
    if (merl::recognise(file.bytes()))
        return read_merl;
    if (const char* const what = not_yet_read(file.path(), head))
        throw InputError(fmt::format("{}: {}; brdfit cannot read these yet", file.path(), what));
    if (text::trim(head).substr(0, 1) == "{")
        throw InputError(
            fmt::format("{}: a JSON file, such as a material or a specification; "
                        "expected a measurement (brdfit synth makes one of a material)",
                        file.path()));
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

const char* measured_format(const MappedFile& file) {
    const std::string_view head = file.bytes().substr(0, 1 << 16);
    for (const Format& format : formats)
        if (format.recognise(head))
            return format.name;
    return merl::recognise(file.bytes()) ? "MERL .binary" : not_yet_read(file.path(), head);
}

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
