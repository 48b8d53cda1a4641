//! Positions to fly to, of which ROS 2 sends a stream: which of them becomes an order, and when.
//!
//! A node repeats its target ten times a second, or moves it as often. Neither is to fill the link of a plane: the
//! newest target counts, one order is under way at a time, they are a second apart, and a target that the plane has
//! already is not sent again.

use std::time::Duration;

use vencejo_proto::MonoTime;
use vencejo_vehicle::modes::Action;
use vencejo_vehicle::telemetry::{Freshness, Telemetry};
use vencejo_vehicle::{AltFrame, Request, Turn};

use super::message::GeoPoseStamped;

/// The topic below the plane's.
pub const TOPIC: &str = "setpoint_position/global";
/// The time between two orders.
const EVERY: Duration = Duration::from_secs(1);
/// Targets that are no further apart are the same, degrees (0.1 m) and m.
const SAME: [f64; 3] = [1e-6, 1e-6, 0.1];

/// A position to fly to: latitude and longitude, degrees, and altitude above the sea, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Target([f64; 3]);

impl Target {
    /// The position of a message. Its altitude is above the sea, not above the ellipsoid as `GeoPoint` has it: MAVROS
    /// sends it on as it is in MAV_FRAME_GLOBAL_INT, and programs are written for that. Its attitude does not count.
    pub fn of(message: &GeoPoseStamped) -> Self {
        let place = &message.pose.position;
        Self([place.latitude, place.longitude, place.altitude])
    }

    fn is_near(&self, other: &Self) -> bool {
        let apart = |axis: usize| (self.0[axis] - other.0[axis]).abs();
        (0..3).all(|axis| apart(axis) <= SAME[axis])
    }

    /// The order to fly there. As with MAVROS it changes no mode: a stream would take the plane back from whoever
    /// changes it.
    pub fn request(&self) -> Request {
        let Self([lat_deg, lon_deg, alt_m]) = *self;
        Request::Reposition {
            lat_deg,
            lon_deg,
            alt_m,
            alt_frame: AltFrame::Amsl,
            radius_m: None,
            turn: Turn::Clockwise,
            speed_m_s: None,
            change_mode: false,
            below_home: false,
        }
    }
}

/// Why no target is flown to now: the plane's mode. `None`: it is, or the vehicle itself has to say.
pub fn barred_by(telemetry: &Telemetry, now: MonoTime) -> Option<String> {
    let heartbeat = telemetry.heartbeat.filter(|heartbeat| heartbeat.freshness(now) != Freshness::Lost)?;
    let mode = heartbeat.value.mode;
    // A PX4 flies to positions in AUTO.LOITER.
    let guided = Action::Guided.mode(mode.family).or_else(|| Action::Loiter.mode(mode.family))?;
    (mode != guided).then(|| format!("it is in {mode}, and flies to positions in {guided}: call set_mode first"))
}

/// A stream of targets.
#[derive(Debug, Default)]
pub struct Stream {
    newest: Option<Target>,
    under_way: Option<Target>,
    flown: Option<Target>,
    sent_at: Option<MonoTime>,
    /// What was said last, so that a stream does not fill the log.
    said: String,
}

impl Stream {
    /// Another target, or why it cannot be flown to now, which does not wait for that to end. Returns what there is to
    /// say, and whether that is good.
    pub fn on_target(&mut self, target: Result<Target, String>) -> Option<(bool, String)> {
        self.newest = target.as_ref().ok().copied();
        self.news(false, target.err()?)
    }

    /// The plane does not fly to positions now: what it flew to before is not its target any more.
    pub fn left(&mut self) {
        (self.newest, self.flown) = (None, None);
    }

    /// The target that is to be sent now. [`Self::ended`] is called when it is known what became of it.
    pub fn due(&mut self, now: MonoTime) -> Option<Target> {
        if self.under_way.is_some() || self.sent_at.is_some_and(|at| now.since(at) < EVERY) {
            return None;
        }
        let target = self.newest.take()?;
        if self.flown.is_some_and(|flown| flown.is_near(&target)) {
            return None;
        }
        (self.under_way, self.flown, self.sent_at) = (Some(target), None, Some(now));
        Some(target)
    }

    /// The order was carried out, or why not. Returns as [`Self::on_target`].
    pub fn ended(&mut self, end: Result<(), String>) -> Option<(bool, String)> {
        let target = self.under_way.take();
        match end {
            Ok(()) => {
                self.flown = target;
                self.news(true, "it flies to the position".to_owned())
            }
            Err(why) => self.news(false, why),
        }
    }

    fn news(&mut self, is_good: bool, words: String) -> Option<(bool, String)> {
        let is_new = words != self.said;
        self.said.clone_from(&words);
        is_new.then_some((is_good, words))
    }
}

#[cfg(test)]
mod tests {
    use vencejo_proto::{Heartbeat, Message};

    use super::super::message::{GeoPoint, GeoPose, Header, Quaternion, Time};
    use super::*;

    fn at(ms: u64) -> MonoTime {
        MonoTime::from_millis(ms)
    }

    const HERE: Target = Target([40.0, -3.0, 700.0]);
    const THERE: Target = Target([40.01, -3.0, 700.0]);

