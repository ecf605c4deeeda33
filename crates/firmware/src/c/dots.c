/* Sums of two filters at pairs of positions: where the values of the first position lie, the distance of the next one, the
 * weights and starts of both filters, bytes of a segment, segments, bytes between them, and where sums go. */
typedef struct {
    const int8_t *x;
    uint32_t step;
    const int8_t *w, *v;
    int32_t start_w, start_v;
    uint32_t length, segments, gap;
    int32_t *sums;
    uint32_t pairs;
} dot_job;

#if defined(__ARM_FEATURE_MVE) && defined(__GNUC__)

/* Sixteen values at once; the last ones of a segment are masked. r0: the job; r1, r5: values; r2, r3: weights; r4, r6, r8,
 * r10: sums; r7: bytes of a segment; r9: segments that are left; r11: the distance of positions. */
__attribute__((naked, noinline)) static void dots_2x2(dot_job *j __attribute__((unused)))
{
    __asm__ volatile("push {r4-r11, lr}\n\t"
                     "ldr r7, [r0, #24]\n\tldr r11, [r0, #4]\n"
                     "1:\n\t"
                     "ldr r1, [r0]\n\tldrd r2, r3, [r0, #8]\n\tldrd r4, r6, [r0, #16]\n\tldr r9, [r0, #28]\n\t"
                     "add r5, r1, r11\n\tadd r12, r5, r11\n\tstr r12, [r0]\n\t"
                     "mov r8, r4\n\tmov r10, r6\n"
                     "2:\n\t"
                     "dlstp.8 lr, r7\n"
                     "3:\n\t"
                     "vldrb.8 q0, [r1], #16\n\tvldrb.8 q1, [r2], #16\n\tvmladava.s8 r4, q0, q1\n\t"
                     "vldrb.8 q2, [r3], #16\n\tvmladava.s8 r6, q0, q2\n\t"
                     "vldrb.8 q3, [r5], #16\n\tvmladava.s8 r8, q3, q1\n\tvmladava.s8 r10, q3, q2\n\t"
                     "letp lr, 3b\n\t"
                     "subs r9, r9, #1\n\t"
                     "beq 4f\n\t"
                     /* Addresses are ahead by a multiple of sixteen. */
                     "add r12, r7, #15\n\tbic r12, r12, #15\n\tsub r12, r7, r12\n\t"
                     "add r2, r2, r12\n\tadd r3, r3, r12\n\t"
                     "ldr lr, [r0, #32]\n\tadd r12, r12, lr\n\tadd r1, r1, r12\n\tadd r5, r5, r12\n\t"
                     "b 2b\n"
                     "4:\n\t"
                     "ldrd r12, lr, [r0, #36]\n\t"
                     "strd r4, r6, [r12], #8\n\tstrd r8, r10, [r12], #8\n\t"
                     "subs lr, lr, #1\n\tstrd r12, lr, [r0, #36]\n\t"
                     "bne 1b\n\t"
                     "pop {r4-r11, pc}\n" ::: "r1", "r2", "r3", "r12", "q0", "q1", "q2", "q3", "cc", "memory");
}

static void dots_1x2(dot_job *j)
{
    const int8_t *x = j->x, *w = j->w, *v = j->v;
    int32_t s0 = j->start_w, s1 = j->start_v;
    uint32_t segment = j->segments;
    do {
        const int8_t *a = x, *c = w, *d = v;
        __asm__ volatile("dlstp.8 lr, %[n]\n"
                         "1:\n\t"
                         "vldrb.8 q0, [%[a]], #16\n\t"
                         "vldrb.8 q1, [%[c]], #16\n\t"
                         "vmladava.s8 %[s0], q0, q1\n\t"
                         "vldrb.8 q2, [%[d]], #16\n\t"
                         "vmladava.s8 %[s1], q0, q2\n\t"
                         "letp lr, 1b\n"
                         : [a] "+r"(a), [c] "+r"(c), [d] "+r"(d), [s0] "+Te"(s0), [s1] "+Te"(s1)
                         : [n] "r"(j->length)
                         : "lr", "q0", "q1", "q2", "memory");
        x += j->length + j->gap;
        w += j->length;
        v += j->length;
        segment--;
    } while (segment != 0u);
    j->sums[0] = s0;
    j->sums[1] = s1;
    j->sums[2] = s0;
    j->sums[3] = s1;
}

#elif defined(__ARM_FEATURE_DSP) && defined(__GNUC__)

/* Four values of both positions times four weights of both filters: pairs of 16 bits. r0, r1: values; r2, r3: weights;
 * r4 to r7: sums. */
