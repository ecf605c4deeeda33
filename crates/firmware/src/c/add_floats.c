typedef struct {
    float low, high;
    uint32_t a, b, to;
    uint16_t channels, positions, a_pitch, b_pitch, to_pitch;
} add_floats_layer;

static void add_floats(const add_floats_layer *l, float *arena)
{
    uint32_t position, channel;
    for (position = 0; position < l->positions; position++) {
        for (channel = 0; channel < l->channels; channel++) {
            const float a = arena[l->a / 4u + position * l->a_pitch + channel];
            const float b = arena[l->b / 4u + position * l->b_pitch + channel];
            arena[l->to / 4u + position * l->to_pitch + channel] = ended(plus(a, b), 0.0f, l->low, l->high);
        }
    }
}
