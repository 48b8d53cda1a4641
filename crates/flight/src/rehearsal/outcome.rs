//! Result of a rehearsal: the track, the items on the way, and the end.

use super::airframe::Origin;
use super::battery::{BatteryLack, BatteryLeft};
use crate::geodesy::GeoPoint;
use crate::words::words;

/// Longest time between two samples of a thinned track, s.
const THINNED_S: f64 = 10.0;
/// Tolerance up to which a track is thinned further to have no more than so many samples, m.
const COARSEST_M: f64 = 1_000.0;
/// How many times the tolerance of a thinned track the ground below may have risen or fallen between two samples.
const GROUND_TIMES: f64 = 7.0;
/// But ground that differs by more than this is always drawn, m: of a long flight, too, ridges stay.
const COARSEST_GROUND_M: f64 = 20.0;
/// Metres of a degree of latitude, for small differences.
const M_PER_DEG: f64 = 111_195.0;

words! {
    /// How a rehearsed flight ends.
    Ending {
        /// At rest on the ground.
        Landed = "landed",
        /// Circling over home or a rally point.
        Returned = "returned",
        /// In a circle without end.
        Unlimited = "unlimited",
        /// Never: a jump repeats for ever. One round was flown.
        Endless = "endless",
        /// The ground came before a landing.
        Ground = "ground",
        /// The wind does not let the plane come nearer to where it has to go.
        Held = "held",
        /// It does not leave the ground.
        Grounded = "grounded",
        /// At an item that is not rehearsed.
        NotRehearsed = "not-rehearsed",
        /// After the longest time that is rehearsed, mostly six hours.
        TooLong = "too-long",
    }
}

/// One moment of the track.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Since the start, s.
    pub time_s: f64,
    /// Where.
    pub point: GeoPoint,
    /// Height above home, m.
    pub height_m: f64,
    /// Height that the autopilot asked for, m above home.
    pub height_asked_m: f64,
    /// Height of the ground below, m above home; `None` where it is not known.
    pub ground_m: Option<f64>,
    /// Airspeed, m/s EAS.
    pub airspeed_m_s: f64,
    /// Speed over ground, m/s.
    pub groundspeed_m_s: f64,
    /// Course over ground, degrees from true north, 0 to 360.
    pub course_deg: f64,
    /// Heading of the nose, degrees from true north, 0 to 360.
    pub heading_deg: f64,
    /// Climb, m/s.
    pub climb_m_s: f64,
    /// Bank, degrees, right positive.
    pub bank_deg: f64,
    /// Pitch, degrees.
    pub pitch_deg: f64,
    /// Throttle, 0 to 1.
    pub throttle: f64,
    /// Index of the item that is flown; `None` in a return and after the landing.
    pub index: Option<usize>,
}

impl Sample {
    /// Height above the ground below, m; `None` where that is not known.
    pub fn clearance_m(&self) -> Option<f64> {
        self.ground_m.map(|ground_m| self.height_m - ground_m)
    }
}

/// Where a flight comes nearest to the ground, with its time, place and [`Sample::clearance_m`]; `None` where the
/// ground is nowhere known.
pub fn nearest_to_ground<'a>(track: impl IntoIterator<Item = &'a Sample>) -> Option<&'a Sample> {
    let known = track.into_iter().filter_map(|sample| Some((sample, sample.clearance_m()?)));
    known.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(sample, _)| sample)
}

/// Why a plane does not follow the ground though an item's height counts from it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GroundLack {
    /// The ground is not known, there or at home.
    Unknown,
    /// The vehicle's terrain data are switched off (`TERRAIN_ENABLE` 0).
    Off,
}

/// One item on the way, in the order flown; jumps repeat them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Passage {
    /// Index in `mission.items`.
    pub item: usize,
    /// When the plane began to fly to it, s since the start.
    pub begins_s: f64,
    /// When it counted as reached or done; `None`: never.
    pub reached_s: Option<f64>,
    /// How near the plane came to its place, m; `None` for items other than waypoints and landings.
    pub nearest_m: Option<f64>,
    /// Whether it is a waypoint that the plane flew by, farther away than the autopilot's own radius.
    pub is_missed: bool,
    /// How much higher than asked the plane was when a waypoint counted, m; `None` for items other than waypoints.
    pub height_error_m: Option<f64>,
    /// Why the plane did not follow the ground on the way to an item whose height counts from it, though only for a
    /// part: it flew as if the height counted from home, or from the last ground known. `None`: it followed, or had not
    /// to.
    pub lacks_ground: Option<GroundLack>,
}

