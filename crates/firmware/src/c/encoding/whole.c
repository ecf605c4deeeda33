static int stage(const float *sample, float *arena)
{
    const series s = {sample, TAXEL_@NAME@_STEPS, 1u, 0u, TAXEL_@NAME@_STEPS};
    uint32_t i;
    for (i = 0; i < TAXEL_@NAME@_VALUES; i++) {
        if (!is_finite(sample[i])) {
            return TAXEL_@NAME@_NOT_FINITE;
        }
    }
    encode(&s, arena);
    return 0;
}

static inline void stage_ring(const kept *ring, uint32_t oldest, float *arena)
{
    const series s = {ring, 1u, TAXEL_@NAME@_CHANNELS, oldest, TAXEL_@NAME@_RING_STEPS};
    encode(&s, arena);
}
