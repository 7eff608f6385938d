#include "host/microfacet/distribution.hpp"

#include "host/error.hpp"
#include "host/files/file.hpp"
#include "host/image/image.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <limits>

namespace brdfit {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double least_sigma = 1e-3, greatest_sigma = 100;
constexpr int max_mixtures = 8; ///< one in the other

double optional_number(const Json& object, const Place& at, const std::string& key, double lower,
                       double upper, double otherwise) {
    const Json* const found = optional(object, key);
    return found == nullptr ? otherwise : parse_number(*found, at.member(key), lower, upper);
}

/// A width; null: infinite.
double parse_sigma(const Json& value, const Place& at) {
    if (value.is_null())
        return infinity;
    if (!value.is_number())
        at.fail(value, fmt::format("a number in [{}, {}], or null for an infinite width",
                                   least_sigma, greatest_sigma));
    return parse_number(value, at, least_sigma, greatest_sigma);
}

double required_sigma(const Json& object, const Place& at, const std::string& key) {
    return parse_sigma(required(object, at, key, "a number, or null for an infinite width"),
                       at.member(key));
}

double optional_sigma(const Json& object, const Place& at, const std::string& key,
                      double otherwise) {
    return object.contains(key) ? required_sigma(object, at, key) : otherwise;
}

struct Widths {
    double x, y;
};

/// `sigma`, or `sigma_x` and `sigma_y`.
Widths parse_widths(const Json& object, const Place& at) {
    if (!object.contains("sigma"))
        return {required_sigma(object, at, "sigma_x"), required_sigma(object, at, "sigma_y")};
    for (const char* key : {"sigma_x", "sigma_y"})
        if (object.contains(key))
            at.member(key).fail(
                "stands beside sigma; expected either sigma or sigma_x and sigma_y");
    const double sigma = required_sigma(object, at, "sigma");
    return {sigma, sigma};
}

Sector sector_of(const DistributionPart& part) {
    const bool round = part.shape == Shape::Velvet ||
                       (part.shape == Shape::Gaussian && part.sigma_x == part.sigma_y) ||
                       (part.shape == Shape::Tabulated && part.table->width == 1);
    if (part.table != nullptr && !round)
        return Sector::All;
    if (part.table != nullptr && !part.table->tabulated())
        return Sector::All;
    if (part.tilt == 0 && round)
        return Sector::Isotropic;
    if (part.turn != 0)
        return Sector::All;
    return part.tilt == 0 ? Sector::Quarter : Sector::Half;
}

Sector common(Sector a, Sector b) {
    const auto rank = [](Sector s) {
        return s == Sector::Isotropic ? 3 : s == Sector::Quarter ? 2 : s == Sector::Half ? 1 : 0;
    };
    return rank(a) < rank(b) ? a : b;
}

class Parser {
  public:
    explicit Parser(const std::string& source)
        : folder_(std::filesystem::path(source).parent_path()) {}

    Distribution parse(const Json& object, const Place& at, int depth = 0) {
        check_object(object, at, "an object that describes a distribution");
        const std::string expected = "gaussian, grooves, satin, velvet, slanted-velvet, image, "
                                     "tabulated or mixture";
        const Json& name = required(object, at, "distribution", expected);
        if (name == "gaussian")
            return gaussian(object, at);
        if (name == "grooves")
            return grooves(object, at);
        if (name == "satin")
            return satin(object, at);
        if (name == "velvet")
            return velvet(object, at);
        if (name == "slanted-velvet")
            return slanted_velvet(object, at);
        if (name == "image")
            return image(object, at, depth);
        if (name == "tabulated")
            return tabulated(object, at);
        if (name == "mixture")
            return mixture(object, at, depth);
        at.member("distribution").fail(name, expected);
    }

  private:
    // Keys every distribution may have beside its own; `weight` belongs to the mixture it is in.
    static void keys(const Json& object, const Place& at, std::vector<std::string> own) {
        own.insert(own.end(), {"distribution", "weight"});
        check_keys(object, at, own);
    }

    static Distribution single(DistributionPart part, const std::string& name) {
        Distribution result;
        result.sector = sector_of(part);
        result.parts.push_back(std::move(part));
        result.name = name;
        return result;
    }

    static void orient(const Json& object, const Place& at, DistributionPart& part) {
        part.tilt = optional_number(object, at, "tilt", -pi, pi, 0);
        part.turn = optional_number(object, at, "turn", -2 * pi, 2 * pi, 0);
    }

