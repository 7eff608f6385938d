#include "host/measured/read.hpp"

#include "host/error.hpp"
#include "host/files/npy.hpp"
#include "host/measured/formats.hpp"
#include "host/measured/merl.hpp"
#include "host/measured/rgl.hpp"

#include <algorithm>
#include <atomic>
#include <cctype>
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

// Known by their first bytes.
constexpr Format formats[] = {{"scattered CSV", scattered::recognise, scattered::read},
                              {"ASTM E1392 text", astm::recognise, astm::read},
                              {"Cornell spectral text", cornell::recognise, cornell::read},
                              {"RGL tensor file", rgl::recognise, rgl::read},
                              {"ALTA text", alta::recognise, alta::read},
                              {"Zemax BSDF text", zemax::recognise, zemax::read},
                              {"FRED BSDF text", fred::recognise, fred::read},
                              {"NumPy array", npy_samples::recognise, npy_samples::read},
                              {"NumPy archive", npz_samples::recognise, npz_samples::read}};
// By their size too.
constexpr Format sized_formats[] = {{"MERL .binary", merl::recognise, read_merl},
                                    {"UTIA .bin", utia::recognise, utia::read}};
constexpr const char* known_formats =
    "MERL .binary, RGL .bsdf, UTIA .bin, ASTM E1392 text, Cornell spectral text, ALTA text, Zemax "
    "BSDF text, FRED BSDF text, CSV with the columns theta_i,phi_i,theta_o,phi_o and one for each "
    "channel, .npy and .npz that brdfit convert writes";

// The format of a file, or nullptr.
const Format* format_of(const MappedFile& file) {
    // Text formats show in their first lines; what follows them may be long.
    const std::string_view head = file.bytes().substr(0, 1 << 16);
    for (const Format& format : formats)
        if (format.recognise(head))
            return &format;
    for (const Format& format : sized_formats)
        if (format.recognise(file.bytes()))
            return &format;
    return nullptr;
}

// What a file is in place of a measurement, or nullptr.
const char* something_else(std::string_view bytes) {
    const auto begins = [&](std::string_view with) { return bytes.substr(0, with.size()) == with; };
    if (begins("\x76\x2f\x31\x01"))
        return "an OpenEXR file (a table or an image)";
    if (begins("\x1f\x8b"))
        return "compressed by gzip; expected it unpacked";
    text::Lines lines(bytes.substr(0, 4096));
    if (!lines.next())
        return nullptr;
    if (lines.line()[0] == '{')
        return "a JSON file, such as a material or a specification; expected a measurement (brdfit "
               "synth makes one of a material)";
    std::string start(lines.line().substr(0, 9));
    std::transform(start.begin(), start.end(), start.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (start == "<!doctype" || start.substr(0, 5) == "<html")
        return "a page of the web (HTML); expected the file that it links to";
    return nullptr;
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
    const Format* const format = format_of(file);
    return format == nullptr ? nullptr : format->name;
}

Samples read_samples(const std::string& path, std::optional<bool> isotropic) {
    const MappedFile file(path);
    const Format* const format = format_of(file);
    if (format == nullptr) {
        if (const char* const what = something_else(file.bytes()))
            throw InputError(fmt::format("{}: is {}", path, what));
        throw InputError(fmt::format("{}: unknown format; known: {}", path, known_formats));
    }
    Digest digest(file.bytes());
    Samples samples;
    try {
        samples = format->read(file, isotropic);
    } catch (const InputError&) {
        file.require_whole(); // the zeros at its end are not what is wrong
        throw;
    }
    samples.source = path;
    samples.sha256 = digest.get();
    file.require_whole();
    return samples;
}

} // namespace brdfit
