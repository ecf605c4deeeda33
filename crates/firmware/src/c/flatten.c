/* Floats, channels last, as channels first. */
static void flatten(float *arena, uint32_t from, uint32_t from_pitch, uint32_t to, uint32_t channels, uint32_t positions)
{
    uint32_t position, channel;
    for (channel = 0; channel < channels; channel++) {
        for (position = 0; position < positions; position++) {
            arena[to / 4u + channel * positions + position] = arena[from / 4u + position * from_pitch + channel];
        }
    }
}
