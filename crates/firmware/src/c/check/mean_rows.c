/* One row of outputs, from the first number of its windows on. */
static void check_means(const char *name, const pool_layer *l, const uint32_t *wanted, uint32_t first)
{
    uint32_t position;
    int32_t sum;
    for (position = 0; position < l->positions; position++) {
        const span s = l->spans[position];
        const int32_t inside = (int32_t)l->lines * ((int32_t)s.to - (int32_t)s.from);
        begin();
        for (sum = 0; sum <= 255 * inside; sum++) {
            if (l->makes_bytes != 0u) {
                add_word((uint32_t)((int32_t)mean_byte(l, position, sum) + 128));
            } else {
                add_word(bits_of(mean_float(l, position, sum)));
            }
        }
        expect(name, first + position, digest, wanted[first + position]);
    }
}

static void check_mean(const char *name, const pool_layer *layer, const uint32_t *wanted)
{
    pool_layer l = *layer;
    uint32_t row;
    check_means(name, &l, wanted, 0u);
    for (row = 1; layer->tables != 0u && row < layer->row_count; row++) {
        const span s = layer->rows[row];
        l.lines = (uint32_t)s.to - s.from;
        l.factor += layer->tables;
        l.shift += layer->tables;
        check_means(name, &l, wanted, row * layer->tables);
    }
}

