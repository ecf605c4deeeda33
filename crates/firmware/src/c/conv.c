typedef struct {
    const int8_t *weight;
    const int32_t *start;
    const float *factor;
    const int32_t *multiplier; /* of sums as whole numbers; 0 without */
    const float *then;         /* how floats become bytes at once: factor, shift, zero, bounds; 0 where they do not */
    const void *statistics;    /* what becomes of each filter's row of floats; 0 where all are stored */
    float addend_zero, addend_factor, zero, low, high;
    int32_t addend_multiplier, base; /* base: zeros and a half */
    uint32_t from, to, addend;
    uint16_t step, segments, apart, fours, groups, channels, filters, positions, to_pitch, addend_pitch;
    uint8_t shift, fraction, has_addend, makes_bytes;
} conv_layer;

/* What becomes of the sums of one filter. */
typedef struct {
    float factor, addend_zero, addend_factor, zero, low, high;
} conv_ending;

INLINE conv_ending conv_ending_of(const conv_layer *l, uint32_t filter)
{
    conv_ending e;
    e.factor = l->factor[filter];
    e.addend_zero = l->addend_zero;
    e.addend_factor = l->addend_factor;
    e.zero = l->zero;
    e.low = l->low;
    e.high = l->high;
    return e;
}

/* What a sum means, in steps of the output. */
INLINE float conv_value(conv_ending e, int32_t sum, int32_t addend, uint32_t has_addend)
{
    float value = times((float)sum, e.factor);
    if (has_addend != 0u) {
        value = plus(value, times(less((float)(addend + 128), e.addend_zero), e.addend_factor));
    }
    return value;
}

INLINE float conv_float_of(conv_ending e, int32_t sum, int32_t addend, uint32_t has_addend)
{
    return ended(conv_value(e, sum, addend, has_addend), e.zero, e.low, e.high);
}

INLINE int8_t conv_byte_of(conv_ending e, int32_t sum, int32_t addend, uint32_t has_addend)
{
    return byte_of(conv_value(e, sum, addend, has_addend), e.zero, e.low, e.high);
}

INLINE int8_t conv_then_of(conv_ending e, const float *then, int32_t sum, int32_t addend, uint32_t has_addend)
{
    const float value = conv_float_of(e, sum, addend, has_addend);
    return byte_of(plus(times(value, then[0]), then[1]), then[2], then[3], then[4]);
}

#ifdef WHOLE_ENDINGS
/* The byte in whole numbers, or -1 where the value is so near a half that rounding could decide otherwise. */
INLINE int32_t conv_whole_of(const conv_layer *l, int32_t multiplier, int32_t sum, int32_t addend)
{
    const uint32_t fraction = l->fraction, one = 1u << fraction, margin = 1u << (fraction - 11u);
    const int32_t steps =
        (int32_t)(((int64_t)sum * multiplier) >> l->shift) + l->base + addend * l->addend_multiplier;
    int32_t byte = steps >> fraction;
    if (((uint32_t)steps & (one - 1u)) - margin >= one - 2u * margin) {
        return -1;
    }
    byte = byte > 0 ? byte : 0;
    return byte < 255 ? byte : 255;
}
#endif

static inline int8_t conv_byte(const conv_layer *l, uint32_t filter, int32_t sum, int32_t addend)
{
    const conv_ending e = conv_ending_of(l, filter);
#ifdef WHOLE_ENDINGS
    if (l->multiplier != 0) {
        const int32_t byte = conv_whole_of(l, l->multiplier[filter], sum, addend);
        if (byte >= 0) {
            return (int8_t)(byte - 128);
        }
    }
#endif
    return l->then != 0 ? conv_then_of(e, l->then, sum, addend, l->has_addend)
                        : conv_byte_of(e, sum, addend, l->has_addend);
}

static inline float conv_float(const conv_layer *l, uint32_t filter, int32_t sum, int32_t addend)
{
    return conv_float_of(conv_ending_of(l, filter), sum, addend, l->has_addend);
}

