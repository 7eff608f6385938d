#include "bench/native/scalar.hpp"

#include "bench/native/scalar_models.hpp"
#include "fit/nonnegative.hpp"
#include "host/error.hpp"
#include "host/evaluate/sample.hpp"

#include <array>
#include <map>
#include <memory>

namespace brdfit::bench {

namespace {

using lazy::LazyLog;

constexpr std::size_t channels = 3;
constexpr int most_parameters = 4;
constexpr std::size_t most_planes = 16;

constexpr bool is_lambert(const char* name) {
    return std::string_view(name) == "lambert";
}
// Planes of a diffuse shape, which come before the lobe's.
constexpr int diffuse_planes(const char* name) {
    return is_lambert(name) ? 0 : 1;
}

// Half vector and c from the directions alone.
template <typename Geometry>
Geometry geometry_between(const Vector& wi, const Vector& wo) {
    const double x = wi[0] + wo[0], y = wi[1] + wo[1], z = wi[2] + wo[2];
    const double length = std::sqrt(x * x + y * y + z * z), inverse = 1 / length;
    return {wi[0], wi[1],       wi[2],       wo[0],       wo[1],
            wo[2], x * inverse, y * inverse, z * inverse, 0.5 * length};
}

// A diffuse shape and a lobe, or the shape alone, as a type whose functions the loops below inline.
#define DEFINE_SHAPE(DIFFUSE, LOBE)                                                                \
    struct DIFFUSE##_##LOBE {                                                                      \
        static constexpr int basis = 2;                                                            \
        [[gnu::always_inline]] static void prepare(const scalar::geometry& q, LazyLog* plane) {    \
            scalar::DIFFUSE##_prepare(q, plane);                                                   \
            scalar::LOBE##_prepare(q, plane + diffuse_planes(#DIFFUSE));                           \
        }                                                                                          \
        [[gnu::always_inline]] static void value(const LazyLog* plane, const double* theta,        \
                                                 int parameters, LazyLog* b, LazyLog* d) {         \
            b[0] = scalar::DIFFUSE(plane, theta, d + parameters);                                  \
            b[1] = scalar::LOBE(plane + diffuse_planes(#DIFFUSE), theta, d);                       \
        }                                                                                          \
        static scalar::geometry draw(scalar::vector wo, const double* theta, LazyLog u1,           \
                                     LazyLog u2) {                                                 \
            return scalar::LOBE##_sample(wo, theta, u1, u2);                                       \
        }                                                                                          \
        static double density(const scalar::geometry& q, const double* theta) {                    \
            return scalar::LOBE##_density(q, theta).value();                                       \
        }                                                                                          \
        static void count_prepare(const counted::geometry& q, double* plane) {                     \
            counted::DIFFUSE##_prepare(q, plane);                                                  \
            counted::LOBE##_prepare(q, plane + diffuse_planes(#DIFFUSE));                          \
        }                                                                                          \
        static void count_value(const double* plane, const double* theta, double* d) {             \
            counted::DIFFUSE(plane, theta, d);                                                     \
            counted::LOBE(plane + diffuse_planes(#DIFFUSE), theta, d);                             \
        }                                                                                          \
        static counted::geometry count_draw(counted::vector wo, const double* theta, double u1,    \
                                            double u2) {                                           \
            return counted::LOBE##_sample(wo, theta, u1, u2);                                      \
        }                                                                                          \
        static double count_density(const counted::geometry& q, const double* theta) {             \
            return counted::LOBE##_density(q, theta);                                              \
        }                                                                                          \
    };
#define DEFINE_DIFFUSE(DIFFUSE)                                                                    \
    struct DIFFUSE##_alone {                                                                       \
        static constexpr int basis = 1;                                                            \
        [[gnu::always_inline]] static void prepare(const scalar::geometry& q, LazyLog* plane) {    \
            scalar::DIFFUSE##_prepare(q, plane);                                                   \
        }                                                                                          \
        [[gnu::always_inline]] static void value(const LazyLog* plane, const double* theta,        \
                                                 int parameters, LazyLog* b, LazyLog* d) {         \
            b[0] = scalar::DIFFUSE(plane, theta, d + parameters);                                  \
        }                                                                                          \
        static scalar::geometry draw(scalar::vector wo, const double*, LazyLog u1, LazyLog u2) {   \
            return scalar::cosine_sample(wo, u1, u2);                                              \
        }                                                                                          \
        static double density(const scalar::geometry& q, const double*) {                          \
            return scalar::cosine_density(q).value();                                              \
        }                                                                                          \
        static void count_prepare(const counted::geometry& q, double* plane) {                     \
            counted::DIFFUSE##_prepare(q, plane);                                                  \
        }                                                                                          \
        static void count_value(const double* plane, const double* theta, double* d) {             \
            counted::DIFFUSE(plane, theta, d);                                                     \
        }                                                                                          \
        static counted::geometry count_draw(counted::vector wo, const double*, double u1,          \
                                            double u2) {                                           \
            return counted::cosine_sample(wo, u1, u2);                                             \
        }                                                                                          \
        static double count_density(const counted::geometry& q, const double*) {                   \
            return counted::cosine_density(q);                                                     \
        }                                                                                          \
    };
FOR_EACH_SHAPE(DEFINE_SHAPE)
FOR_EACH_DIFFUSE(DEFINE_DIFFUSE)

// Where the loop finds what depends on the directions: computed, or in a row of memory.
struct FromDirections {
    const std::vector<ScalarSample>& samples;
    std::size_t count() const { return samples.size(); }
    template <typename Shape>
    [[gnu::always_inline]] void planes(std::size_t k, LazyLog* plane) const {
        Shape::prepare(geometry_between<scalar::geometry>(samples[k].wi, samples[k].wo), plane);
    }
    const double* values(std::size_t k) const { return samples[k].y.data(); }
    double weight(std::size_t k) const { return samples[k].weight; }
};
struct FromRows {
    const std::vector<double>& rows; // and most_planes more, so that all can be read of the last
    std::size_t row;                 // doubles a sample: planes, channels, weight
    std::size_t count() const { return (rows.size() - most_planes) / row; }
    template <typename Shape>
    [[gnu::always_inline]] void planes(std::size_t k, LazyLog* plane) const {
        for (std::size_t p = 0; p < most_planes; ++p)
            plane[p] = rows[k * row + p];
    }
    const double* values(std::size_t k) const { return rows.data() + (k + 1) * row - channels - 1; }
    double weight(std::size_t k) const { return rows[(k + 1) * row - 1]; }
};

// The shape's values and derivatives as numbers.
template <typename Shape, int parameters>
[[gnu::always_inline]] inline void values_at(const LazyLog* plane, const double* theta, double* b,
                                             double* d) {
    LazyLog lazy_b[2], lazy_d[parameters + 2];
    Shape::value(plane, theta, parameters, lazy_b, lazy_d);
    for (int j = 0; j < Shape::basis; ++j)
        b[j] = lazy_b[j].value();
    for (int e = 0; e < parameters + 2; ++e)
        d[e] = lazy_d[e].value();
}

// The sums of ScalarSums, with numbers of unknowns and derivatives that the compiler knows.
template <typename Shape, int parameters, bool coupled, Sums wanted, typename Source>
ScalarSums sums_of(const Source source, const double* theta) {
    constexpr int basis = Shape::basis, entries = wanted == Sums::Basis ? 0 : parameters + coupled;
    constexpr int all = basis * (basis + 1) / 2 + basis * 3 + 1 + entries * (basis + 3) +
                        (wanted == Sums::Normal ? entries * (entries + 1) / 2 : 0);
    double sum[all] = {};
    const std::size_t count = source.count();
    for (std::size_t i = 0; i < count; ++i) {
        LazyLog plane[most_planes];
        double b[2], d[parameters + 2];
        source.template planes<Shape>(i, plane);
        values_at<Shape, parameters>(plane, theta, b, d);
        const double* const y = source.values(i);
        const double w = source.weight(i);
        int k = 0;
        for (int j = 0; j < basis; ++j)
            for (int l = 0; l <= j; ++l)
                sum[k++] += w * b[j] * b[l];
        for (std::size_t ch = 0; ch < channels; ++ch) {
            const double wy = w * y[ch];
            for (int j = 0; j < basis; ++j)
                sum[k++] += wy * b[j];
        }
        sum[k++] += w * (y[0] * y[0] + y[1] * y[1] + y[2] * y[2]);
        for (int e = 0; e < entries; ++e) {
            const double wd = w * d[e];
            for (int j = 0; j < basis; ++j)
                sum[k++] += wd * b[j];
            for (std::size_t ch = 0; ch < channels; ++ch)
                sum[k++] += wd * y[ch];
        }
        if (wanted == Sums::Normal)
            for (int e = 0; e < entries; ++e)
                for (int f = 0; f <= e; ++f)
                    sum[k++] += w * d[e] * d[f];
    }
    return {sum, sum + all};
}

template <typename Shape, int parameters, bool coupled, typename Source>
ScalarSums sums_of(const Source source, const double* theta, Sums wanted) {
    switch (wanted) {
    case Sums::Basis:
        return sums_of<Shape, parameters, coupled, Sums::Basis>(source, theta);
    case Sums::Gradient:
        return sums_of<Shape, parameters, coupled, Sums::Gradient>(source, theta);
    case Sums::Normal:
        break;
    }
    if constexpr (std::is_same_v<Source, FromDirections>)
        return sums_of<Shape, parameters, coupled, Sums::Normal>(source, theta);
    return {};
}

template <typename Shape, bool coupled, typename Source>
ScalarSums sums_for(const Source source, const double* theta, int parameters, Sums wanted) {
    if constexpr (Shape::basis == 1)
        return sums_of<Shape, 0, coupled>(source, theta, wanted);
    else
        switch (parameters) {
        case 1:
            return sums_of<Shape, 1, coupled>(source, theta, wanted);
        case 2:
            return sums_of<Shape, 2, coupled>(source, theta, wanted);
        case 3:
            return sums_of<Shape, 3, coupled>(source, theta, wanted);
        default:
            return sums_of<Shape, most_parameters, coupled>(source, theta, wanted);
        }
}

template <typename Shape>
std::vector<double> rows_of(const std::vector<ScalarSample>& samples, std::size_t planes) {
    const std::size_t row = planes + channels + 1;
    std::vector<double> rows(samples.size() * row + most_planes);
    for (std::size_t k = 0; k < samples.size(); ++k) {
        double* const to = rows.data() + k * row;
        LazyLog plane[most_planes];
        Shape::prepare(geometry_between<scalar::geometry>(samples[k].wi, samples[k].wo), plane);
        for (std::size_t p = 0; p < planes; ++p)
            to[p] = plane[p].value();
        std::copy(samples[k].y.begin(), samples[k].y.end(), to + planes);
        to[row - 1] = samples[k].weight;
    }
    return rows;
}

template <typename Shape>
void evaluate_with(const std::vector<ScalarSample>& samples, const double* theta, const double* a,
                   double* f) {
    for (std::size_t i = 0; i < samples.size(); ++i) {
        LazyLog plane[most_planes];
        double b[2] = {0, 0}, d[most_parameters + 2];
        Shape::prepare(geometry_between<scalar::geometry>(samples[i].wi, samples[i].wo), plane);
        values_at<Shape, most_parameters>(plane, theta, b, d);
        for (std::size_t ch = 0; ch < channels; ++ch)
            f[channels * i + ch] = a[2 * ch] * b[0] + a[2 * ch + 1] * b[1];
    }
}

template <typename Shape>
void draw_with(std::size_t n, const Vector& wo, const std::uint32_t* scrambles, const double* theta,
               const double* full_theta, double* out) {
    for (std::size_t i = 0; i < n; ++i) {
        const auto index = static_cast<std::uint32_t>(i);
        const LazyLog u1 = scalar::unit_interval(scalar::sobol_0(index, scrambles[0]));
        const LazyLog u2 = scalar::unit_interval(scalar::sobol_1(index, scrambles[1]));
        const scalar::geometry q = Shape::draw({wo[0], wo[1], wo[2]}, full_theta, u1, u2);
        out[3 * i] = q.wi_z.value();
        out[3 * i + 1] = out[3 * i + 2] = 0;
        if (!(q.wi_z > 0))
            continue;
        LazyLog plane[most_planes];
        double b[2], d[most_parameters + 2];
        Shape::prepare(q, plane);
        values_at<Shape, most_parameters>(plane, theta, b, d);
        out[3 * i + 1] = Shape::density(q, full_theta);
        out[3 * i + 2] = b[Shape::basis - 1] * out[3 * i] / out[3 * i + 1];
    }
}

Calls calls_since(const CallCounts& before, std::size_t n) {
    return {static_cast<double>(call_counts.exp - before.exp) / static_cast<double>(n),
            static_cast<double>(call_counts.log - before.log) / static_cast<double>(n)};
}

template <typename Shape>
ScalarModel::Counts count_with(const std::vector<ScalarSample>& samples, const double* theta) {
    constexpr std::size_t enough = 1024;
    const std::size_t step = std::max<std::size_t>(samples.size() / enough, 1);
    const std::size_t n = (samples.size() + step - 1) / step;
    std::vector<std::array<double, most_planes>> planes(n);
    ScalarModel::Counts counts;
    CallCounts before = call_counts;
    for (std::size_t i = 0; i < n; ++i)
        Shape::count_prepare(
            geometry_between<counted::geometry>(samples[i * step].wi, samples[i * step].wo),
            planes[i].data());
    counts.prepare = calls_since(before, n);
    before = call_counts;
    double d[most_parameters + 2];
    for (const auto& plane : planes)
        Shape::count_value(plane.data(), theta, d);
    counts.value = calls_since(before, n);
    return counts;
}

template <typename Shape>
Calls count_draws_with(std::size_t n, const Vector& wo, const std::uint32_t* scrambles,
                       const double* theta, const double* full_theta) {
    const CallCounts before = call_counts;
    for (std::size_t i = 0; i < n; ++i) {
        const auto index = static_cast<std::uint32_t>(i);
        const counted::geometry q =
            Shape::count_draw({wo[0], wo[1], wo[2]}, full_theta,
                              counted::unit_interval(counted::sobol_0(index, scrambles[0])),
                              counted::unit_interval(counted::sobol_1(index, scrambles[1])));
        if (!(q.wi_z > 0))
            continue;
        double plane[most_planes], d[most_parameters + 2];
        Shape::count_prepare(q, plane);
        Shape::count_value(plane, theta, d);
        Shape::count_density(q, full_theta);
    }
    return calls_since(before, n);
}

template <typename Shape, bool coupled>
ScalarModel model_of() {
    return {Shape::basis,
            coupled,
            [](const std::vector<ScalarSample>& samples, const double* theta, int parameters,
               Sums wanted) {
                return sums_for<Shape, coupled>(FromDirections{samples}, theta, parameters, wanted);
            },
            rows_of<Shape>,
            [](const std::vector<double>& rows, std::size_t planes, const double* theta,
               int parameters, Sums wanted) {
                return sums_for<Shape, coupled>(FromRows{rows, planes + channels + 1}, theta,
                                                parameters, wanted);
            },
            evaluate_with<Shape>,
            draw_with<Shape>,
            count_with<Shape>,
            count_draws_with<Shape>};
}

using Key = std::pair<std::string, std::string>;
const std::map<Key, ScalarModel>& models() {
#define ADD_SHAPE(DIFFUSE, LOBE)                                                                   \
    {{#DIFFUSE, #LOBE}, model_of<DIFFUSE##_##LOBE, !is_lambert(#DIFFUSE)>()},
#define ADD_DIFFUSE(DIFFUSE) {{#DIFFUSE, ""}, model_of<DIFFUSE##_alone, !is_lambert(#DIFFUSE)>()},
    static const std::map<Key, ScalarModel> all = {FOR_EACH_SHAPE(ADD_SHAPE)
                                                       FOR_EACH_DIFFUSE(ADD_DIFFUSE)};
    return all;
}

} // namespace

double lazy::logarithm(double x) {
    return std::log(x);
}

const ScalarModel* ScalarModel::find(const Structure& structure) {
    if (structure.lobes.size() > 1 || !structure.isotropic ||
        structure.diffuse->isotropic_planes != diffuse_planes(structure.diffuse->name.c_str()) ||
        layout_of(structure).parameters.size() > most_parameters ||
        layout_of(structure).planes > static_cast<int>(most_planes))
        return nullptr;
    const auto found =
        models().find({structure.diffuse->identifier(),
                       structure.lobes.empty() ? std::string() : structure.lobes[0]->identifier()});
    return found == models().end() ? nullptr : &found->second;
}

namespace {

SmallMatrix gram_of(const ScalarModel& model, const ScalarSums& sums) {
    SmallMatrix gram(model.basis, model.basis);
    std::size_t k = 0;
    for (int j = 0; j < model.basis; ++j)
        for (int l = 0; l <= j; ++l, ++k)
            gram(j, l) = gram(l, j) = sums[k];
    return gram;
}

} // namespace

std::vector<SmallVector> coefficients(const ScalarModel& model, const ScalarSums& sums) {
    const SmallMatrix gram = gram_of(model, sums);
    auto k = static_cast<std::size_t>(model.basis * (model.basis + 1) / 2);
    std::vector<SmallVector> a;
    for (std::size_t ch = 0; ch < channels; ++ch) {
        SmallVector projected(model.basis);
        for (int j = 0; j < model.basis; ++j)
            projected[j] = sums[k++];
        a.push_back(solve_nonnegative(gram, projected, 0, SmallVector::Zero(model.basis)).a);
    }
    return a;
}

std::vector<double> solved(const ScalarModel& model, const ScalarSums& sums, int parameters,
                           bool gradient, std::size_t count) {
    const int basis = model.basis;
    const SmallMatrix gram = gram_of(model, sums);
    const std::vector<SmallVector> a = coefficients(model, sums);
    auto k = static_cast<std::size_t>(basis * (basis + 1) / 2);
    double error = sums[k + static_cast<std::size_t>(basis) * channels];
    for (std::size_t ch = 0; ch < channels; ++ch) {
        error += a[ch].dot(gram * a[ch]);
        for (int j = 0; j < basis; ++j)
            error -= 2 * a[ch][j] * sums[k++];
    }
    ++k;
    std::vector<double> answer{error};
    if (gradient) {
        answer.resize(1 + static_cast<std::size_t>(parameters));
        const int entries = parameters + (model.coupled ? 1 : 0);
        for (int e = 0; e < entries; ++e, k += static_cast<std::size_t>(basis) + channels) {
            const bool of_diffuse = e == parameters;
            const std::size_t parameter = of_diffuse ? 0 : static_cast<std::size_t>(e);
            for (std::size_t ch = 0; ch < channels; ++ch) {
                double pull = sums[k + static_cast<std::size_t>(basis) + ch];
                for (int j = 0; j < basis; ++j)
                    pull -= a[ch][j] * sums[k + static_cast<std::size_t>(j)];
                answer[1 + parameter] -= 2 * a[ch][of_diffuse ? 0 : basis - 1] * pull;
            }
        }
    }
    for (double& value : answer)
        value /= static_cast<double>(count * channels);
    return answer;
}

std::vector<ScalarSample> scalar_samples(const Samples& samples) {
    std::vector<ScalarSample> all;
    double weights = 0;
    for (std::size_t k = 0; k < samples.count(); ++k) {
        if (samples.valid[k] == 0)
            continue;
        const Vector wi = samples.directions->wi(k);
        all.push_back({wi,
                       samples.directions->wo(k),
                       {samples.channel(0)[k], samples.channel(1)[k], samples.channel(2)[k]},
                       samples.weights[k] * wi[2] * wi[2]});
        weights += samples.weights[k];
    }
    for (ScalarSample& s : all)
        s.weight *= static_cast<double>(all.size()) / weights;
    return all;
}

} // namespace brdfit::bench
