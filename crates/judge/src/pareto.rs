//! The Pareto front: what nothing else beats in both cost and merit.

/// Returns which points (cost, merit) are on the front: no other costs at most as much and has at least the
/// merit, and is better in one of the two. Equal points are on the front together.
pub(crate) fn front(points: &[(f64, f64)]) -> Vec<bool> {
    let beats = |other: &(f64, f64), point: &(f64, f64)| {
        other.0 <= point.0 && other.1 >= point.1 && (other.0 < point.0 || other.1 > point.1)
    };
    points.iter().map(|point| !points.iter().any(|other| beats(other, point))).collect()
}

#[cfg(test)]
mod tests {
    use super::front;

    #[test]
    fn dominated_points_are_behind_the_front_and_equal_ones_on_it_together() {
        let points = [(1.0, 90.0), (2.0, 95.0), (2.0, 95.0), (2.0, 94.0), (3.0, 95.0), (0.5, 10.0)];
        assert_eq!(front(&points), [true, true, true, false, false, true]);
        assert!(front(&[]).is_empty());
    }
}
