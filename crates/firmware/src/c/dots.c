#if defined(__ARM_FEATURE_DSP) && defined(__GNUC__)

static inline uint32_t four(const int8_t *p)
{
    uint32_t word;
    memcpy(&word, p, sizeof word);
    return word;
}

/* The first and third, the second and fourth byte of a word as pairs of 16 bits. */
static inline uint32_t even(uint32_t x)
{
    uint32_t pair;
    __asm__("sxtb16 %0, %1" : "=r"(pair) : "r"(x));
    return pair;
}

static inline uint32_t odd(uint32_t x)
{
    uint32_t pair;
    __asm__("sxtb16 %0, %1, ror #8" : "=r"(pair) : "r"(x));
    return pair;
}

static inline int32_t dot_pair(uint32_t a, uint32_t b, int32_t sum)
{
    int32_t result;
    __asm__("smlad %0, %1, %2, %3" : "=r"(result) : "r"(a), "r"(b), "r"(sum));
    return result;
}

static inline void dot_2x2(const conv_layer *l, const int8_t *x, const int8_t *y, const int8_t *w, const int8_t *v,
                           int32_t *of_w, int32_t *of_v)
{
    int32_t s0 = *of_w, s1 = *of_v, s2 = s0, s3 = s1;
    const uint32_t gap = (uint32_t)l->apart - 4u * (uint32_t)l->fours;
    uint32_t segment = l->segments;
    do {
        const int8_t *end = x + 4u * (uint32_t)l->fours;
        do {
            const uint32_t a = four(x), b = four(y), c = four(w), d = four(v);
            const uint32_t a0 = even(a), b0 = even(b), c0 = even(c), d0 = even(d);
            const uint32_t a1 = odd(a), b1 = odd(b), c1 = odd(c), d1 = odd(d);
            s0 = dot_pair(a0, c0, s0);
            s1 = dot_pair(a0, d0, s1);
            s2 = dot_pair(b0, c0, s2);
            s3 = dot_pair(b0, d0, s3);
            s0 = dot_pair(a1, c1, s0);
            s1 = dot_pair(a1, d1, s1);
            s2 = dot_pair(b1, c1, s2);
            s3 = dot_pair(b1, d1, s3);
            x += 4;
            y += 4;
            w += 4;
            v += 4;
        } while (x != end);
        x += gap;
        y += gap;
        segment--;
    } while (segment != 0u);
    of_w[0] = s0;
    of_v[0] = s1;
    of_w[1] = s2;
    of_v[1] = s3;
}

static inline void dot_1x2(const conv_layer *l, const int8_t *x, const int8_t *w, const int8_t *v, int32_t *of_w,
                           int32_t *of_v)
{
    int32_t s0 = *of_w, s1 = *of_v;
    const uint32_t gap = (uint32_t)l->apart - 4u * (uint32_t)l->fours;
    uint32_t segment = l->segments;
    do {
        const int8_t *end = x + 4u * (uint32_t)l->fours;
        do {
            const uint32_t a = four(x), c = four(w), d = four(v);
            const uint32_t a0 = even(a), a1 = odd(a);
            s0 = dot_pair(a0, even(c), s0);
            s1 = dot_pair(a0, even(d), s1);
            s0 = dot_pair(a1, odd(c), s0);
            s1 = dot_pair(a1, odd(d), s1);
            x += 4;
            w += 4;
            v += 4;
        } while (x != end);
        x += gap;
        segment--;
    } while (segment != 0u);
    *of_w = s0;
    *of_v = s1;
}

#else

/* One input of both positions times one weight of both filters. */
#define STEP(k)                                                   \
    {                                                             \
        const int32_t a = x[k], b = y[k], c = w[k], d = v[k];     \
        s0 += a * c;                                              \
        s1 += a * d;                                              \
        s2 += b * c;                                              \
        s3 += b * d;                                              \
    }

static inline void dot_2x2(const conv_layer *l, const int8_t *x, const int8_t *y, const int8_t *w, const int8_t *v,
                           int32_t *of_w, int32_t *of_v)
{
    int32_t s0 = *of_w, s1 = *of_v, s2 = s0, s3 = s1;
    const uint32_t length = 4u * (uint32_t)l->fours;
    uint32_t segment;
    for (segment = 0; segment < l->segments; segment++) {
        uint32_t k;
        for (k = 0; k < length; k += 4u) {
            STEP(k)
            STEP(k + 1u)
            STEP(k + 2u)
            STEP(k + 3u)
        }
        x += l->apart;
        y += l->apart;
        w += length;
        v += length;
    }
    of_w[0] = s0;
    of_v[0] = s1;
    of_w[1] = s2;
    of_v[1] = s3;
}

static inline void dot_1x2(const conv_layer *l, const int8_t *x, const int8_t *w, const int8_t *v, int32_t *of_w,
                           int32_t *of_v)
{
    int32_t s0 = *of_w, s1 = *of_v;
    const uint32_t length = 4u * (uint32_t)l->fours;
    uint32_t segment;
    for (segment = 0; segment < l->segments; segment++) {
        uint32_t k;
        for (k = 0; k < length; k++) {
            const int32_t a = x[k];
            s0 += a * w[k];
            s1 += a * v[k];
        }
        x += l->apart;
        w += length;
        v += length;
    }
    *of_w = s0;
    *of_v = s1;
}

#endif
