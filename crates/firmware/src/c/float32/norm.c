typedef struct {
    const float *weight, *shift;
    float share, eps;
    uint32_t from, to;
    uint16_t features;
} norm_layer;

/* The sum of all values, or of their squared distances from the mean: sixteen sums side by side. */
static float norm_sum(const float *x, uint32_t count, const float *mean)
{
    float sums[16];
    uint32_t i, width;
    for (i = 0; i < 16u; i++) {
        sums[i] = 0.0f;
    }
    for (i = 0; i < count; i++) {
        const float apart = mean != NULL ? less(x[i], *mean) : x[i];
        sums[i % 16u] = plus(sums[i % 16u], mean != NULL ? times(apart, apart) : apart);
    }
    for (width = 8u; width > 0u; width /= 2u) {
        for (i = 0; i < width; i++) {
            sums[i] = plus(sums[i], sums[i + width]);
        }
    }
    return sums[0];
}

static void norm(const norm_layer *l, float *arena)
{
    const float *x = arena + l->from;
    const float mean = times(norm_sum(x, l->features, NULL), l->share);
    const float variance = times(norm_sum(x, l->features, &mean), l->share);
    const float inverse = over(1.0f, root(plus(variance, l->eps)));
    uint32_t i;
    for (i = 0; i < l->features; i++) {
        const float value = times(times(less(x[i], mean), inverse), l->weight[i]);
        arena[l->to + i] = plus(value, l->shift[i]);
    }
}
