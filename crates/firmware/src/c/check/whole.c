/* Compares whole numbers with floats for every sum, some of the addends; only where CHECK_ALL_SUMS is defined. */
static void check_all_sums(const conv_layer *layer, uint32_t filter, int32_t reach, uint32_t has_addend)
{
#ifdef CHECK_ALL_SUMS
    static const int32_t addends[4] = {0, -128, 127, 31};
    uint32_t i, different = 0;
    for (i = 0; i < (layer->makes_bytes == 0u ? 0u : (has_addend != 0u ? 4u : 1u)); i++) {
        int32_t sum;
        for (sum = -reach; sum <= reach; sum++) {
            const conv_ending e = conv_ending_of(layer, filter);
            const int8_t byte = layer->then != 0 ? conv_then_of(e, layer->then, sum, addends[i], has_addend)
                                                : conv_byte_of(e, sum, addends[i], has_addend);
            different += conv_byte(layer, filter, sum, addends[i]) != byte ? 1u : 0u;
        }
    }
    expect("all sums", filter, different, 0u);
#else
    (void)layer;
    (void)filter;
    (void)reach;
    (void)has_addend;
#endif
}

