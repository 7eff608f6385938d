// Random numbers that are functions of seed and index alone, so that sample i does not depend on how
// work was split.

#if V == 1
typedef uint ureal;
#else
typedef JOIN(uint, V) ureal;
#endif

// 0 to V - 1: adds up to the indices of a vector of samples.
static inline ureal lane_numbers(void)
{
    ureal x = 0u;
    for (int lane = 0; lane < V; ++lane)
        ((uint*)&x)[lane] = lane;
    return x;
}

// Philox 4x32-10 (Salmon et al. 2011): ten rounds of multiplication and exchange on a counter x[4].
static inline void philox(ureal* x, uint key0, uint key1)
{
    for (int round = 0; round < 10; ++round) {
        const ureal high0 = mul_hi((ureal)(0xD2511F53u), x[0]);
        const ureal low0 = 0xD2511F53u * x[0];
        const ureal high1 = mul_hi((ureal)(0xCD9E8D57u), x[2]);
        const ureal low1 = 0xCD9E8D57u * x[2];
        x[0] = high1 ^ x[1] ^ key0;
        x[1] = low1;
        x[2] = high0 ^ x[3] ^ key1;
        x[3] = low0;
        key0 += 0x9E3779B9u;
        key1 += 0xBB67AE85u;
    }
}

static inline ureal reversed_bits(ureal x)
{
    x = ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
    x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
    x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
    x = ((x >> 8) & 0x00ff00ffu) | ((x & 0x00ff00ffu) << 8);
    return (x >> 16) | (x << 16);
}

// Laine and Karras 2011, with Vegdahl's constants: every bit is flipped or not depending on the lower
// ones. On reversed bits that is Owen's scrambling.
static inline ureal scrambled_upwards(ureal x, uint seed)
{
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    return x ^ (x * 0x53a22864u);
}

// The first Sobol dimension, scrambled: the index read backwards.
static inline ureal sobol_0(ureal index, uint seed)
{
    return reversed_bits(scrambled_upwards(index, seed));
}

// The second: its direction numbers are Pascal's triangle modulo 2, a Kronecker power, so that five
// steps do for 32 bits.
static inline ureal sobol_1(ureal index, uint seed)
{
    ureal x = reversed_bits(index);
    x ^= (x & 0x55555555u) << 1;
    x ^= (x & 0x33333333u) << 2;
    x ^= (x & 0x0f0f0f0fu) << 4;
    x ^= (x & 0x00ff00ffu) << 8;
    x ^= x << 16;
    return reversed_bits(scrambled_upwards(reversed_bits(x), seed));
}

// The third, of the polynomial x^2 + x + 1: v_k = v_{k-1} ^ v_{k-2} ^ (v_{k-2} >> 2).
static inline ureal sobol_2(ureal index, uint seed)
{
    uint before = 0x80000000u;
    uint v = 0xC0000000u;
    ureal x = (0u - (index & 1u)) & before;
    for (int k = 1; k < 32; ++k) {
        x ^= (0u - ((index >> k) & 1u)) & v;
        const uint next = v ^ before ^ (before >> 2);
        before = v;
        v = next;
    }
    return reversed_bits(scrambled_upwards(reversed_bits(x), seed));
}

// The middle of one of 2^23 equal parts of (0, 1), which float32 holds exactly: never 0 or 1.
static inline real unit_interval(ureal x)
{
#if V == 1
    const real upper = convert_float(x >> 9);
#else
    const real upper = JOIN(convert_float, V)(x >> 9);
#endif
    return (upper + 0.5f) * 0x1p-23f;
}
