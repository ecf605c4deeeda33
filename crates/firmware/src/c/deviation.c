/* The square root, rounded to even, digit by digit. */
static float root(float x)
{
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
}

typedef struct {
    float share, eps;
    uint32_t from, to;
    uint16_t channels, positions, from_pitch;
} deviation_layer;

static void deviation(const deviation_layer *l, float *arena)
{
    uint32_t channel, position;
    for (channel = 0; channel < l->channels; channel++) {
        const float *first = arena + l->from / 4u + channel;
        const float *x = first;
        float average = 0.0f, sum = 0.0f;
        for (position = 0; position < l->positions; position++) {
            average = plus(average, *x);
            x += l->from_pitch;
        }
        average = times(average, l->share);
        x = first;
        for (position = 0; position < l->positions; position++) {
            const float apart = less(*x, average);
            sum = plus(sum, times(apart, apart));
            x += l->from_pitch;
        }
        arena[l->to / 4u + channel] = root(plus(times(sum, l->share), l->eps));
    }
}
