//! A flight in progress compared with an earlier rehearsal of it.

use crate::geodesy::{GeoPoint, LocalFrame};

/// Distance from the expected track beyond which the plane is off it, so that delay and height are not compared,
/// metres.
const ASTRAY_M: f64 = 150.0;
/// Climbing or sinking faster than this is a change of height that was asked for, not a deviation, metres per second.
const CHANGING_M_S: f64 = 2.0;
/// Below this the plane is on the ground or has just left it, metres above home.
const NEAR_GROUND_M: f64 = 10.0;
/// Part of the battery that must be used before its rate says anything, per cent.
const LEAST_USED_PCT: f64 = 2.0;

/// A moment of a flight as it was expected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Expected {
    /// Since the rehearsal's beginning, seconds.
    pub time_s: f64,
    /// Where.
    pub point: GeoPoint,
    /// Above home, metres.
    pub height_m: f64,
    /// Index of the item that is flown to; `None` in a return and after the landing.
    pub index: Option<usize>,
}

/// The moment at which the plane was expected where it is, on its way to the item of this index; `None` where it is
/// more than 150 m away from that way. Of an item that is flown several times, the one nearest to `since_s`, seconds
/// since the rehearsal's beginning; where that is not known, the one nearest in space.
pub fn expected_at(track: &[Expected], at: GeoPoint, index: Option<usize>, since_s: Option<f64>) -> Option<Expected> {
    // Of each time that the item is flown the nearest moment, with how far off it is.
    let mut times: Vec<(f64, Expected)> = Vec::new();
    let mut is_another = true;
    for (from, to) in track.iter().zip(track.iter().skip(1)) {
        if from.index != index {
            is_another = true;
            continue;
        }
        let frame = LocalFrame::new(from.point, 0.0);
        let ([leg_north, leg_east, _], [north, east, _]) = (frame.ned_m(to.point, 0.0), frame.ned_m(at, 0.0));
        let square = leg_north * leg_north + leg_east * leg_east;
        let part = if square > 0.0 { ((leg_north * north + leg_east * east) / square).clamp(0.0, 1.0) } else { 0.0 };
        let off_m = (north - part * leg_north).hypot(east - part * leg_east);
        if off_m > ASTRAY_M {
            continue;
        }
        let between = |from: f64, to: f64| from + (to - from) * part;
        let (time_s, height_m) = (between(from.time_s, to.time_s), between(from.height_m, to.height_m));
        let found = (off_m, Expected { time_s, point: at, height_m, index });
        match times.last_mut().filter(|_| !is_another) {
            Some(nearest) if nearest.0 <= off_m => {}
            Some(nearest) => *nearest = found,
            None => times.push(found),
        }
        is_another = false;
    }
    let by = |(off_m, expected): &(f64, Expected)| since_s.map_or(*off_m, |since_s| (expected.time_s - since_s).abs());
    times.into_iter().min_by(|a, b| by(a).total_cmp(&by(b))).map(|(_, expected)| expected)
}

/// The moment at which the plane was expected to have `left_s` seconds yet at the item of this index: on a circle,
/// where the place is the same after each turn. Of an item that is flown several times, the one nearest to `since_s`;
/// `None` where the track does not leave it.
pub fn expected_before_leaving(track: &[Expected], index: usize, left_s: f64, since_s: f64) -> Option<Expected> {
    let leaves = track.windows(2).filter(|pair| pair[0].index == Some(index) && pair[1].index != Some(index));
    let moments = leaves.map(|pair| pair[1].time_s - left_s);
    let time_s = moments.min_by(|a, b| (a - since_s).abs().total_cmp(&(b - since_s).abs()))?;
    let after = track.partition_point(|moment| moment.time_s <= time_s).clamp(1, track.len() - 1);
    let (from, to) = (track[after - 1], track[after]);
    let part = ((time_s - from.time_s) / (to.time_s - from.time_s).max(1e-9)).clamp(0.0, 1.0);
    let height_m = from.height_m + (to.height_m - from.height_m) * part;
    Some(Expected { time_s, point: from.point, height_m, index: Some(index) })
}

/// How far the plane at `height_m` above home is below what was expected of this moment, metres; negative above it.
/// `None` in the take-off, where the height was expected to change fast, and while the plane climbs or sinks fast
/// towards it: there a second too early or late is many metres. `climb_m_s` is upward.
pub fn low_m(track: &[Expected], expected: &Expected, height_m: f64, climb_m_s: Option<f64>) -> Option<f64> {
    let rate_m_s =
        |pair: &[Expected]| (pair[1].height_m - pair[0].height_m) / (pair[1].time_s - pair[0].time_s).max(1e-9);
    let is_takeoff = track.first().is_some_and(|first| first.height_m < NEAR_GROUND_M) && {
        let level = |pair: &&[Expected]| pair[0].height_m > NEAR_GROUND_M && rate_m_s(pair) < CHANGING_M_S;
        track.windows(2).find(level).is_none_or(|pair| expected.time_s < pair[0].time_s)
    };
    let mut pairs = track.windows(2);
    let is_changing =
        pairs.find(|pair| expected.time_s <= pair[1].time_s).is_some_and(|pair| rate_m_s(pair).abs() > CHANGING_M_S);
    let low_m = expected.height_m - height_m;
    let is_nearing = climb_m_s.is_some_and(|climb_m_s| climb_m_s * low_m.signum() > CHANGING_M_S);
    (!is_takeoff && !is_changing && !is_nearing).then_some(low_m)
}

