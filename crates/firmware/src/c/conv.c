typedef struct {
    const int8_t *weight;
    const int32_t *start;
    const float *factor;
    const int32_t *multiplier; /* of sums as whole numbers; 0 without */
    const void *statistics;    /* what becomes of each filter's row of floats; 0 where all are stored */
    float addend_zero, addend_factor, zero, low, high;
    int32_t addend_multiplier, base; /* base: zeros and a half */
    uint32_t from, to, addend;
    uint16_t step, segments, apart, fours, groups, channels, filters, positions, to_pitch, addend_pitch;
    uint8_t shift, fraction, has_addend, makes_bytes;
} conv_layer;

/* What a sum means, in steps of the output. */
INLINE float conv_value(const conv_layer *l, float factor, int32_t sum, int32_t addend, uint32_t has_addend)
{
    float value = times((float)sum, factor);
    if (has_addend != 0u) {
        const float apart = less((float)(addend + 128), l->addend_zero);
        value = plus(value, times(apart, l->addend_factor));
    }
    return value;
}

INLINE int8_t conv_byte_of(const conv_layer *l, uint32_t filter, float factor, float zero, int32_t sum, int32_t addend,
                           uint32_t has_addend)
{
#ifdef WHOLE_ENDINGS
    /* The same in whole numbers, but where the value is so near a half that rounding could decide otherwise. */
    if (l->multiplier != 0) {
        const uint32_t fraction = l->fraction, one = 1u << fraction, margin = 1u << (fraction - 11u);
        int32_t steps = (int32_t)(((int64_t)sum * l->multiplier[filter]) >> l->shift) + l->base;
        if (has_addend != 0u) {
            steps += addend * l->addend_multiplier;
        }
        if (((uint32_t)steps & (one - 1u)) - margin < one - 2u * margin) {
            int32_t byte = steps >> fraction;
            byte = byte > 0 ? byte : 0;
            byte = byte < 255 ? byte : 255;
            return (int8_t)(byte - 128);
        }
    }
#else
    (void)filter;
#endif
    return byte_of(conv_value(l, factor, sum, addend, has_addend), zero, l->low, l->high);
}

static inline int8_t conv_byte(const conv_layer *l, uint32_t filter, int32_t sum, int32_t addend)
{
    return conv_byte_of(l, filter, l->factor[filter], l->zero, sum, addend, l->has_addend);
}

static inline float conv_float(const conv_layer *l, uint32_t filter, int32_t sum, int32_t addend)
{
    return ended(conv_value(l, l->factor[filter], sum, addend, l->has_addend), l->zero, l->low, l->high);
}

DOTS

STATISTICS
/* Computes all outputs; modes: 1 for bytes, 2 with an addend. */
INLINE void conv_as(const conv_layer *l, float *arena, uint32_t mode)
{
    const int8_t *bytes = (const int8_t *)arena;
    int8_t *to = (int8_t *)arena + l->to;
    const uint32_t each = (uint32_t)l->filters / l->groups;
    const uint32_t row = (uint32_t)l->segments * l->fours * 4u;
    const uint32_t step = l->step, positions = l->positions, to_pitch = l->to_pitch, addend_pitch = l->addend_pitch;
    const float zero = l->zero;
    uint32_t first;
    for (first = 0; first < l->filters; first += each) {
        const int8_t *from = bytes + l->from + first / each * l->channels;
        const uint32_t end = first + each;
        uint32_t filter;
        for (filter = first; filter < end; filter += 2u) {
            const uint32_t next = filter + 1u < end ? filter + 1u : filter;
            const int8_t *w = l->weight + filter * row;
            const int8_t *v = l->weight + next * row;
            const int8_t *x = from;
            const int8_t *addend = bytes + l->addend;
            const float factor = l->factor[filter], other = l->factor[next];
            /* Where both filters' values go, and those of the next position. */
            uint32_t here = l->statistics != 0 ? 0u : filter;
            uint32_t there = l->statistics != 0 ? positions : next;
            uint32_t position;
            for (position = 0; position < positions; position += 2u) {
                const uint32_t has_second = position + 1u < positions;
                int32_t sums[4];
                uint32_t i;
                sums[0] = l->start[filter];
                sums[1] = l->start[next];
                if (has_second != 0u) {
                    sums[2] = sums[0];
                    sums[3] = sums[1];
                    dot_2x2(l, x, x + step, w, v, sums);
                } else {
                    dot_1x2(l, x, w, v, sums);
                }
                for (i = 0; i <= 2u * has_second; i += 2u) {
                    const int32_t a = (mode & 2u) != 0u ? addend[filter] : 0;
                    const int32_t b = (mode & 2u) != 0u ? addend[next] : 0;
                    if ((mode & 1u) != 0u) {
                        to[here] = conv_byte_of(l, filter, factor, zero, sums[i], a, mode & 2u);
                        to[there] = conv_byte_of(l, next, other, zero, sums[i + 1u], b, mode & 2u);
                    } else {
                        float *floats = arena + l->to / 4u;
                        const float low = l->low, high = l->high;
                        floats[here] = ended(conv_value(l, factor, sums[i], a, mode & 2u), zero, low, high);
                        floats[there] = ended(conv_value(l, other, sums[i + 1u], b, mode & 2u), zero, low, high);
                    }
                    here += to_pitch;
                    there += to_pitch;
                    addend += addend_pitch;
                }
                x += 2u * step;
            }
            CONV_ENDED
        }
    }
}

static void conv(const conv_layer *l, float *arena)
{
    MODES
}
