#include "tests/support/reference_models.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>

namespace brdfit {

namespace {

// Products like hz^4 and differences like 1 - hz^2 near the pole want more than float64.
using Real = long double;

constexpr Real pi = 3.141592653589793238462643383279502884L;

/// Cosines of two directions above the horizon and their half vector.
struct Geometry {
    Real iz, oz;     ///< wi.n, wo.n
    Real hx, hy, hz; ///< h = (wi + wo) / |wi + wo|
    Real c;          ///< wi.h = wo.h
    Vector wi, wo;

    Geometry(const Vector& light, const Vector& viewer)
        : iz(light[2]), oz(viewer[2]), wi(light), wo(viewer) {
        const Real sx = Real(wi[0]) + wo[0], sy = Real(wi[1]) + wo[1], sz = Real(wi[2]) + wo[2];
        const Real length = std::sqrt(sx * sx + sy * sy + sz * sz);
        hx = sx / length;
        hy = sy / length;
        hz = sz / length;
        c = length / 2; // (wi + wo).h = 2 c, and nothing cancels
    }
};

/// The non-linear parameters of one lobe; a model uses those it has. An isotropic lobe has one
/// roughness, x = y.
struct Theta {
    Real f0, x, y, alpha;
};

Real schlick(const Geometry& q, Real f0) {
    return f0 + (1 - f0) * std::pow(1 - q.c, 5);
}

/// exp(-tan^2 (cos^2 phi / mx^2 + sin^2 phi / my^2)) of the half vector.
Real beckmann_exponential(const Geometry& q, Real mx, Real my) {
    return std::exp(-(std::pow(q.hx / mx, 2) + std::pow(q.hy / my, 2)) / (q.hz * q.hz));
}

/// Beckmann's distribution: the integral of D hz is 1.
Real beckmann(const Geometry& q, Real mx, Real my) {
    return beckmann_exponential(q, mx, my) / (pi * mx * my * std::pow(q.hz, 4));
}

Real kurt(const Geometry& q, const Theta& t) {
    return schlick(q, t.f0) * beckmann(q, t.x, t.y) / (4 * q.c * std::pow(q.iz * q.oz, t.alpha));
}

Real kurt_plausible(const Geometry& q, const Theta& t) {
    return schlick(q, t.f0) * beckmann(q, t.x, t.y) / (4 * q.c * std::max(q.iz, q.oz));
}

Real ward(const Geometry& q, const Theta& t) {
    return beckmann_exponential(q, t.x, t.y) / (4 * pi * t.x * t.y * std::sqrt(q.iz * q.oz));
}

Real ward_duer(const Geometry& q, const Theta& t) {
    return beckmann_exponential(q, t.x, t.y) / (4 * pi * t.x * t.y * q.iz * q.oz);
}

Real cook_torrance(const Geometry& q, const Theta& t) {
    const Real masking = 2 * q.hz * q.oz / q.c, shadowing = 2 * q.hz * q.iz / q.c;
    const Real g = std::min({Real(1), masking, shadowing});
    return schlick(q, t.f0) * beckmann(q, t.x, t.x) * g / (4 * q.iz * q.oz);
}

Real ashikhmin_shirley(const Geometry& q, const Theta& t) {
    // (nu h.x^2 + nv h.y^2) / (1 - hz^2), where 1 - hz^2 = h.x^2 + h.y^2; at the pole hz^e is 1.
    const Real s = q.hx * q.hx + q.hy * q.hy;
    const Real e = s > 0 ? (t.x * q.hx * q.hx + t.y * q.hy * q.hy) / s : 0;
    // hz rounds to 1 near the pole, s does not.
    const Real log_hz = s < 0.5L ? std::log1p(-s) / 2 : std::log(q.hz);
    return std::sqrt((t.x + 1) * (t.y + 1)) / (8 * pi) * std::exp(e * log_hz) * schlick(q, t.f0) /
           (q.c * std::max(q.iz, q.oz));
}

Real ashikhmin_premoze(const Geometry& q, const Theta& t) {
    return schlick(q, t.f0) * beckmann(q, t.x, t.y) / (4 * (q.iz + q.oz - q.iz * q.oz));
}

Real ward_gmd(const Geometry& q, const Theta& t) {
    // H = wi + wo is 2 c h.
    const Real h_squared = 4 * q.c * q.c, hz = 2 * q.c * q.hz;
    return beckmann_exponential(q, t.x, t.y) * h_squared / (pi * t.x * t.y * std::pow(hz, 4));
}

Real edwards(const Geometry& q, const Theta& t) {
    const Real s = q.hx * q.hx + q.hy * q.hy;
    const Real e = s > 0 ? (t.x * q.hx * q.hx + t.y * q.hy * q.hy) / s : 0;
    const Real log_hz2 = s < 0.5L ? std::log1p(-s) : 2 * std::log(q.hz);
    const Real p = q.hz * std::sqrt((t.x + 1) * (t.y + 1)) / pi * std::exp(e * log_hz2);
    return schlick(q, t.f0) * p / (4 * q.c * q.iz);
}

/// theta: Cx, Cy and, in place of alpha, n.
Real lafortune(const Geometry& q, const Theta& t) {
    const Real base = t.x * q.wi[0] * q.wo[0] + t.y * q.wi[1] * q.wo[1] + q.iz * q.oz;
    const Real scale = std::max({Real(1), std::abs(t.x), std::abs(t.y)});
    return std::pow(std::max(Real(0), base) / scale, t.alpha);
}

Real ggx(const Geometry& q, const Theta& t) {
    const Real e = std::pow(q.hx / t.x, 2) + std::pow(q.hy / t.y, 2) + q.hz * q.hz;
    const Real d = 1 / (pi * t.x * t.y * e * e);
    const auto lambda = [&](const Vector& w) {
        const Real slope2 =
            (std::pow(w[0] * t.x, 2) + std::pow(w[1] * t.y, 2)) / (Real(w[2]) * w[2]);
        return (std::sqrt(1 + slope2) - 1) / 2;
    };
    return schlick(q, t.f0) * d / (1 + lambda(q.wi) + lambda(q.wo)) / (4 * q.iz * q.oz);
}

Real ggx_uncorrelated(const Geometry& q, const Theta& t) {
    const Real e = std::pow(q.hx / t.x, 2) + std::pow(q.hy / t.y, 2) + q.hz * q.hz;
    const Real d = 1 / (pi * t.x * t.y * e * e);
    const auto g1 = [&](const Vector& w) {
        const Real slope2 =
            (std::pow(w[0] * t.x, 2) + std::pow(w[1] * t.y, 2)) / (Real(w[2]) * w[2]);
        return 2 / (1 + std::sqrt(1 + slope2));
    };
    return schlick(q, t.f0) * d * g1(q.wi) * g1(q.wo) / (4 * q.iz * q.oz);
}

Real beckmann_smith(const Geometry& q, const Theta& t) {
    const auto lambda = [&](const Vector& w) {
        const Real projected = std::hypot(w[0] * t.x, w[1] * t.y);
        if (projected == 0)
            return Real(0);
        const Real a = w[2] / projected;
        return (std::exp(-a * a) / (a * std::sqrt(pi)) - std::erfc(a)) / 2;
    };
    return schlick(q, t.f0) * beckmann(q, t.x, t.y) / (1 + lambda(q.wi) + lambda(q.wo)) /
           (4 * q.iz * q.oz);
}

Real ashikhmin_shirley_diffuse(const Geometry& q, const Theta& t) {
    const auto bracket = [](Real z) { return 1 - std::pow(1 - z / 2, 5); };
    return 28 / (23 * pi) * (1 - t.f0) * bracket(q.iz) * bracket(q.oz);
}

Real blinn_phong(const Geometry& q, const Theta& t) {
    return (t.x + 2) / (2 * pi) * std::pow(q.hz, t.x);
}

Real lambert(const Geometry&, const Theta&) {
    return 1 / pi;
}

Real kurt_coupled(const Geometry& q, const Theta& t) {
    return (1 - schlick(q, t.f0)) / pi;
}

/// A model's formula and which parameters theta lists, in this order: f0, roughness (one in the
/// isotropic form, else `roughnesses`), alpha.
struct Reference {
    Real (*value)(const Geometry&, const Theta&);
    bool fresnel;
    std::size_t roughnesses;
    bool alpha;
};

const std::map<std::string, Reference> references = {
    {"lambert", {lambert, false, 0, false}},
    {"kurt", {kurt, true, 2, true}},
    {"kurt-coupled", {kurt_coupled, true, 0, false}},
    {"kurt-plausible", {kurt_plausible, true, 2, false}},
    {"ward", {ward, false, 2, false}},
    {"ward-duer", {ward_duer, false, 2, false}},
    {"cook-torrance", {cook_torrance, true, 1, false}},
    {"ashikhmin-shirley", {ashikhmin_shirley, true, 2, false}},
    {"blinn-phong", {blinn_phong, false, 1, false}},
    {"ashikhmin-premoze", {ashikhmin_premoze, true, 2, false}},
    {"edwards", {edwards, true, 2, false}},
    {"lafortune", {lafortune, false, 2, true}},
    {"ward-gmd", {ward_gmd, false, 2, false}},
    {"ggx", {ggx, true, 2, false}},
    {"ggx-uncorrelated", {ggx_uncorrelated, true, 2, false}},
    {"beckmann-smith", {beckmann_smith, true, 2, false}},
    {"ashikhmin-shirley-diffuse", {ashikhmin_shirley_diffuse, true, 0, false}},
};

Theta read_theta(const Reference& reference, bool isotropic, const std::vector<double>& theta) {
    std::size_t next = 0;
    Theta t{};
    if (reference.fresnel)
        t.f0 = theta.at(next++);
    if (reference.roughnesses > 0)
        t.x = t.y = theta.at(next++);
    if (reference.roughnesses > 1 && !isotropic)
        t.y = theta.at(next++);
    if (reference.alpha)
        t.alpha = theta.at(next++);
    if (next != theta.size())
        throw std::invalid_argument("theta has another length than the reference's");
    return t;
}

/// The model's value after `change` to the geometry.
template <typename Change>
double value_at(const std::string& model, bool isotropic, const std::vector<double>& theta,
                const Vector& wi, const Vector& wo, Change change) {
    const auto found = references.find(model);
    if (found == references.end())
        throw std::invalid_argument("no reference for the model " + model);
    const Theta t = read_theta(found->second, isotropic, theta);
    if (wi[2] <= 0 || wo[2] <= 0)
        return 0;
    Geometry q(wi, wo);
    change(q);
    return static_cast<double>(found->second.value(q, t));
}

} // namespace

double reference_value(const std::string& model, bool isotropic, const std::vector<double>& theta,
                       const Vector& wi, const Vector& wo) {
    return value_at(model, isotropic, theta, wi, wo, [](Geometry&) {});
}

double reference_value_rounded(const std::string& model, bool isotropic,
                               const std::vector<double>& theta, const Vector& wi, const Vector& wo,
                               std::size_t k, double change) {
    return value_at(model, isotropic, theta, wi, wo, [&](Geometry& q) {
        double& component = k < 3 ? q.wi.at(k) : q.wo.at(k - 3);
        component *= 1 + change * double{std::numeric_limits<float>::epsilon()};
        q.iz = q.wi[2];
        q.oz = q.wo[2];
    });
}

Vector seen_turned(const Vector& v, double degrees) {
    const double c = std::cos(degrees * degree), s = std::sin(degrees * degree);
    return {c * v[0] + s * v[1], c * v[1] - s * v[0], v[2]};
}

double reference_evaluate(const Material& material, std::size_t channel, const Vector& wi,
                          const Vector& wo) {
    std::vector<double> coupled;
    if (!material.diffuse->lobe.empty())
        coupled = {material.lobes.at(0).theta.at(0)};
    double f =
        material.kd[channel] * reference_value(material.diffuse->name, true, coupled, wi, wo);
    for (const Lobe& lobe : material.lobes) {
        std::vector<double> theta = lobe.theta;
        double angle = 0;
        if (lobe.model->turns) {
            angle = theta.back();
            theta.pop_back();
        }
        f += lobe.ks[channel] * reference_value(lobe.model->name, lobe.isotropic, theta,
                                                seen_turned(wi, angle), seen_turned(wo, angle));
    }
    return f;
}

} // namespace brdfit