    static Distribution gaussian(const Json& object, const Place& at) {
        keys(object, at, {"sigma", "sigma_x", "sigma_y", "tilt", "turn"});
        const Widths widths = parse_widths(object, at);
        DistributionPart part;
        part.sigma_x = widths.x;
        part.sigma_y = widths.y;
        orient(object, at, part);
        return single(part, "gaussian");
    }

    // Two Gaussians, the sides of grooves along y.
    static Distribution grooves(const Json& object, const Place& at) {
        keys(object, at, {"sigma", "tilt"});
        DistributionPart part;
        part.sigma_x = part.sigma_y = optional_sigma(object, at, "sigma", 0.1);
        part.tilt = optional_number(object, at, "tilt", 0, pi / 2, 40 * degree);
        Distribution result = single(part, "grooves");
        part.tilt = -part.tilt;
        result.parts.push_back(part);
        result.sector = Sector::Quarter;
        return result;
    }

    static Distribution satin(const Json& object, const Place& at) {
        keys(object, at, {"sigmas", "weights"});
        const auto pair = [&](const char* key, std::array<double, 2> otherwise, double lower,
                              double upper) {
            const auto found = object.find(key);
            if (found == object.end())
                return otherwise;
            const Place here = at.member(key);
            if (!found->is_array() || found->size() != 2)
                here.fail(*found, "an array of 2 numbers");
            return std::array<double, 2>{parse_number((*found)[0], here.element(0), lower, upper),
                                         parse_number((*found)[1], here.element(1), lower, upper)};
        };
        const auto sigmas = pair("sigmas", {0.1, 0.3}, least_sigma, greatest_sigma);
        const auto weights = pair("weights", {0.7, 0.3}, 0, 1e6);
        if (weights[0] + weights[1] <= 0)
            at.member("weights").fail("are all 0; expected a positive one");
        Distribution result;
        result.name = "satin";
        result.sector = Sector::Quarter;
        for (std::size_t k = 0; k < 2; ++k) {
            DistributionPart part;
            part.sigma_x = sigmas[k];
            part.sigma_y = infinity;
            if (weights[k] == 0)
                continue;
            result.shares.push_back({result.parts.size(), 1, weights[k], true});
            result.parts.push_back(part);
        }
        return result;
    }

    static Distribution velvet(const Json& object, const Place& at) {
        keys(object, at, {"sigma"});
        DistributionPart part;
        part.shape = Shape::Velvet;
        part.sigma_x = part.sigma_y =
            object.contains("sigma")
                ? parse_number(object["sigma"], at.member("sigma"), least_sigma, greatest_sigma)
                : 0.5;
        return single(part, "velvet");
    }

    static Distribution slanted_velvet(const Json& object, const Place& at) {
        keys(object, at, {"sigma_x", "tilt"});
        DistributionPart part;
        part.sigma_x = optional_sigma(object, at, "sigma_x", 0.5);
        part.sigma_y = infinity;
        part.tilt = optional_number(object, at, "tilt", 0, pi / 2, 50 * degree);
        part.area_scale = 2;
        return single(part, "slanted-velvet");
    }

    std::string file(const Json& object, const Place& at, const std::string& key,
                     const std::string& expected) const {
        const Json& value = required(object, at, key, expected);
        return (folder_ / parse_text(value, at.member(key), expected)).string();
    }

