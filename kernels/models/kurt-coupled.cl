// Kurt, Szirmay-Kalos, Krivanek 2010, Eq. 13, the diffuse term coupled to the specular one:
//     diffuse = (1 - F) / pi = (1 - f0) (1 - p5) / pi,   F of the first lobe, p5 as in terms/schlick.cl
// theta: f0 of the first lobe

enum { KURT_COUPLED_P5, KURT_COUPLED_PLANES };

static inline void kurt_coupled_prepare(geometry q, real* plane) { plane[KURT_COUPLED_P5] = schlick_p5(q); }

static inline real kurt_coupled(const real* plane, PARAMETER_SPACE const float* theta, real* d)
{
    const real transmitted = (1.0f - plane[KURT_COUPLED_P5]) * (1.0f / PI);
    d[0] = -transmitted;
    return (1.0f - theta[0]) * transmitted;
}
