static void check_samples(void)
{
    static float sample[TAXEL_@NAME@_VALUES];
    float row[TAXEL_@NAME@_CLASSES];
    uint32_t i;
    for (i = 0; i < SAMPLES; i++) {
        make_sample(sample);
        @readings@
        expect("outcome", i, (uint32_t)taxel_@name@_logits(sample, row), 0u);
        expect_row("logits", i, row, &expected_outputs[i * OUTPUTS], OUTPUTS);
        @gate@
        expect("outcome", i, (uint32_t)taxel_@name@_predict(sample, row), 0u);
        expect_row("probabilities", i, row, &expected_answers[i * TAXEL_@NAME@_CLASSES], TAXEL_@NAME@_CLASSES);
    }
@live@
    taxel_@name@_clear();
    expect("not ready", 0u, (uint32_t)taxel_@name@_predict_latest(row), (uint32_t)TAXEL_@NAME@_NOT_READY);
    push_sample(sample);
    expect("outcome", 0u, (uint32_t)taxel_@name@_logits_latest(row), 0u);
    expect_row("pushed logits", 0u, row, &expected_outputs[(SAMPLES - 1u) * OUTPUTS], OUTPUTS);
    expect("outcome", 0u, (uint32_t)taxel_@name@_predict_latest(row), 0u);
    expect_row("pushed", 0u, row, &expected_answers[(SAMPLES - 1u) * TAXEL_@NAME@_CLASSES], TAXEL_@NAME@_CLASSES);
@end live@
    sample[TAXEL_@NAME@_VALUES - 1u] = float_of(0x7fc00000u);
    expect("NaN", 0u, (uint32_t)taxel_@name@_predict(sample, row), (uint32_t)TAXEL_@NAME@_NOT_FINITE);
}
