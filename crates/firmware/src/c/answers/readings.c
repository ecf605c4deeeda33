typedef struct {
    float mean, spread, change, low, high;
} channel_numbers;

/* Adds up eight sums that ran beside each other, and that of the rest. */
static float total_of(const float *sums)
{
    float total = 0.0f;
    uint32_t i;
    for (i = 0; i < 9u; i++) {
        total = plus(total, sums[i]);
    }
    return total;
}

INLINE void off_at(channel_numbers *found, float *sum, float value, float first)
{
    *sum = plus(*sum, less(value, first));
    found->low = value < found->low ? value : found->low;
    found->high = value > found->high ? value : found->high;
}

INLINE void square_at(float *sum, float x) { *sum = plus(*sum, times(x, x)); }

/* Eight lanes, one by one, so that their sums stay in registers. */
INLINE void off_lanes(channel_numbers *found, float *off, const float *values, uint32_t by_step, float first)
{
    off_at(found, &off[0], values[0u], first);
    off_at(found, &off[1], values[by_step], first);
    off_at(found, &off[2], values[2u * by_step], first);
    off_at(found, &off[3], values[3u * by_step], first);
    off_at(found, &off[4], values[4u * by_step], first);
    off_at(found, &off[5], values[5u * by_step], first);
    off_at(found, &off[6], values[6u * by_step], first);
    off_at(found, &off[7], values[7u * by_step], first);
}

INLINE void square_lanes(float *squares, const float *values, uint32_t by_step, float first, float mean_off)
{
    square_at(&squares[0], less(less(values[0u], first), mean_off));
    square_at(&squares[1], less(less(values[by_step], first), mean_off));
    square_at(&squares[2], less(less(values[2u * by_step], first), mean_off));
    square_at(&squares[3], less(less(values[3u * by_step], first), mean_off));
    square_at(&squares[4], less(less(values[4u * by_step], first), mean_off));
    square_at(&squares[5], less(less(values[5u * by_step], first), mean_off));
    square_at(&squares[6], less(less(values[6u * by_step], first), mean_off));
    square_at(&squares[7], less(less(values[7u * by_step], first), mean_off));
}

INLINE void change_lanes(float *changes, const float *values, uint32_t by_step)
{
    square_at(&changes[0], less(values[by_step], values[0u]));
    square_at(&changes[1], less(values[2u * by_step], values[by_step]));
    square_at(&changes[2], less(values[3u * by_step], values[2u * by_step]));
    square_at(&changes[3], less(values[4u * by_step], values[3u * by_step]));
    square_at(&changes[4], less(values[5u * by_step], values[4u * by_step]));
    square_at(&changes[5], less(values[6u * by_step], values[5u * by_step]));
    square_at(&changes[6], less(values[7u * by_step], values[6u * by_step]));
    square_at(&changes[7], less(values[8u * by_step], values[7u * by_step]));
}

static channel_numbers numbers_of(const float *values)
{
    const uint32_t steps = @steps_of_channel@u, by_step = @distance_of_steps@u, turns = steps - 1u;
    const float first = values[0];
    float off[9] = {0}, squares[9] = {0}, changes[9] = {0};
    channel_numbers found = {first, 0.0f, 0.0f, first, first};
    float mean_off;
    uint32_t step;
    for (step = 0; step < steps / 8u * 8u; step += 8u) {
        off_lanes(&found, off, &values[step * by_step], by_step, first);
    }
    for (; step < steps; step++) {
        off_at(&found, &off[8], values[step * by_step], first);
    }
    mean_off = over(total_of(off), (float)steps);
    for (step = 0; step < steps / 8u * 8u; step += 8u) {
        square_lanes(squares, &values[step * by_step], by_step, first, mean_off);
    }
    for (; step < steps; step++) {
        square_at(&squares[8], less(less(values[step * by_step], first), mean_off));
    }
    for (step = 0; step < turns / 8u * 8u; step += 8u) {
        change_lanes(changes, &values[step * by_step], by_step);
    }
    for (; step < turns; step++) {
        square_at(&changes[8], less(values[(step + 1u) * by_step], values[step * by_step]));
    }
    found.mean = plus(first, mean_off);
    found.spread = root(over(total_of(squares), (float)steps));
    found.change = root(over(total_of(changes), turns > 0u ? (float)turns : 1.0f));
    return found;
}
@across@
static float logarithm_of(float deviation) { return logarithm(plus(deviation, @floor@)); }

static float distance_of_readings(const float *sample)
{
    const float count = @channel_count@.0f;
    float numbers[@numbers@], mean = 0.0f, square = 0.0f, within = 0.0f, spreads = 0.0f, change = 0.0f;
    float low = 0.0f, high = 0.0f, distance = 0.0f, between, spread;
@ends@    uint32_t i, k, at = 0;
    for (i = 0; i < @channel_count@u; i++) {
        const channel_numbers own = numbers_of(&sample[i * @distance_of_channels@u]);
        const float off = less(own.mean, sample[0]);
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
