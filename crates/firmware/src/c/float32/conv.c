typedef struct {
    const float *weight; /* of four filters at a time: segments x run x 4 */
    const float *bias;
    uint32_t from, to, addend;
    uint16_t step, segments, apart, run, groups, channels, filters, positions, to_pitch, addend_pitch;
    uint8_t has_addend, rectifier;
} float_conv_layer;

/* Sums of four filters at neighbouring positions: stretches of inputs, their length, and the floats between them. */
typedef struct {
    const float *w;
    four start;
    uint32_t segments, run, gap;
} float_job;

/* At four positions, whose inputs are `step` apart. */
static void float_sums_4x4(const float_job *j, const float *x, uint32_t step, four sums[4])
{
    const float *a = x, *b = a + step, *c = b + step, *d = c + step, *w = j->w;
    four s0 = j->start, s1 = j->start, s2 = j->start, s3 = j->start;
    uint32_t segment = j->segments;
    do {
        uint32_t left = j->run;
        do {
            const four v = four_at(w);
            s0 = four_fused(*a, v, s0);
            s1 = four_fused(*b, v, s1);
            s2 = four_fused(*c, v, s2);
            s3 = four_fused(*d, v, s3);
            a++;
            b++;
            c++;
            d++;
            w = &w[4];
            left--;
        } while (left != 0u);
        a += j->gap;
        b += j->gap;
        c += j->gap;
        d += j->gap;
        segment--;
    } while (segment != 0u);
    sums[0] = s0;
    sums[1] = s1;
    sums[2] = s2;
    sums[3] = s3;
}

/* At one position. */
static void float_sums_1x4(const float_job *j, const float *x, four sums[4])
{
    const float *w = j->w;
    four s = j->start;
    uint32_t segment = j->segments;
    do {
        uint32_t left = j->run;
        do {
            s = four_fused(*x, four_at(w), s);
            x++;
            w = &w[4];
            left--;
        } while (left != 0u);
        x += j->gap;
        segment--;
    } while (segment != 0u);
    sums[0] = s;
}

/* Computes up to four filters from `filter` on, whose inputs begin at `x`, at all positions. */
static void float_filters(const float_conv_layer *l, const float_job *j, const float *x, float *arena, uint32_t filter,
                          uint32_t width)
{
    float *y = arena + l->to + filter;
    const float *addend = l->has_addend != 0u ? arena + l->addend + filter : NULL;
    uint32_t position = 0, i;
    while (position < l->positions) {
        uint32_t count = 4u;
        four sums[4];
        if (position + 4u <= l->positions) {
            float_sums_4x4(j, x, l->step, sums);
        } else {
            float_sums_1x4(j, x, sums);
            count = 1u;
        }
        for (i = 0; i < count; i++) {
            store_four(y, sums[i], addend, width, l->rectifier);
            y += l->to_pitch;
            addend = addend != NULL ? addend + l->addend_pitch : NULL;
        }
        x += count * l->step;
        position += count;
    }
}

static void float_conv(const float_conv_layer *l, float *arena)
{
    const uint32_t each = (uint32_t)l->filters / l->groups, depth = (uint32_t)l->segments * l->run;
    const float *x = arena + l->from, *bias = l->bias;
    uint32_t group, first;
    float_job j;
    j.w = l->weight;
    j.segments = l->segments;
    j.run = l->run;
    j.gap = (uint32_t)l->apart - l->run;
    for (group = 0; group < l->groups; group++) {
        for (first = 0; first < each; first += 4u) {
            j.start = four_at(bias);
            float_filters(l, &j, x, arena, group * each + first, each - first < 4u ? each - first : 4u);
            j.w += 4u * depth;
            bias = &bias[4];
        }
        x += l->channels;
    }
}
