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

/* Eight lanes one by one: their sums stay in registers. */
#define EACH_LANE(one) one(0u) one(1u) one(2u) one(3u) one(4u) one(5u) one(6u) one(7u)
#define AT(lane) values[(step + (lane)) * by_step]
#define SUM_OFF(lane) off_at(&found, &off[lane], AT(lane), first);
#define SUM_SQUARE(lane) square_at(&squares[lane], less(less(AT(lane), first), mean_off));
#define SUM_CHANGE(lane) square_at(&changes[lane], less(AT((lane) + 1u), AT(lane)));

INLINE void off_at(channel_numbers *found, float *sum, float value, float first)
{
    *sum = plus(*sum, less(value, first));
    found->low = value < found->low ? value : found->low;
    found->high = value > found->high ? value : found->high;
}

INLINE void square_at(float *sum, float x) { *sum = plus(*sum, times(x, x)); }

static channel_numbers numbers_of(const float *values)
{
    const uint32_t steps = @steps_of_channel@u, by_step = @distance_of_steps@u, turns = steps - 1u;
    const float first = values[0];
    float off[9] = {0.0f}, squares[9] = {0.0f}, changes[9] = {0.0f};
    channel_numbers found = {first, 0.0f, 0.0f, first, first};
    float mean_off;
    uint32_t step;
    for (step = 0; step < steps / 8u * 8u; step += 8u) {
        EACH_LANE(SUM_OFF)
    }
    for (; step < steps; step++) {
        off_at(&found, &off[8], AT(0u), first);
    }
    mean_off = over(total_of(off), (float)steps);
    for (step = 0; step < steps / 8u * 8u; step += 8u) {
        EACH_LANE(SUM_SQUARE)
    }
    for (; step < steps; step++) {
        square_at(&squares[8], less(less(AT(0u), first), mean_off));
    }
    for (step = 0; step < turns / 8u * 8u; step += 8u) {
        EACH_LANE(SUM_CHANGE)
    }
    for (; step < turns; step++) {
        square_at(&changes[8], less(AT(1u), AT(0u)));
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
