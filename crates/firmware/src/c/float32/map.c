typedef struct {
    const float *factor; /* NULL: values as they are */
    const float *shift;
    uint32_t from, to;
    uint16_t channels, positions, from_pitch, to_pitch;
    uint8_t rectifier;
} float_map_layer;

static void float_map(const float_map_layer *l, float *arena)
{
    uint32_t position, channel;
    for (position = 0; position < l->positions; position++) {
        const float *x = arena + l->from + position * l->from_pitch;
        float *y = arena + l->to + position * l->to_pitch;
        for (channel = 0; channel < l->channels; channel++) {
            const float value = l->factor != NULL ? fused(x[channel], l->factor[channel], l->shift[channel]) : x[channel];
            y[channel] = rectified(value, l->rectifier);
        }
    }
}
