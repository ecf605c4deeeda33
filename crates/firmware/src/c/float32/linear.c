typedef struct {
    const float *weight; /* of four outputs at a time: inputs x 4 */
    const float *bias;
    uint32_t from, to;
    uint16_t inputs, outputs;
    uint8_t rectifier;
} float_linear_layer;

static void float_linear(const float_linear_layer *l, float *arena)
{
    const float *w = l->weight;
    uint32_t first, end = 0, chains = 1;
    for (first = 0; first < l->outputs; first += 4u) {
        if (first >= end) {
            chains = chains_of(first, l->outputs, &end);
        }
        store_four(arena + l->to + first, add_chains(four_at(l->bias + first), arena + l->from, w, l->inputs, chains), NULL,
                   l->outputs - first, l->rectifier);
        w = &w[4u * (uint32_t)l->inputs];
    }
}
