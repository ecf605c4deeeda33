static void shuffle(float *arena, uint32_t from, uint32_t from_pitch, uint32_t to, uint32_t to_pitch, uint32_t channels,
                    uint32_t groups, uint32_t positions)
{
    int8_t *bytes = (int8_t *)arena;
    const uint32_t each = channels / groups;
    uint32_t position, channel;
    for (position = 0; position < positions; position++) {
        const int8_t *x = bytes + from + position * from_pitch;
        int8_t *y = bytes + to + position * to_pitch;
        for (channel = 0; channel < channels; channel++) {
            y[channel % each * groups + channel / each] = x[channel];
        }
    }
}
