/* Names of the classes, in the order of the probabilities. */
extern const char *const taxel_@name@_class_names[TAXEL_@NAME@_CLASSES];

/* Predicts one sample: channel after channel, each with its time steps. Returns 0 or an error. */
int taxel_@name@_predict(const float sample[TAXEL_@NAME@_VALUES], float probabilities[TAXEL_@NAME@_CLASSES]);

/* Computes the logits of one sample. */
int taxel_@name@_logits(const float sample[TAXEL_@NAME@_VALUES], float logits[TAXEL_@NAME@_CLASSES]);

/* Makes probabilities of logits, in place. */
void taxel_@name@_probabilities(float logits[TAXEL_@NAME@_CLASSES]);

/* The same in a workspace of the caller's: several threads may predict at once. With TAXEL_@NAME@_NO_STATIC defined
 * these two are all that predicts, and there is no static memory. */
int taxel_@name@_predict_in(float workspace[TAXEL_@NAME@_WORKSPACE], const float sample[TAXEL_@NAME@_VALUES],
                            float probabilities[TAXEL_@NAME@_CLASSES]);
int taxel_@name@_logits_in(float workspace[TAXEL_@NAME@_WORKSPACE], const float sample[TAXEL_@NAME@_VALUES],
                           float logits[TAXEL_@NAME@_CLASSES]);
@live@

/* Predicts the last time steps that were pushed, or computes their logits. */
int taxel_@name@_predict_latest(float probabilities[TAXEL_@NAME@_CLASSES]);
int taxel_@name@_logits_latest(float logits[TAXEL_@NAME@_CLASSES]);
@end live@
