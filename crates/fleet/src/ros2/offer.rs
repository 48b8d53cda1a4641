//! What a plane can be asked for in ROS 2, and how that ends.

use super::cdr::BadCdr;
use super::message::{LongWanted, ParameterValue, Service, Waypoint};

/// `MAV_RESULT_FAILED`: the reason is told in words, in `/rosout`.
const FAILED: u8 = 4;

/// A parameter that was asked for: its name, and its value, or why there is none.
pub type Known = (String, Result<ParameterValue, String>);

/// Parameters to write: their names, and the number, or why it is none.
pub type Wanted = Vec<(String, Result<f64, String>)>;

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

/// A service of this type.
pub(super) const fn offer<S: Service>(
    name: &'static str,
    read: fn(&[u8]) -> Result<Wish, BadCdr>,
    write: fn(&Ended) -> Vec<u8>,
) -> Offer {
    Offer { name, kind: S::TYPE, hash: S::HASH, read, write }
}
