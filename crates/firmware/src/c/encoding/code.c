/* The mean of five readings around a step, edges held. */
static float level_at(const series *s, uint32_t channel, uint32_t step)
{
    float sum = 0.0f;
    uint32_t i;
    for (i = 0; i < 5u; i++) {
        uint32_t at = step + i < 2u ? 0u : step + i - 2u;
        at = at < s->steps ? at : s->steps - 1u;
        sum = i == 0u ? reading_at(s, channel, at) : plus(sum, reading_at(s, channel, at));
    }
    return times(sum, 0.2f);
}

/* One value of a view: the reading, its change, the level, its change over five steps. */
static float view_at(const series *s, uint32_t channel, uint32_t view, uint32_t step)
{
    if (view == 0u) {
        return reading_at(s, channel, step);
    }
    if (view == 1u) {
        return step == 0u ? 0.0f : less(reading_at(s, channel, step), reading_at(s, channel, step - 1u));
    }
    if (view == 2u) {
        return level_at(s, channel, step);
    }
    return step < 5u ? 0.0f : less(level_at(s, channel, step), level_at(s, channel, step - 5u));
}

/* The mean of values on a line, each within bounds. */
static float mean_on(const line *l, const float *values, uint32_t count, float share, float low, float high)
{
    float sum = 0.0f;
    uint32_t i;
    for (i = 0; i < count; i++) {
        float v = times(less(values[i], l->low), l->factor);
        v = v > low ? v : low;
        v = v < high ? v : high;
        sum = plus(sum, v);
    }
    return times(sum, share);
}

static void encode(const series *s, float *arena)
{
    float values[CODE_STRIDE];
    uint32_t number, step, row, i;
    for (number = 0; number < 4u * TAXEL_@NAME@_CHANNELS; number++) {
        const code_view *view = &code_views[number];
        for (step = 0; step < CODE_STEPS; step++) {
            const uint32_t from = step * CODE_STRIDE, left = TAXEL_@NAME@_STEPS - from;
            const uint32_t count = left < CODE_STRIDE ? left : CODE_STRIDE;
            const float share = over(1.0f, (float)count);
            for (i = 0; i < count; i++) {
                values[i] = view_at(s, number / 4u, number % 4u, from + i);
            }
            for (i = 0; i < CODE_ROWS; i++) {
                float v = 0.0f;
                if (i < view->count) {
                    v = mean_on(&ramps[view->first + i], values, count, share, 0.0f, 1.0f);
                }
                row = number * CODE_ROWS + i;
                put(arena, row, step, taken(v, row));
            }
            row = 4u * TAXEL_@NAME@_CHANNELS * CODE_ROWS + number;
            put(arena, row, step, taken(mean_on(&view->score, values, count, share, -8.0f, 8.0f), row));
        }
    }
}
