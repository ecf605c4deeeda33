
/* The root mean square of the differences between neighbouring rows. */
static float across_of(const float *sample)
{
    const uint32_t pairs = (@channel_count@u - 1u) * @steps_of_channel@u;
    float squares[9] = {0};
    uint32_t i;
    for (i = 0; i < pairs; i++) {
        const float apart = less(sample[i + @steps_of_channel@u], sample[i]);
        float *const square = &squares[i < pairs / 8u * 8u ? i % 8u : 8u];
        *square = plus(*square, times(apart, apart));
    }
    return root(over(total_of(squares), pairs > 0u ? (float)pairs : 1.0f));
}
