typedef struct {
    const float *weight; /* of four gates at a time: channels x 4 */
    const float *bias;
    const float *hidden_weight; /* of four gates at a time: hidden x 4 */
    uint32_t from, to, work;
    uint16_t channels, steps, hidden, from_pitch;
} lstm_layer;

/* e^x, held at the ends of the range of normal numbers. */
static float power_of_e(float x)
{
    static const float coefficients[5] = {1.3981999e-3f, 8.333452e-3f, 4.1665796e-2f, 1.6666665e-1f, 0.5f};
    float shifted, power, rest, sum = 1.9875691e-4f;
    uint32_t i;
    x = x >= 88.0f ? 88.0f : x;
    x = x <= -87.0f ? -87.0f : x;
    shifted = fused(x, @log2_e@, ROUND);
    power = less(shifted, ROUND);
    rest = fused(power, -0.6933594f, x);
    rest = fused(power, 2.1219444e-4f, rest);
    for (i = 0; i < 5u; i++) {
        sum = fused(sum, rest, coefficients[i]);
    }
    sum = fused(times(sum, rest), rest, plus(rest, 1.0f));
    return times(sum, float_of((bits_of(shifted) << 23) + 0x3f800000u));
}

static float sigmoid(float x) { return over(1.0f, plus(1.0f, power_of_e(less(0.0f, x)))); }

static float hyperbolic_tangent(float x)
{
    static const float coefficients[4] = {2.063909e-2f, -5.3739716e-2f, 1.3331442e-1f, -3.333328e-1f};
    const float magnitude = x > 0.0f ? x : less(0.0f, x);
    const float square = times(x, x);
    float near = -5.7049887e-3f;
    uint32_t i;
    if (magnitude > 0.625f) {
        const float far = less(1.0f, over(2.0f, plus(power_of_e(plus(magnitude, magnitude)), 1.0f)));
        return x > 0.0f ? far : less(0.0f, far);
    }
    for (i = 0; i < 4u; i++) {
        near = fused(near, square, coefficients[i]);
    }
    return fused(times(near, square), x, x);
}

/* The gates of one step, from its inputs and the hidden state. */
static void gates_of(const lstm_layer *l, const float *x, const float *h, float *gates)
{
    const uint32_t outputs = 4u * (uint32_t)l->hidden;
    const float *w = l->weight, *v = l->hidden_weight;
    uint32_t first, channel, end = 0, chains = 1;
    for (first = 0; first < outputs; first += 4u) {
        four sums = four_at(l->bias + first);
        if (first >= end) {
            chains = chains_of(first, outputs, &end);
        }
        for (channel = 0; channel < l->channels; channel++) {
            sums = four_fused(x[channel], four_at(w), sums);
            w = &w[4];
        }
        store_four(gates + first, add_chains(sums, h, v, l->hidden, chains), NULL, 4u, 0u);
        v = &v[4u * (uint32_t)l->hidden];
    }
}

static void lstm(const lstm_layer *l, float *arena)
{
    const uint32_t hidden = l->hidden;
    float *h = arena + l->to, *gates = arena + l->work, *cell = gates + 4u * hidden;
    const float *x = arena + l->from;
    uint32_t step, i;
    for (i = 0; i < hidden; i++) {
        h[i] = 0.0f;
        cell[i] = 0.0f;
    }
    for (step = 0; step < l->steps; step++) {
        gates_of(l, x, h, gates);
        for (i = 0; i < hidden; i++) {
            const float in = sigmoid(gates[i]), forget = sigmoid(gates[hidden + i]);
            const float fresh = hyperbolic_tangent(gates[2u * hidden + i]), out = sigmoid(gates[3u * hidden + i]);
            cell[i] = fused(forget, cell[i], times(in, fresh));
            h[i] = times(out, hyperbolic_tangent(cell[i]));
        }
        x += l->from_pitch;
    }
}
