static void most(const pool_layer *l, float *arena)
{
    int8_t *bytes = (int8_t *)arena;
    uint32_t position, channel, at;
    for (position = 0; position < l->positions; position++) {
        const span s = l->spans[position];
        for (channel = 0; channel < l->channels; channel++) {
            const int8_t *x = bytes + l->from + (uint32_t)s.from * l->from_pitch + channel;
            int32_t best = -128;
            for (at = s.from; at < s.to; at++) {
                best = *x > best ? *x : best;
                x += l->from_pitch;
            }
            bytes[l->to + position * l->to_pitch + channel] = (int8_t)best;
        }
    }
}
