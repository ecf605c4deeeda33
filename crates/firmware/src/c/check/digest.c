static uint32_t digest;

static void begin(void) { digest = 0x811c9dc5u; }

static void add_word(uint32_t word)
{
    uint32_t i;
    for (i = 0; i < 4u; i++) {
        digest = (digest ^ (word & 0xffu)) * 0x01000193u;
        word >>= 8;
    }
}

/* Whether a layer stores at least a byte, for a whole number that rises. */
typedef int (*is_enough)(int32_t number, int32_t byte);

/* The least number from `low` to `high` that is enough, or `high` + 1: looked for in wider and wider steps. */
static int32_t threshold(int32_t low, int32_t high, int32_t stride, int32_t byte, is_enough enough)
{
    int64_t below = (int64_t)low - 1, above = (int64_t)high + 1, at = (int64_t)low + stride;
    while (stride > 0 && at < high) {
        if (enough((int32_t)at, byte)) {
            above = at;
            break;
        }
        below = at;
        at += stride;
        stride = stride < 0x20000000 ? 2 * stride : stride;
    }
    while (above - below > 1) {
        const int32_t middle = (int32_t)((above + below) / 2);
        if (enough(middle, byte)) {
            above = middle;
        } else {
            below = middle;
        }
    }
    return (int32_t)above;
}

static void add_thresholds(int32_t low, int32_t high, is_enough enough)
{
    int32_t byte, least = low, stride = 0;
    for (byte = 1; byte <= 255; byte++) {
        const int32_t next = least <= high ? threshold(least, high, stride, byte, enough) : least;
        const int64_t apart = (int64_t)next - least;
        stride = apart > 1 && apart < 0x20000000 ? (int32_t)apart - 1 : 0;
        least = next;
        add_word((uint32_t)least);
    }
}

