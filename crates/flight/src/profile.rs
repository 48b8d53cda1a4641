//! The height profile of a mission: heights above home over the way flown, circles included, and the ground below.
//!
//! Like the [`Way`] it stands on it takes the items as they stand in the plan. Between two items the height changes
//! evenly; on the way to an item whose height counts from the terrain, the height above the ground does. How the plane
//! really flies it is shown by the rehearsal.

use crate::geodesy::{GeoPoint, direct, distance_m, inverse, wrap_360_deg};
use crate::plan::{Command, Home, MavFrame, Mission, MissionItem};
use crate::progress::rel_home_m;
use crate::rehearsal::Ground;
use crate::way::{Circling, LegKind, Loiter, Stop, Way, rounded};

/// Tolerated error of terrain data, m: SRTM's absolute error stays below 16 m for nine of ten points and is mostly half
/// of that (Rodríguez et al. 2006). A take-off that they place below the ground by less is not reported.
const TERRAIN_ERROR_M: f64 = 10.0;
/// Places at which the ground is looked up, about; ends of legs come on top.
const SAMPLES: f64 = 400.0;
/// The same at most.
const MOST_SAMPLES: usize = 2_000;
/// They stand no nearer to each other than this, m, except round small circles.
const LEAST_STEP_M: f64 = 10.0;
/// Places round a circle at least and at most.
const CIRCLE_SAMPLES: (f64, f64) = (8.0, 200.0);

/// A point of the line.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "describe", derive(serde::Serialize, utoipa::ToSchema))]
pub struct ProfilePoint {
    /// The item that it belongs to, counted from 1; null for home at the beginning.
    #[cfg_attr(feature = "describe", schema(required = true))]
    pub item: Option<usize>,
    /// Way flown since the beginning, metres.
    pub distance_m: f64,
    /// Height above home, metres.
    pub alt_rel_home_m: f64,
    /// Whether that is known; otherwise home or the ground there is not, or the vehicle chooses it, and it is a guess.
    pub is_certain: bool,
    /// Whether the item's own height is here: others lead to it, over the ground or round a circle.
    pub is_item: bool,
    /// Whether it comes after a circle without end, and is flown only when a pilot goes on to it.
    pub is_beyond: bool,
}

/// A stretch in which the plane circles at an item.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "describe", derive(serde::Serialize, utoipa::ToSchema))]
pub struct ProfileLoiter {
    /// The item, counted from 1.
    pub item: usize,
    /// Until when.
    pub kind: Circling,
    /// Way flown until then, metres.
    pub from_m: f64,
    /// Way flown after it, metres: the same when it has no end or its length is not known.
    pub to_m: f64,
    /// Whether its length is not known, though it has one.
    pub is_unknown: bool,
}

/// How high above the ground the plane passes somewhere.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "describe", derive(serde::Serialize, utoipa::ToSchema))]
pub struct Clearance {
    /// Way flown until there, metres.
    pub distance_m: f64,
    /// Height above the ground, metres.
    pub clearance_m: f64,
}

/// A stretch in which the plane is too low.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "describe", derive(serde::Serialize, utoipa::ToSchema))]
pub struct LowStretch {
    /// Its first place.
    #[cfg_attr(feature = "describe", serde(flatten))]
    pub begin: Clearance,
    /// Way flown until its last place, metres.
    pub to_m: f64,
}

/// The ground below the way, as far as it is known.
#[derive(Debug, Clone, PartialEq, Default)]
#[cfg_attr(feature = "describe", derive(serde::Serialize, utoipa::ToSchema))]
pub struct ProfileGround {
    /// Way flown until each place at which it was looked up, metres.
    pub distance_m: Vec<f64>,
    /// Height of the ground above that at home, metres; null where it is not known.
    pub ground_rel_home_m: Vec<Option<f64>>,
    /// Where the plane is nearest to it, take-off and landing apart; null when it is nowhere known.
    #[cfg_attr(feature = "describe", schema(required = true))]
    pub lowest: Option<Clearance>,
    /// Where it is too low: below the height that was to be kept, and for take-off and landing in the ground by more
    /// than maps err.
    pub too_low: Vec<LowStretch>,
    /// Places whose height is not known.
    pub unknown: usize,
}

/// The heights of a mission.
#[derive(Debug, Clone, PartialEq, Default)]
#[cfg_attr(feature = "describe", derive(serde::Serialize, utoipa::ToSchema))]
pub struct Profile {
    /// The line, from home or from the first item when home is not known.
    pub points: Vec<ProfilePoint>,
    /// Where the plane circles.
    pub loiters: Vec<ProfileLoiter>,
    /// Way flown in all, metres: circles without end or of unknown length left out.
    pub length_m: f64,
    /// The ground below; null when home is not known, from which heights count.
    #[cfg_attr(feature = "describe", schema(required = true))]
    pub ground: Option<ProfileGround>,
}

