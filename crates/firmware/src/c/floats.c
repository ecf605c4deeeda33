#if defined(__FLT_EVAL_METHOD__) && (__FLT_EVAL_METHOD__ == 1 || __FLT_EVAL_METHOD__ == 2)
#error "floats have to be computed in 32 bits: with -mfpmath=sse on a PC"
#endif

#if defined(__GNUC__)
#define INLINE static inline __attribute__((always_inline, unused))
#else
#define INLINE static inline
#endif

/* Without floats in hardware, sums become bytes by whole numbers wherever that gives the same byte. */
#if !defined(WHOLE_ENDINGS) && ((defined(__arm__) && !defined(__ARM_FP)) || (defined(__riscv) && !defined(__riscv_flen)))
#define WHOLE_ENDINGS 1
#endif

/* Hides a float from the optimiser, so that no product is fused into a sum and no sum is reordered. */
INLINE float keep(float x)
{
#if defined(__GNUC__) && defined(__SSE2__)
    __asm__("" : "+x"(x));
#elif defined(__GNUC__) && defined(__aarch64__)
    __asm__("" : "+w"(x));
#elif defined(__GNUC__) && defined(__arm__) && defined(__ARM_FP)
    __asm__("" : "+t"(x));
#elif defined(__GNUC__) && defined(__arm__)
    __asm__("" : "+r"(x));
#elif defined(__GNUC__) && defined(__riscv_flen)
    __asm__("" : "+f"(x));
#elif defined(__GNUC__) && defined(__riscv)
    __asm__("" : "+r"(x));
#else
    volatile float kept = x;
    x = kept;
#endif
    return x;
}

INLINE float times(float a, float b) { return keep(a * b); }
INLINE float plus(float a, float b) { return keep(a + b); }
INLINE float less(float a, float b) { return keep(a - b); }

INLINE float over(float a, float b)
{
#if defined(__clang__) && defined(__SSE2__)
/* No product with an approximate reciprocal at -ffast-math. */
#pragma float_control(precise, on)
#endif
    return keep(a / keep(b));
}


INLINE uint32_t bits_of(float x)
{
    uint32_t bits;
    (void)memcpy(&bits, &x, sizeof bits);
    return bits;
}

INLINE float float_of(uint32_t bits)
{
    float x;
    (void)memcpy(&x, &bits, sizeof x);
    return x;
}

static inline int is_finite(float x) { return (bits_of(x) & 0x7f800000u) != 0x7f800000u; }

/* Adding 1.5 * 2^23 rounds to even and leaves a whole number in the low bits. */
#define ROUND 12582912.0f

#ifdef WHOLE_ENDINGS
/* Shifts a whole number, sign and all. */
INLINE int32_t shifted_right(int32_t x, uint32_t bits) { return x >> bits; }

/* Floats in their order, as whole numbers. */
INLINE int32_t order_of(float x)
{
    const int32_t bits = (int32_t)bits_of(x);
    return bits < 0 ? -1 - (bits & 0x7fffffff) : bits;
}

INLINE int is_above(float a, float b) { return order_of(a) > order_of(b); }
#else
INLINE int is_above(float a, float b) { return a > b; }
#endif

INLINE float ended(float value, float zero, float low, float high)
{
#ifdef WHOLE_ENDINGS
    /* Values are no -0, which alone 0 would change. */
    value = bits_of(zero) != 0u ? plus(value, zero) : value;
#else
    value = plus(value, zero);
#endif
    value = is_above(value, low) ? value : low;
    return is_above(high, value) ? value : high;
}

/* A byte is stored as itself less 128. */
INLINE int8_t byte_of(float value, float zero, float low, float high)
{
#if defined(FULL_BYTES) && defined(__GNUC__) && defined(__arm__) && defined(__ARM_FP)
    /* Bounds are those of a byte: rounded to even, then cut off. */
    uint32_t byte;
    int32_t whole;
    (void)low;
    (void)high;
    value = plus(value, zero);
    __asm__("vcvtr.s32.f32 %0, %0" : "+t"(value));
    __asm__("usat %0, #8, %1" : "=r"(byte) : "r"(bits_of(value)));
    whole = (int32_t)byte - 128;
    return (int8_t)whole;
#else
    const uint32_t bits = bits_of(plus(ended(value, zero, low, high), ROUND));
    const uint32_t byte = bits & 0xffu;
    const int32_t whole = (int32_t)byte - 128;
    return (int8_t)whole;
#endif
}
