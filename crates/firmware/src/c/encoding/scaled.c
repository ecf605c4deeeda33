@live@
/* A value as the ring keeps it. */
typedef reading kept;

static inline kept kept_of(float x, uint32_t channel) { return taken(x, channel); }

@end live@
static int stage(const float *sample, float *arena)
{
    uint32_t channel, step;
    for (channel = 0; channel < TAXEL_@NAME@_CHANNELS; channel++) {
        for (step = 0; step < TAXEL_@NAME@_STEPS; step++) {
            const float x = sample[channel * TAXEL_@NAME@_STEPS + step];
            if (!is_finite(x)) {
                return TAXEL_@NAME@_NOT_FINITE;
            }
            put(arena, channel, step, taken(x, channel));
        }
    }
    return 0;
}
@live@

static inline void stage_ring(const kept *ring, uint32_t oldest, float *arena)
{
    uint32_t channel, step;
    for (step = 0; step < TAXEL_@NAME@_STEPS; step++) {
        const uint32_t from = (oldest + step) % TAXEL_@NAME@_STEPS * TAXEL_@NAME@_CHANNELS;
        for (channel = 0; channel < TAXEL_@NAME@_CHANNELS; channel++) {
            put(arena, channel, step, ring[from + channel]);
        }
    }
}
@end live@
