#ifdef VECTORS
/* Two filters at two positions, with these distances. */
INLINE uint32x4_t places_of(uint32_t next_filter, uint32_t next_position)
{
    const uint32x4_t number = vidupq_n_u32(0u, 1);
    const uint32x4_t filters = vmulq_n_u32(vandq_u32(number, vdupq_n_u32(1u)), next_filter);
    return vaddq_u32(filters, vmulq_n_u32(vshrq_n_u32(number, 1), next_position));
}

/* Stores sums of two filters, two positions at once, as conv_float_of, conv_byte_of and conv_then_of do. Behind an odd
 * number of positions the last two sums are there once more. */
static void conv_store_vectors(const conv_layer *l, float *arena, const uint32_t filter[2], uint32_t first,
                               const int32_t *sums, uint32_t count)
{
    const uint32_t pitch = l->to_pitch, addend_pitch = l->addend_pitch;
    const uint32_t apart = filter[1] - filter[0], next = l->statistics != NULL ? apart * l->positions : apart;
    const uint32_t at = first * pitch + (l->statistics != NULL ? 0u : filter[0]);
    const int8_t *addend = (const int8_t *)arena + l->addend + first * addend_pitch + filter[0];
    const ending4 e = ending4_of(l->zero, l->low, l->high);
    int8_t *to = (int8_t *)arena + l->to + at;
    float *floats = arena + l->to / 4u + at;
    float32x4_t factor = vdupq_n_f32(l->factor[filter[0]]);
    uint32x4_t places = places_of(next, pitch), of_addend = places_of(apart, addend_pitch);
    const uint32_t is_plain = l->makes_bytes != 0u && l->then == NULL && l->has_addend == 0u ? 1u : 0u;
    uint32_t left = count;
    factor = vsetq_lane_f32(l->factor[filter[1]], factor, 1);
    factor = vsetq_lane_f32(l->factor[filter[1]], factor, 3);
    while (left != 0u) {
        uint32_t twos = left / 2u;
        if (twos == 0u) {
            places = places_of(next, 0u);
            of_addend = places_of(apart, 0u);
            twos = 1u;
        }
        left = left % 2u * (left > 1u ? 1u : 0u);
        if (is_plain != 0u) {
            for (; twos != 0u; twos--) {
                const int32x4_t four = vldrwq_s32(sums);
                vstrbq_scatter_offset_s32(to, places, bytes4_of(conv_value4(l, factor, e, four, four, 0u, NULL)));
                sums += 4;
                to += 2u * pitch;
            }
            continue;
        }
        for (; twos != 0u; twos--) {
            const int32x4_t added = vldrbq_gather_offset_s32(addend, of_addend);
            const float32x4_t value = conv_value4(l, factor, e, vldrwq_s32(sums), added, l->has_addend, l->then);
            if (l->makes_bytes != 0u) {
                vstrbq_scatter_offset_s32(to, places, bytes4_of(value));
            } else {
                vstrwq_scatter_shifted_offset_f32(floats, places, value);
            }
            addend += 2u * addend_pitch;
            sums += 4;
            to += 2u * pitch;
            floats += 2u * pitch;
        }
    }
}
#endif

