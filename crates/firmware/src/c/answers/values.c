const char *const taxel_@name@_quantity_names[TAXEL_@NAME@_QUANTITIES] = {
@quantities@};

const char *const taxel_@name@_quantity_units[TAXEL_@NAME@_QUANTITIES] = {
@units@};

int taxel_@name@_predict_in(float workspace[TAXEL_@NAME@_WORKSPACE], const float sample[TAXEL_@NAME@_VALUES],
                            float values[TAXEL_@NAME@_QUANTITIES])
{
    float row[OUTPUTS];
    const int outcome = outputs_of(workspace, sample, row);
    if (outcome == 0) {
        (void)memcpy(values, row, sizeof(float) * TAXEL_@NAME@_QUANTITIES);
    }
    return outcome;
}

#ifndef TAXEL_@NAME@_NO_STATIC

int taxel_@name@_predict(const float sample[TAXEL_@NAME@_VALUES], float values[TAXEL_@NAME@_QUANTITIES])
{
    return taxel_@name@_predict_in(own_workspace, sample, values);
}
@live@

int taxel_@name@_predict_latest(float values[TAXEL_@NAME@_QUANTITIES])
{
    float row[OUTPUTS];
    const int outcome = outputs_of_ring(row);
    if (outcome == 0) {
        (void)memcpy(values, row, sizeof(float) * TAXEL_@NAME@_QUANTITIES);
    }
    return outcome;
}
@end live@

#endif
