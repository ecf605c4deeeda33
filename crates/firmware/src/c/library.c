/* @title@
 *
 * Printed by taxel @version@. Equal models give equal files. The code belongs to the owner of the model; do not edit it,
 * print it again. Predictions have the bits of `taxel predict`. */
#include "taxel_@name@.h"

#include <string.h>

typedef char taxel_@name@_has_floats_of_32_bits[sizeof(float) == 4u ? 1 : -1];
typedef char taxel_@name@_workspace_is_large_enough[sizeof(float) * TAXEL_@NAME@_WORKSPACE >= @arena@u ? 1 : -1];
typedef char taxel_@name@_states_its_ram[sizeof(float) * TAXEL_@NAME@_WORKSPACE == TAXEL_@NAME@_RAM_BYTES ? 1 : -1];

#define OUTPUTS @outputs@u

@kernels@
@tables@
/* One value of the input, as the first layer reads it. */
typedef @reading@ reading;

@encoding@
/* Runs all layers behind the input, which lies in the arena. */
static void run(float *arena, float *outputs)
{
@stage_margins@@calls@    (void)memcpy(outputs, @logits@, sizeof(float) * OUTPUTS);
}

/* Computes the outputs of one sample. */
static int outputs_of(float *arena, const float *sample, float *outputs)
{
    const int outcome = stage(sample, arena);
    if (outcome == 0) {
        run(arena, outputs);
    }
    return outcome;
}

#ifndef TAXEL_@NAME@_NO_STATIC

static float own_workspace[TAXEL_@NAME@_WORKSPACE];
@live@
/* The last time steps, the oldest at `oldest`. */
static kept ring[TAXEL_@NAME@_RING_STEPS * TAXEL_@NAME@_CHANNELS];
static uint32_t oldest, held;

void taxel_@name@_clear(void)
{
    oldest = 0;
    held = 0;
}

int taxel_@name@_push(const float step[TAXEL_@NAME@_CHANNELS])
{
    uint32_t channel;
    for (channel = 0; channel < TAXEL_@NAME@_CHANNELS; channel++) {
        if (!is_finite(step[channel])) {
            return TAXEL_@NAME@_NOT_FINITE;
        }
    }
    for (channel = 0; channel < TAXEL_@NAME@_CHANNELS; channel++) {
        ring[oldest * TAXEL_@NAME@_CHANNELS + channel] = kept_of(step[channel], channel);
    }
    oldest = oldest + 1u < TAXEL_@NAME@_RING_STEPS ? oldest + 1u : 0u;
    held += held < TAXEL_@NAME@_RING_STEPS ? 1u : 0u;
    return 0;
}

int taxel_@name@_ready(void) { return held == TAXEL_@NAME@_RING_STEPS; }

/* Computes the outputs of the last time steps. */
static int outputs_of_ring(float *outputs)
{
    if (held != TAXEL_@NAME@_RING_STEPS) {
        return TAXEL_@NAME@_NOT_READY;
    }
    stage_ring(ring, oldest, own_workspace);
    run(own_workspace, outputs);
    return 0;
}
@end live@

#endif

@answers@