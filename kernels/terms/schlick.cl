// Schlick's approximation of Fresnel's reflectance,
//     F = f0 + (1 - f0) (1 - c)^5
// which is affine in f0: with p5 = (1 - c)^5, a plane of each model that has F,
//     dF/df0 = 1 - p5

static inline real schlick_p5(geometry q)
{
    const real x = 1.0f - q.c;
    const real x2 = x * x;
    return x2 * x2 * x;
}

static inline real schlick(real p5, float f0) { return f0 + (1.0f - f0) * p5; }

// F s, and in *by_f0 its derivative: how every lobe with Schlick's F ends.
static inline real schlick_times(real p5, float f0, real s, real* by_f0)
{
    *by_f0 = (1.0f - p5) * s;
    return schlick(p5, f0) * s;
}
