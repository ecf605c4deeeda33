/* 1 / (1 + e^-x) of each. */
static void of_each(float *row, uint32_t count)
{
    uint32_t i;
    for (i = 0; i < count; i++) {
        const float power = -row[i] > @most@ ? float_of(0x7f800000u) : exponential(-row[i]);
        row[i] = over(1.0f, plus(1.0f, power));
    }
}
