//! How much a plane has flown of the circle at the item in execution, from its telemetry.
//!
//! No message carries it: an ArduPlane reports that an item began (`MISSION_CURRENT`) and ended
//! (`MISSION_ITEM_REACHED`), and counts turns and time from the moment at which its lateral law is on the circle
//! (`Plane::verify_loiter_time`, `Plane::loiter_angle_update` of ArduPilot 4.7). So the same law is evaluated here for
//! every position.

use std::f64::consts::TAU;

use crate::geodesy::{GeoPoint, LocalFrame};
use crate::guidance::l1::{L1Params, L1State, Motion, Track, Turn, steer};
use crate::guidance::{NorthEast, wrap_pi};
use crate::plan::MissionItem;
use crate::progress::{Circled, ProgressOptions};
use crate::way::{Circling, circle, signed_radius_m};

/// Beyond this many radii a plane is still on its way to a circle (`Plane::update_loiter`).
const NEAR_RADII: f64 = 3.0;
/// A plane that was not heard for longer may have reached its circle meanwhile, s.
const HEARD_WITHIN_S: f64 = 3.0;
/// Bounds of the turn flown between two messages, as factors of the turn rate: in wind the rate varies around the
/// circle.
const UNHEARD: (f64, f64) = (0.5, 1.5);
/// A plane that has finished a circle stays on it until it heads for the next item, at most one turn if undisturbed
/// (`Plane::verify_loiter_heading`).
const TURNS_AFTER: f64 = 1.5;

/// A plane as it was heard to be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Heard {
    /// When, by the vehicle's clock, s.
    pub at_s: f64,
    /// Where.
    pub point: GeoPoint,
    /// Over ground, m/s.
    pub velocity: NorthEast,
}

/// Follows a plane around the circles of its mission.
#[derive(Debug, Clone, Default)]
pub struct CircleWatch {
    /// When it was heard last.
    heard_s: Option<f64>,
    /// When it was last known not to be on the circle yet.
    outside_s: Option<f64>,
    law: L1State,
    lap: Option<Lap>,
    is_unknown: bool,
}

/// Tracks how much of a circle was flown.
#[derive(Debug, Clone, Copy)]
struct Lap {
    since_s: f64,
    swept_rad: f64,
    bearing_rad: f64,
    /// How fast it turns about the centre.
    rate_rad_s: f64,
}

impl Lap {
    /// Turns since the item's own were flown, or since its time was over; less than 0 before, and 0 where it has no
    /// such end.
    fn turns_after(&self, kind: Circling, amount: f64, at_s: f64) -> f64 {
        match kind {
            Circling::Turns => self.swept_rad / TAU - amount,
            Circling::Time => self.swept_rad / TAU * (1.0 - amount / (at_s - self.since_s)),
            Circling::Height | Circling::Unlimited => 0.0,
        }
    }
}

impl CircleWatch {
    /// An item begins, or begins again: now, or at a moment that was missed (`is_now` is false).
    pub fn begins(&mut self, is_now: bool) {
        let heard_s = self.heard_s;
        *self = Self { heard_s, outside_s: heard_s.filter(|_| is_now), ..Self::default() };
    }

    /// A position outside of a known mission.
    pub fn elsewhere(&mut self, at_s: f64) {
        self.heard_s = Some(at_s);
    }

    /// A position on the way to this item, or around it.
    pub fn on(&mut self, heard: &Heard, item: &MissionItem, options: &ProgressOptions, law: &L1Params) {
        let before_s = self.heard_s.replace(heard.at_s);
        let Some((kind, _)) = signed_radius_m(item).filter(|_| !self.is_unknown) else { return };
        // The place of one without its own is where the plane was.
        let Some(circle) = circle(item, options) else {
            self.is_unknown = true;
            return;
        };
        let [north, east, _] = LocalFrame::new(circle.centre, 0.0).ned_m(heard.point, 0.0);
        let position = NorthEast::new(north, east);
        let (turn, sign) = if circle.is_clockwise { (Turn::Clockwise, 1.0) } else { (Turn::Anticlockwise, -1.0) };
        let bearing_rad = position.bearing_rad();
        let rate_rad_s = heard.velocity.length() / position.length().max(0.5 * circle.radius_m);
        if let Some(lap) = &mut self.lap {
            let dt_s = before_s.map_or(0.0, |before_s| heard.at_s - before_s).max(0.0);
            // The number of whole turns between two positions follows from the turn rate: of all turns before, else of
            // both ends.
            let mean_rad_s = if lap.swept_rad >= TAU {
                lap.swept_rad / (heard.at_s - dt_s - lap.since_s)
            } else {
                0.5 * (lap.rate_rad_s + rate_rad_s)
            };
            let about_rad = mean_rad_s * dt_s;
            let swept_rad = about_rad + wrap_pi(sign * (bearing_rad - lap.bearing_rad) - about_rad);
            // A turn more or less might be as true.
            let is_doubtful = swept_rad - TAU > UNHEARD.0 * about_rad || swept_rad + TAU < UNHEARD.1 * about_rad;
            lap.swept_rad += swept_rad;
            (lap.bearing_rad, lap.rate_rad_s) = (bearing_rad, rate_rad_s);
            // One that goes on has begun again at a moment that was missed.
            self.is_unknown =
                is_doubtful || lap.turns_after(kind, item.param(1).unwrap_or(0.0), heard.at_s) > TURNS_AFTER;
            return;
        }
        if position.length() <= NEAR_RADII * circle.radius_m {
            let track = Track::Circle { centre: NorthEast::default(), radius_m: circle.radius_m, turn };
            let heading_rad = heard.velocity.bearing_rad();
            let motion = Motion { position, velocity: heard.velocity, heading_rad };
            (self.law, _) = steer(self.law, &motion, &track, law, 0.0);
        } else {
            self.law = L1State::default();
        }
        if !self.law.on_circle {
            self.outside_s = Some(heard.at_s);
        } else if self.outside_s.is_some_and(|outside_s| heard.at_s - outside_s <= HEARD_WITHIN_S) {
            self.lap = Some(Lap { since_s: heard.at_s, swept_rad: 0.0, bearing_rad, rate_rad_s });
        } else {
            self.is_unknown = true;
        }
    }

