/* Compares whole numbers with floats for every sum, some of the addends; only where CHECK_ALL_SUMS is defined. */
static void check_all_sums(const conv_layer *layer, uint32_t filter, int32_t reach, uint32_t has_addend)
{
#ifdef CHECK_ALL_SUMS
    static const int32_t addends[4] = {0, -128, 127, 31};
    uint32_t i, different = 0;
    for (i = 0; i < (layer->makes_bytes == 0u ? 0u : (has_addend != 0u ? 4u : 1u)); i++) {
        int32_t sum;
        for (sum = -reach; sum <= reach; sum++) {
            const float value = conv_value(layer, layer->factor[filter], sum, addends[i], has_addend);
            const int8_t byte = byte_of(value, layer->zero, layer->low, layer->high);
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

