typedef struct {
    const float *weight; /* taps x channels */
    const float *bias;
    uint32_t from, to;
    uint16_t step, taps, apart, channels, positions, to_pitch;
    uint8_t rectifier;
} float_depthwise_layer;

static void float_depthwise(const float_depthwise_layer *l, float *arena)
{
    uint32_t position, channel, tap;
    for (channel = 0; channel < l->channels; channel++) {
        const float *x = arena + l->from + channel;
        float *y = arena + l->to + channel;
        for (position = 0; position < l->positions; position++) {
            const float *at = x, *w = l->weight + channel;
            float sum = l->bias[channel];
            for (tap = 0; tap < l->taps; tap++) {
                sum = fused(*at, *w, sum);
                at += l->apart;
                w += l->channels;
            }
            *y = rectified(sum, l->rectifier);
            x += l->step;
            y += l->to_pitch;
        }
    }
}
