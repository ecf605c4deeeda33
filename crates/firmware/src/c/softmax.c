/* e^x within 2 units in the last place; 0 below the normal numbers. */
static float exponential(float x)
{
    static const float coefficients[6] = { EXP_COEFFICIENTS };
    float shifted, power, rest, sum;
    uint32_t i;
    if (x < EXP_LEAST) {
        return 0.0f;
    }
    shifted = plus(times(x, LOG2_E), ROUND);
    power = less(shifted, ROUND);
    rest = less(less(x, times(power, LN_2_HIGH)), times(power, LN_2_LOW));
    sum = coefficients[0];
    for (i = 1; i < 6u; i++) {
        sum = plus(times(sum, rest), coefficients[i]);
    }
    sum = plus(plus(times(times(sum, rest), rest), rest), 1.0f);
    return times(sum, float_of((bits_of(shifted) << 23) + 0x3f800000u));
}

/* Divides by the sum; 0 below the normal numbers. */
static void shares(float *row, uint32_t count)
{
    float sum = 0.0f;
    uint32_t i;
    for (i = 0; i < count; i++) {
        sum = plus(sum, row[i]);
    }
    for (i = 0; i < count; i++) {
        const float share = over(row[i], sum);
        row[i] = share < 0x1.0p-126f ? 0.0f : share;
    }
}

static void softmax(float *row, uint32_t count)
{
    float largest = row[0];
    uint32_t i;
    for (i = 1; i < count; i++) {
        largest = row[i] > largest ? row[i] : largest;
    }
    for (i = 0; i < count; i++) {
        row[i] = exponential(less(row[i], largest));
    }
    shares(row, count);
}
