typedef struct {
    float share, eps;
    uint32_t from, to;
    uint16_t channels, positions, from_pitch;
} float_deviation_layer;

/* The sum of `count` values, or of their squared distances from the mean: four sums side by side. */
static float sum_of(const float *x, uint32_t pitch, uint32_t count, const float *mean)
{
    const uint32_t whole = count - count % 4u;
    float sums[4] = {0.0f, 0.0f, 0.0f, 0.0f};
    uint32_t i;
    for (i = 0; i < count; i++) {
        float *sum = sums + (i < whole ? i % 4u : 0u);
        if (mean != NULL) {
            const float apart = less(*x, *mean);
            *sum = fused(apart, apart, *sum);
        } else {
            *sum = plus(*sum, *x);
        }
        x = &x[pitch];
    }
    return plus(plus(sums[0], sums[1]), plus(sums[2], sums[3]));
}

/* The same of a channel of the layer; where there are few channels, so many positions are taken as one. */
static float sum_over(const float_deviation_layer *l, const float *x, const float *mean)
{
    const uint32_t together = l->channels <= 8u ? 16u / l->channels : 1u, rows = together > 1u ? l->positions / together : 0u;
    float total = 0.0f;
    uint32_t i;
    for (i = 0; i < together && rows != 0u; i++) {
        total = plus(total, sum_of(x + i * l->from_pitch, together * l->from_pitch, rows, mean));
    }
    return plus(total, sum_of(x + rows * together * l->from_pitch, l->from_pitch, l->positions - rows * together, mean));
}

static void float_deviation(const float_deviation_layer *l, float *arena)
{
    uint32_t channel;
    for (channel = 0; channel < l->channels; channel++) {
        const float *x = arena + l->from + channel;
        const float mean = times(sum_over(l, x, NULL), l->share);
        arena[l->to + channel] = root(plus(times(sum_over(l, x, &mean), l->share), l->eps));
    }
}
