//! Many rehearsals of one plan in winds and with planes that are not quite those expected: where it may be, and what
//! the odds are.
//!
//! [`fly_once`] as often as wanted, [`gather`] at the end.

use super::air::{Air, normals};
use super::aircraft::Aircraft;
use super::battery::BatteryLeft;
use super::fly::{Conditions, rehearse};
use super::outcome::{Ending, Rehearsal};
use crate::geodesy::{LocalFrame, wrap_180_deg};
use crate::landing::Wind;
use crate::plan::Plan;

/// How much may be otherwise than expected, as standard deviations.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "describe", derive(serde::Deserialize, utoipa::ToSchema), serde(default, deny_unknown_fields))]
pub struct Doubts {
    /// Of the wind's speed, m/s. Default 1.5.
    pub wind_speed_m_s: f64,
    /// Of its direction, degrees. Default 15.
    pub wind_from_deg: f64,
    /// Gusts of each flight, m/s. Default 1.
    pub gust_m_s: f64,
    /// Of thrust, as a part of it. Default 0.05.
    pub thrust: f64,
    /// Of drag, as a part of it. Default 0.1.
    pub drag: f64,
    /// Of the power that a thrust takes, as a part of it. Default 0.1.
    pub power: f64,
}

impl Doubts {
    /// The first value out of range: the field, its value and its range.
    pub fn fault(&self) -> Option<(&'static str, f64, (f64, f64))> {
        let fields = [
            ("wind_speed_m_s", self.wind_speed_m_s, (0.0, 20.0)),
            ("wind_from_deg", self.wind_from_deg, (0.0, 180.0)),
            ("gust_m_s", self.gust_m_s, (0.0, 20.0)),
            ("thrust", self.thrust, (0.0, 1.0)),
            ("drag", self.drag, (0.0, 1.0)),
            ("power", self.power, (0.0, 1.0)),
        ];
        // NaN is in no range.
        fields.into_iter().find(|(_, value, (low, high))| !(*low..=*high).contains(value))
    }
}

impl Default for Doubts {
    fn default() -> Self {
        Self { wind_speed_m_s: 1.5, wind_from_deg: 15.0, gust_m_s: 1.0, thrust: 0.05, drag: 0.1, power: 0.1 }
    }
}

/// Least, median and most of nine in ten flights.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "describe", derive(serde::Serialize, utoipa::ToSchema), schema(as = SpreadRange))]
pub struct Range {
    /// One flight in twenty has less.
    pub low: f64,
    /// Half of them have less.
    pub median: f64,
    /// One flight in twenty has more.
    pub high: f64,
}

/// How far flights lie from the expected one at a moment of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Breadth {
    /// Moment of the expected flight, s.
    pub time_s: f64,
    /// Across its course, m, to the right positive.
    pub across_m: Range,
    /// In height, m, higher positive.
    pub height_m: Range,
}

/// What many flights of one plan show.
#[derive(Debug, Clone, PartialEq)]
pub struct Spread {
    /// The flight in the expected wind.
    pub expected: Rehearsal,
    /// Flights beside it.
    pub runs: usize,
    /// How many ended how, the most first.
    pub endings: Vec<(Ending, usize)>,
    /// Duration, s, of those that ended as the expected one.
    pub duration_s: Range,
    /// Energy, Wh, of the same; `None` where the plane's power is not known.
    pub energy_wh: Option<Range>,
    /// Part of the battery's capacity that the same leave, below 0 where they need more than it holds; `None` where
    /// unknown.
    pub battery_left: Option<Range>,
    /// How many of all flights leave less than the reserve; `None` likewise.
    pub below_reserve: Option<usize>,
    /// Distance of touch-downs from the expected one, m; `None` without any.
    pub touch_down_m: Option<Range>,
    /// The corridor, a moment every five seconds.
    pub corridor: Vec<Breadth>,
}

/// Time between two moments of the corridor, s.
const CORRIDOR_S: f64 = 5.0;
/// Part of the flight, and s, by which another flight may be ahead or late at a moment of the expected one.
const LATE: (f64, f64) = (0.1, 15.0);

/// One of many flights: in a wind and with a plane that the seed chooses. Pure, so that a caller flies as many at once
/// as it has processors. `None` for a plan that is not rehearsed.
pub fn fly_once(
    plan: &Plan,
    conditions: &Conditions<'_>,
    doubts: &Doubts,
    expected: &Rehearsal,
    seed: u64,
) -> Option<Run> {
    let (plane, air) = doubtful(conditions, doubts, seed);
    let flown = rehearse(plan, &Conditions { plane: &plane, air, ..*conditions }).ok()?;
    Some(Run::of(&flown, expected))
}

