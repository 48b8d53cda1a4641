//! Notices another station that uses our own MAVLink address. Pure: time comes in.

use std::time::Duration;

use vencejo_link::Origin;
use vencejo_proto::MonoTime;

/// Two of its frames within this time show a station; a single one may be a very late echo.
const TOGETHER: Duration = Duration::from_secs(5);
/// After this time without a frame it is gone.
const OVER: Duration = Duration::from_secs(10);

/// Another station with our address.
#[derive(Debug, Default)]
pub(crate) struct Namesake {
    last: Option<(Origin, MonoTime)>,
    is_station: bool,
}

impl Namesake {
    /// Notes a frame with our address that we did not send; whether it newly shows another station.
    pub(crate) fn on_frame(&mut self, origin: Origin, now: MonoTime) -> bool {
        let was_there = self.heard(now).is_some();
        let is_second = self.last.is_some_and(|(_, at)| now.since(at) <= TOGETHER);
        self.is_station = was_there || is_second;
        self.last = Some((origin, now));
        self.is_station && !was_there
    }

    /// The link on which it is heard, if it is.
    pub(crate) fn heard(&self, now: MonoTime) -> Option<Origin> {
        let (origin, at) = self.last.filter(|_| self.is_station)?;
        (now.since(at) <= OVER).then_some(origin)
    }
}

#[cfg(test)]
mod tests {
    use vencejo_link::{LinkId, PeerId};

    use super::*;

    // fault 33: at its second frame within 5 s
    #[test]
    fn a_station_is_told_at_its_second_frame_and_an_echo_is_none() {
        let origin = Origin { link: LinkId(1), peer: PeerId(0) };
        let at = MonoTime::from_millis;
        let mut namesake = Namesake::default();
        assert!(!namesake.on_frame(origin, at(1_000)));
        assert!(!namesake.on_frame(origin, at(60_000)), "two, but not together");
        assert_eq!(namesake.heard(at(60_000)), None);
        assert!(namesake.on_frame(origin, at(61_000)), "a heartbeat each second");
        assert!(!namesake.on_frame(origin, at(62_000)), "told once");
        assert_eq!(namesake.heard(at(71_000)), Some(origin));
        assert_eq!(namesake.heard(at(73_000)), None, "it went");
        assert!(!namesake.on_frame(origin, at(80_000)));
        assert!(namesake.on_frame(origin, at(81_000)), "and came back");
    }
}
