//! The bodies of orders: a [`Request`](vencejo_vehicle::Request) with its numbers unrounded.

use crate::content::Content;

/// No fields.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct Nothing {}

/// A [`Request`](vencejo_vehicle::Request). Numbers are unrounded: what was confirmed is what is executed.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Act {
    /// Execute it although the mission on board may be a mixture.
    #[prost(bool, tag = "1")]
    pub despite_mixed_plan: bool,
    /// The danger that a person has confirmed, by its code; empty: none.
    #[prost(string, tag = "2")]
    pub confirmed: String,
    /// The act.
    #[prost(
        oneof = "Deed",
        tags = "3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 18, 19, 21, 22, 24, 25, 26, 29, 30, 31, 32, 33, 34, 35"
    )]
    pub deed: Option<Deed>,
}

/// The acts that can be ordered over a network. Not among them: acts that must be repeated to continue (a velocity),
/// and those without an answer (raw messages). Fields 17, 20, 23, 27 and 28 were forms of their own for what
/// [`Deed::Other`] says; they stay free.
#[derive(Clone, PartialEq, prost::Oneof)]
pub enum Deed {
    /// Arm; true: by force.
    #[prost(bool, tag = "3")]
    Arm(bool),
    /// Disarm; true: by force.
    #[prost(bool, tag = "4")]
    Disarm(bool),
    /// Change to the mode of this name.
    #[prost(string, tag = "5")]
    Mode(String),
    /// Change to the mode of this number.
    #[prost(uint32, tag = "6")]
    ModeNumber(u32),
    /// Take off and climb to this height above home, m.
    #[prost(double, tag = "7")]
    Takeoff(f64),
    /// Fly to a position.
    #[prost(message, tag = "8")]
    Reposition(Reposition),
    /// Change the airspeed, m/s.
    #[prost(double, tag = "9")]
    Airspeed(f64),
    /// Change the speed over ground, m/s.
    #[prost(double, tag = "10")]
    Groundspeed(f64),
    /// Change the height.
    #[prost(message, tag = "11")]
    Altitude(Altitude),
    /// Circle here.
    #[prost(message, tag = "12")]
    LoiterHere(Nothing),
    /// Return to launch.
    #[prost(message, tag = "13")]
    ReturnToLaunch(Nothing),
    /// Land.
    #[prost(message, tag = "14")]
    Land(Nothing),
    /// Abort a landing.
    #[prost(message, tag = "15")]
    AbortLanding(AbortLanding),
    /// Prepare a flight.
    #[prost(message, tag = "16")]
    PrepareFlight(Nothing),
    /// Interrupt the mission.
    #[prost(message, tag = "18")]
    MissionPause(Nothing),
    /// Go on with the mission.
    #[prost(message, tag = "19")]
    MissionResume(Nothing),
    /// A command by COMMAND_LONG.
    #[prost(message, tag = "21")]
    Long(Long),
    /// A command by COMMAND_INT.
    #[prost(message, tag = "22")]
    Int(Int),
    /// Turn to a course.
    #[prost(message, tag = "24")]
    Course(Course),
    /// Climb or sink to a height at a rate.
    #[prost(message, tag = "25")]
    Climb(Climb),
    /// Restart the autopilot.
    #[prost(message, tag = "26")]
    Reboot(Nothing),
    /// Replace a plan.
    #[prost(message, tag = "29")]
    PlanPut(PlanPut),
    /// Remove a plan.
    #[prost(message, tag = "30")]
    PlanClear(PlanClear),
    /// Read a plan of this kind from the vehicle.
    #[prost(uint32, tag = "31")]
    PlanRead(u32),
    /// Read all parameters.
    #[prost(message, tag = "32")]
    ParamList(Nothing),
    /// Read the parameter of this name.
    #[prost(string, tag = "33")]
    ParamRead(String),
    /// Write a parameter.
    #[prost(message, tag = "34")]
    ParamSet(NewParam),
    /// Any other request, which describes itself, as JSON.
    #[prost(string, tag = "35")]
    Other(String),
}

