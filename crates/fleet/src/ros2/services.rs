//! What a plane can be asked for in ROS 2, service by service: what was wanted, and how an answer is told.

use super::cdr::{BadCdr, Cdr};
use super::message::{
    CommandBool, CommandHome, CommandLong, CommandTOL, Commanded, CommandedPlace, CurrentWanted, HomeWanted,
    LongWanted, MissionPushed, ModeSent, ModeWanted, Pulled, Pushed, Service, SetBool, SetMode, Succeeded, Switch,
    Told, Trigger, Waypoint, WaypointClear, WaypointPull, WaypointPush, WaypointSetCurrent,
};
use super::name::Names;
use super::params::{self, Known, Wanted};

/// `MAV_RESULT_ACCEPTED`.
const ACCEPTED: u8 = 0;
/// `MAV_RESULT_FAILED`: the reason is told in words, in `/rosout`.
const FAILED: u8 = 4;

/// Something that is wanted of a plane.
#[derive(Debug, Clone, PartialEq)]
pub enum Wish {
    /// To be armed, or disarmed.
    Arm(bool),
    /// Another mode, by its name or number.
    Mode(String),
    /// To take off to that altitude above home, m.
    Takeoff(f64),
    /// To land.
    Land,
    /// Its home at that latitude, longitude and altitude above the sea (m), or where it is.
    Home(Option<[f64; 3]>),
    /// Another current waypoint, by its number on the wire.
    Current(u16),
    /// Any command.
    Command(LongWanted),
    /// Its parameters read: those with these names, or all.
    Params(Option<Vec<String>>),
    /// Its parameters written, each to a number, or why that is none.
    SetParams(Wanted),
    /// Several parameters written at once, which it cannot.
    SetAtOnce,
    /// To return to launch.
    Return,
    /// To circle where it is.
    Loiter,
    /// To start its mission.
    Start,
    /// Its mission removed.
    Clear,
    /// Its mission read.
    Pull,
    /// Its mission replaced, from that waypoint of the wire on; 0 is all of it.
    Push(u16, Vec<Waypoint>),
    /// Whether it would let itself be armed.
    IsReady,
}

/// Why it was not done.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Failed {
    /// In words.
    pub why: String,
    /// The `MAV_RESULT` of the vehicle, where it gave one.
    pub result: u8,
}

impl<T: Into<String>> From<T> for Failed {
    fn from(why: T) -> Self {
        Self { why: why.into(), result: FAILED }
    }
}

impl Wish {
    /// The names of the parameters of which each is answered, whatever becomes of the call.
    pub fn names(&self) -> Option<Vec<String>> {
        match self {
            Self::Params(names) => names.clone(),
            Self::SetParams(wanted) => Some(wanted.iter().map(|(name, _)| name.clone()).collect()),
            _ => None,
        }
    }
}

/// What there is to say of what was done.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Done {
    /// In words, where there are any.
    pub words: String,
    /// How many waypoints or parameters.
    pub count: u32,
    /// The parameters that were asked for.
    pub params: Vec<Known>,
}

impl Done {
    /// Nothing is known of these parameters, for this reason.
    pub fn without(names: Vec<String>, why: &str) -> Self {
        Self { params: names.into_iter().map(|name| (name, Err(why.to_owned()))).collect(), ..Self::default() }
    }

    /// What was not done of it, in words.
    pub fn problem(&self) -> Option<String> {
        let mut failed = self.params.iter().filter_map(|(name, value)| Some((name, value.as_ref().err()?)));
        let (name, why) = failed.next()?;
        let more = failed.count();
        let more = if more == 0 { String::new() } else { format!("; and {more} more") };
        Some(format!("{}: {why}{more}", vencejo_proto::plain(name, 40)))
    }
}

/// How it ended.
pub type Ended = Result<Done, Failed>;

/// A service of a plane.
#[derive(Debug, Clone, Copy)]
pub struct Offer {
    /// Its name below the plane's.
    pub name: &'static str,
    /// Such as `std_srvs/srv/SetBool`.
    pub kind: &'static str,
    /// `RIHS01_…`.
    pub hash: &'static str,
    /// Reads a request.
    pub read: fn(&[u8]) -> Result<Wish, BadCdr>,
    /// Writes the answer.
    pub write: fn(&Ended) -> Vec<u8>,
}

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

pub(super) const fn offer<S: Service>(
    name: &'static str,
    read: fn(&[u8]) -> Result<Wish, BadCdr>,
    write: fn(&Ended) -> Vec<u8>,
) -> Offer {
    Offer { name, kind: S::TYPE, hash: S::HASH, read, write }
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
