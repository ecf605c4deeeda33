static inline float mean_value(const pool_layer *l, uint32_t position, int32_t sum)
{
    return plus(times((float)sum, l->factor[position]), l->shift[position]);
}

static inline int8_t mean_byte(const pool_layer *l, uint32_t position, int32_t sum)
{
    return byte_of(mean_value(l, position, sum), l->zero, l->low, l->high);
}

static inline float mean_float(const pool_layer *l, uint32_t position, int32_t sum)
{
    return ended(mean_value(l, position, sum), l->zero, l->low, l->high);
}

static void mean(const pool_layer *l, float *arena)
{
    int8_t *bytes = (int8_t *)arena;
    uint32_t position, channel, at;
    for (position = 0; position < l->positions; position++) {
        const span s = l->spans[position];
        for (channel = 0; channel < l->channels; channel++) {
            const int8_t *x = bytes + l->from + (uint32_t)s.from * l->from_pitch + channel;
            const uint32_t to = position * l->to_pitch + channel;
            int32_t sum = 0;
            LINES
            for (at = s.from; at < s.to; at++) {
                sum += (int32_t)*x + 128;
                x += l->from_pitch;
            }
            END LINES
            if (l->makes_bytes != 0u) {
                bytes[l->to + to] = mean_byte(l, position, sum);
            } else {
                arena[l->to / 4u + to] = mean_float(l, position, sum);
            }
        }
    }
}
