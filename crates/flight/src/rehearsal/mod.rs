//! Rehearsal: a plan flown by a point mass under ArduPlane's own laws, before the plane does.
//!
//! [`rehearse`] returns the track that the plane is expected to fly in a wind, when each item begins and is reached,
//! how near the plane comes to it, and where and how the flight ends. It is pure and deterministic; a mission of half
//! an hour takes some ten milliseconds, so that the track can follow a finger.
//!
//! | file | what it holds |
//! |---|---|
//! | `aircraft` | the autopilot's parameters |
//! | `airframe` | lift, drag and thrust |
//! | `battery` | the battery, and its charge after a flight |
//! | `air` | density, wind over height, gusts |
//! | `course` | the plan laid out in metres around home |
//! | `autopilot` | items, circles, heights, landing and return, as ArduPlane decides them; its laws are those of [`crate::guidance`] |
//! | `body` | the point mass |
//! | `doing` | activity at the start |
//! | `fly` | one rehearsal from its start to its end |
//! | `outcome` | track, items and end |
//! | `expected` | a flight in progress compared with its rehearsal |
//! | `spread` | many rehearsals: the corridor and the odds |
//! | `failsafe` | failures and the autopilot's reactions |
//! | `what_if` | the flight from any moment on when something fails |
//! | `glide` | how far the plane glides |
//! | `learn` | learning the plane from a recorded flight |
//!
//! # Limits
//!
//! No ground but the one given, no other traffic. Quadplanes, scripts and a glider's release are not rehearsed: the
//! flight ends there as [`Ending::NotRehearsed`]. How far rehearsals are from recorded flights, `make truth` measures.

mod air;
mod aircraft;
mod airframe;
mod autopilot;
mod battery;
mod body;
mod course;
mod doing;
mod expected;
mod failsafe;
mod fly;
mod glide;
mod learn;
mod outcome;
mod spread;
mod what_if;

#[cfg(test)]
mod tests;

pub use air::Air;
pub(crate) use air::eas_to_tas;
pub use aircraft::{Aircraft, Autoland};
pub use airframe::{Airframe, Origin};
pub use battery::{Battery, BatteryLack, BatteryLeft, BatterySettings};
pub use course::Ground;
pub use doing::Doing;
pub use expected::{Expected, battery_left_pct, expected_at, expected_before_leaving, low_m};
pub use failsafe::{BatteryAction, Failsafes, Reaction, Trigger};
pub use fly::{Conditions, IsWanted, NotRehearsed, Start, rehearse};
pub use glide::glide_range;
pub use learn::{Learned, Learner, Recorded, learn};
pub use outcome::{CameraOrder, Ending, GroundLack, Passage, Rehearsal, Sample, nearest_to_ground};
pub use spread::{Breadth, Doubts, Range, Run, Spread, fly_once, gather};
pub use what_if::{Decision, WhatIf, what_ifs};
