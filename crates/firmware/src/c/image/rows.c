/* One row of an image after the other: how many there are, and how far they are apart. */
static void @name@_rows(const @name@_layer *l, float *arena, uint32_t rows@distances@)
{
    @name@_layer row = *l;
    for (; rows != 0u; rows--) {
        @name@(&row, arena);
@steps@    }
}