/// The heights of a mission along its way, with the ground below it. `clearance_m` is the height above the ground that
/// should be kept.
pub fn profile(mission: &Mission, way: &Way, ground: &Ground<'_>, clearance_m: f64) -> Profile {
    let below = mission.home.map(|home| Below::new(mission, home, way, ground));
    let drawn = drawn(mission, way, below.as_ref());
    Profile { ground: below.map(|below| below.told(clearance_m)), ..drawn }
}

/// The line and its circles.
fn drawn(mission: &Mission, way: &Way, below: Option<&Below>) -> Profile {
    let home_m = mission.home.map(|home| home.alt_amsl_m);
    let (mut points, mut loiters) = (Vec::new(), Vec::new());
    let mut total_m = 0.0;
    let mut is_beyond = false;
    let at_home = ProfilePoint {
        item: None,
        distance_m: 0.0,
        alt_rel_home_m: 0.0,
        is_certain: true,
        is_item: false,
        is_beyond: false,
    };
    points.extend(home_m.map(|_| at_home));
    for (index, stop) in way.stops.iter().enumerate() {
        let Some(item) = mission.items.get(stop.item - 1) else { continue };
        let before_m = points.last().map_or(0.0, |point: &ProfilePoint| point.alt_rel_home_m);
        let over: Vec<_> = match (below, over_ground_m(item)) {
            (Some(below), Some(_)) => below.at(index).collect(),
            _ => Vec::new(),
        };
        let alt_m = match over_ground_m(item) {
            Some(over_m) => over.last().map(|(_, ground_m, _)| ground_m + over_m),
            // the height of a return is a parameter of the vehicle, not in the plan
            None => rel_home_m(item, home_m).filter(|_| item.command != Command::NAV_RETURN_TO_LAUNCH),
        };
        let there_m = alt_m.or(over_ground_m(item)).unwrap_or(before_m);
        let begin_m = total_m;
        let mut push = |distance_m: f64, height_m: f64, is_item: bool| {
            points.push(ProfilePoint {
                item: Some(stop.item),
                distance_m: rounded(distance_m, 1),
                alt_rel_home_m: rounded(height_m, 2),
                is_certain: alt_m.is_some(),
                is_item,
                is_beyond,
            });
        };
        let follow = |from_m: f64, to_m: f64, push: &mut dyn FnMut(f64, f64, bool)| {
            for (distance_m, ground_m, clearance_m) in &over {
                if *distance_m > from_m && *distance_m < to_m {
                    push(*distance_m, ground_m + clearance_m, false);
                }
            }
        };
        total_m += stop.leg.as_ref().map_or(0.0, |leg| leg.length_m);
        follow(begin_m, total_m, &mut push);
        let Some(loiter) = stop.loiter else {
            push(total_m, there_m, true);
            continue;
        };
        let is_climb = loiter.kind == Circling::Height;
        push(total_m, before_m + (there_m - before_m) * loiter.changed_before, !is_climb);
        let from_m = total_m;
        total_m += loiter.length_m.unwrap_or(0.0);
        if is_climb || total_m > from_m {
            follow(from_m, total_m, &mut push);
            push(total_m, there_m, is_climb);
        }
        loiters.push(ProfileLoiter {
            item: stop.item,
            kind: loiter.kind,
            from_m: rounded(from_m, 1),
            to_m: rounded(total_m, 1),
            is_unknown: loiter.length_m.is_none() && loiter.kind != Circling::Unlimited,
        });
        is_beyond |= loiter.kind == Circling::Unlimited;
    }
    Profile { points, loiters, length_m: rounded(total_m, 1), ground: None }
}

/// A place of the way at which the ground is looked up.
struct Sample {
    at: GeoPoint,
    /// Index of the stop that it leads to, or that is circled.
    stop: usize,
    distance_m: f64,
    /// How much of the change of height is done there, 0 to 1.
    changed: f64,
    /// Leaving home and coming in to land a plane is low on purpose.
    is_low: bool,
}

