//! The services of a plane in ROS 2, one by one: what each wants, and how its answer is told.

use super::cdr::{BadCdr, Cdr};
use super::message::{
    CommandBool, CommandHome, CommandLong, CommandTOL, Commanded, CommandedPlace, CurrentWanted, HomeWanted,
    LongWanted, MissionPushed, ModeSent, ModeWanted, Pulled, Pushed, SetBool, SetMode, Succeeded, Switch, Told,
    Trigger, WaypointClear, WaypointPull, WaypointPush, WaypointSetCurrent,
};
use super::name::Names;
use super::offer::{Ended, Offer, Wish, offer};
use super::params;

/// `MAV_RESULT_ACCEPTED`.
const ACCEPTED: u8 = 0;

fn told(ended: &Ended) -> Vec<u8> {
    let (success, message) = match ended {
        Ok(done) => (true, done.words.clone()),
        Err(failed) => (false, failed.why.clone()),
    };
    Told { success, message }.to_bytes()
}

fn trigger<const WISH: usize>(bytes: &[u8]) -> Result<Wish, BadCdr> {
    // The byte in place of fields is left out by some, such as hiroz.
    <()>::from_bytes(bytes)?;
    Ok([Wish::Return, Wish::Loiter, Wish::Start, Wish::Clear, Wish::Pull, Wish::IsReady][WISH].clone())
}

fn arm(bytes: &[u8]) -> Result<Wish, BadCdr> {
    Ok(Wish::Arm(Switch::from_bytes(bytes)?.data))
}

fn commanded(ended: &Ended) -> Vec<u8> {
    let result = ended.as_ref().map_or_else(|failed| failed.result, |_| ACCEPTED);
    Commanded { success: ended.is_ok(), result }.to_bytes()
}

fn succeeded(ended: &Ended) -> Vec<u8> {
    Succeeded { success: ended.is_ok() }.to_bytes()
}

/// The services of a plane.
pub fn offers(names: Names) -> Vec<Offer> {
    match names {
        Names::Mavros => [
            offer::<CommandBool>("cmd/arming", arm, commanded),
            offer::<CommandTOL>("cmd/takeoff", takeoff, commanded),
            offer::<CommandTOL>("cmd/land", land, commanded),
            offer::<CommandHome>("cmd/set_home", home, commanded),
            offer::<CommandLong>("cmd/command", command, commanded),
            offer::<SetMode>("set_mode", mode, |ended| ModeSent { mode_sent: ended.is_ok() }.to_bytes()),
            offer::<WaypointSetCurrent>("mission/set_current", current, succeeded),
            offer::<WaypointClear>("mission/clear", trigger::<3>, succeeded),
            offer::<WaypointPull>("mission/pull", trigger::<4>, |ended| {
                let wp_received = ended.as_ref().map_or(0, |done| done.count);
                Pulled { success: ended.is_ok(), wp_received }.to_bytes()
            }),
            offer::<WaypointPush>("mission/push", push, |ended| {
                let wp_transfered = ended.as_ref().map_or(0, |done| done.count);
                Pushed { success: ended.is_ok(), wp_transfered }.to_bytes()
            }),
            // The same without MAVROS's types, and with an answer in words.
            offer::<SetBool>("vencejo/arm", arm, told),
            offer::<Trigger>("vencejo/return_to_launch", trigger::<0>, told),
            offer::<Trigger>("vencejo/loiter", trigger::<1>, told),
            offer::<Trigger>("vencejo/mission_start", trigger::<2>, told),
            offer::<Trigger>("vencejo/mission_clear", trigger::<3>, told),
        ]
        .into_iter()
        .chain(params::offers())
        .collect(),
        Names::ArduPilot => vec![offer::<Trigger>("prearm_check", trigger::<5>, told)],
    }
}

/// The altitude alone: where it stands and to where it points is the plane's own.
fn takeoff(bytes: &[u8]) -> Result<Wish, BadCdr> {
    Ok(Wish::Takeoff(CommandedPlace::from_bytes(bytes)?.altitude.into()))
}

fn land(bytes: &[u8]) -> Result<Wish, BadCdr> {
    CommandedPlace::from_bytes(bytes)?;
    Ok(Wish::Land)
}

fn home(bytes: &[u8]) -> Result<Wish, BadCdr> {
    let HomeWanted { current_gps, latitude, longitude, altitude, .. } = HomeWanted::from_bytes(bytes)?;
    Ok(Wish::Home((!current_gps).then(|| [latitude, longitude, altitude].map(f64::from))))
}

fn current(bytes: &[u8]) -> Result<Wish, BadCdr> {
    Ok(Wish::Current(CurrentWanted::from_bytes(bytes)?.wp_seq))
}

