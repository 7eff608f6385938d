// Lambert: diffuse = 1 / pi.

enum { LAMBERT_PLANES };

static inline void lambert_prepare(geometry q, real* plane) {}

static inline real lambert(const real* plane, PARAMETER_SPACE const float* theta, real* d)
{
    return (real)(1.0f / PI);
}
