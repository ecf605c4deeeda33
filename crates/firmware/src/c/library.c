/* @title@
 *
 * Printed by taxel @version@. Equal models give equal files. The code belongs to the owner of the model; do not edit it,
 * print it again. Predictions have the bits of `taxel predict`. */
#include "taxel_@name@.h"

#include <string.h>

typedef char taxel_@name@_has_floats_of_32_bits[sizeof(float) == 4u ? 1 : -1];
typedef char taxel_@name@_workspace_is_large_enough[sizeof(float) * TAXEL_@NAME@_WORKSPACE >= @arena@u ? 1 : -1];
typedef char taxel_@name@_states_its_ram[sizeof(float) * TAXEL_@NAME@_WORKSPACE == TAXEL_@NAME@_RAM_BYTES ? 1 : -1];

@kernels@
@tables@
const char *const taxel_@name@_class_names[TAXEL_@NAME@_CLASSES] = {
@classes@};

/* One value of a sample, as the first layer reads it. */
typedef @reading@ reading;

@taken@
static inline void put(float *arena, uint32_t channel, uint32_t step, reading value)
{
    reading *to = (reading *)arena;
    to[@stage_to@u + channel * @by_channel@u + step * @by_step@u] = value;
}

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

/* Runs all layers behind the sample, which lies in the arena. */
static void run(float *arena, float *logits)
{
@stage_margins@@calls@    memcpy(logits, (const int8_t *)arena + @logits@, sizeof(float) * TAXEL_@NAME@_CLASSES);
}

static void decide(float *row)
{
    softmax(row, TAXEL_@NAME@_CLASSES);
@temper@}

int taxel_@name@_logits_in(float workspace[TAXEL_@NAME@_WORKSPACE], const float sample[TAXEL_@NAME@_VALUES],
                           float logits[TAXEL_@NAME@_CLASSES])
{
    const int outcome = stage(sample, workspace);
    if (outcome == 0) {
        run(workspace, logits);
    }
    return outcome;
}

int taxel_@name@_predict_in(float workspace[TAXEL_@NAME@_WORKSPACE], const float sample[TAXEL_@NAME@_VALUES],
                            float probabilities[TAXEL_@NAME@_CLASSES])
{
    const int outcome = taxel_@name@_logits_in(workspace, sample, probabilities);
    if (outcome == 0) {
        decide(probabilities);
    }
    return outcome;
}

#ifndef TAXEL_@NAME@_NO_STATIC

static float workspace[TAXEL_@NAME@_WORKSPACE];

int taxel_@name@_logits(const float sample[TAXEL_@NAME@_VALUES], float logits[TAXEL_@NAME@_CLASSES])
{
    return taxel_@name@_logits_in(workspace, sample, logits);
}

int taxel_@name@_predict(const float sample[TAXEL_@NAME@_VALUES], float probabilities[TAXEL_@NAME@_CLASSES])
{
    return taxel_@name@_predict_in(workspace, sample, probabilities);
}

/* The last time steps, the oldest at `oldest`. */
static reading ring[TAXEL_@NAME@_VALUES];
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
        ring[oldest * TAXEL_@NAME@_CHANNELS + channel] = taken(step[channel], channel);
    }
    oldest = oldest + 1u < TAXEL_@NAME@_STEPS ? oldest + 1u : 0u;
    held += held < TAXEL_@NAME@_STEPS ? 1u : 0u;
    return 0;
}

int taxel_@name@_ready(void) { return held == TAXEL_@NAME@_STEPS; }

int taxel_@name@_predict_latest(float probabilities[TAXEL_@NAME@_CLASSES])
{
    uint32_t channel, step;
    if (held != TAXEL_@NAME@_STEPS) {
        return TAXEL_@NAME@_NOT_READY;
    }
    for (step = 0; step < TAXEL_@NAME@_STEPS; step++) {
        const uint32_t from = (oldest + step) % TAXEL_@NAME@_STEPS * TAXEL_@NAME@_CHANNELS;
        for (channel = 0; channel < TAXEL_@NAME@_CHANNELS; channel++) {
            put(workspace, channel, step, ring[from + channel]);
        }
    }
    run(workspace, probabilities);
    decide(probabilities);
    return 0;
}

#endif
