static const map_layer *map_now;
static uint32_t map_channel;

static int map_enough(int32_t place, int32_t byte)
{
    return (int32_t)map_byte(map_now, map_channel, ordered(place)) + 128 >= byte;
}

static void check_map(const char *name, const map_layer *layer, const uint32_t *wanted)
{
    int32_t i;
    map_now = layer;
    for (map_channel = 0; map_channel < layer->channels; map_channel++) {
        begin();
        if (layer->reads_bytes == 0u && layer->makes_bytes != 0u && layer->factor[map_channel] > 0.0f) {
            add_thresholds(-0x7f000000, 0x7f000000, map_enough);
        } else {
            for (i = 0; i <= 255; i++) {
                const float x = (float)i;
                if (layer->makes_bytes != 0u) {
                    add_word((uint32_t)((int32_t)map_byte(layer, map_channel, x) + 128));
                } else {
                    add_word(bits_of(map_float(layer, map_channel, x)));
                }
            }
        }
        expect(name, map_channel, digest, wanted[map_channel]);
    }
}

