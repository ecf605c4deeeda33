/* The square root, rounded to even: by the processor where it has that, else digit by digit. */
static float root(float x)
{
#if defined(__GNUC__) && defined(__arm__) && defined(__ARM_FP) && (__ARM_FP & 4)
    __asm__("vsqrt.f32 %0, %0" : "+t"(x));
    return x;
#elif defined(__GNUC__) && defined(__riscv_flen)
    __asm__("fsqrt.s %0, %0" : "+f"(x));
    return x;
#else
    uint32_t bits = bits_of(x);
    int32_t exponent;
    uint64_t rest, result = 0, digit = (uint64_t)1 << 48;
    if ((bits & 0x7fffffffu) == 0u) {
        return x;
    }
    exponent = (int32_t)(bits >> 23) - 127;
    rest = (uint64_t)((bits & 0x7fffffu) | 0x800000u) << 25;
    if ((exponent & 1) != 0) {
        rest <<= 1;
        exponent -= 1;
    }
    while (digit != 0u) {
        if (rest >= result + digit) {
            rest -= result + digit;
            result = (result >> 1) + digit;
        } else {
            result >>= 1;
        }
        digit >>= 2;
    }
    bits = (uint32_t)((result + 1u) >> 1);
    return float_of((bits - 0x800000u) + ((uint32_t)(exponent / 2 + 127) << 23));
#endif
}
