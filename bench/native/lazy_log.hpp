#pragma once

#include <algorithm>
#include <cmath>

namespace brdfit::bench::lazy {

// A constant function, so that the compiler takes the logarithm of one number once.
[[gnu::const]] double logarithm(double x);

/// A number v + log p whose logarithm is not taken before it must be. The kernels add logarithms
/// where plain float64 code multiplies, since float32 would overflow: for a fair baseline exp(v +
/// log p) is exp(v) p. Where p is known to be 1, as for all other numbers, nothing of this is left
/// in the program.
struct LazyLog {
    double v = 0, p = 1;
    LazyLog() = default;
    [[gnu::always_inline]] LazyLog(double value) : v(value) {}
    [[gnu::always_inline]] LazyLog(double value, double product) : v(value), p(product) {}
    [[gnu::always_inline]] double value() const { return p == 1 ? v : v + logarithm(p); }
};

#define LAZY [[gnu::always_inline]] inline

LAZY LazyLog operator+(LazyLog a, LazyLog b) {
    return {a.v + b.v, a.p * b.p};
}
LAZY LazyLog operator-(LazyLog a) {
    return {-a.v, a.p == 1 ? 1 : 1 / a.p};
}
LAZY LazyLog operator-(LazyLog a, LazyLog b) {
    return {a.v - b.v, b.p == 1 ? a.p : a.p / b.p};
}
LAZY LazyLog times(LazyLog a, double c) {
    if (a.p == 1)
        return a.v * c;
    const double squared = a.p * a.p;
    // Powers that the compiler knows; others need the logarithm.
    if (__builtin_constant_p(c == 0.5) && c == 0.5)
        return {a.v * c, std::sqrt(a.p)};
    if (__builtin_constant_p(c == 2) && c == 2)
        return {a.v * c, squared};
    if (__builtin_constant_p(c == 3) && c == 3)
        return {a.v * c, squared * a.p};
    if (__builtin_constant_p(c == 4) && c == 4)
        return {a.v * c, squared * squared};
    return a.value() * c;
}
LAZY LazyLog operator*(LazyLog a, LazyLog b) {
    if (a.p == 1)
        return times(b, a.v);
    if (b.p == 1)
        return times(a, b.v);
    return a.value() * b.value();
}
LAZY LazyLog operator/(LazyLog a, LazyLog b) {
    return a.value() / b.value();
}
LAZY LazyLog& operator+=(LazyLog& a, LazyLog b) {
    return a = a + b;
}
LAZY LazyLog& operator-=(LazyLog& a, LazyLog b) {
    return a = a - b;
}
LAZY LazyLog& operator*=(LazyLog& a, LazyLog b) {
    return a = a * b;
}
LAZY bool operator<(LazyLog a, LazyLog b) {
    return a.value() < b.value();
}
LAZY bool operator>(LazyLog a, LazyLog b) {
    return a.value() > b.value();
}
LAZY bool operator<=(LazyLog a, LazyLog b) {
    return a.value() <= b.value();
}
LAZY bool operator>=(LazyLog a, LazyLog b) {
    return a.value() >= b.value();
}
LAZY bool operator==(LazyLog a, LazyLog b) {
    return a.value() == b.value();
}
LAZY LazyLog log(LazyLog x) {
    return {0, x.value()};
}
LAZY LazyLog exp(LazyLog x) {
    return std::exp(x.v) * x.p;
}
// The smaller of two logarithms is that of the smaller number.
LAZY LazyLog fmin(LazyLog a, LazyLog b) {
    return a.v == b.v ? LazyLog(a.v, std::min(a.p, b.p)) : LazyLog(std::min(a.value(), b.value()));
}
LAZY LazyLog fmax(LazyLog a, LazyLog b) {
    return a.v == b.v ? LazyLog(a.v, std::max(a.p, b.p)) : LazyLog(std::max(a.value(), b.value()));
}
LAZY LazyLog sqrt(LazyLog x) {
    return std::sqrt(x.value());
}
LAZY LazyLog rsqrt(LazyLog x) {
    return 1 / std::sqrt(x.value());
}
LAZY LazyLog fabs(LazyLog x) {
    return std::fabs(x.value());
}
LAZY LazyLog rint(LazyLog x) {
    return std::rint(x.value());
}
LAZY LazyLog log1p(LazyLog x) {
    return std::log1p(x.value());
}

#undef LAZY

} // namespace brdfit::bench::lazy
