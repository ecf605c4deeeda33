/* The logarithm of a positive normal number within 2 units in the last place. */
static float logarithm(float x)
{
    static const float coefficients[9] = { LN_COEFFICIENTS };
    const uint32_t bits = bits_of(x) - 0x3f3504f3u;
    const int32_t exponent = (int32_t)(bits >> 23) - (bits >= 0x80000000u ? 512 : 0);
    const float power = (float)exponent;
    const float fraction = less(float_of((bits & 0x7fffffu) + 0x3f3504f3u), 1.0f);
    const float square = times(fraction, fraction);
    float sum = coefficients[0];
    uint32_t i;
    for (i = 1; i < 9u; i++) {
        sum = plus(times(sum, fraction), coefficients[i]);
    }
    sum = plus(times(times(sum, fraction), square), times(power, LN_2_LOW));
    sum = less(sum, times(0.5f, square));
    return plus(plus(fraction, sum), times(power, LN_2_HIGH));
}

/* Divides the logits of probabilities by the temperature of the model's calibration. */
static void temper(float *row, uint32_t count)
{
    float largest = 0x1.0p-126f;
    uint32_t i;
    for (i = 0; i < count; i++) {
        largest = row[i] > largest ? row[i] : largest;
    }
    largest = logarithm(largest);
    for (i = 0; i < count; i++) {
        const float p = row[i] > 0x1.0p-126f ? row[i] : 0x1.0p-126f;
        row[i] = exponential(times(less(logarithm(p), largest), INVERSE_TEMPERATURE));
    }
    shares(row, count);
}
