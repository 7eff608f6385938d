#include "host/directions.hpp"

#include <cmath>

namespace brdfit {

namespace {

double dot(const Vector& a, const Vector& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

} // namespace

Vector direction(double theta, double phi) {
    return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

void Directions::set(std::size_t k, const Vector& wi, const Vector& wo) {
    const Vector sum{wi[0] + wo[0], wi[1] + wo[1], wi[2] + wo[2]};
    const double length = std::sqrt(dot(sum, sum));
    if (length > 0)
        set(k, wi, wo, {sum[0] / length, sum[1] / length, sum[2] / length}, length / 2);
    else
        set(k, wi, wo, {0, 0, 1}, 0);
}

void Directions::set(std::size_t k, const Vector& wi, const Vector& wo, const Vector& h, double c) {
    for (std::size_t i = 0; i < 3; ++i) {
        plane(static_cast<Plane>(WiX + i))[k] = static_cast<float>(wi[i]);
        plane(static_cast<Plane>(WoX + i))[k] = static_cast<float>(wo[i]);
        plane(static_cast<Plane>(HX + i))[k] = static_cast<float>(h[i]);
    }
    plane(C)[k] = static_cast<float>(c);
}

std::pair<Vector, Vector> Directions::pair(std::size_t k) const {
    const Vector i = wi(k), o = wo(k), h = at(HX, k);
    const double c = plane(C)[k];
    if (c == 0)
        return {i, o};
    // wi and wo are c h + d and c h - d, with d perpendicular to h.
    Vector d{(i[0] - o[0]) / 2, (i[1] - o[1]) / 2, (i[2] - o[2]) / 2};
    const double along = dot(d, h) / dot(h, h);
    for (std::size_t a = 0; a < 3; ++a)
        d[a] -= along * h[a];
    const double scale = 1 / std::sqrt(dot(d, d) + c * c * dot(h, h));
    Vector first, second;
    for (std::size_t a = 0; a < 3; ++a) {
        first[a] = (c * h[a] + d[a]) * scale;
        second[a] = (c * h[a] - d[a]) * scale;
    }
    return {first, second};
}

} // namespace brdfit
