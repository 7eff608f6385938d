#pragma once

#include "host/directions.hpp"

#include <cmath>
#include <random>
#include <string>
#include <vector>

// Directions that reach everything a model does, and how its values there are compared.

namespace brdfit::test {

/// Beyond this, intermediate results of float32 may overflow: only finiteness is asked for.
inline constexpr double huge = 1e36;
/// Below this, intermediate results of float32 may vanish.
inline constexpr double tiny = 1e-30;

using Random = std::mt19937_64;
double uniform(Random& random, double lower = 0, double upper = 1);

struct Pair {
    Vector wi, wo;
};

/// Unit direction of height z; exact where z is as small as grazing angles make it.
Vector at_height(double z, double phi);
/// Direction with tangent `tangent` from the normal.
Vector at_tangent(double tangent, double phi);
/// w reflected about h.
Vector mirrored(const Vector& w, const Vector& h);

/// Two directions, each uniform over the hemisphere.
Pair random_pair(Random& random);
/// Random pairs of every kind in turn: uniform, grazing (heights down to 1e-7), mirrored about a
/// half vector near the normal, opposite, back along the same way.
Pair extreme_pair(Random& random, std::size_t kind);
/// Exact mirror, grazing on the same, the opposite and other sides, back along the same way, the
/// normal, the half vector at the horizon.
std::vector<Pair> special_pairs();
/// Pairs that reach everything a lobe does: random, with the half vector at every distance from the
/// normal, grazing, special.
std::vector<Pair> chosen_pairs();

Directions directions_of(const std::vector<Pair>& pairs);

/// Relative error of float32 in a product that goes through exp of a sum: the sum's rounding
/// counts.
double relative_tolerance(double value);

/// Counts mismatches and keeps the first few for the message.
class Mismatches {
  public:
    void check(bool good, const std::string& what, const Pair& pair, double value, double reference,
               double tolerance);
    void check_near(const std::string& what, const Pair& pair, double value, double reference,
                    double tolerance) {
        check_near(what, pair, value, reference, tolerance, [] { return 0.0; });
    }
    /// `more` is added to the tolerance where it is needed: it takes long to find.
    template <typename More>
    void check_near(const std::string& what, const Pair& pair, double value, double reference,
                    double tolerance, More more) {
        if (std::abs(value - reference) > tolerance)
            tolerance += more();
        check(std::abs(value - reference) <= tolerance, what, pair, value, reference, tolerance);
    }
    ~Mismatches(); ///< fails the test where there was any

  private:
    int count_ = 0;
    std::string text_;
};

} // namespace brdfit::test
