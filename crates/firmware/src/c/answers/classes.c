const char *const taxel_@name@_class_names[TAXEL_@NAME@_CLASSES] = {
@classes@};

void taxel_@name@_probabilities(float row[TAXEL_@NAME@_CLASSES])
{
@shares@}

int taxel_@name@_logits_in(float workspace[TAXEL_@NAME@_WORKSPACE], const float sample[TAXEL_@NAME@_VALUES],
                           float logits[TAXEL_@NAME@_CLASSES])
{
    return outputs_of(workspace, sample, logits);
}

int taxel_@name@_predict_in(float workspace[TAXEL_@NAME@_WORKSPACE], const float sample[TAXEL_@NAME@_VALUES],
                            float probabilities[TAXEL_@NAME@_CLASSES])
{
    const int outcome = outputs_of(workspace, sample, probabilities);
    if (outcome == 0) {
        taxel_@name@_probabilities(probabilities);
    }
    return outcome;
}

#ifndef TAXEL_@NAME@_NO_STATIC

int taxel_@name@_logits(const float sample[TAXEL_@NAME@_VALUES], float logits[TAXEL_@NAME@_CLASSES])
{
    return outputs_of(own_workspace, sample, logits);
}

int taxel_@name@_predict(const float sample[TAXEL_@NAME@_VALUES], float probabilities[TAXEL_@NAME@_CLASSES])
{
    return taxel_@name@_predict_in(own_workspace, sample, probabilities);
}
@live@

int taxel_@name@_logits_latest(float logits[TAXEL_@NAME@_CLASSES]) { return outputs_of_ring(logits); }

int taxel_@name@_predict_latest(float probabilities[TAXEL_@NAME@_CLASSES])
{
    const int outcome = outputs_of_ring(probabilities);
    if (outcome == 0) {
        taxel_@name@_probabilities(probabilities);
    }
    return outcome;
}
@end live@

#endif
