/* A convolution of an image of which numbers of each filter's values remain: two filters at all rows, then the next two. */
static void conv_numbers(const conv_layer *l, float *arena, uint32_t rows, uint32_t from_row, uint32_t addend_row)
{
    const uint32_t length = (uint32_t)l->segments * l->fours * 4u;
    conv_layer all = *l;
    uint32_t filter;
    all.positions = (uint16_t)(rows * l->positions);
    for (filter = 0; filter < l->filters; filter += 2u) {
        const uint32_t is_pair = filter + 1u < l->filters ? 1u : 0u;
        conv_layer two = *l;
        uint32_t row;
        two.weight += filter * length;
        two.start += filter;
        two.factor += filter;
        two.addend += filter;
        two.filters = (uint16_t)(1u + is_pair);
        two.statistics = NULL;
        for (row = 0; row < rows; row++) {
            conv(&two, arena);
            two.from += from_row;
            two.addend += addend_row;
            two.to += 8u * l->positions;
        }
        conv_statistics(&all, arena + l->to / 4u, arena, filter);
        if (is_pair != 0u) {
            conv_statistics(&all, arena + l->to / 4u + 1u, arena, filter + 1u);
        }
    }
}