/// Where to fly.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct Reposition {
    /// WGS-84.
    #[prost(double, tag = "1")]
    pub lat_deg: f64,
    /// WGS-84.
    #[prost(double, tag = "2")]
    pub lon_deg: f64,
    /// Height, counted as `frame` says.
    #[prost(double, tag = "3")]
    pub alt_m: f64,
    /// `MAV_FRAME`: 0, 3 or 10.
    #[prost(uint32, tag = "4")]
    pub frame: u32,
    /// Radius of the circle.
    #[prost(double, optional, tag = "5")]
    pub radius_m: Option<f64>,
    /// Sense of the circle.
    #[prost(bool, tag = "6")]
    pub counter_clockwise: bool,
    /// Speed: of a plane an airspeed, of others over ground.
    #[prost(double, optional, tag = "7")]
    pub speed_m_s: Option<f64>,
    /// Whether to enter GUIDED for it.
    #[prost(bool, tag = "8")]
    pub change_mode: bool,
    /// Whether a height far below home is meant.
    #[prost(bool, tag = "9")]
    pub below_home: bool,
}

/// How high to fly.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct Altitude {
    /// Height, counted as `frame` says.
    #[prost(double, tag = "1")]
    pub alt_m: f64,
    /// `MAV_FRAME`: 0, 3 or 10.
    #[prost(uint32, tag = "2")]
    pub frame: u32,
    /// Whether a height far below home is meant.
    #[prost(bool, tag = "3")]
    pub below_home: bool,
}

/// How to abort a landing.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct AbortLanding {
    /// Height to climb to, above home.
    #[prost(double, optional, tag = "1")]
    pub alt_rel_home_m: Option<f64>,
}

/// A command by COMMAND_LONG, to the autopilot.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Long {
    /// `MAV_CMD`.
    #[prost(uint32, tag = "1")]
    pub command: u32,
    /// Parameters 1 to 7.
    #[prost(float, repeated, tag = "2")]
    pub params: Vec<f32>,
}

/// A command by COMMAND_INT, to the autopilot.
#[derive(Clone, PartialEq, prost::Message)]
pub struct Int {
    /// `MAV_CMD`.
    #[prost(uint32, tag = "1")]
    pub command: u32,
    /// `MAV_FRAME`.
    #[prost(uint32, tag = "2")]
    pub frame: u32,
    /// Parameters 1 to 4 and z.
    #[prost(float, repeated, tag = "3")]
    pub params: Vec<f32>,
    /// Latitude in degE7 in a global frame.
    #[prost(sint32, tag = "4")]
    pub x: i32,
    /// Longitude in degE7 in a global frame.
    #[prost(sint32, tag = "5")]
    pub y: i32,
}

/// A course to fly.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct Course {
    /// Degrees from true north, over ground.
    #[prost(double, tag = "1")]
    pub course_deg: f64,
    /// Greatest centripetal acceleration.
    #[prost(double, tag = "2")]
    pub accel_m_s2: f64,
}

/// A climb or descent.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct Climb {
    /// Height, counted as `frame` says.
    #[prost(double, tag = "1")]
    pub alt_m: f64,
    /// `MAV_FRAME`: 0, 3 or 10.
    #[prost(uint32, tag = "2")]
    pub frame: u32,
    /// How fast; as fast as it can when absent.
    #[prost(double, optional, tag = "3")]
    pub rate_m_s: Option<f64>,
    /// Whether a height far below home is meant.
    #[prost(bool, tag = "4")]
    pub below_home: bool,
}

/// A plan to upload.
#[derive(Clone, PartialEq, prost::Message)]
pub struct PlanPut {
    /// `MAV_MISSION_TYPE`.
    #[prost(uint32, tag = "1")]
    pub kind: u32,
    /// Revision of the plan on board that it replaces.
    #[prost(uint64, tag = "2")]
    pub revision: u64,
    /// Its items.
    #[prost(message, optional, tag = "3")]
    pub list: Option<Content>,
    /// Upload it in spite of errors that checks find.
    #[prost(bool, tag = "4")]
    pub despite_findings: bool,
}

/// A plan to remove.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct PlanClear {
    /// `MAV_MISSION_TYPE`.
    #[prost(uint32, tag = "1")]
    pub kind: u32,
    /// Revision of the plan on board that is meant.
    #[prost(uint64, tag = "2")]
    pub revision: u64,
}

/// A parameter's new value.
#[derive(Clone, PartialEq, prost::Message)]
pub struct NewParam {
    /// Its name.
    #[prost(string, tag = "1")]
    pub name: String,
    /// Its value.
    #[prost(double, tag = "2")]
    pub value: f64,
}
