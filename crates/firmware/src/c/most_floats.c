static void most_floats(const pool_layer *l, float *arena)
{
    uint32_t position, channel, at;
    for (position = 0; position < l->positions; position++) {
        const span s = l->spans[position];
        for (channel = 0; channel < l->channels; channel++) {
            const float *x = arena + l->from / 4u + (uint32_t)s.from * l->from_pitch + channel;
            float best = *x;
            LINES
            for (at = s.from; at < s.to; at++) {
                best = *x > best ? *x : best;
                x += l->from_pitch;
            }
            END LINES
            arena[l->to / 4u + position * l->to_pitch + channel] = best;
        }
    }
}
