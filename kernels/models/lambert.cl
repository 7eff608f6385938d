// Lambert: diffuse = 1 / pi.

inline void lambert_prepare(geometry q, real* plane) {}

inline real lambert(const real* plane, __constant const float* theta, real* d)
{
    return (real)(1.0f / PI);
}