#define FOUR_2X2                                                                                                   \
    "ldr r8, [r0], #4\n\tldr r10, [r1], #4\n\tldr r12, [r2], #4\n\t"                                              \
    "sxtb16 r9, r8\n\tsxtb16 r8, r8, ror #8\n\tsxtb16 r11, r10\n\tsxtb16 r10, r10, ror #8\n\t"                    \
    "sxtb16 lr, r12\n\tsxtb16 r12, r12, ror #8\n\t"                                                               \
    "smlad r4, r9, lr, r4\n\tsmlad r6, r11, lr, r6\n\tsmlad r4, r8, r12, r4\n\tsmlad r6, r10, r12, r6\n\t"        \
    "ldr r12, [r3], #4\n\tsxtb16 lr, r12\n\tsxtb16 r12, r12, ror #8\n\t"                                          \
    "smlad r5, r9, lr, r5\n\tsmlad r7, r11, lr, r7\n\tsmlad r5, r8, r12, r5\n\tsmlad r7, r10, r12, r7\n\t"

/* On the stack: the end of a segment, segments that are left, the job. */
__attribute__((naked, noinline)) static void dots_2x2(dot_job *j __attribute__((unused)))
{
    __asm__ volatile("push {r0, r4-r11, lr}\n\t"
                     "sub sp, sp, #8\n"
                     "1:\n\t"
                     "ldr r12, [sp, #8]\n\t"
                     "ldm r12, {r0-r5}\n\t"
                     "add r8, r0, r1, lsl #1\n\t"
                     "str r8, [r12]\n\t"
                     "add r1, r1, r0\n\t"
                     "mov r6, r4\n\t"
                     "mov r7, r5\n\t"
                     "ldrd lr, r8, [r12, #24]\n\t"
                     "str r8, [sp, #4]\n"
                     "2:\n\t"
                     "add r8, r0, lr\n\t"
                     "str r8, [sp]\n\t"
                     "tst lr, #4\n\t"
                     "bne 4f\n"
                     "3:\n\t" FOUR_2X2 "\n"
                     "4:\n\t" FOUR_2X2
                     "ldr r12, [sp]\n\t"
                     "cmp r0, r12\n\t"
                     "bne 3b\n\t"
                     "ldrd r8, r12, [sp, #4]\n\t"
                     "subs r8, r8, #1\n\t"
                     "beq 5f\n\t"
                     "str r8, [sp, #4]\n\t"
                     "ldr r9, [r12, #32]\n\t"
                     "ldr lr, [r12, #24]\n\t"
                     "add r0, r0, r9\n\t"
                     "add r1, r1, r9\n\t"
                     "b 2b\n"
                     "5:\n\t"
                     "ldrd r8, r9, [r12, #36]\n\t"
                     "stm r8!, {r4-r7}\n\t"
                     "subs r9, r9, #1\n\t"
                     "strd r8, r9, [r12, #36]\n\t"
                     "bne 1b\n\t"
                     "add sp, sp, #8\n\t"
                     "pop {r0, r4-r11, pc}\n" ::: "r1", "r2", "r3", "r12", "cc", "memory");
}

/* Four values of one position: r1: values; r2, r3: weights; r4, r5: sums. */
#define FOUR_1X2                                                                                                   \
    "ldr r8, [r1], #4\n\tldr r9, [r2], #4\n\tldr r10, [r3], #4\n\t"                                               \
    "sxtb16 r11, r8\n\tsxtb16 r8, r8, ror #8\n\tsxtb16 r12, r9\n\tsxtb16 r9, r9, ror #8\n\t"                      \
    "smlad r4, r11, r12, r4\n\tsmlad r4, r8, r9, r4\n\t"                                                         \
    "sxtb16 r12, r10\n\tsxtb16 r10, r10, ror #8\n\tsmlad r5, r11, r12, r5\n\tsmlad r5, r8, r10, r5\n\t"

/* r0: the job; r6: segments that are left; r7: the end of a segment. */
__attribute__((naked, noinline)) static void dots_1x2(dot_job *j __attribute__((unused)))
{
    __asm__ volatile("push {r4-r11, lr}\n\t"
                     "ldr r1, [r0]\n\tldrd r2, r3, [r0, #8]\n\tldrd r4, r5, [r0, #16]\n\tldrd lr, r6, [r0, #24]\n"
                     "1:\n\t"
                     "add r7, r1, lr\n\t"
                     "tst lr, #4\n\t"
                     "bne 3f\n"
                     "2:\n\t" FOUR_1X2 "\n"
                     "3:\n\t" FOUR_1X2
                     "cmp r1, r7\n\t"
                     "bne 2b\n\t"
                     "subs r6, r6, #1\n\t"
                     "beq 4f\n\t"
                     "ldr r8, [r0, #32]\n\t"
                     "add r1, r1, r8\n\t"
                     "b 1b\n"
                     "4:\n\t"
                     "ldr r8, [r0, #36]\n\t"
                     "strd r4, r5, [r8]\n\t"
                     "pop {r4-r11, pc}\n" ::: "r1", "r2", "r3", "r12", "cc", "memory");
}

#else

#if defined(__ARM_ARCH_6M__) && defined(__GNUC__)

