static uint32_t stage_channel;

static int stage_enough(int32_t place, int32_t byte)
{
    return (int32_t)taken(ordered(place), stage_channel) + 128 >= byte;
}

static void check_stage(const uint32_t *wanted)
{
    for (stage_channel = 0; stage_channel < TAXEL_@NAME@_CHANNELS; stage_channel++) {
        begin();
        add_thresholds(-0x7f000000, 0x7f000000, stage_enough);
        expect("input", stage_channel, digest, wanted[stage_channel]);
    }
}