    /// Ten targets a second for three seconds: the orders that become of them, each answered after `answer_ms`.
    fn orders(answer_ms: u64, target: impl Fn(u64) -> Target) -> Vec<(u64, Target)> {
        let (mut stream, mut sent, mut answers) = (Stream::default(), Vec::new(), None);
        for ms in (0..3_000).step_by(50) {
            if ms % 100 == 0 {
                assert_eq!(stream.on_target(Ok(target(ms))), None);
            }
            if answers == Some(ms) {
                let said = stream.ended(Ok(()));
                assert_eq!(said.is_some(), sent.len() == 1, "said once");
                answers = None;
            }
            if let Some(target) = stream.due(at(ms)) {
                sent.push((ms, target));
                answers = Some(ms + answer_ms);
            }
        }
        sent
    }

    #[test]
    fn a_stream_does_not_fill_the_link() {
        assert_eq!(orders(200, |_| HERE), [(0, HERE)], "what it has already");
        let nearly = |ms: u64| if ms.is_multiple_of(200) { HERE } else { Target([40.000_000_1, -3.0, 700.01]) };
        assert_eq!(orders(200, nearly), [(0, HERE)], "but for a centimetre");
        let moving = |ms: u32| Target([40.0 + 1e-6 * f64::from(ms), -3.0, 700.0]);
        let moves = |ms: u64| moving(u32::try_from(ms).expect("short"));
        let newest = [(0, moving(0)), (1_000, moving(1_000)), (2_000, moving(2_000))];
        assert_eq!(orders(200, moves), newest, "once a second");
        assert_eq!(orders(1_500, moves), [(0, moving(0)), (1_500, moving(1_500))], "and one at a time");
        let turned = |ms: u64| if ms < 500 { HERE } else { THERE };
        assert_eq!(orders(200, turned), [(0, HERE), (1_000, THERE)]);
    }

    #[test]
    fn one_target_is_one_order_and_what_was_refused_is_tried_while_it_is_repeated() {
        let (mut stream, held) = (Stream::default(), || Err("Ana holds control".to_owned()));
        let returns = || Err("it is in RTL".to_owned());
        stream.on_target(Ok(HERE));
        assert_eq!(stream.due(at(0)), Some(HERE));
        // A single one that comes meanwhile waits.
        stream.on_target(Ok(THERE));
        assert_eq!(stream.due(at(2_000)), None);
        assert_eq!(stream.ended(Ok(())).map(|(is_good, _)| is_good), Some(true));
        assert_eq!((stream.due(at(2_000)), stream.due(at(4_000))), (Some(THERE), None));
        assert_eq!(stream.ended(held()), Some((false, "Ana holds control".to_owned())));
        assert_eq!(stream.due(at(9_000)), None, "it is not tried again by itself");
        stream.on_target(Ok(THERE));
        assert_eq!(stream.due(at(9_000)), Some(THERE));
        assert_eq!(stream.ended(held()), None, "said once");
        // In another mode it flies to none, and once it may again not to the last one either.
        stream.on_target(Ok(HERE));
        assert_eq!(stream.due(at(11_000)), Some(HERE));
        stream.ended(Ok(()));
        assert_eq!(stream.on_target(returns()), Some((false, "it is in RTL".to_owned())));
        assert_eq!(stream.on_target(returns()), None);
        stream.left();
        assert_eq!(stream.due(at(20_000)), None);
        stream.on_target(Ok(HERE));
        assert_eq!(stream.due(at(20_000)), Some(HERE), "it left that target, which is another order now");
    }

    #[test]
    fn a_target_is_flown_to_in_the_mode_for_it_alone() {
        let barred = |autopilot, custom_mode, ms| {
            let mut telemetry = Telemetry::new();
            let heartbeat = Heartbeat { mav_type: 1, autopilot, custom_mode, base_mode: 1, ..Heartbeat::default() };
            telemetry.apply(&Message::Heartbeat(heartbeat), at(0));
            barred_by(&telemetry, at(ms))
        };
        assert_eq!(barred(3, 15, 0), None);
        let why = barred(3, 11, 0).expect("it returns");
        assert_eq!(why, "it is in RTL, and flies to positions in GUIDED: call set_mode first");
        assert_eq!(barred(12, 0x0304_0000, 0), None);
        assert!(barred(12, 0x0404_0000, 0).is_some_and(|why| why.contains("positions in AUTO_LOITER")));
        // Of one that is not heard the request says so.
        assert_eq!((barred(3, 11, 60_000), barred_by(&Telemetry::new(), at(0))), (None, None));
    }

    /// MAVROS sends the altitude on as it is, in MAV_FRAME_GLOBAL_INT: above the sea.
    #[test]
    fn an_altitude_is_above_the_sea() {
        let position = GeoPoint { latitude: 40.5, longitude: -3.5, altitude: 700.0 };
        let orientation = Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 0.0 };
        let header = Header { stamp: Time { sec: 0, nanosec: 0 }, frame_id: String::new() };
        let message = GeoPoseStamped { header, pose: GeoPose { position, orientation } };
        let Request::Reposition { lat_deg, lon_deg, alt_m, alt_frame, change_mode, below_home, .. } =
            Target::of(&message).request()
        else {
            panic!("another request");
        };
        assert_eq!((lat_deg, lon_deg, alt_m, alt_frame), (40.5, -3.5, 700.0, AltFrame::Amsl));
        assert!(!change_mode && !below_home);
    }
}
