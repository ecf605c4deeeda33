typedef char taxel_@name@_measures_in_64_bits[sizeof(double) == 8u ? 1 : -1];

/* A row of a triangle times deviations. Volatile: sums are added one after the other. */
static double row_product(const float *row, const double *off, uint32_t count)
{
    volatile double sum = 0.0;
    uint32_t i;
    for (i = 0; i < count; i++) {
        sum = sum + (double)row[i] * off[i];
    }
    return sum;
}

static double distance_of(const float *logits)
{
    double off[TAXEL_@NAME@_CLASSES], own[TAXEL_@NAME@_CLASSES];
    double nearest = 0.0;
    volatile double to_all = 0.0, square;
    uint32_t i, row, at = 0;
    for (i = 0; i < TAXEL_@NAME@_CLASSES; i++) {
        off[i] = (double)less(logits[i], gate_center[i]);
    }
    for (i = 0; i < TAXEL_@NAME@_CLASSES; i++) {
        const double around = row_product(&gate_around[at], off, i + 1u);
        own[i] = row_product(&gate_within[at], off, i + 1u);
        square = around * around;
        to_all = to_all + square;
        at += i + 1u;
    }
    for (row = 0; row < @rows@u; row++) {
        volatile double sum = 0.0;
        for (i = 0; i < TAXEL_@NAME@_CLASSES; i++) {
            const double apart = own[i] - (double)gate_means[row * TAXEL_@NAME@_CLASSES + i];
            square = apart * apart;
            sum = sum + square;
        }
        nearest = row == 0u || sum < nearest ? sum : nearest;
    }
    return nearest - to_all;
}

float taxel_@name@_distance(const float logits[TAXEL_@NAME@_CLASSES]) { return (float)distance_of(logits); }

int taxel_@name@_is_unknown(const float logits[TAXEL_@NAME@_CLASSES])
{
    return (double)@limit@ >= distance_of(logits) ? 0 : 1;
}