/// What will be left of a battery in `left_s` when it goes on as in the `since_s` in which it went from `before_pct` to
/// `now_pct`, per cent; `None` while less than 2 % of it were used, too little to extrapolate.
pub fn battery_left_pct(before_pct: f64, now_pct: f64, since_s: f64, left_s: f64) -> Option<f64> {
    let used_pct = before_pct - now_pct;
    (used_pct >= LEAST_USED_PCT && since_s > 0.0).then(|| (now_pct - used_pct / since_s * left_s).max(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(lat_deg: f64, lon_deg: f64) -> GeoPoint {
        GeoPoint::new(lat_deg, lon_deg).unwrap()
    }

    /// 1,112 m northward to item 2 in 60 s, climbing, then as far eastward to item 3.
    fn track() -> Vec<Expected> {
        let moment = |time_s, point, height_m, item: usize| Expected { time_s, point, height_m, index: Some(item - 1) };
        vec![
            moment(10.0, at(40.0, -3.0), 50.0, 2),
            moment(70.0, at(40.01, -3.0), 80.0, 3),
            moment(130.0, at(40.01, -2.987), 80.0, 3),
        ]
    }

    #[test]
    fn what_was_expected_is_the_moment_of_the_same_leg() {
        let half = expected_at(&track(), at(40.005, -3.000_3), Some(1), None).unwrap();
        assert_eq!((half.time_s.round(), half.height_m.round()), (40.0, 65.0));
        let late = expected_at(&track(), at(40.010_1, -2.99), Some(2), None).unwrap();
        assert_eq!(late.time_s.round(), 116.0);
    }

    #[test]
    fn nothing_was_expected_away_from_that_leg() {
        assert_eq!(expected_at(&track(), at(40.005, -3.01), Some(1), None), None);
        assert_eq!(expected_at(&track(), at(40.005, -3.0), Some(3), None), None);
        assert_eq!(expected_at(&[], at(40.005, -3.0), None, None), None);
    }

    #[test]
    fn of_laps_it_is_the_one_that_the_time_tells() {
        let lap = |after_s: f64| track().into_iter().map(move |one| Expected { time_s: one.time_s + after_s, ..one });
        let twice: Vec<Expected> = lap(0.0).chain(lap(200.0)).collect();
        let first: Vec<Expected> = lap(0.0).collect();
        let expected_s =
            |track, since_s| expected_at(track, at(40.005, -3.0), Some(1), since_s).map(|one| one.time_s.round());
        assert_eq!((expected_s(&twice, Some(45.0)), expected_s(&twice, Some(250.0))), (Some(40.0), Some(240.0)));
        assert_eq!((expected_s(&first, Some(250.0)), expected_s(&twice, None)), (Some(40.0), Some(40.0)));
    }

    #[test]
    fn on_a_circle_what_is_left_of_it_tells_the_moment() {
        let found = |index, left_s, since_s| {
            let expected = expected_before_leaving(&track(), index, left_s, since_s)?;
            Some((expected.time_s, expected.height_m))
        };
        assert_eq!(found(1, 30.0, 40.0), Some((40.0, 65.0)));
        assert_eq!(found(1, 80.0, 0.0), Some((-10.0, 50.0)), "before the beginning: earlier than expected");
        assert_eq!(found(2, 5.0, 125.0), None, "it ends there");
        let twice: Vec<Expected> = track()
            .into_iter()
            .chain([170.0, 200.0].map(|time_s| Expected { time_s, ..track()[0] }))
            .chain([Expected { time_s: 230.0, ..track()[2] }])
            .collect();
        let again = |since_s| expected_before_leaving(&twice, 1, 10.0, since_s).unwrap().time_s;
        assert_eq!((again(65.0), again(215.0)), (60.0, 220.0));
        assert_eq!(expected_before_leaving(&[], 1, 0.0, 0.0), None);
    }

    #[test]
    fn heights_are_compared_where_they_do_not_change_fast() {
        let moment = |time_s, height_m| Expected { time_s, point: at(40.0, -3.0), height_m, index: Some(0) };
        let flight: Vec<Expected> =
            [(0.0, 0.0), (8.0, 0.0), (20.0, 60.0), (40.0, 62.0), (60.0, 112.0), (90.0, 112.0), (150.0, 30.0)]
                .map(|(time_s, height_m)| moment(time_s, height_m))
                .to_vec();
        let low = |time_s, expected_m, height_m, climb_m_s| {
            low_m(&flight, &moment(time_s, expected_m), height_m, Some(climb_m_s))
        };
        assert_eq!((low(5.0, 0.0, 53.0, 5.0), low(15.0, 35.0, 53.0, 0.0)), (None, None), "in the take-off");
        assert_eq!(low(30.0, 61.0, 53.0, 0.0), Some(8.0));
        assert_eq!(low(50.0, 87.0, 60.0, 0.0), None, "in a climb that was expected");
        assert_eq!((low(70.0, 112.0, 90.0, 4.0), low(70.0, 112.0, 140.0, -4.0)), (None, None), "on its way there");
        assert_eq!(
            (low(70.0, 112.0, 90.0, -4.0), low(70.0, 112.0, 140.0, 4.0)),
            (Some(22.0), Some(-28.0)),
            "away from it"
        );
        assert_eq!(low(120.0, 71.0, 60.0, -1.4), Some(11.0), "on an approach");
        assert_eq!(low_m(&flight[4..], &moment(65.0, 112.0), 100.0, None), Some(12.0));
    }

    #[test]
    fn a_battery_goes_on_as_it_went_and_says_nothing_at_the_beginning() {
        assert_eq!(battery_left_pct(90.0, 80.0, 100.0, 300.0), Some(50.0));
        assert_eq!(battery_left_pct(90.0, 80.0, 100.0, 3000.0), Some(0.0));
        assert_eq!(battery_left_pct(90.0, 89.0, 100.0, 300.0), None);
        assert_eq!(battery_left_pct(90.0, 80.0, 0.0, 300.0), None);
    }
}
