static void encode(const series *s, float *arena)
{
    uint32_t channel, i, row = 0;
    for (channel = 0; channel < TAXEL_@NAME@_CHANNELS; channel++) {
        const float last = reading_at(s, channel, s->steps - 1u);
        put(arena, row, 0u, taken(last, row));
        row++;
        for (i = 0; i < lag_count; i++) {
            const float before = reading_at(s, channel, s->steps - 1u - lags[i]);
            put(arena, row, 0u, taken(less(last, before), row));
            row++;
        }
    }
}
