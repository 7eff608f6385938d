// The power of the half vector's cosine that Ashikhmin-Shirley and Edwards share: hz^(scale e) with
//     e = nx cos^2 phi_h + ny sin^2 phi_h
// ROUGHNESSES: 1 (isotropic form, one plane) or 2.

// scale log(hz) for each exponent, so that they add up to scale e log(hz).
static inline void cosine_power_prepare(geometry q, float scale, real* plane)
{
#if ROUGHNESSES == 1
    plane[0] = scale * log_hz(q);
#else
    // log(hz) / (1 - hz^2) tends to -1/2 at the pole.
    const real s = q.h_x * q.h_x + q.h_y * q.h_y;
    const real ratio = s < 1e-30f ? (real)(-0.5f) : log_hz(q) / s;
    plane[0] = scale * ratio * (q.h_x * q.h_x);
    plane[1] = scale * ratio * (q.h_y * q.h_y);
#endif
}

// sqrt((nx+1)(ny+1)) exp(exponent) hz^(scale e), and in d[] the derivative of its logarithm by each exponent.
static inline real cosine_power(const real* plane, real exponent, PARAMETER_SPACE const float* n, real* d)
{
#if ROUGHNESSES == 1
    d[0] = plane[0] + 1.0f / (n[0] + 1.0f);
    return (n[0] + 1.0f) * exp(exponent + n[0] * plane[0]);
#else
    d[0] = plane[0] + 0.5f / (n[0] + 1.0f);
    d[1] = plane[1] + 0.5f / (n[1] + 1.0f);
    return sqrt((n[0] + 1.0f) * (n[1] + 1.0f)) * exp(exponent + n[0] * plane[0] + n[1] * plane[1]);
#endif
}

// Half vectors whose density goes with hz^(scale e): tan phi = sqrt((nx+1)/(ny+1)) tan(2 pi u1), carried on
// through all quadrants so that equal parts of u1 are stratified over the azimuth;
// hz^scale = u2^(1/(e+1)).
static inline vector cosine_power_half(float nx, float ny, float scale, real u1, real u2)
{
    real cosine;
    real sine = sine_of_turns(u1, &cosine);
    cosine *= sqrt(ny + 1.0f);
    sine *= sqrt(nx + 1.0f);
    return half_of_log(cosine, sine, log(u2) / (scale * (exponent_at(cosine, sine, nx, ny) + 1.0f)));
}
