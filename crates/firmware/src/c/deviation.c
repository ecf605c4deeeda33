typedef struct {
    float share, eps;
    uint32_t from, to;
    uint16_t channels, positions, from_pitch;
} deviation_layer;

static void deviation(const deviation_layer *l, float *arena)
{
    uint32_t channel, position;
    for (channel = 0; channel < l->channels; channel++) {
        const float *first = arena + l->from / 4u + channel;
        const float *x = first;
        float average = 0.0f, sum = 0.0f;
        for (position = 0; position < l->positions; position++) {
            average = plus(average, *x);
            x += l->from_pitch;
        }
        average = times(average, l->share);
        x = first;
        for (position = 0; position < l->positions; position++) {
            const float apart = less(*x, average);
            sum = plus(sum, times(apart, apart));
            x += l->from_pitch;
        }
        arena[l->to / 4u + channel] = root(plus(times(sum, l->share), l->eps));
    }
}
