//! The Pareto front: what is not beaten in both respects at once.

/// Which of the `points`, (cost, error), no other one beats: a point that costs no more and errs no more beats another
/// unless both are the same, of which the first counts. In order of cost. Points that are not finite are on no front.
pub fn front(points: &[(f64, f64)]) -> Vec<usize> {
    let finite = |i: &usize| points[*i].0.is_finite() && points[*i].1.is_finite();
    let mut order: Vec<usize> = (0..points.len()).filter(finite).collect();
    order.sort_by(|&i, &j| points[i].0.total_cmp(&points[j].0).then(points[i].1.total_cmp(&points[j].1)));
    let mut least = f64::INFINITY;
    order.retain(|&i| {
        let better = points[i].1 < least;
        least = least.min(points[i].1);
        better
    });
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dominated_points_are_rejected_and_the_rest_is_in_order_of_cost() {
        let points = [(3.0, 0.1), (1.0, 1.0), (2.0, 2.0), (2.0, 0.5), (4.0, 0.1), (2.0, 0.6)];
        // (2, 2) and (2, 0.6) err more at no less cost than (2, 0.5), (4, 0.1) costs more than (3, 0.1).
        assert_eq!(front(&points), [1, 3, 0]);
    }

    #[test]
    fn of_equal_points_the_first_counts_and_what_is_not_finite_does_not() {
        let points = [(f64::NAN, 0.0), (1.0, 0.5), (1.0, 0.5), (0.5, f64::NAN), (0.1, f64::INFINITY)];
        assert_eq!(front(&points), [1]);
        assert!(front(&[]).is_empty());
    }

    #[test]
    fn every_point_off_the_front_is_beaten_by_one_on_it() {
        let points: Vec<(f64, f64)> =
            (0..60).map(|i| (f64::from(i * 37 % 61), f64::from(i * i * 17 % 59))).collect();
        let kept = front(&points);
        let beats = |a: (f64, f64), b: (f64, f64)| a != b && a.0 <= b.0 && a.1 <= b.1;
        for (i, &p) in points.iter().enumerate() {
            let beaten = points.iter().any(|&q| beats(q, p));
            assert_eq!(kept.contains(&i), !beaten, "{p:?}");
        }
    }
}
