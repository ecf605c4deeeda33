typedef char taxel_@name@_sums_in_64_bits[sizeof(double) == 8u ? 1 : -1];

/* Doubles lie in the arena as bytes, for floats lie at multiples of four. */
static inline double double_at(const float *arena, uint32_t place)
{
    double x;
    (void)memcpy(&x, arena + place, sizeof x);
    return x;
}

static void clear_sums(float *arena) { (void)memset(arena + @sums@, 0, sizeof(float) * 32u * OUTPUTS); }

/* Adds a feature to one of the sixteen sums of each output. Products of floats are exact in doubles. */
static void add_feature(float *arena, uint32_t number, float value)
{
    const float *weight = &ridge_weight[number * OUTPUTS];
    float *at = arena + @sums@ + 2u * (number % 16u);
    uint32_t k;
    for (k = 0; k < OUTPUTS; k++) {
        const double sum = double_at(at, 32u * k) + (double)value * (double)weight[k];
        (void)memcpy(at + 32u * k, &sum, sizeof sum);
    }
}

/* Adds the sums pairwise. */
static void put_outputs(float *arena)
{
    volatile double sums[16];
    uint32_t k, i, left;
    for (k = 0; k < OUTPUTS; k++) {
        for (i = 0; i < 16u; i++) {
            sums[i] = double_at(arena, @sums@ + 32u * k + 2u * i);
        }
        for (left = 8u; left > 0u; left /= 2u) {
            for (i = 0; i < left; i++) {
                sums[i] = sums[i] + sums[i + left];
            }
        }
        sums[0] = sums[0] + (double)ridge_bias[k];
        arena[@row_outputs@ + k] = (float)sums[0];
    }
}
