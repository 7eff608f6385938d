#include "host/error.hpp"
#include "host/files/channels.hpp"
#include "host/measured/formats.hpp"
#include "host/measured/rows.hpp"

#include <algorithm>
#include <array>
#include <cfloat>
#include <cmath>
#include <fmt/format.h>

namespace brdfit::alta {

namespace {

struct Pair {
    Vector wi, wo; ///< unit; to the light and to the viewer
};

Vector unit(const double* x) {
    const double length = std::hypot(x[0], x[1], x[2]);
    return length > 0 ? Vector{x[0] / length, x[1] / length, x[2] / length} : Vector{0, 0, 1};
}

/// The pair whose half vector has polar angle theta_h and azimuth phi_h, and whose light lies at
/// (theta_d, phi_d) from it (Rusinkiewicz 1998).
Pair from_half(double theta_h, double phi_h, double theta_d, double phi_d) {
    const Vector d = direction(theta_d, phi_d);
    const double cosine = std::cos(theta_h), sine = std::sin(theta_h);
    const Vector turned{cosine * d[0] + sine * d[2], d[1], -sine * d[0] + cosine * d[2]};
    const double c = std::cos(phi_h), s = std::sin(phi_h);
    const Vector wi{c * turned[0] - s * turned[1], s * turned[0] + c * turned[1], turned[2]};
    const Vector h = direction(theta_h, phi_h);
    const double dot = wi[0] * h[0] + wi[1] * h[1] + wi[2] * h[2];
    return {wi, {2 * dot * h[0] - wi[0], 2 * dot * h[1] - wi[1], 2 * dot * h[2] - wi[2]}};
}

/// What the numbers ahead of the values are, by ALTA's name.
struct Parametrisation {
    const char* name;
    std::size_t size;
    bool isotropic;
    Pair (*pair)(const double* x);
};

constexpr Parametrisation parametrisations[] = {
    {"ISOTROPIC_TL_TV_PROJ_DPHI", 3, true,
     [](const double* x) {
         return Pair{direction(x[0], 0), direction(std::hypot(x[1], x[2]), std::atan2(x[2], x[1]))};
     }},
    {"ISOTROPIC_TV_TL_DPHI", 3, true,
     [](const double* x) {
         return Pair{direction(x[1], 0), direction(x[0], x[2])};
     }},
    {"SPHERICAL_TL_PL_TV_PV", 4, false,
     [](const double* x) {
         return Pair{direction(x[0], x[1]), direction(x[2], x[3])};
     }},
    {"RUSIN_TH_TD_PD", 3, true, [](const double* x) { return from_half(x[0], 0, x[1], x[2]); }},
    {"RUSIN_TH_PH_TD_PD", 4, false,
     [](const double* x) { return from_half(x[0], x[1], x[2], x[3]); }},
    {"CARTESIAN", 6, false, [](const double* x) {
         return Pair{unit(x + 3), unit(x)};
     }}};

/// The comments ahead of the first row: `#KEY value`.
struct Header {
    std::size_t parameters = 0, channels = 0; ///< #DIM
    std::size_t ignored = 0;                  ///< columns after the channels
    const Parametrisation* in = nullptr;
    bool cosine = false; ///< values include the cosine of wo
    std::string out;     ///< #PARAM_OUT
};

class HeaderReader {
  public:
    HeaderReader(const text::Lines& lines, std::string_view comments) : lines_(lines) {
        while (!comments.empty()) {
            const std::size_t end = std::min(comments.find('\n'), comments.size());
            read(text::trim(comments.substr(0, end)));
            comments.remove_prefix(std::min(end + 1, comments.size()));
        }
        if (header_.in == nullptr)
            fail("no #PARAM_IN; expected what the numbers are");
        if (header_.parameters == 0)
            fail("no #DIM; expected the numbers of parameters and of channels");
        if (header_.in->size != header_.parameters)
            fail(fmt::format("#DIM {}; {} has {} parameters", header_.parameters, header_.in->name,
                             header_.in->size));
        header_.ignored = variances_ * header_.channels;
    }
    const Header& header() const { return header_; }

  private:
    [[noreturn]] void fail(const std::string& message) const { lines_.fail_file(message); }

