/* The last step of each channel, then the mean of each. */
static void levels(float *arena, uint32_t number)
{
    uint32_t channel, t;
    for (channel = 0; channel < TAXEL_@NAME@_CHANNELS; channel++) {
        const float *x = arena + channel * TAXEL_@NAME@_STEPS;
        volatile double sum = 0.0, count = (double)TAXEL_@NAME@_STEPS;
        for (t = 0; t < TAXEL_@NAME@_STEPS; t++) {
            sum = sum + (double)x[t];
        }
        add_feature(arena, number + channel, x[TAXEL_@NAME@_STEPS - 1u]);
        sum = sum / count;
        add_feature(arena, number + TAXEL_@NAME@_CHANNELS + channel, (float)sum);
    }
}

