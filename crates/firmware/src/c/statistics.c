static void conv_statistics(const conv_layer *l, const float *row, float *arena, uint32_t filter)
{
    const statistic_list *all = l->statistics;
    const uint32_t positions = l->positions;
    uint32_t i, at;
    for (i = 0; i < all->count; i++) {
        const statistic *s = &all->list[i];
        float result;
        if (s->kind == 1u) {
            result = row[0];
            for (at = 1; at < positions; at++) {
                result = is_above(row[at], result) ? row[at] : result;
            }
        } else {
            float sum = 0.0f;
            for (at = 0; at < positions; at++) {
                sum = plus(sum, row[at]);
            }
            result = times(sum, s->share);
            DEVIATION
        }
        arena[s->to / 4u + filter] = result;
    }
}

