
/* How unlike those of the training the readings of a sample are, whatever the model makes of them: dead, stuck and noisy
 * sensors, and other sensors. */
float taxel_@name@_readings_distance(const float sample[TAXEL_@NAME@_VALUES]);

/* Returns 1 for a sample whose readings are unlike those of the training, else 0. */
int taxel_@name@_readings_are_unknown(const float sample[TAXEL_@NAME@_VALUES]);
