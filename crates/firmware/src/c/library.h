/* @title@
 *
 * Printed by taxel @version@. A prediction reads one sample, as the sensor gives it, and has the bits of
 * `taxel predict`. */
#ifndef TAXEL_@NAME@_H
#define TAXEL_@NAME@_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Classes, and the channels and time steps of a sample. */
#define TAXEL_@NAME@_CLASSES @class_count@u
#define TAXEL_@NAME@_CHANNELS @channels@u
#define TAXEL_@NAME@_STEPS @steps@u
#define TAXEL_@NAME@_VALUES @values@u

/* Floats of a workspace, and its bytes: all the memory that a prediction needs besides the stack. */
#define TAXEL_@NAME@_WORKSPACE @workspace@u
#define TAXEL_@NAME@_RAM_BYTES @ram@u
/* Bytes that `push` needs besides, if the program calls it. */
#define TAXEL_@NAME@_RING_BYTES @ring@u
/* Bytes of the constant tables; with the code on an Arm Cortex-M at -O2, about. */
#define TAXEL_@NAME@_TABLE_BYTES @table@u
#define TAXEL_@NAME@_FLASH_BYTES @flash@u
/* Products of one prediction. */
#define TAXEL_@NAME@_MACS @macs@u

/* A value of the sample is not a finite number; nothing was predicted. */
#define TAXEL_@NAME@_NOT_FINITE (-1)
/* Fewer than TAXEL_@NAME@_STEPS time steps have been pushed. */
#define TAXEL_@NAME@_NOT_READY (-2)

/* Names of the classes, in the order of the probabilities. */
extern const char *const taxel_@name@_class_names[TAXEL_@NAME@_CLASSES];

/* Predicts one sample: channel after channel, each with its time steps. Returns 0 or an error. */
int taxel_@name@_predict(const float sample[TAXEL_@NAME@_VALUES], float probabilities[TAXEL_@NAME@_CLASSES]);

/* Computes the logits of one sample. */
int taxel_@name@_logits(const float sample[TAXEL_@NAME@_VALUES], float logits[TAXEL_@NAME@_CLASSES]);

/* The same in a workspace of the caller's: several threads may predict at once. With TAXEL_@NAME@_NO_STATIC defined
 * these two are all there is, and no static memory. */
int taxel_@name@_predict_in(float workspace[TAXEL_@NAME@_WORKSPACE], const float sample[TAXEL_@NAME@_VALUES],
                            float probabilities[TAXEL_@NAME@_CLASSES]);
int taxel_@name@_logits_in(float workspace[TAXEL_@NAME@_WORKSPACE], const float sample[TAXEL_@NAME@_VALUES],
                           float logits[TAXEL_@NAME@_CLASSES]);

/* Takes one time step of a live sensor, all channels. A step that is not finite is left out. */
int taxel_@name@_push(const float step[TAXEL_@NAME@_CHANNELS]);

/* Returns 1 once a whole sample has been pushed. */
int taxel_@name@_ready(void);

/* Predicts the last TAXEL_@NAME@_STEPS time steps. */
int taxel_@name@_predict_latest(float probabilities[TAXEL_@NAME@_CLASSES]);

/* Forgets the time steps. */
void taxel_@name@_clear(void);

#ifdef __cplusplus
}
#endif

#endif
