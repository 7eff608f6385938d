#pragma once

#include "host/directions.hpp"

#include <functional>
#include <vector>

namespace brdfit::test {

/// The microfacet generator once more, from Ashikhmin, Premoze, Shirley 2000 and in float64.
struct ReferenceDistribution {
    /// p(h), section 6; any direction of the sphere.
    std::function<double(const Vector& h)> p;
    /// Ends of pieces over which p is smooth, in the angles of h = (cos b sin a, sin b, cos b cos
    /// a).
    std::vector<double> a_ends, b_ends;
};

ReferenceDistribution reference_gaussian(double sigma_x, double sigma_y, double tilt = 0);
ReferenceDistribution reference_velvet(double sigma);
ReferenceDistribution reference_sum(double weight_1, const ReferenceDistribution& one,
                                    double weight_2, const ReferenceDistribution& two);

/// Integral of weight(h) p(h) over the h of the sphere with h.k > 0.
double integrate_facing(const ReferenceDistribution& distribution, const Vector& k,
                        const std::function<double(const Vector& h)>& weight);
/// g(k), Eq. 18.
double reference_area(const ReferenceDistribution& distribution, const Vector& k);
/// The integral of weight(h) p(h) over the sphere.
double integrate_sphere(const ReferenceDistribution& distribution,
                        const std::function<double(const Vector& h)>& weight);

} // namespace brdfit::test
