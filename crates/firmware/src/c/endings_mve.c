#if defined(__ARM_FEATURE_MVE) && __ARM_FEATURE_MVE == 3 && defined(__GNUC__)
#define VECTORS 1
#include <arm_mve.h>

/* Hides floats from the optimiser. */
INLINE float32x4_t keep4(float32x4_t x)
{
    __asm__("" : "+w"(x));
    return x;
}

/* Zero and bounds. */
typedef struct {
    float32x4_t low, high;
    float zero;
} ending4;

INLINE ending4 ending4_of(float zero, float low, float high)
{
    ending4 e;
    e.low = vdupq_n_f32(low);
    e.high = vdupq_n_f32(high);
    e.zero = zero;
    return e;
}

INLINE float32x4_t ended4(float32x4_t value, ending4 e)
{
    return vminnmq_f32(vmaxnmq_f32(keep4(vaddq_n_f32(value, e.zero)), e.low), e.high);
}

/* Values of sums and addends as they are stored: floats, or bytes before they are rounded. */
INLINE float32x4_t conv_value4(const conv_layer *l, float32x4_t factor, ending4 e, int32x4_t sums, int32x4_t addend,
                               uint32_t has_addend, const float *then)
{
    float32x4_t value = keep4(vmulq_f32(vcvtq_f32_s32(sums), factor));
    if (has_addend != 0u) {
        const int32x4_t added = vaddq_n_s32(addend, l->addend_offset);
        value = keep4(vaddq_f32(value, keep4(vmulq_n_f32(vcvtq_f32_s32(added), l->addend_factor))));
    }
    value = ended4(value, e);
    if (then != NULL) {
        value = keep4(vaddq_n_f32(keep4(vmulq_n_f32(value, then[0])), then[1]));
        value = ended4(value, ending4_of(then[2], then[3], then[4]));
    }
    return value;
}

/* Rounds to even. */
INLINE int32x4_t bytes4_of(float32x4_t value) { return vsubq_n_s32(vcvtnq_s32_f32(value), 128); }
#endif

