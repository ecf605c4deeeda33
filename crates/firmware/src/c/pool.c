/* First input of a window, and one past the last. */
typedef struct {
    uint16_t from, to;
} span;

typedef struct {
    const span *spans;
    const float *factor; /* of each window's sum */
    const float *shift;
    float zero, low, high;
    uint32_t from, to;
    uint16_t channels, positions, from_pitch, to_pitch;
    uint8_t makes_bytes;
MORE_FIELDS
} pool_layer;
