//! Fewer points for the same picture.

/// Indices of at most `most` of `values`, in order: the first, the last, and of each of equal stretches in between
/// the lowest and the highest. Every extreme of the whole is among them.
pub(super) fn indices(values: &[f64], most: usize) -> Vec<usize> {
    let n = values.len();
    if n <= most || most < 4 {
        return (0..n).collect();
    }
    let stretches = (most - 2) / 2;
    let mut kept = Vec::with_capacity(most);
    kept.push(0);
    for stretch in 0..stretches {
        let of = |stretch: usize| 1 + stretch * (n - 2) / stretches;
        let members = of(stretch)..of(stretch + 1);
        let by_value = |&a: &usize, &b: &usize| values[a].total_cmp(&values[b]);
        let Some((low, high)) = members.clone().min_by(by_value).zip(members.max_by(by_value)) else { continue };
        kept.push(low.min(high));
        if low != high {
            kept.push(low.max(high));
        }
    }
    kept.push(n - 1);
    kept
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn few_points_are_left_alone() {
        assert_eq!(indices(&[3.0, 1.0, 2.0], 10), [0, 1, 2]);
        assert!(indices(&[], 10).is_empty());
    }

    proptest! {
        #[test]
        fn no_extreme_of_any_stretch_is_lost(values in prop::collection::vec(-1e3..1e3, 30..3000), most in 10_usize..200) {
            let kept = indices(&values, most);
            prop_assert!(kept.len() <= most.max(values.len().min(most)));
            prop_assert!(kept.is_sorted_by(|a, b| a < b));
            prop_assert_eq!((kept[0], *kept.last().unwrap()), (0, values.len() - 1));
            let of = |pick: fn(f64, f64) -> f64, all: &mut dyn Iterator<Item = f64>| all.reduce(pick).unwrap();
            for pick in [f64::min as fn(f64, f64) -> f64, f64::max] {
                prop_assert_eq!(
                    of(pick, &mut values.iter().copied()),
                    of(pick, &mut kept.iter().map(|&i| values[i]))
                );
            }
        }
    }
}
