#include "fit/compare.hpp"

#include "fit/report.hpp"
#include "fit/samples.hpp"
#include "host/error.hpp"
#include "host/measured/merl.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <limits>

namespace brdfit {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Channels of A and of B that go together.
std::vector<std::pair<std::size_t, std::size_t>> common_channels(const Brdf& a, const Brdf& b,
                                                                 const std::string& name_a,
                                                                 const std::string& name_b) {
    const std::vector<std::string>&of_a = a.channels(), &of_b = b.channels();
    if (of_a.size() == 1 && of_b.size() == 1)
        return {{0, 0}};
    std::vector<std::pair<std::size_t, std::size_t>> common;
    for (std::size_t i = 0; i < of_a.size(); ++i) {
        const auto at = std::find(of_b.begin(), of_b.end(), of_a[i]);
        if (at != of_b.end())
            common.emplace_back(i, at - of_b.begin());
    }
    if (common.empty()) {
        const auto few = [](const std::vector<std::string>& names) {
            constexpr std::size_t most = 8;
            const std::vector<std::string> first(
                names.begin(),
                names.begin() + static_cast<std::ptrdiff_t>(std::min(most, names.size())));
            return fmt::format("{}{}", fmt::join(first, ", "), names.size() > most ? ", ..." : "");
        };
        throw InputError(fmt::format("{} has the channels {} and {} has {}; expected some in "
                                     "common, or one each",
                                     name_a, few(of_a), name_b, few(of_b)));
    }
    return common;
}

/// Pairs turned about the normal, each by another angle, spread evenly over the circle.
std::shared_ptr<const Directions> turned_pairs(const Directions& directions) {
    constexpr double golden = 0.6180339887498949;
    auto turned = std::make_shared<Directions>(directions.count());
    for (std::size_t k = 0; k < directions.count(); ++k) {
        const double turns = static_cast<double>(k) * golden;
        const double angle = 2 * pi * (turns - std::floor(turns));
        const double cos_a = std::cos(angle), sin_a = std::sin(angle);
        const auto turn = [&](const Vector& v) {
            return Vector{cos_a * v[0] - sin_a * v[1], sin_a * v[0] + cos_a * v[1], v[2]};
        };
        const auto [wi, wo] = directions.pair(k);
        turned->set(k, turn(wi), turn(wo));
    }
    return turned;
}

/// The values of a BRDF at pairs of directions: of a measurement at its own samples, these.
std::vector<float> values_at(const Device& device, const Brdf& brdf,
                             const std::shared_ptr<const Directions>& directions,
                             const ProgressFunction& progress) {
    if (brdf.measured() != nullptr && brdf.measured()->samples().directions == directions)
        return brdf.measured()->samples().values;
    return brdf.evaluate(device, *directions, progress);
}

/// The channels of `values`, [channel][sample], in another order.
std::vector<float> chosen(const std::vector<float>& values, std::size_t count,
                          const std::vector<std::size_t>& channels) {
    std::vector<float> made;
    made.reserve(channels.size() * count);
    for (const std::size_t channel : channels) {
        const auto begin = values.begin() + static_cast<std::ptrdiff_t>(channel * count);
        made.insert(made.end(), begin, begin + static_cast<std::ptrdiff_t>(count));
    }
    return made;
}

double angle_of(const Vector& v) {
    return std::atan2(std::hypot(v[0], v[1]), v[2]) / degree;
}
/// Of the half vector or the difference, as their planes give the cosine, which rounds past 1.
double angle_of(float cosine) {
    return std::acos(std::clamp(static_cast<double>(cosine), -1.0, 1.0)) / degree;
}

/// Sums over channels at a sample.
struct AtSample {
    double difference = 0; ///< sum |b - a|
    double size = 0;       ///< sum |a|
    double change = 0;     ///< sum (b - a)
    double squared = 0;    ///< mean (b - a)^2

    AtSample(const ComparedValues& values, std::size_t k) {
        const std::size_t count = values.a.count(), channels = values.a.channels.size();
        for (std::size_t c = 0; c < channels; ++c) {
            const double a = values.a.channel(c)[k], b = values.b[c * count + k];
            difference += std::abs(b - a);
            change += b - a;
            size += std::abs(a);
            squared += (b - a) * (b - a) / static_cast<double>(channels);
        }
    }
    double relative() const {
        return size > 0         ? difference / size
               : difference > 0 ? std::numeric_limits<double>::infinity()
                                : 0;
    }
};

double weight_of(const Samples& samples, std::size_t k) {
    return samples.weights.empty() ? 1 : double{samples.weights[k]};
}
double cosine_of(const Samples& samples, std::size_t k) {
    return samples.directions->plane(Directions::WiZ)[k];
}

/// Sums whose quotient is the bias.
struct Bias {
    double difference = 0, size = 0;

