// The power of the half vector's cosine that Ashikhmin-Shirley and Edwards share,
//     hz^(scale e),   e = nx cos^2 phi_h + ny sin^2 phi_h = (nx h.x^2 + ny h.y^2) / (1 - hz^2)
// Each of these models is, but for F,
//     g = sqrt((nx + 1)(ny + 1)) exp(k + scale e log(hz))
// with k the logarithm of all factors that depend on the directions alone, so that
//     dlog g/dnx = scale log(hz) cos^2 phi_h + 1 / (2 (nx + 1))
// ROUGHNESSES: 1 (isotropic form, e = n) or 2.

// The planes that these models are made of.
enum {
#if ROUGHNESSES == 1
    LOG_POWER, // scale log(hz)
#else
    LOG_POWER_X, // scale log(hz) cos^2 phi_h
    LOG_POWER_Y, // scale log(hz) sin^2 phi_h
#endif
    COSINE_POWER_LOG_FACTOR, // k
    COSINE_POWER_P5,         // (1 - c)^5
    COSINE_POWER_PLANES
};

static inline void cosine_power_prepare(geometry q, float scale, real log_factor, real* plane)
{
#if ROUGHNESSES == 1
    plane[LOG_POWER] = scale * log_hz(q);
#else
    // log(hz) / (1 - hz^2) tends to -1/2 at the pole.
    const real s = q.h_x * q.h_x + q.h_y * q.h_y;
    const real ratio = s < 1e-30f ? (real)(-0.5f) : log_hz(q) / s;
    plane[LOG_POWER_X] = scale * ratio * (q.h_x * q.h_x);
    plane[LOG_POWER_Y] = scale * ratio * (q.h_y * q.h_y);
#endif
    plane[COSINE_POWER_LOG_FACTOR] = log_factor;
    plane[COSINE_POWER_P5] = schlick_p5(q);
}

// sqrt((nx+1)(ny+1)) exp(k) hz^(scale e), and in d[] the derivative of its logarithm by each exponent.
static inline real cosine_power(const real* plane, real k, PARAMETER_SPACE const float* n, real* d)
{
#if ROUGHNESSES == 1
    d[0] = plane[LOG_POWER] + 1.0f / (n[0] + 1.0f);
    return (n[0] + 1.0f) * exp(k + n[0] * plane[LOG_POWER]);
#else
    d[0] = plane[LOG_POWER_X] + 0.5f / (n[0] + 1.0f);
    d[1] = plane[LOG_POWER_Y] + 0.5f / (n[1] + 1.0f);
    return sqrt((n[0] + 1.0f) * (n[1] + 1.0f)) *
           exp(k + n[0] * plane[LOG_POWER_X] + n[1] * plane[LOG_POWER_Y]);
#endif
}

// The lobe: theta is f0, then n or nx ny.
static inline real cosine_power_lobe(const real* plane, PARAMETER_SPACE const float* theta, real* d)
{
    const real s = cosine_power(plane, plane[COSINE_POWER_LOG_FACTOR], theta + 1, d + 1);
    const real g = schlick_times(plane[COSINE_POWER_P5], theta[0], s, d);
    scale_by(g, d + 1);
    return g;
}

// The derivative of log hz^(scale e) by the angle of the frame: dh.x = h.y, dh.y = -h.x.
static inline real cosine_power_by_turn(geometry q, float scale, float nx, float ny)
{
    const real s = q.h_x * q.h_x + q.h_y * q.h_y;
    const real ratio = s < 1e-30f ? (real)(-0.5f) : log_hz(q) / s;
    return 2.0f * scale * ratio * q.h_x * q.h_y * (nx - ny);
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
