typedef struct {
    const int8_t *weight;
    const int32_t *start;
    const float *factor;
    float zero, low, high;
    uint32_t from, to;
    uint16_t step, taps, apart, channels, positions, to_pitch;
    uint8_t makes_bytes;
MORE_FIELDS
} depthwise_layer;

static inline float depthwise_value(const depthwise_layer *l, uint32_t channel, int32_t sum)
{
    return times((float)sum, l->factor[channel]);
}

static inline int8_t depthwise_byte(const depthwise_layer *l, uint32_t channel, int32_t sum)
{
    return byte_of(depthwise_value(l, channel, sum), l->zero, l->low, l->high);
}

static inline float depthwise_float(const depthwise_layer *l, uint32_t channel, int32_t sum)
{
    return ended(depthwise_value(l, channel, sum), l->zero, l->low, l->high);
}

static void depthwise(const depthwise_layer *l, float *arena)
{
    int8_t *bytes = (int8_t *)arena;
    uint32_t position, channel, tap;
    for (position = 0; position < l->positions; position++) {
        for (channel = 0; channel < l->channels; channel++) {
            const int8_t *x = bytes + l->from + position * l->step + channel;
            const int8_t *w = l->weight + channel;
            const uint32_t at = position * l->to_pitch + channel;
            int32_t sum = l->start[channel];
            LINES
            for (tap = 0; tap < l->taps; tap++) {
                sum += *x * *w;
                x += l->apart;
                w += l->channels;
            }
            END LINES
            if (l->makes_bytes != 0u) {
                bytes[l->to + at] = depthwise_byte(l, channel, sum);
            } else {
                arena[l->to / 4u + at] = depthwise_float(l, channel, sum);
            }
        }
    }
}