    void add(const ComparedValues& values, std::size_t k) {
        const AtSample at(values, k);
        const double w = weight_of(values.a, k) * cosine_of(values.a, k);
        difference += w * at.change;
        size += w * at.size;
    }
    double value() const { return size > 0 ? difference / size : nan; }
};

/// Of which the metric `ngan` takes the mean and the root.
double squared_error(const ComparedValues& values, const std::vector<std::uint32_t>& used) {
    double sum = 0;
    for (const std::uint32_t k : used) {
        const double iz = cosine_of(values.a, k);
        sum += weight_of(values.a, k) * iz * iz * AtSample(values, k).squared;
    }
    return sum;
}

/// `whole`: the squared error of which these samples have a share.
Difference difference_of(const ComparedValues& values, const std::vector<std::uint32_t>& used,
                         double whole) {
    Difference made;
    made.share = whole > 0 ? squared_error(values, used) / whole : 0;
    made.samples = used.size();
    made.errors = value_errors(values.a, used, values.b);
    Bias bias;
    std::vector<double> relative;
    relative.reserve(used.size());
    for (const std::uint32_t k : used) {
        const AtSample at(values, k);
        bias.add(values, k);
        if (at.size > 0)
            relative.push_back(at.relative());
        else
            ++made.zeros;
    }
    made.bias = bias.value();
    const auto percentile = [&](double share) {
        if (relative.empty())
            return nan;
        const auto at = static_cast<std::ptrdiff_t>(
            std::llround(share * static_cast<double>(relative.size() - 1)));
        std::nth_element(relative.begin(), relative.begin() + at, relative.end());
        return relative[static_cast<std::size_t>(at)];
    };
    made.median = percentile(0.5);
    made.high = percentile(0.95);
    made.largest = percentile(1);
    return made;
}

WorstSample sample_at(const ComparedValues& values, std::uint32_t k) {
    const Directions& directions = *values.a.directions;
    const auto [wi, wo] = directions.pair(k);
    const AtSample at(values, k);
    return {k,
            angle_of(wi),
            std::atan2(wi[1], wi[0]) / degree,
            angle_of(wo),
            std::atan2(wo[1], wo[0]) / degree,
            angle_of(directions.plane(Directions::HZ)[k]),
            angle_of(directions.plane(Directions::C)[k]),
            cosine_of(values.a, k) * std::sqrt(at.squared),
            at.relative()};
}

const std::vector<double> even = {0, 10, 20, 30, 40, 50, 60, 70, 80, 90};
/// Of theta_h: the peaks of specular lobes are narrow.
const std::vector<double> fine = {0, 1, 2, 5, 10, 20, 30, 40, 50, 60, 70, 80, 90};

std::vector<Band> bands_of(const ComparedValues& values, const std::vector<std::uint32_t>& used,
                           Directions::Plane cosine, const std::vector<double>& edges,
                           double whole) {
    const float* const plane = values.a.directions->plane(cosine);
    std::vector<std::vector<std::uint32_t>> of(edges.size() - 1);
    for (const std::uint32_t k : used) {
        const auto above = std::upper_bound(edges.begin(), edges.end(), angle_of(plane[k]));
        const auto band = std::max<std::ptrdiff_t>(above - edges.begin(), 1) - 1;
        of[std::min(static_cast<std::size_t>(band), of.size() - 1)].push_back(k);
    }
    std::vector<Band> bands;
    for (std::size_t i = 0; i < of.size(); ++i) {
        if (!of[i].empty())
            bands.push_back({edges[i], edges[i + 1], difference_of(values, of[i], whole)});
    }
    return bands;
}

} // namespace

std::shared_ptr<const Directions> comparison_directions(bool turned) {
    return turned ? turned_pairs(*merl::bin_directions()) : merl::bin_directions();
}

ComparedValues values_to_compare(const Device& device, const Brdf& a, const Brdf& b,
                                 const std::string& name_a, const std::string& name_b,
                                 const ProgressFunction& progress) {
    const auto channels = common_channels(a, b, name_a, name_b);
    const MeasuredBrdf* const from = a.measured() != nullptr ? a.measured() : b.measured();
    const bool isotropic = a.isotropic() && b.isotropic();
    ComparedValues made;
    std::shared_ptr<const Directions> own; // of the samples, before they are turned
    if (from != nullptr) {
        made.at = "the samples of " + (from == a.measured() ? name_a : name_b);
        own = from->samples().directions;
        made.a.weights = from->samples().weights;
        made.a.valid = from->samples().valid;
        const bool turned = from->isotropic() && !isotropic;
        made.a.directions = turned ? turned_pairs(*own) : own;
        made.at += turned ? ", turned to all azimuths" : "";
    } else {
        made.at = fmt::format("the centres of MERL's bins{}",
                              isotropic ? "" : ", turned to all azimuths");
        own = made.a.directions = comparison_directions(!isotropic);
        made.a.weights = merl::bin_weights();
        made.a.valid.assign(made.a.count(), 1);
    }
    made.a.isotropic = isotropic;
    made.a.source = name_a;
    std::vector<std::size_t> of_a, of_b;
    for (const auto& [i, j] : channels) {
        of_a.push_back(i);
        of_b.push_back(j);
        made.a.channels.push_back(a.channels()[i]);
    }
    // An isotropic measurement's own samples are its values, however turned.
    const auto values = [&](const Brdf& brdf, const ProgressFunction& told) {
        const bool itself = brdf.measured() != nullptr && brdf.measured() == from;
        return values_at(device, brdf, itself ? own : made.a.directions, told);
    };
    const std::size_t count = made.a.count();
    made.a.values = chosen(values(a, part_of(progress, 0, 0.5)), count, of_a);
    made.b = chosen(values(b, part_of(progress, 0.5, 1)), count, of_b);
    for (const Brdf* brdf : {&a, &b}) // on one grid: what either has not measured
        if (brdf->measured() != nullptr && brdf->measured()->samples().directions == own)
            for (std::size_t k = 0; k < count; ++k)
                made.a.valid[k] &= brdf->measured()->samples().valid[k];
    return made;
}

