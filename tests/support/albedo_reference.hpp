#pragma once

#include "host/directions.hpp"

#include <functional>
#include <string>
#include <vector>

namespace brdfit::test {

/// Integral over the hemisphere of wi, by its solid angle, in float64: Gauss-Legendre over the
/// slopes of the half vector in polar coordinates, each azimuth up to the very slope where wi meets
/// the horizon. `wo` is above the horizon; `scale`: slope at which the function falls off (the
/// lobe's roughness), panels shrink geometrically towards the lobe's centre, the horizon and the
/// places where the limits turn sharply. `kinks`: whether the function has kinks where models with
/// min or max of the cosines have them.
double hemisphere_integral(const std::function<double(const Vector& wi)>& f, const Vector& wo,
                           double scale, bool kinks = false);

/// Directional albedo of a model's reference (tests/support/reference_models.hpp), g iz over wi.
double reference_albedo(const std::string& model, bool isotropic, const std::vector<double>& theta,
                        const Vector& wo, double scale);

/// Directional albedo of GGX (height-correlated Smith) written out for itself, as tables need tens
/// of thousands of them: with Schlick's F, integral of g iz and of (1 - c)^5 g iz at f0 = 1, or
/// where ior > 0 of the dielectric Fresnel term in place of (1 - c)^5. alpha 0 is the mirror.
struct GgxAlbedo {
    double all, weighted;
};
GgxAlbedo ggx_albedo(double mu, double alpha, double ior = 0);

/// 2 integral of a function of mu times mu over [0, 1], for functions that change fast where mu is
/// small.
double average_over_cosine(const std::function<double(double mu)>& f);

} // namespace brdfit::test
