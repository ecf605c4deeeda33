typedef struct {
    const int8_t *weight;
    const int32_t *start;
    const float *factor;
    float addend_zero, addend_factor, zero, low, high;
    uint32_t from, to, addend;
    uint16_t step, segments, apart, fours, groups, channels, filters, positions, to_pitch, addend_pitch;
    uint8_t has_addend, makes_bytes;
} conv_layer;

/* What a sum means, in steps of the output. */
static inline float conv_value(const conv_layer *l, uint32_t filter, int32_t sum, int32_t addend)
{
    float value = times((float)sum, l->factor[filter]);
    if (l->has_addend != 0u) {
        const float apart = less((float)(addend + 128), l->addend_zero);
        value = plus(value, times(apart, l->addend_factor));
    }
    return value;
}

static inline int8_t conv_byte(const conv_layer *l, uint32_t filter, int32_t sum, int32_t addend)
{
    return byte_of(conv_value(l, filter, sum, addend), l->zero, l->low, l->high);
}

static inline float conv_float(const conv_layer *l, uint32_t filter, int32_t sum, int32_t addend)
{
    return ended(conv_value(l, filter, sum, addend), l->zero, l->low, l->high);
}

static inline void conv_store(const conv_layer *l, float *arena, uint32_t filter, uint32_t position, int32_t sum)
{
    int8_t *bytes = (int8_t *)arena;
    const uint32_t at = position * l->to_pitch + filter;
    const int32_t addend =
        l->has_addend != 0u ? bytes[l->addend + position * l->addend_pitch + filter] : 0;
    if (l->makes_bytes != 0u) {
        bytes[l->to + at] = conv_byte(l, filter, sum, addend);
    } else {
        arena[l->to / 4u + at] = conv_float(l, filter, sum, addend);
    }
}

DOTS

static void conv(const conv_layer *l, float *arena)
{
    const int8_t *bytes = (const int8_t *)arena;
    const uint32_t each = (uint32_t)l->filters / l->groups;
    const uint32_t row = (uint32_t)l->segments * l->fours * 4u;
    uint32_t group;
    for (group = 0; group < l->groups; group++) {
        const int8_t *from = bytes + l->from + group * l->channels;
        const uint32_t end = (group + 1u) * each;
        uint32_t filter;
        for (filter = group * each; filter < end; filter += 2u) {
            const uint32_t next = filter + 1u < end ? filter + 1u : filter;
            const int8_t *w = l->weight + filter * row;
            const int8_t *v = l->weight + next * row;
            uint32_t position = 0;
            for (; position + 1u < l->positions; position += 2u) {
                const int8_t *x = from + position * l->step;
                int32_t sums[4];
                sums[0] = l->start[filter];
                sums[1] = l->start[next];
                sums[2] = sums[0];
                sums[3] = sums[1];
                dot_2x2(l, x, x + l->step, w, v, sums);
                conv_store(l, arena, filter, position, sums[0]);
                conv_store(l, arena, filter, position + 1u, sums[2]);
                if (next != filter) {
                    conv_store(l, arena, next, position, sums[1]);
                    conv_store(l, arena, next, position + 1u, sums[3]);
                }
            }
            if (position < l->positions) {
                int32_t sums[2];
                sums[0] = l->start[filter];
                sums[1] = l->start[next];
                dot_1x2(l, from + position * l->step, w, v, sums);
                conv_store(l, arena, filter, position, sums[0]);
                if (next != filter) {
                    conv_store(l, arena, next, position, sums[1]);
                }
            }
        }
    }
}