fn samples(mission: &Mission, way: &Way) -> Vec<Sample> {
    let length_m = |stop: &Stop| {
        stop.leg.as_ref().map_or(0.0, |leg| leg.length_m) + stop.loiter.and_then(|one| one.length_m).unwrap_or(0.0)
    };
    let total_m: f64 = way.stops.iter().map(length_m).sum();
    let step_m = (total_m / (SAMPLES - 2.0 * way.stops.len() as f64).max(1.0)).max(LEAST_STEP_M);
    let mut found = Vec::new();
    let mut begin_m = 0.0;
    for (index, stop) in way.stops.iter().enumerate() {
        let changed_before = stop.loiter.map_or(1.0, |loiter| loiter.changed_before);
        let mut last = None;
        if let Some(leg) = &stop.leg {
            let line: Vec<GeoPoint> = leg.points().collect();
            last = line.last().copied();
            let pieces = (leg.length_m / step_m).ceil().max(1.0);
            let is_low = leg.from_item.is_none() || leg.kind == LegKind::Approach;
            found.extend(along(&line, pieces as usize).into_iter().enumerate().map(|(piece, at)| {
                let part = piece as f64 / pieces;
                let distance_m = begin_m + leg.length_m * part;
                Sample { at, stop: index, distance_m, changed: part * changed_before, is_low }
            }));
            begin_m += leg.length_m;
        }
        let centre = mission.items.get(stop.item - 1).and_then(MissionItem::point);
        let Some((loiter, centre)) = stop.loiter.zip(centre) else { continue };
        let length_m = loiter.length_m.unwrap_or(0.0);
        let round = round(&loiter, centre, last, step_m);
        let pieces = round.len() as f64;
        found.extend(round.into_iter().enumerate().map(|(piece, at)| {
            let part = (piece + 1) as f64 / pieces;
            let changed = changed_before + (1.0 - changed_before) * part;
            Sample { at, stop: index, distance_m: begin_m + length_m * part, changed, is_low: false }
        }));
        begin_m += length_m;
    }
    let every = found.len().div_ceil(MOST_SAMPLES).max(1);
    found.into_iter().step_by(every).collect()
}

/// Places round a circle that begins at `from`; the ground below one without end is looked up once around.
fn round(loiter: &Loiter, centre: GeoPoint, from: Option<GeoPoint>, step_m: f64) -> Vec<GeoPoint> {
    let flown_m = loiter.length_m.unwrap_or(std::f64::consts::TAU * loiter.radius_m);
    if flown_m <= 0.0 || loiter.radius_m <= 0.0 {
        return Vec::new();
    }
    let pieces = (flown_m / step_m).ceil().clamp(CIRCLE_SAMPLES.0, CIRCLE_SAMPLES.1);
    let begin_deg = from.map_or(0.0, |from| inverse(centre, from).bearing_start_deg);
    let turned_deg = (flown_m / loiter.radius_m).to_degrees() * if loiter.is_clockwise { 1.0 } else { -1.0 };
    (1..=pieces as usize)
        .map(|piece| direct(centre, wrap_360_deg(begin_deg + turned_deg * piece as f64 / pieces), loiter.radius_m))
        .collect()
}

/// `pieces` + 1 places, evenly spaced, of a line.
fn along(line: &[GeoPoint], pieces: usize) -> Vec<GeoPoint> {
    let stretches: Vec<f64> = line.windows(2).map(|pair| distance_m(pair[0], pair[1])).collect();
    let whole_m: f64 = stretches.iter().sum();
    let mut places = Vec::with_capacity(pieces + 1);
    let (mut index, mut passed_m) = (0, 0.0);
    for piece in 0..pieces {
        let wanted_m = whole_m * piece as f64 / pieces as f64;
        while index + 1 < stretches.len() && passed_m + stretches[index] < wanted_m {
            passed_m += stretches[index];
            index += 1;
        }
        let Some([from, to]) = line.get(index..index + 2) else { break };
        places.push(direct(*from, inverse(*from, *to).bearing_start_deg, wanted_m - passed_m));
    }
    places.extend(line.last());
    places
}

/// Heights at the beginning of a leg.
#[derive(Clone, Copy)]
struct Begin {
    rel_home_m: Option<f64>,
    above_ground_m: Option<f64>,
}

/// Heights above the ground of the item, where they count from there.
fn over_ground_m(item: &MissionItem) -> Option<f64> {
    item.alt_m().filter(|_| item.frame == MavFrame::GlobalTerrainAlt)
}

/// The ground below the way, and the plane's height above it.
struct Below {
    samples: Vec<Sample>,
    /// Above the ground at home.
    ground_m: Vec<Option<f64>>,
    clearance_m: Vec<Option<f64>>,
}

