// The compressions phi of the losses that are not quadratic, of x = iz f; *slope = phi'(x), at the
// kink of log that towards x > 0.
static inline real compressed_log(real x, real* slope)
{
    const real y = 1.0f + fmax(x, (real)(0.0f));
    *slope = x >= 0.0f ? 1.0f / y : (real)(0.0f);
    return log(y);
}

// cbrt(x), continued below |x| = 1e-6 by the odd cubic that meets it with its slope there.
static inline real compressed_cbrt(real x, real* slope)
{
    const float epsilon = 1e-6f;
    const real u = x * (1.0f / epsilon);
    const real magnitude = fmax(fabs(x), (real)(epsilon));
    const real root = exp(log(magnitude) * (1.0f / 3.0f));
    const mask inside = fabs(u) < 1.0f;
    *slope = inside ? (4.0f - 3.0f * u * u) * 3333.3333f : root / (3.0f * magnitude);
    return inside ? u * (4.0f - u * u) * (0.01f / 3.0f) : copysign(root, x);
}

// Curvatures k of h(x) = (phi(x) - phi(y))^2 / 2, for p = phi(x) and q = phi(y) with slope phi'(x).
// Newton's own, phi'^2 + (p - q) phi'', kept positive; or for `secant` that of the parabola that
// meets h at x and has its minimum at y: it leads far where h is far from a parabola.
#define LEAST_CURVATURE 0.25f
#define MOST_CURVATURE 8.0f

static inline real curvature_log(real p, real q, real slope, int secant)
{
    const real share = secant ? (real)(1.0f) : 1.0f - (p - q);
    return slope * slope * clamp(share, (real)(LEAST_CURVATURE), (real)(MOST_CURVATURE));
}

static inline real curvature_cbrt(real p, real q, real slope, int secant)
{
    if (secant)
        return slope / fmax(p * p + p * q + q * q, (real)(1e-4f));
    const real share = 2.0f * q / fmax(p, (real)(1e-3f)) - 1.0f;
    return slope * slope * clamp(share, (real)(LEAST_CURVATURE), (real)(MOST_CURVATURE));
}
