/* One row of outputs of an image after the other. */
static void pool_rows(const pool_layer *l, float *arena, void (*pool)(const pool_layer *, float *))
{
    pool_layer row = *l;
    uint32_t i;
    for (i = 0; i < l->row_count; i++) {
        const span s = l->rows[i];
        row.from = l->from + s.from * l->from_row;
        row.lines = (uint32_t)s.to - s.from;
        pool(&row, arena);
        row.to += l->to_row;
        if (l->tables != 0u) {
            row.factor += l->tables;
            row.shift = l->shift != NULL ? row.shift + l->tables : NULL;
        }
    }
}
