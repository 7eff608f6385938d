// Kurt, Szirmay-Kalos, Krivanek 2010, Eq. 13, the diffuse term coupled to the specular one:
//     diffuse = (1 - F) / pi,   F of the first lobe
// theta: f0 of the first lobe

static inline void kurt_coupled_prepare(geometry q, real* plane) { plane[0] = schlick_p5(q); }

static inline real kurt_coupled(const real* plane, PARAMETER_SPACE const float* theta, real* d)
{
    const real transmitted = (1.0f - plane[0]) * (1.0f / PI);
    d[0] = -transmitted;
    return (1.0f - theta[0]) * transmitted;
}
