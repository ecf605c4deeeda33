static const @kind@_layer *@kind@_now;
static uint32_t @kind@_filter;
static int32_t @kind@_addend;

static int @kind@_enough(int32_t sum, int32_t byte)
{
    return (int32_t)@byte@ + 128 >= byte;
}

static void check_@kind@(const char *name, const @kind@_layer *layer, uint32_t filters, int32_t reach,
                         uint32_t has_addend, const uint32_t *wanted)
{
    @kind@_now = layer;
    for (@kind@_filter = 0; @kind@_filter < filters; @kind@_filter += CHECK_EVERY) {
        begin();
        if (layer->makes_bytes != 0u) {
            const int32_t last = has_addend != 0u ? 127 : -128;
            for (@kind@_addend = -128; @kind@_addend <= last; @kind@_addend++) {
                add_thresholds(-reach, reach, @kind@_enough);
            }
        } else {
            int32_t i;
            for (i = -512; i <= 512; i++) {
                const int32_t sum = reach / 512 * i;
                @kind@_addend = i & 127;
                add_word(bits_of(@float@));
            }
        }
        expect(name, @kind@_filter, digest, wanted[@kind@_filter]);
        @all@
    }
}

