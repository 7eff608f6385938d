// Ashikhmin, Shirley 2000, Eq. 5, the diffuse term of their model:
//     diffuse = 28 / (23 pi) (1 - f0) (1 - (1 - iz/2)^5) (1 - (1 - oz/2)^5)
// theta: f0 of the first lobe

enum { ASHIKHMIN_SHIRLEY_DIFFUSE_WHITE, ASHIKHMIN_SHIRLEY_DIFFUSE_PLANES }; // white: at f0 = 0

static inline real one_minus_fifth_power(real z)
{
    // 1 - (1 - x)^5 without its cancellation at grazing, x = z / 2
    const real x = 0.5f * z;
    return x * (5.0f - x * (10.0f - x * (10.0f - x * (5.0f - x))));
}

static inline void ashikhmin_shirley_diffuse_prepare(geometry q, real* plane)
{
    plane[ASHIKHMIN_SHIRLEY_DIFFUSE_WHITE] =
        (28.0f / (23.0f * PI)) * one_minus_fifth_power(q.wi_z) * one_minus_fifth_power(q.wo_z);
}

static inline real ashikhmin_shirley_diffuse(const real* plane, PARAMETER_SPACE const float* theta, real* d)
{
    const real white = plane[ASHIKHMIN_SHIRLEY_DIFFUSE_WHITE];
    d[0] = -white;
    return (1.0f - theta[0]) * white;
}
