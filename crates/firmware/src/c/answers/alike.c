/* All samples are off alike. */
static void around(const float *row, uint32_t i, float *below, float *above)
{
    (void)row;
    (void)i;
    *below = 1.0f;
    *above = 1.0f;
}