    void read(std::string_view line) {
        std::vector<std::string_view> words;
        text::split(line, ' ', words);
        if (words.empty())
            return;
        if (words[0] == "#DIM") {
            if (words.size() != 3)
                fail("#DIM: expected the numbers of parameters and of channels");
            header_.parameters = text::count(lines_, "#DIM", words[1]);
            header_.channels = text::count(lines_, "#DIM", words[2]);
            if (header_.channels == 0 || header_.channels > max_channels)
                fail(fmt::format("#DIM: {} channels; expected 1 to {}", header_.channels,
                                 max_channels));
        } else if (words[0] == "#PARAM_IN") {
            header_.in = parametrisation(words);
        } else if (words[0] == "#PARAM_OUT") {
            read_out(words);
        } else if (words[0] == "#VS") {
            variances_ = words.size() == 2 ? text::count(lines_, "#VS", words[1]) : 3;
            if (variances_ > 2)
                fail("#VS: expected 0, 1 or 2: columns of confidence for each channel");
        }
    }
    const Parametrisation* parametrisation(const std::vector<std::string_view>& words) const {
        std::string known;
        for (const Parametrisation& p : parametrisations) {
            if (words.size() == 2 && words[1] == p.name)
                return &p;
            known += fmt::format("{}{}", known.empty() ? "" : ", ", p.name);
        }
        fail(fmt::format("#PARAM_IN {}; expected one that tells both directions: {}",
                         text::quoted(words.size() == 2 ? words[1] : ""), known));
    }
    void read_out(const std::vector<std::string_view>& words) {
        header_.out = words.size() == 2 ? std::string(words[1]) : "";
        header_.cosine = header_.out == "INV_STERADIAN_COSINE_FACTOR";
        for (const char* known :
             {"INV_STERADIAN", "INV_STERADIAN_COSINE_FACTOR", "RGB_COLOR", "XYZ_COLOR"})
            if (header_.out == known)
                return;
        fail(fmt::format("#PARAM_OUT {}; expected INV_STERADIAN, INV_STERADIAN_COSINE_FACTOR, "
                         "RGB_COLOR or XYZ_COLOR",
                         text::quoted(header_.out)));
    }
    const text::Lines& lines_;
    Header header_;
    std::size_t variances_ = 0;
};

constexpr const char* parameter_names[] = {"parameter 1", "parameter 2", "parameter 3",
                                           "parameter 4", "parameter 5", "parameter 6"};

/// Values with a cosine below this tell nothing of what is without.
constexpr double least_cosine = 1e-4;

} // namespace

bool recognise(std::string_view bytes) {
    text::Lines lines(bytes);
    const bool any = lines.next();
    const auto comments =
        any ? static_cast<std::size_t>(lines.line().data() - bytes.data()) : bytes.size();
    const std::string_view head = bytes.substr(0, comments);
    return head.find("#DIM ") != head.npos || head.find("#PARAM_IN") != head.npos;
}

Samples read(const MappedFile& file, std::optional<bool> isotropic) {
    text::Lines lines(file);
    if (!lines.next())
        lines.fail_file("no samples; expected rows of numbers after the header");
    const auto comments = static_cast<std::size_t>(lines.line().data() - file.bytes().data());
    const Header header = HeaderReader(lines, file.bytes().substr(0, comments)).header();
    const std::size_t columns = header.parameters + header.channels + header.ignored;
    Rows rows(lines,
              header.out == "XYZ_COLOR" && header.channels == 3
                  ? std::vector<std::string>{"X", "Y", "Z"}
                  : numbered_channels(header.channels),
              1 + lines.rows_ahead(columns));
    std::vector<std::string_view> fields;
    std::array<double, 6> x{};
    do {
        text::split(lines.line(), ' ', fields);
        if (fields.size() != columns)
            lines.fail(fmt::format("{} fields; expected {}", fields.size(), columns));
        for (std::size_t i = 0; i < header.parameters; ++i)
            x[i] = text::number(lines, parameter_names[i], fields[i]);
        const Pair pair = header.in->pair(x.data());
        const double cosine = header.cosine ? pair.wo[2] : 1;
        rows.add(pair.wi, pair.wo, !header.cosine || cosine > least_cosine);
        for (std::size_t c = 0; c < header.channels; ++c) {
            const std::string_view field = fields[header.parameters + c];
            const double value =
                text::number(lines, "value", field) / std::max(cosine, least_cosine);
            if (!(std::abs(value) <= FLT_MAX))
                lines.fail(fmt::format("value: {} is too large", text::quoted(field)));
            rows.add_value(static_cast<float>(value));
        }
    } while (lines.next());
    const char* const note = header.cosine        ? ", values with cos(theta_o)"
                             : header.out.empty() ? ", no #PARAM_OUT: values taken as 1/sr"
                                                  : "";
    return rows.samples(fmt::format("ALTA text, {}{}", header.in->name, note),
                        isotropic.value_or(header.in->isotropic));
}

} // namespace brdfit::alta
