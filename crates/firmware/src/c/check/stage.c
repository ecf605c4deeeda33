static uint32_t stage_row;

static int stage_enough(int32_t place, int32_t byte)
{
    return (int32_t)taken(ordered(place), stage_row) + 128 >= byte;
}

static void check_stage(const uint32_t *wanted)
{
    for (stage_row = 0; stage_row < STAGE_ROWS; stage_row++) {
        begin();
        add_thresholds(-0x7f000000, 0x7f000000, stage_enough);
        expect("input", stage_row, digest, wanted[stage_row]);
    }
}

