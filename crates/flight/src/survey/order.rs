//! In which order the lines of a survey are flown, so that a plane can turn from one to the next, and where they can
//! begin.
//!
//! A plane that turns within a radius R comes out of a half circle 2 R beside where it went in. Where lines lie nearer
//! to each other than that, it does not fly the next one but the one that it comes out on, and comes back for those
//! between: the race-track order of surveys by plane.

use crate::geodesy::{GeoPoint, distance_m, leg_offset};

/// The order in which `count` lines are flown when two that follow each other should be at least `apart` lines apart.
///
/// Each line once. They are taken in blocks of at least `2 apart + 1` as equal as can be; in a block of `2 h − 1` lines
/// the order is 0, h, 1, h + 1, …, h − 1, so that steps are of h and h − 1 lines, to the next block too; in one of `2
/// h` lines h, 0, h + 1, 1, …. With fewer lines than `2 apart` no order keeps them that far apart, and this keeps them
/// as far apart as they can be: half their number.
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

/// The places where lines can begin, in turn around them: the ends of the outermost ones, those of the first side
/// first. Lines of a corridor end where its line does, on either side.
fn entries(lines: &[&[GeoPoint]]) -> Vec<GeoPoint> {
    let lines: Vec<&[GeoPoint]> = lines.iter().copied().filter(|line| line.len() > 1).collect();
    let ends = |line: &[GeoPoint]| (line[0], line[line.len() - 1]);
    let Some((from, to)) = lines.first().map(|first| ends(first)) else { return Vec::new() };
    let aside_m = |line: &&&[GeoPoint]| leg_offset(from, to, line[0]).cross_m;
    let by_side = |a: &&&[GeoPoint], b: &&&[GeoPoint]| aside_m(a).total_cmp(&aside_m(b));
    // of those that lie on top of each other the first is the left one, the last the right one
    let (Some(left), Some(right)) = (lines.iter().min_by(by_side), lines.iter().max_by(by_side)) else {
        return Vec::new();
    };
    let (near, far) = ends(left);
    if std::ptr::eq(*left, *right) {
        return vec![near, far];
    }
    let (a, b) = ends(right);
    // once around: from the far end over to the end of the other line beside it
    if distance_m(far, a) <= distance_m(far, b) { vec![near, far, a, b] } else { vec![near, far, b, a] }
}

/// Where lines can begin in place of where they do now: at the next of their corners, in turn around them; `None` of no
/// line.
pub(super) fn next_entry(lines: &[&[GeoPoint]]) -> Option<GeoPoint> {
    let begin = *lines.first()?.first()?;
    let around = entries(lines);
    let away_m = |(_, place): &(usize, &GeoPoint)| distance_m(begin, **place);
    let (now, _) = around.iter().enumerate().min_by(|a, b| away_m(a).total_cmp(&away_m(b)))?;
    Some(around[(now + 1) % around.len()])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geodesy::direct;

    /// 800 m from west to east, so far north of a place, or back.
    fn line(north_m: f64, is_back: bool) -> Vec<GeoPoint> {
        let middle = direct(GeoPoint::new(40.3332, -3.7978).unwrap(), 0.0, north_m);
        let mut ends = [-400.0, 400.0].map(|east_m| direct(middle, 90.0, east_m)).to_vec();
        if is_back {
            ends.reverse();
        }
        ends
    }

    #[test]
    fn a_survey_can_begin_at_the_ends_of_its_outermost_lines_in_turn_around_them() {
        // the middle one is flown last
        let lines = [line(100.0, false), line(-100.0, true), line(0.0, false)];
        let lines: Vec<&[GeoPoint]> = lines.iter().map(Vec::as_slice).collect();
        let around = entries(&lines);
        assert_eq!(around.len(), 4);
        for (index, place) in around.iter().enumerate() {
            let far_m = distance_m(*place, around[(index + 1) % 4]);
            assert!((far_m - if index % 2 == 0 { 800.0 } else { 200.0 }).abs() < 0.5, "{index}: {far_m}");
        }
        assert_eq!(next_entry(&lines), Some(lines[0][1]));
        assert_eq!(next_entry(&lines[2..]), Some(lines[2][1]));
        assert_eq!(next_entry(&[]), None);
    }

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
