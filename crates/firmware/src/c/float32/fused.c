#if !defined(SOFT_FLOATS) && ((defined(__arm__) && !defined(__ARM_FEATURE_FMA)) || (defined(__riscv) && !defined(__riscv_flen)))
#error "this network is in 32-bit floats, and this processor has no FPU with fused products (@soft@ instructions a product would be needed): `taxel quantize` makes a network in eight bits; -DSOFT_FLOATS compiles this one all the same"
#endif

#if !defined(__FMA__) && !defined(__aarch64__) && !defined(__ARM_FEATURE_FMA) && !defined(__riscv_flen)
/* Hides a double from the optimiser. */
INLINE double keep_double(double x)
{
#if defined(__GNUC__) && defined(__SSE2__)
    __asm__("" : "+x"(x));
    return x;
#else
    volatile double kept = x;
    return kept;
#endif
}

/* a * b + c, rounded once: the sum of doubles is rounded to odd, which the rounding to 32 bits then sees as inexact. */
static float fused(float a, float b, float c)
{
    const double product = keep_double((double)a * (double)b), addend = (double)c;
    double sum = keep_double(product + addend);
    const double rest = keep_double(sum - product);
    const double error = keep_double(keep_double(product - keep_double(sum - rest)) + keep_double(addend - rest));
    uint64_t bits;
    (void)memcpy(&bits, &sum, sizeof bits);
    if ((error > 0.0 || error < 0.0) && (bits & 1u) == 0u) {
        bits += (error > 0.0) == (sum > 0.0) ? 1u : UINT64_MAX;
        (void)memcpy(&sum, &bits, sizeof bits);
    }
    return (float)sum;
}
#else
/* a * b + c, rounded once. clang calls libm where a function could set errno. */
INLINE float fused(float a, float b, float c)
{
#if defined(__clang__) && defined(__arm__)
    __asm__("vfma.f32 %0, %1, %2" : "+t"(c) : "t"(a), "t"(b));
    return c;
#elif defined(__clang__) && defined(__riscv)
    __asm__("fmadd.s %0, %1, %2, %0" : "+f"(c) : "f"(a), "f"(b));
    return c;
#else
    return __builtin_fmaf(a, b, c);
#endif
}
#endif

/* Cuts a sum off: not at all (0), below 0 (1), above 6 as well (2). */
INLINE float rectified(float x, uint32_t rectifier)
{
    if (rectifier != 0u) {
        x = x <= 0.0f ? 0.0f : x;
        x = rectifier == 2u && x >= 6.0f ? 6.0f : x;
    }
    return x;
}

/* Numbers of four neighbouring filters. */
typedef struct {
    float a, b, c, d;
} four;

INLINE four four_at(const float *x)
{
    four v;
    v.a = x[0];
    v.b = x[1];
    v.c = x[2];
    v.d = x[3];
    return v;
}

INLINE four four_fused(float x, four w, four sums)
{
    sums.a = fused(x, w.a, sums.a);
    sums.b = fused(x, w.b, sums.b);
    sums.c = fused(x, w.c, sums.c);
    sums.d = fused(x, w.d, sums.d);
    return sums;
}

/* Stores the first `width` of four sums behind an addend (NULL: none) and a rectifier. */
INLINE void store_four(float *y, four sums, const float *addend, uint32_t width, uint32_t rectifier)
{
    if (addend != NULL) {
        sums.a = plus(sums.a, addend[0]);
        sums.b = width > 1u ? plus(sums.b, addend[1]) : sums.b;
        sums.c = width > 2u ? plus(sums.c, addend[2]) : sums.c;
        sums.d = width > 3u ? plus(sums.d, addend[3]) : sums.d;
    }
    y[0] = rectified(sums.a, rectifier);
    if (width > 1u) {
        y[1] = rectified(sums.b, rectifier);
    }
    if (width > 2u) {
        y[2] = rectified(sums.c, rectifier);
    }
    if (width > 3u) {
        y[3] = rectified(sums.d, rectifier);
    }
}
