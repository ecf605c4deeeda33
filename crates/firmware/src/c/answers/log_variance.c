/* The deviation that the model expects of a value. */
static void around(const float *row, uint32_t i, float *below, float *above)
{
    const float x = times(0.5f, row[TAXEL_@NAME@_QUANTITIES + i]);
    float deviation = x > @most@ ? float_of(0x7f800000u) : exponential(x);
    deviation = deviation > @least@ ? deviation : @least@;
    *below = deviation;
    *above = deviation;
}