    Distribution image(const Json& object, const Place& at, int depth) {
        keys(object, at, {"image", "base", "extent", "mapping"});
        const std::string path = file(object, at, "image", "the name of a PNG or EXR image");
        const std::string base_expected = "the distribution that the image modulates";
        Distribution result =
            parse(required(object, at, "base", base_expected), at.member("base"), depth + 1);
        for (const DistributionPart& part : result.parts)
            if (part.table != nullptr)
                at.member("base").fail("has an image or a table; expected one given by a formula");
        auto table = std::make_shared<DirectionTable>();
        table->extent = optional_number(object, at, "extent", 1e-3, 1, 1);
        const auto mapping = object.find("mapping");
        if (mapping != object.end() && *mapping != "disk" && *mapping != "polar")
            at.member("mapping").fail(*mapping, "disk or polar");
        if (mapping != object.end() && *mapping == "polar") {
            if (object.contains("extent"))
                at.member("extent").fail("stands beside mapping polar; expected it with disk only");
            table->extent = 0;
        }
        const Image pixels = read_image(path);
        table->width = pixels.width;
        table->height = pixels.height;
        // Luminance of linear light where there are colours.
        const auto* y = pixels.plane("Y");
        const auto *r = pixels.plane("R"), *g = pixels.plane("G"), *b = pixels.plane("B");
        if (y == nullptr && pixels.planes.size() == 1)
            y = &pixels.planes[0];
        if (y == nullptr && (r == nullptr || g == nullptr || b == nullptr))
            throw InputError(fmt::format("{}: has channels {}; expected Y or R, G, B", path,
                                         fmt::join(pixels.channels, ", ")));
        table->values.resize(pixels.width * pixels.height);
        for (std::size_t i = 0; i < table->values.size(); ++i)
            table->values[i] =
                y != nullptr ? (*y)[i] : 0.2126F * (*r)[i] + 0.7152F * (*g)[i] + 0.0722F * (*b)[i];
        check_values(*table, path);
        for (DistributionPart& part : result.parts)
            part.table = table;
        result.sector = Sector::All;
        result.name = "image on " + result.name;
        return result;
    }

    Distribution tabulated(const Json& object, const Place& at) const {
        keys(object, at, {"file", "tilt", "turn"});
        DistributionPart part;
        part.shape = Shape::Tabulated;
        part.table = read_tabulated(file(object, at, "file", "the name of a CSV or EXR file"));
        orient(object, at, part);
        return single(part, "tabulated");
    }

    Distribution mixture(const Json& object, const Place& at, int depth) {
        keys(object, at, {"parts", "normalise"});
        if (depth >= max_mixtures)
            at.fail(fmt::format("is nested too deeply; expected at most {} levels", max_mixtures));
        const std::string expected = fmt::format("an array of 1 to {} distributions", max_parts);
        const Json& parts = required(object, at, "parts", expected);
        const Place here = at.member("parts");
        if (!parts.is_array() || parts.empty() || parts.size() > max_parts)
            here.fail(parts, expected);
        bool normalise = true;
        if (const Json* const found = optional(object, "normalise"))
            normalise = parse_bool(*found, at.member("normalise"));
        Distribution result;
        result.name = "mixture";
        result.sector = Sector::Isotropic;
        for (std::size_t i = 0; i < parts.size(); ++i) {
            const Place element = here.element(i);
            const Distribution part = parse(parts[i], element, depth + 1);
            const double weight =
                parse_number(required(parts[i], element, "weight", "a number of at least 0"),
                             element.member("weight"), 0, 1e6);
            if (weight == 0)
                continue;
            const std::size_t first = result.parts.size();
            for (Share share : part.shares) {
                share.first += first;
                result.shares.push_back(share);
            }
            result.shares.push_back({first, part.parts.size(), weight, normalise});
            result.parts.insert(result.parts.end(), part.parts.begin(), part.parts.end());
            result.sector = common(result.sector, part.sector);
        }
        if (result.parts.empty())
            here.fail("have weights that are all 0; expected a positive one");
        if (result.parts.size() > max_parts)
            here.fail(fmt::format("come to {} parts; expected at most {}", result.parts.size(),
                                  max_parts));
        return result;
    }

    std::filesystem::path folder_;
};

} // namespace

std::array<double, 9> DistributionPart::frame() const {
    const double c = std::cos(tilt), s = std::sin(tilt), ct = std::cos(turn), st = std::sin(turn);
    // Undo the turn, then the tilt, which takes z to (sin tilt, 0, cos tilt).
    return {c * ct, c * st, -s, -st, ct, 0, s * ct, s * st, c};
}

namespace {

Distribution distribution_from(const Json& json, const std::string& source) {
    const Place top{source, ""};
    check_object(json, top, "an object that describes a distribution");
    if (json.contains("weight"))
        top.member("weight").fail("is an unknown key; expected it in the parts of a mixture only");
    return Parser(source).parse(json, top);
}

} // namespace

Distribution parse_distribution(const std::string& text, const std::string& source) {
    return distribution_from(parse_json(text, source, "a distribution"), source);
}

Distribution read_distribution(const std::string& path) {
    constexpr std::size_t most_bytes = std::size_t{1} << 20;
    return distribution_from(read_json(path, "a distribution", most_bytes), path);
}

} // namespace brdfit
