/* A number of a row: its mean (0), largest value (1) or standard deviation (2). */
typedef struct {
    float share, eps;
    uint32_t to;
    uint32_t kind;
} statistic;

typedef struct {
    const statistic *list;
    uint32_t count;
} statistic_list;

typedef struct {
    const int8_t *weight;
    const int32_t *start;
    const float *factor;
    const int32_t *multiplier; /* of sums as whole numbers; 0 without */
    const float *then;         /* how floats become bytes at once: factor, shift, zero, bounds; 0 where they do not */
    const statistic_list *statistics; /* what becomes of each filter's row of floats; 0 where all are stored */
    float addend_factor, zero, low, high;
    int32_t addend_offset;           /* 128 less the byte that means 0 */
    int32_t addend_multiplier, base; /* base: zeros, a half and the margin */
    uint32_t from, to, addend;
    uint16_t step, segments, apart, fours, groups, channels, filters, positions, to_pitch, addend_pitch;
    uint8_t shift, has_addend, makes_bytes;
} conv_layer;

VECTOR_ENDINGS
#ifndef WHOLE_ENDINGS
#define OF_WHOLE(table) NULL
#endif

#ifndef VECTORS
/* What becomes of the sums of one filter. */
typedef struct {
    float factor, addend_factor, zero, low, high;
    int32_t addend_offset;
} conv_ending;

INLINE conv_ending conv_ending_of(const conv_layer *l, uint32_t filter)
{
    conv_ending e;
    e.factor = l->factor[filter];
    e.addend_factor = l->addend_factor;
    e.zero = l->zero;
    e.low = l->low;
    e.high = l->high;
    e.addend_offset = l->addend_offset;
    return e;
}

