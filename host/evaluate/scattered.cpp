#include "host/evaluate/scattered.hpp"

#include "host/parallel.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nanoflann.hpp>

namespace brdfit {

namespace {

constexpr std::size_t dimensions = 4, neighbours = 8;
constexpr std::size_t pairs_a_piece = 4096;
constexpr std::size_t none = std::numeric_limits<std::size_t>::max(); // no sample
using Point = std::array<double, dimensions>;

/// Where a pair lies. The order of wi and wo turns the sign of the last two.
Point point_of(const Vector& wi, const Vector& wo, bool isotropic) {
    const Vector sum{wi[0] + wo[0], wi[1] + wo[1], wi[2] + wo[2]};
    const Vector half{(wi[0] - wo[0]) / 2, (wi[1] - wo[1]) / 2, (wi[2] - wo[2]) / 2};
    const double radius = std::hypot(sum[0], sum[1]);
    const double theta_h = std::atan2(radius, sum[2]);
    const double cos_phi = radius > 0 ? sum[0] / radius : 1;
    const double sin_phi = radius > 0 ? sum[1] / radius : 0;
    // Half the difference is perpendicular to h and as long as the sine of theta_d.
    const double along =
        std::cos(theta_h) * (cos_phi * half[0] + sin_phi * half[1]) - std::sin(theta_h) * half[2];
    const double across = cos_phi * half[1] - sin_phi * half[0];
    const double u = std::sqrt(2 * theta_h / pi);
    if (isotropic)
        return {u, 0, std::abs(along), std::abs(across)};
    // In the surface's frame: h's azimuth says nothing near the normal.
    return {u * cos_phi, u * sin_phi, along * cos_phi - across * sin_phi,
            along * sin_phi + across * cos_phi};
}

/// The points, as nanoflann asks for them.
struct Cloud {
    std::vector<Point> points;
    std::size_t kdtree_get_point_count() const { return points.size(); }
    double kdtree_get_pt(std::size_t i, std::size_t dimension) const {
        return points[i][dimension];
    }
    template <typename Box>
    bool kdtree_get_bbox(Box&) const {
        return false;
    }
};

} // namespace

struct ScatteredBrdf::Tree {
    using Index = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Cloud>,
                                                      Cloud, dimensions, std::size_t>;
    Cloud cloud;
    std::vector<std::size_t> sample; ///< of each point
    std::unique_ptr<Index> index;
};

ScatteredBrdf::~ScatteredBrdf() = default;

ScatteredBrdf::ScatteredBrdf(const Samples& samples)
    : samples_(samples), tree_(std::make_unique<Tree>()) {
    const std::size_t points = samples.valid_count() * (samples.isotropic ? 1 : 2);
    tree_->cloud.points.reserve(points);
    tree_->sample.reserve(points);
    for (std::size_t k = 0; k < samples.count(); ++k) {
        if (samples.valid[k] == 0)
            continue;
        const auto [wi, wo] = samples.directions->pair(k);
        Point point = point_of(wi, wo, samples.isotropic);
        tree_->cloud.points.push_back(point);
        tree_->sample.push_back(k);
        if (samples.isotropic)
            continue;
        point[2] = -point[2];
        point[3] = -point[3];
        tree_->cloud.points.push_back(point);
        tree_->sample.push_back(k);
    }
    tree_->index = std::make_unique<Tree::Index>(dimensions, tree_->cloud,
                                                 nanoflann::KDTreeSingleIndexAdaptorParams(16));
    tree_->index->buildIndex();
}

void ScatteredBrdf::interpolate(const Vector& wi, const Vector& wo, std::size_t left_out,
                                std::size_t stride, float* values) const {
    constexpr double nearest = 1e-14; // squared distance of what counts as the same pair
    std::array<std::size_t, neighbours + 2> index; // a sample is two points at most
    std::array<double, neighbours + 2> weight;
    const Point at = point_of(wi, wo, samples_.isotropic);
    const std::size_t asked = left_out == none ? neighbours : neighbours + 2;
    const std::size_t found =
        tree_->index->knnSearch(at.data(), asked, index.data(), weight.data());
    std::size_t used = 0;
    double all = 0;
    for (std::size_t n = 0; n < found && used < neighbours; ++n)
        if (tree_->sample[index[n]] != left_out) {
            index[used] = tree_->sample[index[n]];
            weight[used] = 1 / std::max(weight[n], nearest);
            all += weight[used++];
        }
    for (std::size_t c = 0; c < samples_.channels.size(); ++c) {
        double sum = 0;
        for (std::size_t n = 0; n < used; ++n)
            sum += weight[n] * samples_.channel(c)[index[n]];
        values[c * stride] = static_cast<float>(sum / all);
    }
}

std::vector<float> ScatteredBrdf::evaluate(const Directions& directions,
                                           const ProgressFunction& progress) const {
    const std::size_t count = directions.count();
    std::vector<float> values(samples_.channels.size() * count);
    const auto piece = [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
            if (!directions.above_horizon(k))
                continue;
            const auto [wi, wo] = directions.pair(k);
            interpolate(wi, wo, none, count, values.data() + k);
        }
    };
    parallel_pieces(count, pairs_a_piece, piece, progress);
    return values;
}

RelativeError ScatteredBrdf::leave_one_out() const {
    constexpr std::size_t most = 20000;
    std::vector<std::size_t> valid;
    for (std::size_t k = 0; k < samples_.count(); ++k)
        if (samples_.valid[k] != 0)
            valid.push_back(k);
    if (valid.size() < 2)
        return {};
    const std::size_t count = std::min(valid.size(), most), channels = samples_.channels.size();
    std::vector<float> values(channels * count), expected(channels * count);
    parallel_pieces(count, pairs_a_piece, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const std::size_t k = valid[i * valid.size() / count];
            const auto [wi, wo] = samples_.directions->pair(k);
            interpolate(wi, wo, k, count, values.data() + i);
            for (std::size_t c = 0; c < channels; ++c)
                expected[c * count + i] = samples_.channel(c)[k];
        }
    });
    return relative_error(values, expected, channels);
}

} // namespace brdfit
