//! Which label comes next: blocks of all labels, each in a random order.

use taxel::base::seed;

/// Returns the label to record next, where `counts` says how many recordings each has; none where all have `wanted`.
///
/// A block holds each label once, in an order of its own that `seed` says. Recordings of one class in a row would differ from
/// the others by the hour and by the warmth of the sensor.
pub fn next(labels: &[String], counts: &[usize], wanted: usize, seed: u64) -> Option<usize> {
    let block = counts.iter().min().copied().filter(|block| *block < wanted)?;
    let place = |label: &usize| seed::derived(seed, &format!("record/{block}/{}", labels[*label]));
    (0..labels.len()).filter(|label| counts[*label] == block).min_by_key(place)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(count: usize) -> Vec<String> {
        (0..count).map(|i| format!("class-{i}")).collect()
    }

    fn order(count: usize, wanted: usize, seed: u64, mut counts: Vec<usize>) -> Vec<usize> {
        let labels = labels(count);
        let mut order = vec![];
        while let Some(label) = next(&labels, &counts, wanted, seed) {
            counts[label] += 1;
            order.push(label);
        }
        order
    }

    #[test]
    fn every_block_holds_every_label_once_in_orders_that_differ() {
        let order = order(4, 50, 7, vec![0; 4]);
        let blocks: Vec<&[usize]> = order.chunks_exact(4).collect();
        assert_eq!(blocks.len(), 50);
        for block in &blocks {
            let mut sorted = block.to_vec();
            sorted.sort_unstable();
            assert_eq!(sorted, [0, 1, 2, 3]);
        }
        let mut first = [0; 4];
        blocks.iter().for_each(|block| first[block[0]] += 1);
        assert!(first.iter().all(|count| *count > 3), "each comes first at times: {first:?}");
        assert!(order.windows(3).all(|three| three[0] != three[1] || three[1] != three[2]), "never thrice");
    }

    #[test]
    fn who_goes_on_goes_on_in_the_same_order() {
        let whole = order(3, 10, 1, vec![0; 3]);
        for done in 0..whole.len() {
            let mut counts = vec![0; 3];
            whole[..done].iter().for_each(|label| counts[*label] += 1);
            assert_eq!(order(3, 10, 1, counts), whole[done..]);
        }
        assert_ne!(whole, order(3, 10, 2, vec![0; 3]), "another seed");
        // One that was recorded out of turn waits for the others.
        assert_eq!(order(2, 2, 0, vec![2, 0]), [1, 1]);
    }
}
