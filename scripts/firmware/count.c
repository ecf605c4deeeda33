/* Counts the instructions and the stack of one prediction, or of a GATE; NAME and the source of the library come from the command
 * line. */
#include <stdio.h>

#include SOURCE

#define JOIN(a, b, c) a##b##c
#define PREDICT(name) JOIN(taxel_, name, _predict)
#define CALL(name) PREDICT(name)

static float sample[VALUES];
static float row[CLASSES];

#ifdef GATE
#define GATE_OF(name, gate) JOIN(taxel_, name, gate)
#define GATE_CALL(name, gate) GATE_OF(name, gate)
/* Through a pointer, so that the result is not known before. */
static int (*volatile gate)(const float *) = GATE_CALL(NAME, GATE);
#define ASK() ((void)gate(GATED))
#else
#define ASK() ((void)CALL(NAME)(sample, row))
#endif

#if defined(__riscv)
static const uint32_t wraps = 0;
#define MOVE "mv"
static uint32_t now(void)
{
    uint32_t count;
    __asm__ volatile("csrr %0, minstret" : "=r"(count));
    return count;
}
#else
/* SysTick counts 24 bits; its interrupt counts how often it began anew. */
extern volatile uint32_t wraps;
#define MOVE "mov"
#define SYSTICK ((volatile uint32_t *)0xE000E010u)
static uint32_t now(void) { return 0xFFFFFFu - SYSTICK[2]; }
#endif

static uint32_t used_stack(void)
{
    /* Painted below the stack pointer, then looked at. */
    volatile uint8_t *below;
    uint32_t i, used = 0;
    __asm__ volatile(MOVE " %0, sp" : "=r"(below));
    for (i = 1; i < 2048u; i++) {
        below[-(int32_t)i] = 0xA5u;
    }
    ASK();
    for (i = 1; i < 2048u; i++) {
        used = below[-(int32_t)i] != 0xA5u ? i : used;
    }
    return used;
}

int main(void)
{
    uint32_t i, begin, end, empty, ticks, wrapped;
    for (i = 0; i < VALUES; i++) {
        sample[i] = (float)((i * 37u) % 1024u);
    }
#if !defined(__riscv)
    SYSTICK[1] = 0xFFFFFFu;
    SYSTICK[2] = 0;
    SYSTICK[0] = 7;
    /* It begins at 0 and wraps at once. */
    while (SYSTICK[2] == 0u) {
    }
#endif
    begin = now();
    end = now();
    empty = end - begin;
    wrapped = wraps;
    begin = now();
    ASK();
    end = now();
    ticks = ((wraps - wrapped) << 24) + end - begin - empty;
#if !defined(__riscv)
    SYSTICK[0] = 0;
#endif
    printf("ticks %lu stack %lu\n", (unsigned long)ticks, (unsigned long)used_stack());
    return 0;
}
