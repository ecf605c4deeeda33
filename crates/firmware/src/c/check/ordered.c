/* The float at a place of their order. */
static float ordered(int32_t place)
{
    return place < 0 ? -float_of((uint32_t)-place) : float_of((uint32_t)place);
}

