/* Of ordered classes: the softmax of the sums up to each logit, without the first one. */
static void of_ordered(float *row, uint32_t count)
{
    float sum = 0.0f;
    uint32_t i;
    for (i = 1; i < count; i++) {
        sum = plus(sum, row[i]);
        row[i] = sum;
    }
    row[0] = 0.0f;
    softmax(row, count);
}
