//! A plane at a moment, as its topics look at it.

use std::time::Duration;

use vencejo_flight::plan::{Home, Mission};
use vencejo_proto::MonoTime;
use vencejo_vehicle::telemetry::{Freshness, Sampled, Telemetry};

use super::frames;
use super::message::{Header, Pose, Time};
use super::name::Place;

/// Values of two messages belong together when they are no further apart.
const TOGETHER: Duration = Duration::from_secs(1);

/// A plane at a moment.
pub struct Moment<'a> {
    /// What it said.
    pub telemetry: &'a Telemetry,
    /// When that was looked at.
    pub now: MonoTime,
    /// The same by this machine's clock, UTC since 1970, ns.
    pub utc_ns: i64,
    /// Where it is in ROS.
    pub place: &'a Place,
    /// Its home.
    pub home: Option<Home>,
    /// Its mission, where that is known.
    pub mission: Option<&'a Mission>,
}

/// UTC since 1970, ns, as ROS has it.
pub fn time(utc_ns: i64) -> Time {
    let sec = i32::try_from(utc_ns.div_euclid(1_000_000_000)).unwrap_or(i32::MAX);
    Time { sec, nanosec: u32::try_from(utc_ns.rem_euclid(1_000_000_000)).unwrap_or(0) }
}

impl Moment<'_> {
    /// What stands at the head of a message of that moment: when it was received, by this machine's clock, which ROS
    /// goes by.
    pub(super) fn header(&self, at: MonoTime, frame: &str) -> Header {
        let age = i64::try_from(self.now.since(at).as_nanos()).unwrap_or(i64::MAX);
        Header { stamp: time(self.utc_ns.saturating_sub(age)), frame_id: self.frame(frame) }
    }

    /// A frame of this plane.
    pub(super) fn frame(&self, name: &str) -> String {
        format!("{}{name}", self.place.frames)
    }

    /// What is as good as now.
    pub(super) fn fresh<T: Copy>(&self, group: Option<Sampled<T>>) -> Option<Sampled<T>> {
        group.filter(|sampled| sampled.freshness(self.now) == Freshness::Fresh)
    }

    /// What belongs to a message that came then.
    pub(super) fn beside<T: Copy>(&self, at: MonoTime, group: Option<Sampled<T>>) -> Option<T> {
        let near = |sampled: &Sampled<T>| at.since(sampled.at).max(sampled.at.since(at)) <= TOGETHER;
        group.filter(near).map(|sampled| sampled.value)
    }

    /// Where it is from home, and when.
    pub(super) fn pose(&self) -> Option<(MonoTime, Pose)> {
        let position = self.fresh(self.telemetry.position)?;
        let attitude = self.beside(position.at, self.telemetry.attitude)?;
        Some((position.at, frames::pose(self.home.as_ref()?, &position.value, &attitude)?))
    }
}
