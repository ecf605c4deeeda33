static void linear(float *arena)
{
    uint32_t i;
    clear_sums(arena);
    for (i = 0; i < TAXEL_@NAME@_VALUES; i++) {
        add_feature(arena, i, arena[i]);
    }
    put_outputs(arena);
}
