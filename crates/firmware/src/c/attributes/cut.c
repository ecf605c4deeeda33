/* Cut at 0 and 1; of bits, so that no optimiser takes -0 for 0. */
static void of_cut(float *row, uint32_t count)
{
    uint32_t i;
    for (i = 0; i < count; i++) {
        const float x = row[i];
        row[i] = bits_of(x) > 0x80000000u ? 0.0f : (x > 1.0f ? 1.0f : x);
    }
}
