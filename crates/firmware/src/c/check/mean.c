static void check_mean(const char *name, const pool_layer *layer, const uint32_t *wanted)
{
    uint32_t position;
    int32_t sum;
    for (position = 0; position < layer->positions; position++) {
        const span s = layer->spans[position];
        begin();
        for (sum = 0; sum <= 255 * ((int32_t)s.to - (int32_t)s.from); sum++) {
            if (layer->makes_bytes != 0u) {
                add_word((uint32_t)((int32_t)mean_byte(layer, position, sum) + 128));
            } else {
                add_word(bits_of(mean_float(layer, position, sum)));
            }
        }
        expect(name, position, digest, wanted[position]);
    }
}