fn command(bytes: &[u8]) -> Result<Wish, BadCdr> {
    Ok(Wish::Command(LongWanted::from_bytes(bytes)?))
}

fn push(bytes: &[u8]) -> Result<Wish, BadCdr> {
    let MissionPushed { start_index, waypoints } = MissionPushed::from_bytes(bytes)?;
    Ok(Wish::Push(start_index, waypoints))
}

fn mode(bytes: &[u8]) -> Result<Wish, BadCdr> {
    Ok(Wish::Mode(ModeWanted::from_bytes(bytes)?.custom_mode))
}

#[cfg(test)]
mod tests {
    use super::super::message::Empty;
    use super::*;
    use crate::ros2::offer::{Done, Failed};

    #[test]
    fn what_is_wanted_is_read_and_what_became_of_it_told() {
        let offers = offers(Names::Mavros);
        let find = |name: &str| *offers.iter().find(|offer| offer.name == name).expect("a service");
        let on = Switch { data: true }.to_bytes();
        assert_eq!((find("cmd/arming").read)(&on), Ok(Wish::Arm(true)));
        assert!((find("cmd/arming").read)(b"\0\x01\0\0\x07").is_err());
        let auto = ModeWanted { base_mode: 0, custom_mode: "AUTO".into() }.to_bytes();
        assert_eq!((find("set_mode").read)(&auto), Ok(Wish::Mode("AUTO".into())));
        let nothing = Empty { structure_needs_at_least_one_member: 0 }.to_bytes();
        for (name, wish) in [
            ("mission/clear", Wish::Clear),
            ("mission/pull", Wish::Pull),
            ("vencejo/return_to_launch", Wish::Return),
            ("vencejo/loiter", Wish::Loiter),
            ("vencejo/mission_start", Wish::Start),
            ("vencejo/mission_clear", Wish::Clear),
        ] {
            assert_eq!((find(name).read)(b"\0\x01\0\0").as_ref(), Ok(&wish), "{name} without a byte for nothing");
            assert_eq!((find(name).read)(&nothing), Ok(wish), "{name}");
            assert!((find(name).read)(b"\0\x01").is_err());
        }
        let place = |altitude| CommandedPlace { min_pitch: 0.0, yaw: 0.0, latitude: 1.0, longitude: 2.0, altitude };
        assert_eq!((find("cmd/takeoff").read)(&place(50.0).to_bytes()), Ok(Wish::Takeoff(50.0)));
        assert_eq!((find("cmd/land").read)(&place(0.0).to_bytes()), Ok(Wish::Land));
        let home = |current_gps| HomeWanted { current_gps, yaw: 0.0, latitude: 40.5, longitude: -3.5, altitude: 600.0 };
        assert_eq!((find("cmd/set_home").read)(&home(true).to_bytes()), Ok(Wish::Home(None)));
        let there = Wish::Home(Some([40.5, -3.5, 600.0]));
        assert_eq!((find("cmd/set_home").read)(&home(false).to_bytes()), Ok(there));
        let third = CurrentWanted { wp_seq: 3 }.to_bytes();
        assert_eq!((find("mission/set_current").read)(&third), Ok(Wish::Current(3)));
        let push = MissionPushed { start_index: 3, waypoints: Vec::new() }.to_bytes();
        assert_eq!((find("mission/push").read)(&push), Ok(Wish::Push(3, Vec::new())));
        // A list that says it is longer than what came.
        assert!((find("mission/push").read)(b"\0\x01\0\0\0\0\0\0\xff\xff\xff\xff").is_err());
        assert_eq!((find("mission/push").write)(&Err("no".into())), b"\0\x01\0\0\0\0\0\0\0\0\0\0");
        let ready = super::offers(Names::ArduPilot)[0];
        assert_eq!((ready.read)(&nothing), Ok(Wish::IsReady));
        assert_eq!((find("cmd/arming").write)(&Err("no".into())), b"\0\x01\0\0\0\x04");
        let denied = Failed { why: "no".into(), result: 2 };
        assert_eq!((find("cmd/command").write)(&Err(denied)), b"\0\x01\0\0\0\x02");
        assert_eq!((find("mission/set_current").write)(&Ok(Done::default())), b"\0\x01\0\0\x01");
        assert_eq!(
            (find("mission/pull").write)(&Ok(Done { count: 7, ..Done::default() })),
            b"\0\x01\0\0\x01\0\0\0\x07\0\0\0"
        );
        assert_eq!(
            Told::from_bytes(&(find("vencejo/arm").write)(&Err("no".into()))).map(|told| told.message),
            Ok("no".into())
        );
    }
}