impl Below {
    fn new(mission: &Mission, home: Home, way: &Way, ground: &Ground<'_>) -> Self {
        let samples = samples(mission, way);
        let above_sea_m: Vec<_> = samples.iter().map(|sample| ground(sample.at)).collect();
        // The plane stands on the ground at home: what a map is off there it is off everywhere, as for ArduPlane and
        // the rehearsal.
        let starts_at_home =
            way.stops.first().is_some_and(|stop| stop.leg.as_ref().is_some_and(|leg| leg.from_item.is_none()));
        let base_m = above_sea_m.first().copied().flatten().filter(|_| starts_at_home).unwrap_or(home.alt_amsl_m);
        let ground_m: Vec<_> = above_sea_m.iter().map(|height| height.map(|height_m| height_m - base_m)).collect();
        let item_of = |stop: usize| mission.items.get(way.stops[stop].item - 1);
        let end = |item: &MissionItem, begin: Begin, ground_m: Option<f64>| match over_ground_m(item) {
            Some(over_m) => ground_m.map(|ground_m| ground_m + over_m),
            // the height of a return is a parameter of the vehicle, not in the plan
            None => rel_home_m(item, Some(home.alt_amsl_m))
                .filter(|_| item.command != Command::NAV_RETURN_TO_LAUNCH)
                .or(begin.rel_home_m),
        };
        let mut begin = Begin { rel_home_m: Some(0.0), above_ground_m: Some(0.0) };
        let mut stop = None;
        let clearance_m = samples.iter().zip(&ground_m).map(|(sample, ground_m)| {
            if stop != Some(sample.stop) {
                stop = Some(sample.stop);
                let before = sample.stop.checked_sub(1).and_then(item_of);
                let rel_home_m = before.map_or(Some(0.0), |before| end(before, begin, *ground_m));
                let above_ground_m = rel_home_m.zip(*ground_m).map(|(height_m, ground_m)| height_m - ground_m);
                begin = Begin { rel_home_m, above_ground_m };
            }
            let (item, ground_m) = item_of(sample.stop).zip(*ground_m)?;
            let changed = |from_m: Option<f64>, to_m: f64| match from_m {
                Some(from_m) => Some(from_m + (to_m - from_m) * sample.changed),
                None => Some(to_m).filter(|_| sample.changed > 1.0 - 1e-9),
            };
            match over_ground_m(item) {
                Some(over_m) => changed(begin.above_ground_m, over_m),
                None => {
                    changed(begin.rel_home_m, end(item, begin, Some(ground_m))?).map(|height_m| height_m - ground_m)
                }
            }
        });
        let clearance_m = clearance_m.collect();
        Self { samples, ground_m, clearance_m }
    }

    /// Way, ground and height above it at the places on the way to a stop, where that is known.
    fn at(&self, stop: usize) -> impl Iterator<Item = (f64, f64, f64)> {
        let first = self.samples.partition_point(|sample| sample.stop < stop);
        (first..self.samples.len())
            .take_while(move |index| self.samples[*index].stop == stop)
            .filter_map(|index| Some((self.samples[index].distance_m, self.ground_m[index]?, self.clearance_m[index]?)))
    }

    fn told(&self, wanted_m: f64) -> ProfileGround {
        let mut told = ProfileGround::default();
        let mut is_open = false;
        for ((sample, ground_m), clearance_m) in self.samples.iter().zip(&self.ground_m).zip(&self.clearance_m) {
            let distance_m = rounded(sample.distance_m, 1);
            told.distance_m.push(distance_m);
            told.ground_rel_home_m.push(ground_m.map(|ground_m| rounded(ground_m, 1)));
            told.unknown += usize::from(ground_m.is_none());
            let here = clearance_m.map(|clearance_m| Clearance { distance_m, clearance_m: rounded(clearance_m, 2) });
            let least_m = if sample.is_low { -TERRAIN_ERROR_M } else { wanted_m };
            let low = here.filter(|here| here.clearance_m < least_m);
            match (low, told.too_low.last_mut().filter(|_| is_open)) {
                (Some(_), Some(stretch)) => stretch.to_m = distance_m,
                (Some(begin), None) => told.too_low.push(LowStretch { begin, to_m: distance_m }),
                (None, _) => {}
            }
            is_open = low.is_some();
            let is_nearer = |here: &Clearance| told.lowest.is_none_or(|lowest| here.clearance_m < lowest.clearance_m);
            told.lowest = here.filter(|_| !sample.is_low).filter(is_nearer).or(told.lowest);
        }
        told
    }
}

#[cfg(test)]
#[path = "profile_tests.rs"]
mod tests;
