/* Weights are 2 and -1: products are exact, and sums are added in the order of channels and taps. */
static void convolve(const dilated *c, const float *values, float *row)
{
    uint32_t i, tap, t;
    for (t = 0; t < TAXEL_@NAME@_STEPS; t++) {
        row[t] = 0.0f;
    }
    for (i = 0; i < c->channels; i++) {
        const float *x = values + rocket_channels[c->first_channel + i] * TAXEL_@NAME@_STEPS;
        for (tap = 0; tap < 9u; tap++) {
            const uint32_t back = tap < 4u ? (4u - tap) * c->dilation : 0u;
            const uint32_t ahead = tap > 4u ? (tap - 4u) * c->dilation : 0u;
            if (tap == c->twos[0] || tap == c->twos[1] || tap == c->twos[2]) {
                for (t = back; t < TAXEL_@NAME@_STEPS - ahead; t++) {
                    row[t] = plus(row[t], times(2.0f, x[t - back + ahead]));
                }
            } else {
                for (t = back; t < TAXEL_@NAME@_STEPS - ahead; t++) {
                    row[t] = less(row[t], x[t - back + ahead]);
                }
            }
        }
    }
}

@levels@
static void linear(float *arena)
{
    float *row = arena + @row@;
    uint32_t which, i, t, number = 0;
    clear_sums(arena);
    for (which = 0; which < CONVOLUTIONS; which++) {
        const dilated *c = &convolutions[which];
        convolve(c, arena, row);
        for (i = 0; i < c->biases; i++) {
            const float bias = rocket_biases[c->first_bias + i];
            uint32_t count = 0;
            for (t = c->from; t < c->to; t++) {
                count += row[t] > bias ? 1u : 0u;
            }
            if (count != 0u) {
                const uint32_t positions = (uint32_t)c->to - c->from;
                add_feature(arena, number, over((float)count, (float)positions));
            }
            number++;
        }
    }
    @call_levels@
    put_outputs(arena);
}