    /// The part of the circle flown so far.
    pub fn circled(&self) -> Circled {
        match (self.is_unknown, self.lap, self.heard_s) {
            (true, ..) => Circled::Unknown,
            (false, Some(Lap { since_s, swept_rad, .. }), Some(heard_s)) => {
                Circled::Flown { turns: (swept_rad / TAU).max(0.0), time_s: (heard_s - since_s).max(0.0) }
            }
            _ => Circled::Nothing,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::Command;

    const CENTRE: (f64, f64) = (40.0, -3.0);
    const RADIUS_M: f64 = 80.0;
    const SPEED_M_S: f64 = 20.0;
    /// Between two decisions of the autopilot, s.
    const STEP_S: f64 = 0.1;

    /// A plane that flies from 700 m in the west to an anticlockwise circle and around it, ten moments a second, and
    /// when its own law begins to count.
    fn flight(wind: NorthEast) -> (Vec<Heard>, f64) {
        let frame = LocalFrame::new(GeoPoint::new(CENTRE.0, CENTRE.1).unwrap(), 0.0);
        let track = Track::Circle { centre: NorthEast::default(), radius_m: RADIUS_M, turn: Turn::Anticlockwise };
        let (mut position, mut heading_rad) = (NorthEast::new(0.0, -700.0), TAU / 4.0);
        let (mut law, mut begins_s) = (L1State::default(), None);
        let mut moments = Vec::new();
        for step in 0..1_100_u32 {
            let at_s = 1_000.0 + f64::from(step) * STEP_S;
            let velocity = NorthEast::from_bearing(heading_rad) * SPEED_M_S + wind;
            let (point, _) = frame.geodetic_from_ned([position.north, position.east, 0.0]);
            moments.push(Heard { at_s, point, velocity });
            if law.on_circle {
                begins_s.get_or_insert(at_s);
            }
            let motion = Motion { position, velocity, heading_rad };
            let (next, output) = steer(law, &motion, &track, &L1Params::default(), STEP_S);
            law = next;
            heading_rad += output.lateral_accel_m_s2 / SPEED_M_S * STEP_S;
            position = position + velocity * STEP_S;
        }
        (moments, begins_s.unwrap())
    }

    /// What is known at the end of these parts of that flight without wind, seconds since it was on the circle, of an
    /// item that began with the first.
    fn after(is_now: bool, parts_s: &[(f64, f64)]) -> Circled {
        let turns = MissionItem::loiter_turns(CENTRE.0, CENTRE.1, 80.0, 3.0, -RADIUS_M);
        flown_of(&flight(NorthEast::default()), &turns, &ProgressOptions::default(), is_now, parts_s)
    }

    fn flown_of(
        (moments, begins_s): &(Vec<Heard>, f64),
        item: &MissionItem,
        options: &ProgressOptions,
        is_now: bool,
        parts_s: &[(f64, f64)],
    ) -> Circled {
        let mut watch = CircleWatch::default();
        let mut begins = Some(is_now);
        let is_heard = |at_s: f64| parts_s.iter().any(|(from_s, to_s)| (*from_s..=*to_s).contains(&(at_s - begins_s)));
        for heard in moments.iter().step_by(3).filter(|heard| is_heard(heard.at_s)) {
            if let Some(is_now) = begins.take() {
                watch.elsewhere(heard.at_s);
                watch.begins(is_now);
            }
            watch.on(heard, item, options, &L1Params::default());
        }
        watch.circled()
    }

    fn check(is_now: bool, parts_s: &[(f64, f64)], flown_s: f64) {
        let found = after(is_now, parts_s);
        let Circled::Flown { turns, time_s } = found else { panic!("{parts_s:?}: {found:?}") };
        let expected = flown_s * SPEED_M_S / (TAU * RADIUS_M);
        assert!((turns - expected).abs() < 0.12, "{parts_s:?}: {turns} of {expected} turns");
        assert!((time_s - flown_s).abs() < 0.7, "{parts_s:?}: {time_s} of {flown_s} s");
    }

    #[test]
    fn what_is_flown_of_a_circle_is_counted_from_its_beginning() {
        assert_eq!(after(true, &[(-20.0, -8.0)]), Circled::Nothing, "on its way");
        check(true, &[(-20.0, 40.0)], 40.0);
        check(true, &[(5.0, 45.0)], 40.0);
        check(false, &[(-20.0, 40.0)], 40.0);
        // The vehicle's own circle turns as its radius' sign says; an item's sign or radius goes before.
        let flight = flight(NorthEast::default());
        let (lat_deg, lon_deg) = CENTRE;
        for (item_m, own_m, is_flown) in
            [(0.0, -RADIUS_M, true), (-0.0, RADIUS_M, true), (0.0, RADIUS_M, false), (RADIUS_M, -RADIUS_M, false)]
        {
            let item = MissionItem::loiter_turns(lat_deg, lon_deg, 80.0, 3.0, item_m);
            let options = ProgressOptions { loiter_radius_m: own_m, ..ProgressOptions::default() };
            let found = flown_of(&flight, &item, &options, true, &[(-20.0, 40.0)]);
            assert_eq!(found.flown().is_some_and(|(turns, _)| turns > 1.0), is_flown, "{item_m} {own_m}: {found:?}");
        }
    }

    #[test]
    fn a_plane_that_circles_on_and_on_has_begun_anew_unheard() {
        let turn_s = TAU * RADIUS_M / SPEED_M_S;
        let (lat_deg, lon_deg) = CENTRE;
        let turns = MissionItem::loiter_turns(lat_deg, lon_deg, 80.0, 0.5, -RADIUS_M);
        let time = MissionItem::loiter_time(lat_deg, lon_deg, 80.0, 0.5 * turn_s, false);
        let unlimited = MissionItem { command: Command::NAV_LOITER_UNLIM, ..turns.clone() };
        let options = ProgressOptions { loiter_radius_m: RADIUS_M, ..ProgressOptions::default() };
        let knows = |item: &MissionItem, turns: f64| {
            let found = flown_of(&flight(NorthEast::default()), item, &options, true, &[(-20.0, turns * turn_s)]);
            found != Circled::Unknown
        };
        for item in [turns, time] {
            assert!(knows(&item, 1.85) && !knows(&item, 2.15), "{item:?}");
        }
        assert!(knows(&unlimited, 2.15));
    }

    #[test]
    fn turns_that_were_not_heard_count_and_a_beginning_that_was_not_heard_is_not_known() {
        check(true, &[(-20.0, 3.0), (40.0, 42.0)], 42.0);
        assert_eq!(after(true, &[(-20.0, 3.0), (55.0, 57.0)]), Circled::Unknown, "several turns");
        assert_eq!(after(true, &[(-20.0, -8.0), (20.0, 30.0)]), Circled::Unknown);
        assert_eq!(after(false, &[(20.0, 30.0)]), Circled::Unknown, "whoever comes while it circles");
    }
    #[test]
    fn turns_that_were_not_heard_in_wind_are_right_or_not_known() {
        let item = MissionItem::loiter_turns(CENTRE.0, CENTRE.1, 80.0, 5.0, -RADIUS_M);
        let (mut known, mut unknown) = (0, 0);
        for wind_m_s in [4.0, 7.0, 9.0] {
            let flight = flight(NorthEast::new(0.0, wind_m_s));
            let turns = |parts_s: &[(f64, f64)]| {
                let found = flown_of(&flight, &item, &ProgressOptions::default(), true, parts_s);
                found.flown().map(|(turns, _)| turns)
            };
            for from_s in [3.0, 8.0, 13.0, 18.0, 23.0, 28.0, 33.0] {
                for unheard_s in [10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0] {
                    let (again_s, end_s) = (from_s + unheard_s, from_s + unheard_s + 1.0);
                    let expected = turns(&[(-20.0, end_s)]).unwrap();
                    match turns(&[(-20.0, from_s), (again_s, end_s)]) {
                        Some(found) => {
                            assert!(
                                (found - expected).abs() < 0.1,
                                "{wind_m_s} {from_s} {unheard_s}: {found}, {expected}"
                            );
                            known += 1;
                        }
                        None => unknown += 1,
                    }
                }
            }
        }
        assert!(known > 120 && unknown > 5, "{known} known, {unknown} not");
    }
}
