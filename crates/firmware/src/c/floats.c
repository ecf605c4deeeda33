#if defined(__FLT_EVAL_METHOD__) && (__FLT_EVAL_METHOD__ == 1 || __FLT_EVAL_METHOD__ == 2)
#error "floats have to be computed in 32 bits: with -mfpmath=sse on a PC"
#endif

#if defined(__GNUC__)
#define INLINE static inline __attribute__((always_inline))
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
INLINE float over(float a, float b) { return keep(a / keep(b)); }

INLINE uint32_t bits_of(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

INLINE float float_of(uint32_t bits)
{
    float x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

static inline int is_finite(float x) { return (bits_of(x) & 0x7f800000u) != 0x7f800000u; }

/* Adding 1.5 * 2^23 rounds to even and leaves a whole number in the low bits. */
#define ROUND 12582912.0f

INLINE float ended(float value, float zero, float low, float high)
{
    value = plus(value, zero);
    value = value > low ? value : low;
    return value < high ? value : high;
}

/* A byte is stored as itself less 128. */
INLINE int8_t byte_of(float value, float zero, float low, float high)
{
#if defined(FULL_BYTES) && defined(__GNUC__) && defined(__arm__) && defined(__ARM_FP)
    /* Bounds are those of a byte: rounded to even, then cut off. */
    uint32_t byte;
    (void)low;
    (void)high;
    value = plus(value, zero);
    __asm__("vcvtr.s32.f32 %0, %0" : "+t"(value));
    __asm__("usat %0, #8, %1" : "=r"(byte) : "r"(bits_of(value)));
    return (int8_t)((int32_t)byte - 128);
#else
    const uint32_t bits = bits_of(plus(ended(value, zero, low, high), ROUND));
    return (int8_t)((int32_t)(bits & 0xffu) - 128);
#endif
}
