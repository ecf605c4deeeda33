/* Copies rows of so many bytes. */
static void copy(float *arena, uint32_t from, uint32_t from_pitch, uint32_t to, uint32_t to_pitch, uint32_t width,
                 uint32_t positions)
{
    int8_t *bytes = (int8_t *)arena;
    uint32_t position;
    for (position = 0; position < positions; position++) {
        (void)memcpy(bytes + to + position * to_pitch, bytes + from + position * from_pitch, width);
    }
}
