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

/* @answer_noun@, and the @axes@ of a sample. */
#define TAXEL_@NAME@_@ANSWERS@ @answer_count@u
#define TAXEL_@NAME@_CHANNELS @channels@u
@live@
#define TAXEL_@NAME@_STEPS @steps@u
@end live@
@still@
#define TAXEL_@NAME@_ROWS @rows@u
#define TAXEL_@NAME@_COLUMNS @columns@u
#define TAXEL_@NAME@_PIXELS @steps@u
@end still@
#define TAXEL_@NAME@_VALUES @values@u
@live@
/* Time steps that `push` has to bring before a prediction: those that the model reads. */
#define TAXEL_@NAME@_RING_STEPS @ring_steps@u
@end live@

/* Floats of a workspace, and its bytes: all the memory that a prediction needs besides the stack. */
#define TAXEL_@NAME@_WORKSPACE @workspace@u
#define TAXEL_@NAME@_RAM_BYTES @ram@u
@live@
/* Bytes that `push` needs besides, if the program calls it. */
#define TAXEL_@NAME@_RING_BYTES @ring@u
@end live@
/* Bytes of the constant tables; with the code on an Arm Cortex-M at -O2, about. */
#define TAXEL_@NAME@_TABLE_BYTES @table@u
#define TAXEL_@NAME@_FLASH_BYTES @flash@u
/* Products of one prediction. */
#define TAXEL_@NAME@_MACS @macs@u
@fpu@
/* A value of the sample is not a finite number; nothing was predicted. */
#define TAXEL_@NAME@_NOT_FINITE (-1)
@live@
/* Fewer than TAXEL_@NAME@_RING_STEPS time steps have been pushed. */
#define TAXEL_@NAME@_NOT_READY (-2)
@end live@

@api@
@live@
/* Takes one time step of a live sensor, all channels. A step that is not finite is left out. */
int taxel_@name@_push(const float step[TAXEL_@NAME@_CHANNELS]);

/* Returns 1 once TAXEL_@NAME@_RING_STEPS time steps have been pushed. */
int taxel_@name@_ready(void);

/* Forgets the time steps. */
void taxel_@name@_clear(void);

@end live@
#ifdef __cplusplus
}
#endif

#endif
