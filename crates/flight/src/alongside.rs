//! A rehearsed flight over the height profile of its plan: where each moment of it stands there, and where it is
//! nearest to the ground.

use std::collections::HashMap;

use crate::geodesy::distance_m;
use crate::plan::Mission;
use crate::profile::{Clearance, Profile};
use crate::rehearsal::{Passage, Sample};

/// A part of the flight that is one leg of the profile.
struct Stretch {
    /// Way flown until its end, m.
    until_m: f64,
    /// Way flown until its beginning, m.
    flown_from_m: f64,
    /// Where it begins in the profile, m.
    from_m: f64,
    /// Metres of the profile to one flown.
    scale: f64,
}

/// Where each moment of a track stands in the profile of its plan, metres: by distance flown, with each item where the
/// profile has it, so that planned and flown heights of one place stand over each other. After a jump it goes back.
pub fn along(track: &[&Sample], passages: &[Passage], profile: &Profile) -> Vec<f64> {
    let flown_m = flown_m(track);
    let stretches = stretches(track, &flown_m, passages, profile);
    let mut at = 0;
    let place = |way_m: f64| {
        while stretches.get(at + 1).is_some() && way_m > stretches[at].until_m {
            at += 1;
        }
        let Stretch { flown_from_m, from_m, scale, .. } = stretches[at];
        from_m + (way_m - flown_from_m) * scale
    };
    flown_m.iter().copied().map(place).collect()
}

/// Way over ground until each moment, m.
fn flown_m(track: &[&Sample]) -> Vec<f64> {
    let mut total_m = 0.0;
    let steps = track.windows(2).map(|pair| {
        total_m += distance_m(pair[0].point, pair[1].point);
        total_m
    });
    track.first().map(|_| 0.0).into_iter().chain(steps).collect()
}

fn stretches(track: &[&Sample], flown_m: &[f64], passages: &[Passage], profile: &Profile) -> Vec<Stretch> {
    // of each item's number: where its leg begins, and where it is done with
    let mut legs: HashMap<usize, (f64, f64)> = HashMap::new();
    let mut before_m = 0.0;
    for (at, point) in profile.points.iter().enumerate() {
        if let Some(item) = point.item {
            legs.insert(item, (before_m, point.distance_m));
            if profile.points.get(at + 1).is_some_and(|next| next.item == Some(item)) {
                continue;
            }
        }
        before_m = point.distance_m;
    }
    let mut found = Vec::new();
    let (mut begun_m, mut at_m) = (0.0, 0.0);
    for passage in passages {
        let Some(&(from_m, to_m)) = legs.get(&(passage.item + 1)) else { continue };
        let until_m = passage.reached_s.map_or(f64::INFINITY, |time_s| value_at(track, flown_m, time_s));
        let is_mapped = passage.reached_s.is_some() && until_m > begun_m;
        let scale = if is_mapped { (to_m - from_m) / (until_m - begun_m) } else { 1.0 };
        found.push(Stretch { until_m, flown_from_m: begun_m, from_m, scale });
        (begun_m, at_m) = (until_m, to_m);
    }
    // what comes after the last item: a return, the run on the ground
    found.push(Stretch { until_m: f64::INFINITY, flown_from_m: begun_m, from_m: at_m, scale: 1.0 });
    found
}

/// A value between two moments, kept within the track.
fn value_at(track: &[&Sample], values: &[f64], time_s: f64) -> f64 {
    let after = track.partition_point(|sample| sample.time_s <= time_s).clamp(1, track.len().max(2) - 1);
    let (Some(from), Some(to)) = (track.get(after - 1), track.get(after)) else {
        return values.last().copied().unwrap_or(0.0);
    };
    let part = ((time_s - from.time_s) / (to.time_s - from.time_s).max(1e-9)).clamp(0.0, 1.0);
    values[after - 1] + (values[after] - values[after - 1]) * part
}

