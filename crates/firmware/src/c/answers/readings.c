typedef struct {
    float mean, spread, change, low, high;
} channel_numbers;

/* Eight sums beside each other, and that of the rest. */
static void add_to(float *sums, uint32_t at, uint32_t whole, float value)
{
    float *const to = &sums[at < whole ? at % 8u : 8u];
    *to = plus(*to, value);
}

static float total_of(const float *sums)
{
    float total = 0.0f;
    uint32_t i;
    for (i = 0; i < 9u; i++) {
        total = plus(total, sums[i]);
    }
    return total;
}

static channel_numbers numbers_of(const float *values)
{
    const uint32_t steps = @steps_of_channel@u, by_step = @distance_of_steps@u, changes = steps - 1u;
    const float first = values[0], count = (float)steps;
    float off[9] = {0.0f}, squares[9] = {0.0f}, turns[9] = {0.0f};
    channel_numbers found = {first, 0.0f, 0.0f, first, first};
    float mean_off;
    uint32_t step;
    for (step = 0; step < steps; step++) {
        const float value = values[step * by_step];
        add_to(off, step, steps / 8u * 8u, less(value, first));
        found.low = value < found.low ? value : found.low;
        found.high = value > found.high ? value : found.high;
    }
    mean_off = over(total_of(off), count);
    for (step = 0; step < steps; step++) {
        const float apart = less(less(values[step * by_step], first), mean_off);
        add_to(squares, step, steps / 8u * 8u, times(apart, apart));
    }
    for (step = 0; step < changes; step++) {
        const float turn = less(values[(step + 1u) * by_step], values[step * by_step]);
        add_to(turns, step, changes / 8u * 8u, times(turn, turn));
    }
    found.mean = plus(first, mean_off);
    found.spread = root(over(total_of(squares), count));
    found.change = root(over(total_of(turns), changes > 0u ? (float)changes : 1.0f));
    return found;
}
@across@
static float logarithm_of(float deviation) { return logarithm(plus(deviation, @floor@)); }

static float distance_of_readings(const float *sample)
{
    const float count = @channel_count@.0f;
    float numbers[@numbers@], off, mean = 0.0f, square = 0.0f, within = 0.0f, spreads = 0.0f, change = 0.0f;
    float low = 0.0f, high = 0.0f, distance = 0.0f, between, spread;
@ends@    uint32_t i, k, at = 0;
    for (i = 0; i < @channel_count@u; i++) {
        const channel_numbers own = numbers_of(&sample[i * @distance_of_channels@u]);
        off = less(own.mean, sample[0]);
        mean = plus(mean, off);
        square = plus(square, times(off, off));
        within = plus(within, own.spread);
        spreads = plus(spreads, times(own.spread, own.spread));
        change = plus(change, own.change);
        low = i == 0u || own.low < low ? own.low : low;
        high = i == 0u || own.high > high ? own.high : high;
@each_end@    }
    mean = over(mean, count);
    between = less(over(square, count), times(mean, mean));
    between = between > 0.0f ? between : 0.0f;
    spread = root(plus(over(spreads, count), between));
    within = over(within, count);
    change = over(change, count);
    mean = plus(sample[0], mean);
@set@    for (i = 0; i < @numbers@u; i++) {
        float sum = 0.0f;
        numbers[i] = less(numbers[i], readings_center[i]);
        for (k = 0; k <= i; k++) {
            sum = plus(sum, times(readings_around[at + k], numbers[k]));
        }
        distance = plus(distance, times(sum, sum));
        at += i + 1u;
    }
    return root(over(distance, @numbers@.0f));
}

float taxel_@name@_readings_distance(const float sample[TAXEL_@NAME@_VALUES]) { return distance_of_readings(sample); }

int taxel_@name@_readings_are_unknown(const float sample[TAXEL_@NAME@_VALUES])
{
    return distance_of_readings(sample) <= @limit@ ? 0 : 1;
}
