static void most(const pool_layer *l, float *arena)
{
    int8_t *bytes = (int8_t *)arena;
    uint32_t position, channel, at;
    for (position = 0; position < l->positions; position++) {
        const span s = l->spans[position];
#ifdef VECTORS
        for (channel = 0; channel < l->channels; channel += 16u) {
            const mve_pred16_t inside = vctp8q(l->channels - channel);
            const int8_t *x = bytes + l->from + (uint32_t)s.from * l->from_pitch + channel;
            int8x16_t best = vdupq_n_s8(-128);
            LINES
            for (at = s.from; at < s.to; at++) {
                best = vmaxq_s8(best, vldrbq_z_s8(x, inside));
                x += l->from_pitch;
            }
            END LINES
            vstrbq_p_s8(bytes + l->to + position * l->to_pitch + channel, best, inside);
        }
#else
        for (channel = 0; channel < l->channels; channel++) {
            const int8_t *x = bytes + l->from + (uint32_t)s.from * l->from_pitch + channel;
            int32_t best = -128;
            LINES
            for (at = s.from; at < s.to; at++) {
                best = *x > best ? *x : best;
                x += l->from_pitch;
            }
            END LINES
            bytes[l->to + position * l->to_pitch + channel] = (int8_t)best;
        }
#endif
    }
}
