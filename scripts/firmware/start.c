/* Starts a program on a Cortex-M under QEMU: vectors, FPU, data, then main with newlib's semihosting. */
#include <stdint.h>

extern uint32_t stack_top, data_from, data_begin, data_end, bss_begin, bss_end;
extern void initialise_monitor_handles(void);
extern int main(void);
extern void _exit(int);

static void reset(void)
{
    uint32_t *from = &data_from, *to = &data_begin;
#if defined(__ARM_FP) || defined(__ARM_FEATURE_MVE)
    *(volatile uint32_t *)0xE000ED88u |= 0xFu << 20;
    __asm__ volatile("dsb\n isb");
#endif
    while (to < &data_end) {
        *to++ = *from++;
    }
    for (to = &bss_begin; to < &bss_end; to++) {
        *to = 0;
    }
    initialise_monitor_handles();
    _exit(main());
}

static void fault(void) { _exit(99); }

/* How often SysTick began anew. */
volatile uint32_t wraps;

static void tick(void) { wraps++; }

__attribute__((section(".vectors"), used)) static void *const vectors[16] = {
    &stack_top, (void *)reset, (void *)fault, (void *)fault, (void *)fault, (void *)fault, (void *)fault,
    0, 0, 0, 0, 0, 0, 0, 0, (void *)tick,
};

void _init(void) {}
void _fini(void) {}
