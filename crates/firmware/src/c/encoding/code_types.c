/* Makes (v - low) * factor of a value. */
typedef struct {
    float low, factor;
} line;

/* A view of a channel: its score, and its first ramp and their number. */
typedef struct {
    line score;
    uint16_t first, count;
} code_view;

