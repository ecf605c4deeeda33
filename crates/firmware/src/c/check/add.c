static void check_add(const char *name, const add_layer *layer, const uint32_t *wanted)
{
    int32_t a, b;
    begin();
    for (a = -128; a <= 127; a++) {
        for (b = -128; b <= 127; b++) {
            if (layer->makes_bytes != 0u) {
                add_word((uint32_t)((int32_t)add_byte(layer, a, b) + 128));
            } else {
                add_word(bits_of(add_float(layer, a, b)));
            }
        }
    }
    expect(name, 0u, digest, wanted[0]);
}

