//! The first of many entries that come and go, without allocating.

/// A tournament: the first of each pair of entries goes on.
#[derive(Debug, Clone)]
pub(crate) struct Ranking<K> {
    keys: Vec<Option<K>>,
    /// Winners, from the whole (1) to pairs; a place is one entry or none.
    winners: Vec<Option<usize>>,
    leaves: usize,
}

impl<K: Copy> Ranking<K> {
    /// Makes so many places, all empty.
    pub fn new(places: usize) -> Self {
        let leaves = places.next_power_of_two();
        Self { keys: vec![None; places], winners: vec![None; 2 * leaves], leaves }
    }

    /// Puts entries into all places.
    pub fn fill(&mut self, is_before: impl Fn(&K, &K) -> bool, key: impl Fn(usize) -> Option<K>) {
        for place in 0..self.keys.len() {
            self.keys[place] = key(place);
            self.winners[self.leaves + place] = self.keys[place].map(|_| place);
        }
        for at in (1..self.leaves).rev() {
            self.settle(at, &is_before);
        }
    }

    /// Puts an entry into a place, or takes it out.
    pub fn set(&mut self, place: usize, key: Option<K>, is_before: impl Fn(&K, &K) -> bool) {
        self.keys[place] = key;
        let mut at = self.leaves + place;
        self.winners[at] = key.map(|_| place);
        while at > 1 {
            at /= 2;
            self.settle(at, &is_before);
        }
    }

    /// Returns the first entry; of equals that of the lowest place.
    pub fn first(&self) -> Option<(usize, K)> {
        // A ranking of one place has its leaf there.
        let place = self.winners[1]?;
        self.keys[place].map(|key| (place, key))
    }

    fn settle(&mut self, at: usize, is_before: &impl Fn(&K, &K) -> bool) {
        let [left, right] = [self.winners[2 * at], self.winners[2 * at + 1]];
        let key = |place: Option<usize>| place.and_then(|place| self.keys[place]);
        self.winners[at] = match (key(left), key(right)) {
            (Some(a), Some(b)) if is_before(&b, &a) => right,
            (None, _) => right,
            _ => left,
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_is_found_however_entries_change() {
        for places in 1..12 {
            let mut ranking = Ranking::new(places);
            let mut keys: Vec<Option<u64>> =
                (0..places as u64).map(|i| (i % 3 > 0).then_some(i * 7 % 5)).collect();
            let before = |a: &u64, b: &u64| a < b;
            ranking.fill(before, |place| keys[place]);
            for step in 0..40u64 {
                let want = keys
                    .iter()
                    .enumerate()
                    .filter_map(|(i, key)| Some((i, (*key)?)))
                    .min_by_key(|(_, key)| *key);
                assert_eq!(ranking.first(), want);
                let place = (step * 5 % places as u64) as usize;
                keys[place] = (step % 4 > 0).then_some(step * 11 % 7);
                ranking.set(place, keys[place], before);
            }
        }
    }
}
