/* A convolution: its channels, its thresholds, the distance of its taps, the positions that count and its taps of 2. */
typedef struct {
    uint32_t first_channel, channels, first_bias, biases;
    uint16_t dilation, from, to;
    uint8_t twos[3];
} dilated;

