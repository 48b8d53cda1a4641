//! In which order the lines of a survey are flown, so that a plane can turn from one to the next.
//!
//! A plane that turns within a radius R comes out of a half circle 2 R beside where it went in. Where lines lie nearer to each other than
//! that, it does not fly the next one but the one that it comes out on, and comes back for those between: the race-track order of
//! surveys by plane.

/// The order in which `count` lines are flown when two that follow each other should be at least `apart` lines apart.
///
/// Each line once. They are taken in blocks of at least `2 apart + 1` as equal as can be; in a block of `2 h − 1` lines the order is
/// 0, h, 1, h + 1, …, h − 1, so that steps are of h and h − 1 lines, to the next block too; in one of `2 h` lines h, 0, h + 1, 1, …. With
/// fewer lines than `2 apart` no order keeps them that far apart, and this keeps them as far apart as they can be: half their number.
#[must_use]
pub fn race_track(count: usize, apart: usize) -> Vec<usize> {
    let apart = apart.clamp(1, (count / 2).max(1));
    if apart == 1 {
        return (0..count).collect();
    }
    let blocks = (count / (2 * apart + 1)).max(1);
    let mut order = Vec::with_capacity(count);
    for block in 0..blocks {
        let first = block * count / blocks;
        let size = (block + 1) * count / blocks - first;
        let half = size.div_ceil(2);
        let [lower, upper] = [first..first + half, first + half..first + size];
        if size.is_multiple_of(2) {
            order.extend(upper.zip(lower).flat_map(|(far, near)| [far, near]));
        } else {
            order.extend(lower.clone().zip(upper).flat_map(|(near, far)| [near, far]));
            order.push(lower.end - 1);
        }
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_block_is_flown_like_a_race_track() {
        assert_eq!(race_track(5, 2), [0, 3, 1, 4, 2]);
        assert_eq!(race_track(10, 2), [0, 3, 1, 4, 2, 5, 8, 6, 9, 7]);
        assert_eq!(race_track(6, 3), [3, 0, 4, 1, 5, 2]);
        assert_eq!(race_track(4, 1), [0, 1, 2, 3]);
        assert_eq!(race_track(3, 9), [0, 1, 2]);
        assert_eq!(race_track(0, 3), [0_usize; 0]);
    }

    proptest! {
        #[test]
        fn every_line_once_and_far_enough_apart(count in 0..400_usize, apart in 0..40_usize) {
            let order = race_track(count, apart);
            let mut sorted = order.clone();
            sorted.sort_unstable();
            prop_assert_eq!(sorted, (0..count).collect::<Vec<_>>());
            let wanted = apart.min(count / 2).max(1);
            for pair in order.windows(2) {
                prop_assert!(pair[0].abs_diff(pair[1]) >= wanted, "{order:?}");
                prop_assert!(pair[0].abs_diff(pair[1]) <= 4 * apart.max(1) + 3, "{order:?}");
            }
        }
    }
}
