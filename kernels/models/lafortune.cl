// Lafortune et al. 1997, scaled to a base of at most 1 (the scale is in ks):
//     g = (max(0, Cx wi.x wo.x + Cy wi.y wo.y + wi.z wo.z) / s)^n,   s = max(1, |Cx|, |Cy|)
// theta: C n or Cx Cy n
//
// With n up to 1e5 the base must be exact where it is near 1. So there 1 - base is summed from terms
// that vanish: half the squared distance of wi from wo with its x and y signed like Cx and Cy, and
// what the base loses as |Cx|, |Cy| and 1 are not all s. As |wi| = |wo| = 1, with Cz = 1,
//     1 - base = sum over k = x, y, z of (wi_k - sign(C_k) wo_k)^2 / 2
//                                        + (1 - |C_k| / s) sign(C_k) wi_k wo_k

// The planes: for each axis k (x and y, or both together) of wi and wo, then of z.
#define NEAR2(k) (3 * (k))     // half the squared difference along it
#define FAR2(k) (3 * (k) + 1)  // half the squared sum
#define ALONG(k) (3 * (k) + 2) // the product
enum {
    LAFORTUNE_NEAR2_Z = 3 * ROUGHNESSES,
    LAFORTUNE_ALONG_Z, // iz oz
    LAFORTUNE_PLANES
};

static inline void lafortune_prepare(geometry q, real* plane)
{
    const real near_x = 0.5f * squared(q.wi_x - q.wo_x);
    const real near_y = 0.5f * squared(q.wi_y - q.wo_y);
    const real far_x = 0.5f * squared(q.wi_x + q.wo_x);
    const real far_y = 0.5f * squared(q.wi_y + q.wo_y);
#if ROUGHNESSES == 1
    plane[NEAR2(0)] = near_x + near_y;
    plane[FAR2(0)] = far_x + far_y;
    plane[ALONG(0)] = q.wi_x * q.wo_x + q.wi_y * q.wo_y;
#else
    plane[NEAR2(0)] = near_x;
    plane[FAR2(0)] = far_x;
    plane[ALONG(0)] = q.wi_x * q.wo_x;
    plane[NEAR2(1)] = near_y;
    plane[FAR2(1)] = far_y;
    plane[ALONG(1)] = q.wi_y * q.wo_y;
#endif
    plane[LAFORTUNE_NEAR2_Z] = 0.5f * squared(q.wi_z - q.wo_z);
    plane[LAFORTUNE_ALONG_Z] = q.wi_z * q.wo_z;
}

static inline real lafortune(const real* plane, PARAMETER_SPACE const float* theta, real* d)
{
    const float n = theta[ROUGHNESSES];
    const real zz = plane[LAFORTUNE_ALONG_Z];
    float s = 1.0f;
    for (int k = 0; k < ROUGHNESSES; ++k)
        s = fmax(s, fabs(theta[k]));
    real loss = plane[LAFORTUNE_NEAR2_Z] + (1.0f - 1.0f / s) * zz; // 1 - base
    real product = zz;                                           // s base
    for (int k = 0; k < ROUGHNESSES; ++k) {
        const float c = theta[k];
        const real along = plane[ALONG(k)];
        loss += (c < 0.0f ? plane[FAR2(k)] : plane[NEAR2(k)]) +
                (1.0f - fabs(c) / s) * (c < 0.0f ? -along : along);
        product += c * along;
    }
    const real base = product * (1.0f / s);
    const mask positive = base > 0.0f;
    const real log_base = log_one_minus(loss, fmax(base, (real)(FLT_MIN)));
    const real g = positive ? exp(n * log_base) : (real)(0.0f);
    const real slope = (n / s) * g / fmax(base, (real)(FLT_MIN)); // n / s base^(n-1)
    // By C_k: the product along the axis; where |C_k| is s that cancels, and the scale's slope stays.
    for (int k = 0; k < ROUGHNESSES; ++k) {
        const float c = theta[k];
        const real along = plane[ALONG(k)];
#if ROUGHNESSES == 1
        const real others = zz;
#else
        const real others = zz + theta[1 - k] * plane[ALONG(1 - k)];
#endif
        const real rest = others * (-sign(c) / s);
        d[k] = slope * (s > 1.0f && fabs(c) == s ? rest : along);
    }
    d[ROUGHNESSES] = g * log_base;
    return g;
}

// wi from the cosine lobe (n + 1) / (2 pi) (wi.L)^n about L = (Cx wo.x, Cy wo.y, wo.z), normalised.
static inline vector lafortune_axis(vector wo, PARAMETER_SPACE const float* theta)
{
    const vector axis = {theta[0] * wo.x, theta[1] * wo.y, wo.z};
    return unit(axis);
}

static inline geometry lafortune_sample(vector wo, PARAMETER_SPACE const float* theta, real u1, real u2)
{
    const vector axis = lafortune_axis(wo, theta);
    real cosine;
    const real sine = sine_of_turns(u2, &cosine);
    const vector w = half_of_log(cosine, sine, log(u1) / (theta[2] + 1.0f));
    // A frame about the axis, which is above the horizon (Duff et al. 2017).
    const real a = -1.0f / (1.0f + axis.z);
    const real b = axis.x * axis.y * a;
    const vector wi = {
        w.x * (1.0f + a * axis.x * axis.x) + w.y * b + w.z * axis.x,
        w.x * b + w.y * (1.0f + a * axis.y * axis.y) + w.z * axis.y,
        -w.x * axis.x - w.y * axis.y + w.z * axis.z,
    };
    return between(wi, wo);
}

static inline real lafortune_density(geometry q, PARAMETER_SPACE const float* theta)
{
    const float n = theta[2];
    const vector axis = lafortune_axis(wo_of(q), theta);
    // 1 - wi.L, exact where it is small.
    const real loss =
        0.5f * (squared(q.wi_x - axis.x) + squared(q.wi_y - axis.y) + squared(q.wi_z - axis.z));
    const real power = exp(n * log1p(-fmin(loss, (real)(0.9999999f))));
    return loss < 1.0f ? (n + 1.0f) * (0.5f / PI) * power : (real)(0.0f);
}

static inline real lafortune_by_turn(geometry q, PARAMETER_SPACE const float* theta)
{
    // d(wi.x wo.x) = wi.y wo.x + wi.x wo.y = -d(wi.y wo.y); s cancels
    const float cx = theta[0];
    const float cy = theta[1];
    const real product = cx * q.wi_x * q.wo_x + cy * q.wi_y * q.wo_y + q.wi_z * q.wo_z;
    return theta[2] * (cx - cy) * (q.wi_y * q.wo_x + q.wi_x * q.wo_y) /
           fmax(product, (real)(FLT_MIN));
}
