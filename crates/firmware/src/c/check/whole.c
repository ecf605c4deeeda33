/* The byte and the float that are stored for a sum. */
#ifdef VECTORS
static float32x4_t conv_value_of(const conv_layer *l, uint32_t filter, int32_t sum, int32_t addend)
{
    return conv_value4(l, vdupq_n_f32(l->factor[filter]), ending4_of(l->zero, l->low, l->high), vdupq_n_s32(sum),
                       vdupq_n_s32(addend), l->has_addend, l->then);
}

static int8_t conv_byte(const conv_layer *l, uint32_t filter, int32_t sum, int32_t addend)
{
    return (int8_t)vgetq_lane_s32(bytes4_of(conv_value_of(l, filter, sum, addend)), 0);
}

static float conv_float(const conv_layer *l, uint32_t filter, int32_t sum, int32_t addend)
{
    return vgetq_lane_f32(conv_value_of(l, filter, sum, addend), 0);
}
#else
static int8_t conv_by_floats(const conv_layer *l, uint32_t filter, int32_t sum, int32_t addend)
{
    const conv_ending e = conv_ending_of(l, filter);
    return l->then != NULL ? conv_then_of(e, l->then, sum, addend, l->has_addend)
                        : conv_byte_of(e, sum, addend, l->has_addend);
}

static int8_t conv_byte(const conv_layer *l, uint32_t filter, int32_t sum, int32_t addend)
{
#ifdef WHOLE_ENDINGS
    if (l->multiplier != NULL) {
        const int32_t base = l->has_addend != 0u ? base_of(l->base, addend, l->addend_multiplier) : l->base;
        const int32_t whole = conv_whole_of(l->multiplier[filter], l->shift, base, sum);
        return is_doubtful(whole) ? conv_doubtful(l, filter, sum, addend) : byte_of_whole(whole);
    }
#endif
    return conv_by_floats(l, filter, sum, addend);
}

static float conv_float(const conv_layer *l, uint32_t filter, int32_t sum, int32_t addend)
{
    return conv_float_of(conv_ending_of(l, filter), sum, addend, l->has_addend);
}
#endif

/* Compares whole numbers with floats for every sum, some of the addends; only where CHECK_ALL_SUMS is defined. */
static void check_all_sums(const conv_layer *layer, uint32_t filter, int32_t reach, uint32_t has_addend)
{
#ifdef CHECK_ALL_SUMS
    static const int32_t addends[4] = {0, -128, 127, 31};
    uint32_t i, different = 0;
    for (i = 0; i < (layer->makes_bytes == 0u ? 0u : (has_addend != 0u ? 4u : 1u)); i++) {
        int32_t sum;
        for (sum = -reach; sum <= reach; sum++) {
            const int8_t byte = conv_by_floats(layer, filter, sum, addends[i]);
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

