// The error function and its inverse.

// erfc(x) = t p(t) exp(-x^2) for x >= 0, to 1.5e-7 (Abramowitz and Stegun 7.1.26): t, then p.
static inline real erfc_variable(real x) { return 1.0f / (1.0f + 0.3275911f * x); }

static inline real erfc_polynomial(real t)
{
    return 0.254829592f +
           t * (-0.284496736f + t * (1.421413741f + t * (-1.453152027f + t * 1.061405429f)));
}

// 1 + erf(x); `gauss`: exp(-x^2).
static inline real one_plus_erf(real x, real gauss)
{
    const real t = erfc_variable(fabs(x));
    const real tail = gauss * t * erfc_polynomial(t);
    return x < 0.0f ? tail : 2.0f - tail;
}

// The inverse of erf (Giles 2010).
static inline real inverse_erf(real x)
{
    const real w = -log((1.0f - x) * (1.0f + x));
    const real a = w - 2.5f;
    real p = 2.81022636e-08f;
    p = 3.43273939e-07f + p * a;
    p = -3.5233877e-06f + p * a;
    p = -4.39150654e-06f + p * a;
    p = 0.00021858087f + p * a;
    p = -0.00125372503f + p * a;
    p = -0.00417768164f + p * a;
    p = 0.246640727f + p * a;
    p = 1.50140941f + p * a;
    const real b = sqrt(w) - 3.0f;
    real q = -0.000200214257f;
    q = 0.000100950558f + q * b;
    q = 0.00134934322f + q * b;
    q = -0.00367342844f + q * b;
    q = 0.00573950773f + q * b;
    q = -0.0076224613f + q * b;
    q = 0.00943887047f + q * b;
    q = 1.00167406f + q * b;
    q = 2.83297682f + q * b;
    return x * (w < 5.0f ? p : q);
}
