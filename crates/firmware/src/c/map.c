typedef struct {
    const float *factor;
    const float *shift;
    float zero, low, high;
    uint32_t from, to;
    uint16_t channels, positions, from_pitch, to_pitch;
    uint8_t reads_bytes, makes_bytes;
} map_layer;

static inline float map_value(const map_layer *l, uint32_t channel, float x)
{
    return plus(times(x, l->factor[channel]), l->shift[channel]);
}

static inline int8_t map_byte(const map_layer *l, uint32_t channel, float x)
{
    return byte_of(map_value(l, channel, x), l->zero, l->low, l->high);
}

static inline float map_float(const map_layer *l, uint32_t channel, float x)
{
    return ended(map_value(l, channel, x), l->zero, l->low, l->high);
}

static void map(const map_layer *l, float *arena)
{
    int8_t *bytes = (int8_t *)arena;
    uint32_t position, channel;
    for (position = 0; position < l->positions; position++) {
        for (channel = 0; channel < l->channels; channel++) {
            const uint32_t from = position * l->from_pitch + channel;
            const uint32_t to = position * l->to_pitch + channel;
            float x;
            if (l->reads_bytes != 0u) {
                const int32_t byte = (int32_t)bytes[l->from + from] + 128;
                x = (float)byte;
            } else {
                x = arena[l->from / 4u + from];
            }
            if (l->makes_bytes != 0u) {
                bytes[l->to + to] = map_byte(l, channel, x);
            } else {
                arena[l->to / 4u + to] = map_float(l, channel, x);
            }
        }
    }
}
