/* How far below and above its value the quantiles of the model are. */
static void around(const float *row, uint32_t i, float *below, float *above)
{
    const float under = less(row[i], row[TAXEL_@NAME@_QUANTITIES + i]);
    const float over_it = less(row[2u * TAXEL_@NAME@_QUANTITIES + i], row[i]);
    *below = under > @least@ ? under : @least@;
    *above = over_it > @least@ ? over_it : @least@;
}