DOTS

STATISTICS
/* Stores the sums of one filter at some positions. */
static void conv_store(const conv_layer *l, float *arena, uint32_t filter, uint32_t row, uint32_t first,
                       const int32_t *sums, uint32_t count)
{
    const uint32_t place = l->statistics != 0 ? row * l->positions : filter;
    const uint32_t at = first * l->to_pitch + place, pitch = l->to_pitch;
    int8_t *to = (int8_t *)arena + l->to + at;
    const int8_t *addend = (const int8_t *)arena + l->addend + first * l->addend_pitch + filter;
    const uint32_t addend_pitch = l->addend_pitch;
    const int32_t *end = sums + count;
    const conv_ending e = conv_ending_of(l, filter);
    if (l->makes_bytes == 0u) {
        float *floats = arena + l->to / 4u + at;
        for (; sums < end; sums++) {
            *floats = conv_float_of(e, *sums, l->has_addend != 0u ? *addend : 0, l->has_addend);
            floats += pitch;
            addend += addend_pitch;
        }
        return;
    }
#ifdef WHOLE_ENDINGS
    if (l->multiplier != 0) {
        for (; sums < end; sums++) {
            const int32_t added = l->has_addend != 0u ? *addend : 0;
            const int32_t byte = conv_whole_of(l, l->multiplier[filter], *sums, added);
            *to = byte >= 0 ? (int8_t)(byte - 128) : conv_byte(l, filter, *sums, added);
            to += pitch;
            addend += addend_pitch;
        }
        return;
    }
#endif
    if (l->then != 0 || l->has_addend != 0u) {
        for (; sums < end; sums++) {
            const int32_t added = l->has_addend != 0u ? *addend : 0;
            *to = l->then != 0 ? conv_then_of(e, l->then, *sums, added, l->has_addend)
                               : conv_byte_of(e, *sums, added, 1u);
            to += pitch;
            addend += addend_pitch;
        }
        return;
    }
    for (; sums < end; sums++) {
        *to = conv_byte_of(e, *sums, 0, 0u);
        to += pitch;
    }
}

/* Positions whose sums are computed before they are stored. */
#define CHUNK 16u

static void conv(const conv_layer *l, float *arena)
{
    const int8_t *bytes = (const int8_t *)arena + l->from;
    const uint32_t each = (uint32_t)l->filters / l->groups;
    const uint32_t length = (uint32_t)l->segments * l->fours * 4u;
    uint32_t first, filter, position;
    for (first = 0; first < l->filters; first += each) {
        for (filter = first; filter < first + each; filter += 2u) {
            const uint32_t next = filter + 1u < first + each ? filter + 1u : filter;
            const int8_t *w = l->weight + filter * length;
            const int8_t *v = l->weight + next * length;
            const int8_t *x = bytes + first / each * l->channels;
            for (position = 0; position < l->positions; position += CHUNK) {
                int32_t sums[2][CHUNK];
                const uint32_t left = l->positions - position;
                const uint32_t count = left < CHUNK ? left : CHUNK;
                uint32_t i;
                for (i = 0; i + 1u < count; i += 2u) {
                    sums[0][i] = l->start[filter];
                    sums[1][i] = l->start[next];
                    dot_2x2(l, x, x + l->step, w, v, &sums[0][i], &sums[1][i]);
                    x += 2u * (uint32_t)l->step;
                }
                if (i < count) {
                    sums[0][i] = l->start[filter];
                    sums[1][i] = l->start[next];
                    dot_1x2(l, x, w, v, &sums[0][i], &sums[1][i]);
                    x += l->step;
                }
                conv_store(l, arena, filter, 0u, position, sums[0], count);
                if (next != filter) {
                    conv_store(l, arena, next, 1u, position, sums[1], count);
                }
            }
            CONV_ENDED
        }
    }
}
