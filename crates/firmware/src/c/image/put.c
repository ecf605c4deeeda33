/* Pixels lie row by row, with margins between the rows. */
static inline void put(float *arena, uint32_t channel, uint32_t pixel, reading value)
{
    reading *to = (reading *)arena;
    to[@stage_to@u + channel * @by_channel@u + pixel / @columns@u * @by_row@u + pixel % @columns@u * @by_step@u] = value;
}