/* Both positions times both filters: r0, r1: ends of values; r2, r3: ends of weights; r4: less than 0, up to 0. */
#define ONE_2X2                                                                                            \
    "ldrsb r5, [r0, r4]\n\tldrsb r6, [r2, r4]\n\tmovs r7, r5\n\tmuls r7, r6\n\tadd r8, r7\n\t"            \
    "ldrsb r7, [r3, r4]\n\tmuls r5, r7\n\tadd r9, r5\n\t"                                                 \
    "ldrsb r5, [r1, r4]\n\tmuls r6, r5\n\tadd r10, r6\n\tmuls r7, r5\n\tadd r11, r7\n\tadds r4, #1\n\t"

/* On the stack: segments that are left, the job. */
__attribute__((naked, noinline)) static void dots_2x2(dot_job *j __attribute__((unused)))
{
    __asm__ volatile(".syntax unified\n\t"
                     "push {r4-r7, lr}\n\t"
                     "mov r4, r8\n\tmov r5, r9\n\tmov r6, r10\n\tmov r7, r11\n\t"
                     "push {r0, r4-r7}\n\t"
                     "sub sp, #8\n"
                     "1:\n\t"
                     "ldr r7, [sp, #8]\n\t"
                     "ldr r0, [r7]\n\tldr r1, [r7, #4]\n\tldr r2, [r7, #8]\n\tldr r3, [r7, #12]\n\t"
                     "ldr r5, [r7, #16]\n\tldr r6, [r7, #20]\n\t"
                     "mov r8, r5\n\tmov r9, r6\n\tmov r10, r5\n\tmov r11, r6\n\t"
                     "adds r4, r0, r1\n\tadds r5, r4, r1\n\tstr r5, [r7]\n\tmovs r1, r4\n\t"
                     "ldr r5, [r7, #28]\n\tstr r5, [sp]\n"
                     "2:\n\t"
                     "ldr r7, [sp, #8]\n\tldr r4, [r7, #24]\n\t"
                     "adds r0, r0, r4\n\tadds r1, r1, r4\n\tadds r2, r2, r4\n\tadds r3, r3, r4\n\t"
                     "rsbs r4, r4, #0\n"
                     "3:\n\t" ONE_2X2 ONE_2X2 ONE_2X2 ONE_2X2 "bne 3b\n\t"
                     "ldr r7, [sp, #8]\n\tldr r4, [r7, #32]\n\tadds r0, r0, r4\n\tadds r1, r1, r4\n\t"
                     "ldr r4, [sp]\n\tsubs r4, #1\n\tstr r4, [sp]\n\tbne 2b\n\t"
                     "ldr r4, [r7, #36]\n\tmov r0, r8\n\tmov r1, r9\n\tmov r2, r10\n\tmov r3, r11\n\t"
                     "stmia r4!, {r0-r3}\n\tstr r4, [r7, #36]\n\t"
                     "ldr r4, [r7, #40]\n\tsubs r4, #1\n\tstr r4, [r7, #40]\n\tbne 1b\n\t"
                     "add sp, #8\n\tpop {r0, r4-r7}\n\t"
                     "mov r8, r4\n\tmov r9, r5\n\tmov r10, r6\n\tmov r11, r7\n\t"
                     "pop {r4-r7, pc}\n" ::: "r1", "r2", "r3", "cc", "memory");
}

#else

/* One value of both positions times one weight of both filters. */
#define ONE_2X2(k)                                            \
    {                                                         \
        const int32_t a = x[k], b = y[k], c = w[k], d = v[k]; \
        s0 += a * c;                                          \
        s1 += a * d;                                          \
        s2 += b * c;                                          \
        s3 += b * d;                                          \
    }

static void dots_2x2(dot_job *j)
{
    do {
        const int8_t *x = j->x, *y = x + j->step, *w = j->w, *v = j->v;
        int32_t s0 = j->start_w, s1 = j->start_v, s2 = s0, s3 = s1;
        uint32_t segment = j->segments;
        do {
            const int8_t *end = x + j->length;
            do {
                ONE_2X2(0)
                ONE_2X2(1)
                ONE_2X2(2)
                ONE_2X2(3)
                x += 4;
                y += 4;
                w += 4;
                v += 4;
            } while (x != end);
            x += j->gap;
            y += j->gap;
            segment--;
        } while (segment != 0u);
        j->sums[0] = s0;
        j->sums[1] = s1;
        j->sums[2] = s2;
        j->sums[3] = s3;
        j->sums += 4;
        j->x += 2u * j->step;
        j->pairs--;
    } while (j->pairs != 0u);
}

#endif

static void dots_1x2(dot_job *j)
{
    const int8_t *x = j->x, *w = j->w, *v = j->v;
    int32_t s0 = j->start_w, s1 = j->start_v;
    uint32_t segment = j->segments;
    do {
        const int8_t *end = x + j->length;
        do {
            const int32_t a = *x;
            s0 += a * *w;
            s1 += a * *v;
            x++;
            w++;
            v++;
        } while (x != end);
        x += j->gap;
        segment--;
    } while (segment != 0u);
    j->sums[0] = s0;
    j->sums[1] = s1;
}

#endif