Comparison compare(const ComparedValues& values, double max_theta, std::size_t worst) {
    const std::vector<std::uint32_t> used = used_samples(values.a, max_theta);
    Comparison made;
    const double whole = squared_error(values, used);
    made.all = difference_of(values, used, whole);
    made.theta_i = bands_of(values, used, Directions::WiZ, even, whole);
    made.theta_h = bands_of(values, used, Directions::HZ, fine, whole);
    made.theta_d = bands_of(values, used, Directions::C, even, whole);

    std::vector<std::pair<double, std::uint32_t>> order;
    std::pair<double, std::uint32_t> relative{-1, used.front()};
    for (const std::uint32_t k : used) {
        const AtSample at(values, k);
        order.emplace_back(-cosine_of(values.a, k) * std::sqrt(at.squared), k);
        if (at.size > 0 && at.relative() > relative.first)
            relative = {at.relative(), k};
    }
    worst = std::min(worst, order.size());
    std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(worst),
                      order.end());
    for (std::size_t i = 0; i < worst; ++i)
        made.worst.push_back(sample_at(values, order[i].second));
    made.largest_relative = sample_at(values, relative.second);
    return made;
}

DifferenceMap difference_map(const ComparedValues& values, double max_theta) {
    DifferenceMap map;
    constexpr double cells = map_cells;
    for (std::size_t i = 0; i <= map_cells; ++i) {
        const double share = static_cast<double>(i) / cells;
        map.theta_h.push_back(90 * share * share);
        map.theta_d.push_back(90 * share);
    }
    std::vector<Bias> bias(map_cells * map_cells);
    const Directions& directions = *values.a.directions;
    const auto cell = [](double share) {
        return std::min(static_cast<std::size_t>(share * cells), map_cells - 1);
    };
    for (const std::uint32_t k : used_samples(values.a, max_theta))
        bias[cell(angle_of(directions.plane(Directions::C)[k]) / 90) * map_cells +
             cell(std::sqrt(angle_of(directions.plane(Directions::HZ)[k]) / 90))]
            .add(values, k);
    for (const Bias& of_cell : bias)
        map.bias.push_back(of_cell.value());
    return map;
}

namespace {

Json difference_json(const Difference& difference) {
    return {{"samples", difference.samples},
            {"errors", errors_json(difference.errors)},
            {"bias", difference.bias},
            {"share", difference.share},
            {"relative",
             {{"median", difference.median},
              {"p95", difference.high},
              {"largest", difference.largest},
              {"a_is_zero", difference.zeros}}}};
}

Json bands_json(const std::vector<Band>& bands) {
    Json rows = Json::array();
    for (const Band& band : bands) {
        rows.push_back({{"from", band.from}, {"to", band.to}});
        rows.back().update(difference_json(band.difference));
    }
    return rows;
}

Json sample_json(const WorstSample& worst, const ComparedValues& values) {
    Json a = Json::array(), b = Json::array();
    for (std::size_t c = 0; c < values.a.channels.size(); ++c) {
        a.push_back(values.a.channel(c)[worst.sample]);
        b.push_back(values.b[c * values.a.count() + worst.sample]);
    }
    return {{"theta_i", worst.theta_i},
            {"phi_i", worst.phi_i},
            {"theta_o", worst.theta_o},
            {"phi_o", worst.phi_o},
            {"theta_h", worst.theta_h},
            {"theta_d", worst.theta_d},
            {"a", a},
            {"b", b},
            {"difference", worst.difference},
            {"relative", worst.relative}};
}

} // namespace

Json comparison_json(const Comparison& comparison, const ComparedValues& values, double max_theta) {
    Json json{{"at", values.at}, {"channels", values.a.channels}, {"max_theta", max_theta}};
    json.update(difference_json(comparison.all));
    json["bands"] = {{"theta_i", bands_json(comparison.theta_i)},
                     {"theta_h", bands_json(comparison.theta_h)},
                     {"theta_d", bands_json(comparison.theta_d)}};
    json["worst"] = Json::array();
    for (const WorstSample& worst : comparison.worst)
        json["worst"].push_back(sample_json(worst, values));
    json["largest_relative"] = sample_json(comparison.largest_relative, values);
    return json;
}

} // namespace brdfit
