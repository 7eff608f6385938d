// The Beckmann exponential that the Kurt and Ward families and Cook-Torrance share.
//
// Each of these models is exp(-t + k) / (mx my), with t = (h.x/mx)^2/hz^2 + (h.y/my)^2/hz^2 and k the
// logarithm of what depends on the directions alone; merging all factors into one exponential keeps
// it finite where hz^-4 overflows and exp(-t) vanishes.
// ROUGHNESSES: 1 (isotropic form, one plane tan2) or 2 (planes tan2_x, tan2_y).

static inline void beckmann_prepare(geometry q, real* plane)
{
#if ROUGHNESSES == 1
    plane[0] = tan2_x(q) + tan2_y(q);
#else
    plane[0] = tan2_x(q);
    plane[1] = tan2_y(q);
#endif
}

// exp(exponent - t) / (mx my), and in d[] the derivative of its logarithm by each roughness.
static inline real beckmann(const real* plane, real exponent, PARAMETER_SPACE const float* m, real* d)
{
#if ROUGHNESSES == 1
    const float inverse = 1.0f / m[0];
    const real t = plane[0] * (inverse * inverse);
    d[0] = (2.0f * inverse) * (t - 1.0f);
    return exp(exponent - t) * (inverse * inverse);
#else
    const float ix = 1.0f / m[0];
    const float iy = 1.0f / m[1];
    const real tx = plane[0] * (ix * ix);
    const real ty = plane[1] * (iy * iy);
    d[0] = ix * (2.0f * tx - 1.0f);
    d[1] = iy * (2.0f * ty - 1.0f);
    return exp(exponent - tx - ty) * (ix * iy);
#endif
}