/// Statistics of many flights and the expected one; the order of the flights does not matter.
pub fn gather(expected: Rehearsal, others: &[Run]) -> Spread {
    let mut endings: Vec<(Ending, usize)> = Vec::new();
    for other in others {
        match endings.iter_mut().find(|(ending, _)| *ending == other.ending) {
            Some((_, count)) => *count += 1,
            None => endings.push((other.ending, 1)),
        }
    }
    endings.sort_by_key(|(ending, count)| (std::cmp::Reverse(*count), *ending as u8));
    let alike = || others.iter().filter(|other| other.ending == expected.ending);
    let moments = expected.track.iter().filter(|sample| is_moment(sample.time_s)).map(|sample| sample.time_s);
    let corridor: Vec<Breadth> = moments
        .enumerate()
        .filter_map(|(index, time_s)| {
            let at = |which: fn(&(f64, f64)) -> f64| {
                range(others.iter().filter_map(|other| other.off[index].as_ref().map(which)))
            };
            Some(Breadth { time_s, across_m: at(|off| off.0)?, height_m: at(|off| off.1)? })
        })
        .collect();
    Spread {
        runs: others.len(),
        duration_s: range(alike().map(|other| other.duration_s)).unwrap_or(Range {
            low: expected.duration_s,
            median: expected.duration_s,
            high: expected.duration_s,
        }),
        energy_wh: range(alike().filter_map(|other| other.energy_wh)),
        battery_left: range(alike().filter_map(|other| Some(other.battery?.left()))),
        below_reserve: expected.battery.is_ok().then(|| {
            others.iter().filter(|other| other.battery.is_some_and(|battery| battery.is_below_reserve())).count()
        }),
        touch_down_m: range(others.iter().filter_map(|other| other.touch_down_m)),
        corridor,
        endings,
        expected,
    }
}

/// Whether a moment of the track is one of the corridor.
fn is_moment(time_s: f64) -> bool {
    let over = time_s.rem_euclid(CORRIDOR_S);
    !(0.05..=CORRIDOR_S - 0.05).contains(&over)
}

/// A wind and a plane that may be.
fn doubtful(conditions: &Conditions<'_>, doubts: &Doubts, seed: u64) -> (Aircraft, Air) {
    let Conditions { plane, air, .. } = *conditions;
    let [speed, direction, thrust, drag, power] = normals(seed);
    let mut airframe = plane.airframe;
    let pulls = (1.0 + doubts.thrust * thrust).clamp(0.5, 1.5);
    airframe.thrust_full_m_s2 *= pulls;
    airframe.thrust_static_m_s2 = airframe.thrust_static_m_s2.map(|still| still * pulls);
    airframe.drag_m_s2 *= (1.0 + doubts.drag * drag).clamp(0.5, 1.5);
    let costs = (1.0 + doubts.power * power).clamp(0.5, 1.5);
    airframe.power_cruise_w = airframe.power_cruise_w.map(|power_w| power_w * costs);
    let wind = Wind {
        from_deg: air.wind.from_deg + doubts.wind_from_deg * direction,
        speed_m_s: (air.wind.speed_m_s + doubts.wind_speed_m_s * speed).max(0.0),
    };
    (Aircraft { airframe, ..*plane }, Air { wind, gust_m_s: doubts.gust_m_s.hypot(air.gust_m_s), seed, ..air })
}

/// Result of one of many flights.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    ending: Ending,
    duration_s: f64,
    energy_wh: Option<f64>,
    battery: Option<BatteryLeft>,
    touch_down_m: Option<f64>,
    /// Across and in height, for each moment of the corridor.
    off: Vec<Option<(f64, f64)>>,
}

impl Run {
    fn of(flown: &Rehearsal, expected: &Rehearsal) -> Self {
        let down = expected.touch_down.zip(flown.touch_down);
        let mut from = 0;
        let moments = expected.track.iter().filter(|sample| is_moment(sample.time_s));
        let off = moments.map(|sample| {
            let frame = LocalFrame::new(sample.point, 0.0);
            let late_s = LATE.1 + LATE.0 * sample.time_s;
            while flown.track.get(from).is_some_and(|other| other.time_s < sample.time_s - late_s) {
                from += 1;
            }
            let near = flown.track[from..].iter().take_while(|other| other.time_s <= sample.time_s + late_s);
            let of_item = near.filter(|other| other.index == sample.index).map(|other| {
                let [north, east, _] = frame.ned_m(other.point, 0.0);
                (north.hypot(east), north, east, other.height_m - sample.height_m)
            });
            let (_, north, east, higher_m) = of_item.min_by(|a, b| a.0.total_cmp(&b.0))?;
            let (sin, cos) = wrap_180_deg(sample.course_deg).to_radians().sin_cos();
            Some((east * cos - north * sin, higher_m))
        });
        Self {
            ending: flown.ending,
            duration_s: flown.duration_s,
            energy_wh: flown.energy_wh,
            battery: flown.battery.ok(),
            touch_down_m: down.map(|(a, b)| crate::geodesy::distance_m(a.point, b.point)),
            off: off.collect(),
        }
    }
}

/// 90th percentile; `None` without values.
fn range(values: impl Iterator<Item = f64>) -> Option<Range> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    let at = |part: f64| values.get(((values.len() as f64 - 1.0) * part).round() as usize).copied();
    Some(Range { low: at(0.05)?, median: at(0.5)?, high: at(0.95)? })
}
