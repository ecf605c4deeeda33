
/* How unlike those of the training a sample is: the relative Mahalanobis distance of its logits. */
float taxel_@name@_distance(const float logits[TAXEL_@NAME@_CLASSES]);

/* Returns 1 for the logits of a sample that is unlike those of the training, else 0. Of samples like them about 5 % are
 * taken for unknown too. */
int taxel_@name@_is_unknown(const float logits[TAXEL_@NAME@_CLASSES]);
