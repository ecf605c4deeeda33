/* Names of the values, and their units; "" where the model does not know it. */
extern const char *const taxel_@name@_quantity_names[TAXEL_@NAME@_QUANTITIES];
extern const char *const taxel_@name@_quantity_units[TAXEL_@NAME@_QUANTITIES];

/* Predicts the values of one sample: channel after channel, each with its time steps. Returns 0 or an error. */
int taxel_@name@_predict(const float sample[TAXEL_@NAME@_VALUES], float values[TAXEL_@NAME@_QUANTITIES]);

/* The same in a workspace of the caller's: several threads may predict at once. With TAXEL_@NAME@_NO_STATIC defined
 * nothing else predicts, and there is no static memory. */
int taxel_@name@_predict_in(float workspace[TAXEL_@NAME@_WORKSPACE], const float sample[TAXEL_@NAME@_VALUES],
                            float values[TAXEL_@NAME@_QUANTITIES]);
@live@

/* Predicts the values of the last time steps that were pushed. */
int taxel_@name@_predict_latest(float values[TAXEL_@NAME@_QUANTITIES]);
@end live@
