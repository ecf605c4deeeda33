/* Checks on this processor that predictions have the bits of `taxel predict`: samples, and every threshold of every
 * layer's ending. Returns 0 and prints "equal" if they have. */
#include <stdio.h>

#include "../src/taxel_@name@.c"
#include "vectors.h"

/* Only every so many filters are checked, for slow processors. */
#ifndef CHECK_EVERY
#define CHECK_EVERY 1u
#endif

static uint32_t random_state = SAMPLE_SEED;

static uint32_t random_number(void)
{
    random_state ^= random_state << 13;
    random_state ^= random_state >> 17;
    random_state ^= random_state << 5;
    return random_state >> 8;
}

static void make_sample(float *sample)
{
    uint32_t channel, step;
    for (channel = 0; channel < TAXEL_@NAME@_CHANNELS; channel++) {
        const int32_t low = walk_low[channel], high = walk_high[channel];
        const uint32_t span_of = (uint32_t)(high - low), most_of = span_of / 8u + 1u;
        int32_t at = low + (int32_t)(random_number() % (span_of + 1u));
        for (step = 0; step < TAXEL_@NAME@_STEPS; step++) {
            sample[channel * TAXEL_@NAME@_STEPS + step] = (float)at * walk_unit[channel];
            at += (int32_t)(random_number() % (2u * most_of + 1u)) - (int32_t)most_of;
            at = at < low ? low : (at > high ? high : at);
        }
    }
}

@digest@static uint32_t failures;

static void expect(const char *layer, uint32_t place, uint32_t found, uint32_t wanted)
{
    if (found != wanted) {
        failures++;
        if (failures < 20u) {
            printf("%s, %lu: %08lx, not %08lx\n", layer, (unsigned long)place, (unsigned long)found,
                   (unsigned long)wanted);
        }
    }
}

static void expect_row(const char *what, uint32_t place, const float *row, const uint32_t *wanted, uint32_t count)
{
    uint32_t i;
    for (i = 0; i < count; i++) {
        expect(what, place, bits_of(row[i]), wanted[i]);
    }
}

@live@
/* Pushes a sample step by step, behind others that it pushes out of the ring. */
static void push_sample(const float *sample)
{
    float pushed[TAXEL_@NAME@_CHANNELS];
    uint32_t channel, step;
    for (step = 0; step < TAXEL_@NAME@_STEPS + 3u; step++) {
        for (channel = 0; channel < TAXEL_@NAME@_CHANNELS; channel++) {
            const uint32_t at = step < 3u ? 0u : step - 3u;
            pushed[channel] = sample[channel * TAXEL_@NAME@_STEPS + at];
        }
        expect("push", step, (uint32_t)taxel_@name@_push(pushed), 0u);
    }
    expect("ready", 0u, (uint32_t)taxel_@name@_ready(), 1u);
}

@end live@
@check_samples@
@checks@
int main(void)
{
    check_samples();
@check_calls@    printf("%s: %lu samples, %lu layers, %lu differences\n", failures == 0u ? "equal" : "DIFFERENT",
           (unsigned long)SAMPLES, (unsigned long)LAYERS, (unsigned long)failures);
    return failures == 0u ? 0 : 1;
}