/// An order of an item to the camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraOrder {
    /// Since the start, s.
    pub time_s: f64,
    /// Distance after which it takes the next picture, m; 0: no more; `None`: unchanged.
    pub every_m: Option<f64>,
    /// Whether it takes a picture now.
    pub is_at_once: bool,
}

/// A plan, flown.
#[derive(Debug, Clone, PartialEq)]
pub struct Rehearsal {
    /// Origin of the airframe.
    pub airframe: Origin,
    /// The track, five moments a second, with its first and last.
    pub track: Vec<Sample>,
    /// The items flown.
    pub passages: Vec<Passage>,
    /// Orders to the camera, in order.
    pub camera: Vec<CameraOrder>,
    /// How it ends.
    pub ending: Ending,
    /// Where the ground was touched.
    pub touch_down: Option<Sample>,
    /// Until its end, s.
    pub duration_s: f64,
    /// Way over ground, m.
    pub distance_m: f64,
    /// Electrical energy used, Wh; `None` where the plane's power is not known.
    pub energy_wh: Option<f64>,
    /// Charge of the battery at the end.
    ///
    /// # Errors
    /// The value that is unknown.
    pub battery: Result<BatteryLeft, BatteryLack>,
    /// How far home lies above the known ground there, m; `None` where it is unknown. The ground of the whole flight
    /// counts from the ground at home, so this is the error of home's height.
    pub home_above_ground_m: Option<f64>,
}

impl Rehearsal {
    /// The samples that are needed to draw the track, and no more than `most`, which is at least 2: with a tolerance
    /// twice as large, as often as it takes.
    pub fn thinned_to(&self, tolerance_m: f64, most: usize) -> Vec<&Sample> {
        let (mut tolerance_m, mut kept) = (tolerance_m, self.thinned(tolerance_m));
        while kept.len() > most && tolerance_m < COARSEST_M {
            tolerance_m *= 2.0;
            kept = self.thinned(tolerance_m);
        }
        if kept.len() > most {
            let every = kept.len().div_ceil(most - 1);
            let last = kept.last().copied();
            kept = kept.into_iter().step_by(every).chain(last).take(most).collect();
        }
        kept
    }

    /// The samples that are needed to draw the track: the others lie within `tolerance_m` of where the last one kept
    /// was going, in place and in height, and over ground as high within seven times that, at most 20 m.
    pub fn thinned(&self, tolerance_m: f64) -> Vec<&Sample> {
        let mut kept: Vec<&Sample> = Vec::new();
        let mut before: Option<&Sample> = None;
        for sample in &self.track {
            let is_needed = kept.last().is_none_or(|last| {
                let dt = sample.time_s - last.time_s;
                let course = last.course_deg.to_radians();
                let north = (sample.point.lat_deg() - last.point.lat_deg()) * M_PER_DEG;
                let turned = crate::geodesy::wrap_180_deg(sample.point.lon_deg() - last.point.lon_deg());
                let east = turned * M_PER_DEG * last.point.lat_deg().to_radians().cos();
                let off_m = (north - last.groundspeed_m_s * dt * course.cos())
                    .hypot(east - last.groundspeed_m_s * dt * course.sin());
                let off_height_m = (sample.height_m - last.height_m - last.climb_m_s * dt).abs();
                let ground = sample.ground_m.zip(last.ground_m);
                let off_ground_m = ground.map_or(0.0, |(ground_m, last_m)| (ground_m - last_m).abs());
                let is_off = off_m.max(off_height_m) > tolerance_m
                    || off_ground_m > (GROUND_TIMES * tolerance_m).min(COARSEST_GROUND_M);
                let is_another = sample.index != last.index || sample.ground_m.is_some() != last.ground_m.is_some();
                dt > THINNED_S || is_off || is_another
            });
            if is_needed {
                // The one before it still was where it was expected.
                if let Some(before) =
                    before.filter(|before| kept.last().is_some_and(|last| last.time_s < before.time_s))
                {
                    kept.push(before);
                }
                kept.push(sample);
            }
            before = Some(sample);
        }
        if let Some(last) = before.filter(|last| kept.last().is_some_and(|kept| kept.time_s < last.time_s)) {
            kept.push(last);
        }
        kept
    }
}
