{
        float low[TAXEL_@NAME@_QUANTITIES], high[TAXEL_@NAME@_QUANTITIES];
@live@
        expect("outcome", 0u, (uint32_t)taxel_@name@_intervals_latest(row, low, high), 0u);
        expect_row("pushed, low", 0u, low, &expected_low[last], TAXEL_@NAME@_QUANTITIES);
@end live@
        random_state = SAMPLE_SEED;
        for (i = 0; i < SAMPLES; i++) {
            make_sample(sample);
            expect("outcome", i, (uint32_t)taxel_@name@_intervals(sample, row, low, high), 0u);
            expect_row("values", i, row, &expected_answers[i * TAXEL_@NAME@_QUANTITIES], TAXEL_@NAME@_QUANTITIES);
            expect_row("low", i, low, &expected_low[i * TAXEL_@NAME@_QUANTITIES], TAXEL_@NAME@_QUANTITIES);
            expect_row("high", i, high, &expected_high[i * TAXEL_@NAME@_QUANTITIES], TAXEL_@NAME@_QUANTITIES);
        }
    }
