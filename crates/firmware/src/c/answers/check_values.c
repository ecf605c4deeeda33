static void check_samples(void)
{
    static float sample[TAXEL_@NAME@_VALUES];
    float row[OUTPUTS];
@live@
    const uint32_t last = (SAMPLES - 1u) * TAXEL_@NAME@_QUANTITIES;
@end live@
    uint32_t i;
    for (i = 0; i < SAMPLES; i++) {
        make_sample(sample);
        @readings@
        expect("outcome", i, (uint32_t)outputs_of(own_workspace, sample, row), 0u);
        expect_row("outputs", i, row, &expected_outputs[i * OUTPUTS], OUTPUTS);
        expect("outcome", i, (uint32_t)taxel_@name@_predict(sample, row), 0u);
        expect_row("values", i, row, &expected_answers[i * TAXEL_@NAME@_QUANTITIES], TAXEL_@NAME@_QUANTITIES);
    }
@live@
    taxel_@name@_clear();
    expect("not ready", 0u, (uint32_t)taxel_@name@_predict_latest(row), (uint32_t)TAXEL_@NAME@_NOT_READY);
    push_sample(sample);
    expect("outcome", 0u, (uint32_t)taxel_@name@_predict_latest(row), 0u);
    expect_row("pushed", 0u, row, &expected_answers[last], TAXEL_@NAME@_QUANTITIES);
@end live@
    @intervals@
    sample[TAXEL_@NAME@_VALUES - 1u] = float_of(0x7fc00000u);
    expect("NaN", 0u, (uint32_t)taxel_@name@_predict(sample, row), (uint32_t)TAXEL_@NAME@_NOT_FINITE);
}
