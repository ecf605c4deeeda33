static inline void put(float *arena, uint32_t row, uint32_t step, reading value)
{
    reading *to = (reading *)arena;
    to[@stage_to@u + row * @by_channel@u + step * @by_step@u] = value;
}
