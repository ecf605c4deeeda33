
/* Predicts values, and between which two numbers each true value lies in 90 % of samples; as the functions above. */
int taxel_@name@_intervals(const float sample[TAXEL_@NAME@_VALUES], float values[TAXEL_@NAME@_QUANTITIES],
                           float low[TAXEL_@NAME@_QUANTITIES], float high[TAXEL_@NAME@_QUANTITIES]);
int taxel_@name@_intervals_in(float workspace[TAXEL_@NAME@_WORKSPACE], const float sample[TAXEL_@NAME@_VALUES],
                              float values[TAXEL_@NAME@_QUANTITIES], float low[TAXEL_@NAME@_QUANTITIES],
                              float high[TAXEL_@NAME@_QUANTITIES]);
@live@
int taxel_@name@_intervals_latest(float values[TAXEL_@NAME@_QUANTITIES], float low[TAXEL_@NAME@_QUANTITIES],
                                  float high[TAXEL_@NAME@_QUANTITIES]);
@end live@
