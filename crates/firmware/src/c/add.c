typedef struct {
    float of_a, of_b, shift, zero, low, high;
    uint32_t a, b, to;
    uint16_t channels, positions, a_pitch, b_pitch, to_pitch;
    uint8_t makes_bytes;
} add_layer;

static inline float add_value(const add_layer *l, int32_t a, int32_t b)
{
    const float both = plus(times((float)(a + 128), l->of_a), times((float)(b + 128), l->of_b));
    return plus(both, l->shift);
}

static inline int8_t add_byte(const add_layer *l, int32_t a, int32_t b)
{
    return byte_of(add_value(l, a, b), l->zero, l->low, l->high);
}

static inline float add_float(const add_layer *l, int32_t a, int32_t b)
{
    return ended(add_value(l, a, b), l->zero, l->low, l->high);
}

static void add(const add_layer *l, float *arena)
{
    int8_t *bytes = (int8_t *)arena;
    uint32_t position, channel;
    for (position = 0; position < l->positions; position++) {
        for (channel = 0; channel < l->channels; channel++) {
            const int32_t a = bytes[l->a + position * l->a_pitch + channel];
            const int32_t b = bytes[l->b + position * l->b_pitch + channel];
            const uint32_t at = position * l->to_pitch + channel;
            if (l->makes_bytes != 0u) {
                bytes[l->to + at] = add_byte(l, a, b);
            } else {
                arena[l->to / 4u + at] = add_float(l, a, b);
            }
        }
    }
}
