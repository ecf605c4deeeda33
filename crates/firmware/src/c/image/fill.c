/* Fills stretches of `length` bytes, so far apart, with the byte that means 0. */
static void fill(int8_t *to, int32_t zero, uint32_t length, uint32_t apart, uint32_t count)
{
    uint32_t i;
    for (i = 0; i < count; i++) {
        (void)memset(to + i * apart, zero, length);
    }
}
