
typedef char taxel_@name@_has_doubles_of_64_bits[sizeof(double) == 8u ? 1 : -1];

/* How far from its value each end of the 90 % interval is. */
static const double half_width[TAXEL_@NAME@_QUANTITIES] = {@half@};

@around@
/* Copies the values of a row of outputs and adds the ends of their intervals. */
static void interval(const float *row, float *values, float *low, float *high)
{
    uint32_t i;
    for (i = 0; i < TAXEL_@NAME@_QUANTITIES; i++) {
        float below, above;
        volatile double under, over_it;
        around(row, i, &below, &above);
        /* Volatile: no product is fused into a sum. */
        under = half_width[i] * (double)below;
        over_it = half_width[i] * (double)above;
        low[i] = (float)((double)row[i] - under);
        high[i] = (float)((double)row[i] + over_it);
        values[i] = row[i];
    }
}

int taxel_@name@_intervals_in(float workspace[TAXEL_@NAME@_WORKSPACE], const float sample[TAXEL_@NAME@_VALUES],
                              float values[TAXEL_@NAME@_QUANTITIES], float low[TAXEL_@NAME@_QUANTITIES],
                              float high[TAXEL_@NAME@_QUANTITIES])
{
    float row[OUTPUTS];
    const int outcome = outputs_of(workspace, sample, row);
    if (outcome == 0) {
        interval(row, values, low, high);
    }
    return outcome;
}

#ifndef TAXEL_@NAME@_NO_STATIC

int taxel_@name@_intervals(const float sample[TAXEL_@NAME@_VALUES], float values[TAXEL_@NAME@_QUANTITIES],
                           float low[TAXEL_@NAME@_QUANTITIES], float high[TAXEL_@NAME@_QUANTITIES])
{
    return taxel_@name@_intervals_in(own_workspace, sample, values, low, high);
}
@live@

int taxel_@name@_intervals_latest(float values[TAXEL_@NAME@_QUANTITIES], float low[TAXEL_@NAME@_QUANTITIES],
                                  float high[TAXEL_@NAME@_QUANTITIES])
{
    float row[OUTPUTS];
    const int outcome = outputs_of_ring(row);
    if (outcome == 0) {
        interval(row, values, low, high);
    }
    return outcome;
}
@end live@

#endif
