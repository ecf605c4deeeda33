/* Sums that run side by side for the outputs from `first` on; `end` is one past the last of these outputs. */
static uint32_t chains_of(uint32_t first, uint32_t outputs, uint32_t *end)
{
    const uint32_t left = (outputs - first + 15u) / 16u;
    uint32_t vectors = 8;
    while (vectors > left) {
        vectors /= 2u;
    }
    *end = first + 16u * vectors;
    return 8u / vectors;
}

/* Adds the products of all inputs with the weights of four outputs: every `chains`-th input in a sum of its own. */
static four add_chains(four total, const float *x, const float *w, uint32_t inputs, uint32_t chains)
{
    const uint32_t whole = inputs - inputs % chains;
    uint32_t chain, i;
    for (chain = 0; chain < chains; chain++) {
        const float *at = x + chain, *v = w + 4u * chain;
        four s = {0.0f, 0.0f, 0.0f, 0.0f};
        for (i = chain; i < whole; i += chains) {
            s = four_fused(*at, four_at(v), s);
            at = &at[chains];
            v = &v[4u * chains];
        }
        if (chain == 0u) {
            for (i = whole; i < inputs; i++) {
                s = four_fused(*at, four_at(v), s);
                at++;
                v = &v[4];
            }
        }
        total.a = plus(total.a, s.a);
        total.b = plus(total.b, s.b);
        total.c = plus(total.c, s.c);
        total.d = plus(total.d, s.d);
    }
    return total;
}