/* What a sum means, in steps of the output. */
INLINE float conv_value(conv_ending e, int32_t sum, int32_t addend, uint32_t has_addend)
{
    float value = times((float)sum, e.factor);
    if (has_addend != 0u) {
        const int32_t added = addend + e.addend_offset;
        value = plus(value, times((float)added, e.addend_factor));
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
/* Tables of whole numbers. */
#define OF_WHOLE(table) (table)

/* Bits behind the point of whole numbers, and more of an addend; how near to a half floats could round in another way. */
#define FRACTION @fraction@u
#define MORE @more@u
#define LOW_BITS @low_bits@u
#define DOUBT @doubt@u

/* The upper word of a product, or up to 3 less. */
INLINE int32_t upper(int32_t a, int32_t b)
{
#if defined(__ARM_ARCH_6M__) || defined(WHOLE_HALVES)
    /* There is no product of 64 bits. */
    const int32_t a_high = shifted_right(a, 16u), b_high = shifted_right(b, 16u);
    const int32_t a_low = a & 0xffff, b_low = b & 0xffff;
    const uint32_t crossed = (uint32_t)a_low * (uint32_t)b_high;
    const int32_t crossed_high = (int32_t)(crossed >> 16);
    return a_high * b_high + shifted_right(a_high * b_low, 16u) + crossed_high;
#else
    const int64_t product = (int64_t)a * b;
    const uint64_t bits = (uint64_t)product;
    const uint32_t high = (uint32_t)(bits >> 32);
    return (int32_t)high;
#endif
}

/* The value and a half as whole numbers: the byte less 128 before the point. */
INLINE int32_t conv_whole_of(int32_t multiplier, uint32_t shift, int32_t base, int32_t sum)
{
    const uint32_t shifted = (uint32_t)sum << shift;
    return upper((int32_t)shifted, multiplier) + base;
}

/* The zeros and a half, and an addend. */
INLINE int32_t base_of(int32_t base, int32_t addend, int32_t multiplier)
{
    return base + shifted_right(addend * multiplier, MORE);
}

/* Whether rounding of floats could give another byte. */
INLINE int is_doubtful(int32_t whole) { return ((uint32_t)whole & LOW_BITS) < DOUBT ? 1 : 0; }

INLINE int8_t byte_of_whole(int32_t whole)
{
#if defined(__GNUC__) && defined(__ARM_FEATURE_SAT)
    int32_t byte;
    __asm__("ssat %0, #8, %1, asr %2" : "=r"(byte) : "r"(whole), "i"(FRACTION));
    return (int8_t)byte;
#else
    const int32_t byte = shifted_right(whole, FRACTION);
    return (int8_t)(byte < -128 ? -128 : (byte < 127 ? byte : 127));
#endif
}

/* The byte of a doubtful sum. */
static int8_t conv_doubtful(const conv_layer *l, uint32_t filter, int32_t sum, int32_t addend)
{
    const conv_ending e = conv_ending_of(l, filter);
    return l->then != NULL ? conv_then_of(e, l->then, sum, addend, l->has_addend)
                        : conv_byte_of(e, sum, addend, l->has_addend);
}
#endif
#endif

DOTS

STATISTICS
STORE_MVE
#ifndef VECTORS
/* Where the sums of a filter go, and its addends. */
typedef struct {
    float *floats;
    int8_t *bytes;
    const int8_t *addend;
    const int32_t *sums, *end;
} conv_stream;

/* Stores sums as floats. */
static void conv_store_floats(const conv_layer *l, conv_ending e, conv_stream s)
{
    for (; s.sums != s.end; s.sums += 2) {
        *s.floats = conv_float_of(e, *s.sums, l->has_addend != 0u ? *s.addend : 0, l->has_addend);
        s.floats += l->to_pitch;
        s.addend += l->addend_pitch;
    }
}

#ifdef WHOLE_ENDINGS
/* Stores sums as bytes by whole numbers; the few that are doubtful by floats. */
static void conv_store_whole(const conv_layer *l, uint32_t filter, conv_stream s)
{
    const int32_t multiplier = l->multiplier[filter], base = l->base, of_addend = l->addend_multiplier;
    const uint32_t shift = l->shift, pitch = l->to_pitch, addend_pitch = l->addend_pitch;
    if (l->has_addend != 0u) {
        for (; s.sums != s.end; s.sums += 2) {
            const int32_t whole = conv_whole_of(multiplier, shift, base_of(base, *s.addend, of_addend), *s.sums);
            *s.bytes = is_doubtful(whole) ? conv_doubtful(l, filter, *s.sums, *s.addend) : byte_of_whole(whole);
            s.bytes += pitch;
            s.addend += addend_pitch;
        }
        return;
    }
    for (; s.sums != s.end; s.sums += 2) {
        const int32_t whole = conv_whole_of(multiplier, shift, base, *s.sums);
        *s.bytes = is_doubtful(whole) ? conv_doubtful(l, filter, *s.sums, 0) : byte_of_whole(whole);
        s.bytes += pitch;
    }
}
#endif

/* Stores every second sum: those of one filter at some positions. */
static void conv_store(const conv_layer *l, float *arena, uint32_t filter, uint32_t row, uint32_t first,
                       const int32_t *sums, uint32_t count)
{
    const uint32_t place = l->statistics != NULL ? row * l->positions : filter;
    const uint32_t at = first * l->to_pitch + place;
    const conv_ending e = conv_ending_of(l, filter);
    conv_stream s;
    s.floats = arena + l->to / 4u + at;
    s.bytes = (int8_t *)arena + l->to + at;
    s.addend = (const int8_t *)arena + l->addend + first * l->addend_pitch + filter;
    s.sums = sums;
    s.end = sums + 2u * count;
    if (l->makes_bytes == 0u) {
        conv_store_floats(l, e, s);
        return;
    }
#ifdef WHOLE_ENDINGS
    if (l->multiplier != NULL) {
        conv_store_whole(l, filter, s);
        return;
    }
#endif
    if (l->then != NULL) {
        for (; s.sums != s.end; s.sums += 2) {
            *s.bytes = conv_then_of(e, l->then, *s.sums, l->has_addend != 0u ? *s.addend : 0, l->has_addend);
            s.bytes += l->to_pitch;
            s.addend += l->addend_pitch;
        }
        return;
    }
    if (l->has_addend != 0u) {
        for (; s.sums != s.end; s.sums += 2) {
            *s.bytes = conv_byte_of(e, *s.sums, *s.addend, 1u);
            s.bytes += l->to_pitch;
            s.addend += l->addend_pitch;
        }
        return;
    }
    for (; s.sums != s.end; s.sums += 2) {
        *s.bytes = conv_byte_of(e, *s.sums, 0, 0u);
        s.bytes += l->to_pitch;
    }
}
#endif

/* Positions whose sums are computed before they are stored; an even number. */
#define CHUNK 16u

/* Computes the filters `filter` and `next` at all positions. */
static void conv_pair(const conv_layer *l, float *arena, const int8_t *x, uint32_t filter, uint32_t next)
{
    const uint32_t length = (uint32_t)l->segments * l->fours * 4u;
    int32_t sums[2u * CHUNK];
#ifdef VECTORS
    const uint32_t filters[2] = {filter, next};
#endif
    uint32_t position;
    dot_job j;
    j.x = x;
    j.step = l->step;
    j.w = l->weight + filter * length;
    j.v = l->weight + next * length;
    j.start_w = l->start[filter];
    j.start_v = l->start[next];
    j.length = 4u * (uint32_t)l->fours;
    j.segments = l->segments;
    j.gap = (uint32_t)l->apart - j.length;
    for (position = 0; position < l->positions; position += CHUNK) {
        const uint32_t left = l->positions - position;
        const uint32_t count = left < CHUNK ? left : CHUNK;
        j.sums = sums;
        j.pairs = count / 2u;
        if (j.pairs != 0u) {
            dots_2x2(&j);
        }
        if (count % 2u != 0u) {
            dots_1x2(&j);
        }
#ifdef VECTORS
        conv_store_vectors(l, arena, filters, position, sums, count);
#else
        conv_store(l, arena, filter, 0u, position, sums, count);
        if (next != filter) {
            conv_store(l, arena, next, 1u, position, sums + 1, count);
        }
#endif
    }
    CONV_ENDED
}

static void conv(const conv_layer *l, float *arena)
{
    const int8_t *bytes = (const int8_t *)arena + l->from;
    const uint32_t each = (uint32_t)l->filters / l->groups;
    uint32_t first, filter;
    for (first = 0; first < l->filters; first += each) {
        for (filter = first; filter < first + each; filter += 2u) {
            const uint32_t next = filter + 1u < first + each ? filter + 1u : filter;
            conv_pair(l, arena, bytes, filter, next);
        }
        bytes += l->channels;
    }
}