/// Where a flight is nearest to the ground: the climb to `enough_m` above it, or to the third item flown to, and the
/// ways to take-offs and landings apart. `along_m` has where each moment of the track stands in the profile. `None`
/// where the ground is nowhere known.
pub fn lowest(mission: &Mission, track: &[&Sample], along_m: &[f64], enough_m: f64) -> Option<Clearance> {
    let is_low = |index: usize| {
        mission.items.get(index).is_some_and(|item| item.command.is_takeoff() || item.command.is_landing())
    };
    let mut lowest: Option<Clearance> = None;
    let (mut items, mut has_climbed, mut is_apart) = (0, false, false);
    let mut before = track.first().and_then(|first| first.index);
    for (sample, distance_m) in track.iter().zip(along_m) {
        items += u32::from(sample.index != before);
        before = sample.index;
        let Some(clearance_m) = sample.clearance_m() else { continue };
        has_climbed |= clearance_m >= enough_m || items > 1;
        // what has landed rolls on to no item
        is_apart = sample.index.map_or(is_apart, is_low);
        if has_climbed && !is_apart && lowest.is_none_or(|lowest| clearance_m < lowest.clearance_m) {
            lowest = Some(Clearance { distance_m: *distance_m, clearance_m });
        }
    }
    lowest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geodesy::{GeoPoint, direct};
    use crate::plan::MissionItem;
    use crate::profile::ProfilePoint;

    /// North at 20 m/s, a moment every 100 m; heights above home, of the ground, and the items flown to, from 1.
    fn track(height_m: &[f64], ground_m: &[Option<f64>], items: &[Option<usize>]) -> Vec<Sample> {
        let home = GeoPoint::new(40.3332, -3.7978).unwrap();
        let moment = |(index, height_m): (usize, &f64)| Sample {
            time_s: 5.0 * index as f64,
            point: direct(home, 0.0, 100.0 * index as f64),
            height_m: *height_m,
            height_asked_m: *height_m,
            ground_m: ground_m.get(index).copied().flatten(),
            airspeed_m_s: 20.0,
            groundspeed_m_s: 20.0,
            course_deg: 0.0,
            heading_deg: 0.0,
            climb_m_s: 0.0,
            bank_deg: 0.0,
            pitch_deg: 0.0,
            throttle: 0.5,
            index: items.get(index).copied().flatten().map(|item| item - 1),
        };
        height_m.iter().enumerate().map(moment).collect()
    }

    fn passage(item: usize, begins_s: f64, reached_s: Option<f64>) -> Passage {
        Passage {
            item: item - 1,
            begins_s,
            reached_s,
            nearest_m: Some(0.0),
            is_missed: false,
            height_error_m: None,
            lacks_ground: None,
        }
    }

    /// Where the moments of 1.2 km stand in a profile with home, item 1 at 300 m and item 2 at 800 m.
    fn check(passages: &[Passage], expected_m: &[(usize, f64)]) {
        let point = |item, distance_m, is_item| ProfilePoint {
            item,
            distance_m,
            alt_rel_home_m: 80.0,
            is_certain: true,
            is_item,
            is_beyond: false,
        };
        // the third leads to the second item over the ground
        let points = vec![
            point(None, 0.0, false),
            point(Some(1), 300.0, true),
            point(Some(2), 500.0, false),
            point(Some(2), 800.0, true),
        ];
        let profile = Profile { points, length_m: 800.0, ..Profile::default() };
        let flown = track(&[80.0; 13], &[], &[]);
        let along_m = along(&flown.iter().collect::<Vec<_>>(), passages, &profile);
        assert_eq!(along_m.len(), 13);
        for (moment, wanted_m) in expected_m {
            assert!((along_m[*moment] - wanted_m).abs() < 0.5, "{moment}: {}", along_m[*moment]);
        }
    }

    #[test]
    fn each_item_stands_where_the_profile_has_it_and_what_follows_the_last_beyond() {
        let passages = [passage(1, 0.0, Some(20.0)), passage(2, 20.0, Some(50.0))];
        check(&passages, &[(0, 0.0), (2, 150.0), (4, 300.0), (10, 800.0), (12, 1000.0)]);
        check(&[], &[(0, 0.0), (12, 1200.0)]);
    }

    #[test]
    fn it_goes_back_where_a_jump_does_and_no_farther_than_it_flew_to_what_it_never_reaches() {
        let [there, on] = [passage(1, 0.0, Some(20.0)), passage(2, 20.0, Some(40.0))];
        let passages = [there, on, passage(1, 40.0, Some(50.0)), passage(2, 50.0, None)];
        check(&passages, &[(8, 800.0), (9, 150.0), (12, 500.0)]);
    }

    #[test]
    fn the_lowest_place_is_where_it_flies_not_where_it_climbs_out_or_lands() {
        let along_m: Vec<f64> = (0..8).map(|index| 100.0 * f64::from(index)).collect();
        let ground_m = [Some(0.0), Some(0.0), Some(0.0), None, Some(35.0), Some(20.0), Some(0.0), Some(0.0)];
        let items = [1, 1, 1, 2, 2, 3, 4, 4].map(Some);
        let mission = Mission {
            items: vec![
                MissionItem::takeoff(40.0, -3.0, 50.0, 12.0),
                MissionItem::waypoint(40.01, -3.0, 60.0),
                MissionItem::waypoint(40.02, -3.0, 60.0),
                MissionItem::land(40.03, -3.0, 0.0),
            ],
            ..Mission::default()
        };
        let check = |ground_m: &[Option<f64>], enough_m: f64, expected: Option<(f64, f64)>| {
            let flown = track(&[0.0, 20.0, 50.0, 60.0, 60.0, 60.0, 40.0, 10.0], ground_m, &items);
            let found = lowest(&mission, &flown.iter().collect::<Vec<_>>(), &along_m, enough_m);
            assert_eq!(found.map(|found| (found.clearance_m, found.distance_m)), expected);
        };
        check(&ground_m, 30.0, Some((25.0, 400.0)));
        // what never climbs that high has left all the same at its third item
        check(&ground_m, 80.0, Some((40.0, 500.0)));
        check(&[None; 8], 30.0, None);
    }
}
