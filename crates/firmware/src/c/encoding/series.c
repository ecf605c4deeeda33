/* A value as the ring keeps it. */
typedef float kept;

static inline kept kept_of(float x, uint32_t channel)
{
    (void)channel;
    return x;
}

/* A sample, or a ring of time steps: distances of channels and of steps, the first step and their number. */
typedef struct {
    const float *values;
    uint32_t by_channel, by_step, first, steps;
} series;

static inline float reading_at(const series *s, uint32_t channel, uint32_t step)
{
    step += s->first;
    step -= step < s->steps ? 0u : s->steps;
    return s->values[channel * s->by_channel + step * s->by_step];
}
