//! One item of a plan, its altitude frame, and its way to and from `MISSION_ITEM_INT`.

use vencejo_proto::{Address, MissionSeq};

pub(crate) use vencejo_proto::MissionItemInt;

use crate::error::{FlightError, Plain, Result};
use crate::geodesy::GeoPoint;
use crate::plan::command::Command;
use crate::words::words;

/// Largest height that ArduPilot stores, metres, either sign (exclusive).
pub const MAX_ALT_M: f64 = 83_000.0;

/// Degrees of latitude or longitude to the integers of the wire (degE7).
const DEG_E7: f64 = 1e7;

/// Kind of list that an item belongs to (`MAV_MISSION_TYPE`).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PlanKind {
    /// What to fly.
    Mission = 0,
    /// Geofence.
    Fence = 1,
    /// Rally points.
    Rally = 2,
}

impl PlanKind {
    /// All kinds, in the order in which a plan is sent.
    pub const ALL: [Self; 3] = [Self::Mission, Self::Fence, Self::Rally];

    /// The number on the wire.
    pub const fn mission_type(self) -> u8 {
        self as u8
    }
}

impl TryFrom<u8> for PlanKind {
    type Error = FlightError;

    fn try_from(value: u8) -> Result<Self> {
        Self::ALL.into_iter().find(|kind| kind.mission_type() == value).ok_or(FlightError::UnknownPlanKind(value))
    }
}

impl std::fmt::Display for PlanKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Mission => "mission",
            Self::Fence => "fence",
            Self::Rally => "rally",
        })
    }
}

/// Frame of an item: the datum of its height (`MAV_FRAME`).
///
/// The `*_INT` variants 5, 6 and 11 mean the same as 0, 3 and 10 in a `MISSION_ITEM_INT` and are folded
/// into them when read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum MavFrame {
    /// 0: height above mean sea level.
    Global,
    /// 2: no position; parameters are raw.
    Mission,
    /// 3: height above home.
    GlobalRelativeAlt,
    /// 10: height above the terrain below.
    GlobalTerrainAlt,
    /// Any other number, kept as it came. Not supported for positions.
    Other(u8),
}

impl MavFrame {
    /// The number on the wire.
    pub const fn number(self) -> u8 {
        match self {
            Self::Global => 0,
            Self::Mission => 2,
            Self::GlobalRelativeAlt => 3,
            Self::GlobalTerrainAlt => 10,
            Self::Other(number) => number,
        }
    }

    /// `false` for frames in which a latitude and longitude have no meaning here.
    pub const fn is_supported(self) -> bool {
        !matches!(self, Self::Other(_))
    }
}

impl From<u8> for MavFrame {
    fn from(number: u8) -> Self {
        match number {
            0 | 5 => Self::Global,
            2 => Self::Mission,
            3 | 6 => Self::GlobalRelativeAlt,
            10 | 11 => Self::GlobalTerrainAlt,
            other => Self::Other(other),
        }
    }
}

impl std::fmt::Display for MavFrame {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Global => f.write_str("above mean sea level"),
            Self::Mission => f.write_str("no position"),
            Self::GlobalRelativeAlt => f.write_str("above home"),
            Self::GlobalTerrainAlt => f.write_str("above terrain"),
            Self::Other(number) => write!(f, "frame {number}"),
        }
    }
}

words! {
    /// Requirement on a value that is to be sent.
    #[cfg_attr(feature = "describe", schema(as = WantedValue))]
    Wanted {
        /// A number that fits the wire.
        Finite = "finite",
        /// −90 to 90 degrees.
        Latitude = "latitude",
        /// −180 to 180 degrees.
        Longitude = "longitude",
        /// Within 83,000 m.
        Height = "height",
        /// What fits a whole number of 32 bits, as which it is sent or kept.
        WholeNumber = "whole-number",
        /// A frame that has a meaning for a place.
        Frame = "frame",
    }
}

impl Wanted {
    /// English text about a value that violates it.
    pub const fn problem(self) -> &'static str {
        match self {
            Self::Finite => "which is not a number that can be sent; give a finite one",
            Self::Latitude => "but a latitude goes from -90 to 90 degrees",
            Self::Longitude => "but a longitude goes from -180 to 180 degrees",
            Self::Height => "but a height stays within 83,000 m",
            Self::WholeNumber => "but it is sent, or kept by the vehicle, as a 32-bit whole number",
            Self::Frame => "but a position needs frame 0 (sea level), 3 (home) or 10 (terrain)",
        }
    }
}

/// A value of an item that may not be sent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unsendable {
    /// Which: `param1` … `param4`, `x`, `y`, `z`, `frame`.
    pub field: &'static str,
    /// The value.
    pub value: f64,
    /// The requirement that it violates.
    pub wanted: Wanted,
}

impl std::fmt::Display for Unsendable {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "has {} as its {}, {}", Plain(self.value), self.field, self.wanted.problem())
    }
}

/// One item of a mission, fence or rally list.
///
/// `params[0..4]` are parameters 1 to 4, `params[4..7]` are x, y and z: latitude and longitude in degrees
/// and height in metres when the command has a position, else raw numbers (x and y whole). `None` is
/// unset: sent as NaN where the command allows it (heading of a waypoint, take-off or landing), as 0
/// elsewhere.
#[derive(Debug, Clone, PartialEq)]
pub struct MissionItem {
    /// What to do.
    pub command: Command,
    /// Datum of the height; [`MavFrame::Mission`] for commands without position.
    pub frame: MavFrame,
    /// Parameters 1 to 4, x, y, z.
    pub params: [Option<f64>; 7],
    /// Go on to the next item by itself. ArduPilot ignores it and stores `true`.
    pub autocontinue: bool,
}

/// Names of the seven parameters as messages and errors call them.
pub const PARAM_NAMES: [&str; 7] = ["param1", "param2", "param3", "param4", "x", "y", "z"];

impl MissionItem {
    /// An item with a position relative to home.
    pub fn at(command: Command, params: [f64; 4], lat_deg: f64, lon_deg: f64, alt_rel_home_m: f64) -> Self {
        let [p1, p2, p3, p4] = params;
        Self {
            command,
            frame: MavFrame::GlobalRelativeAlt,
            params: [p1, p2, p3, p4, lat_deg, lon_deg, alt_rel_home_m].map(Some),
            autocontinue: true,
        }
    }

    /// An item without a position.
    pub fn action(command: Command, params: [f64; 4]) -> Self {
        Self { frame: MavFrame::Mission, ..Self::at(command, params, 0.0, 0.0, 0.0) }
    }

    /// Fly to a point; ArduPlane's own acceptance radius applies.
    pub fn waypoint(lat_deg: f64, lon_deg: f64, alt_rel_home_m: f64) -> Self {
        Self::at(Command::NAV_WAYPOINT, [0.0; 4], lat_deg, lon_deg, alt_rel_home_m)
    }

    /// Take off in the direction the plane points, to a height, with at least `pitch_deg` of pitch.
    pub fn takeoff(lat_deg: f64, lon_deg: f64, alt_rel_home_m: f64, pitch_deg: f64) -> Self {
        Self::at(Command::NAV_TAKEOFF, [pitch_deg, 0.0, 0.0, 0.0], lat_deg, lon_deg, alt_rel_home_m)
    }

    /// Land at a point.
    pub fn land(lat_deg: f64, lon_deg: f64, alt_rel_home_m: f64) -> Self {
        Self::at(Command::NAV_LAND, [0.0; 4], lat_deg, lon_deg, alt_rel_home_m)
    }

    /// Mark the start of the landing sequence.
    pub fn land_start(lat_deg: f64, lon_deg: f64, alt_rel_home_m: f64) -> Self {
        Self::at(Command::DO_LAND_START, [0.0; 4], lat_deg, lon_deg, alt_rel_home_m)
    }

    /// Circle for ever. Negative radius: counter-clockwise; 0: the vehicle's own.
    pub fn loiter_unlimited(lat_deg: f64, lon_deg: f64, alt_rel_home_m: f64, radius_m: f64) -> Self {
        Self::at(Command::NAV_LOITER_UNLIM, [0.0, 0.0, radius_m, 0.0], lat_deg, lon_deg, alt_rel_home_m)
    }

    /// Circle a number of turns. Negative radius: counter-clockwise; 0: the vehicle's own.
    pub fn loiter_turns(lat_deg: f64, lon_deg: f64, alt_rel_home_m: f64, turns: f64, radius_m: f64) -> Self {
        Self::at(Command::NAV_LOITER_TURNS, [turns, 0.0, radius_m, 1.0], lat_deg, lon_deg, alt_rel_home_m)
    }

    /// Circle for a time; ArduPlane circles with its own radius, `clockwise` or not.
    pub fn loiter_time(lat_deg: f64, lon_deg: f64, alt_rel_home_m: f64, time_s: f64, clockwise: bool) -> Self {
        let direction = if clockwise { 1.0 } else { -1.0 };
        Self::at(Command::NAV_LOITER_TIME, [time_s, 0.0, direction, 1.0], lat_deg, lon_deg, alt_rel_home_m)
    }

    /// Circle until the height is reached. Negative radius: counter-clockwise; 0: the vehicle's own.
    pub fn loiter_to_alt(lat_deg: f64, lon_deg: f64, alt_rel_home_m: f64, radius_m: f64) -> Self {
        Self::at(Command::NAV_LOITER_TO_ALT, [0.0, radius_m, 0.0, 1.0], lat_deg, lon_deg, alt_rel_home_m)
    }

    /// Return to launch (home or the nearest rally point).
    pub fn return_to_launch() -> Self {
        Self::action(Command::NAV_RETURN_TO_LAUNCH, [0.0; 4])
    }

    /// Set the target airspeed; the throttle stays as it is (−1).
    pub fn change_airspeed(airspeed_m_s: f64) -> Self {
        Self::action(Command::DO_CHANGE_SPEED, [0.0, airspeed_m_s, -1.0, 0.0])
    }

    /// Jump to another item `repeats` times; −1 repeats for ever.
    pub fn jump(target: MissionSeq, repeats: i16) -> Self {
        Self::action(Command::DO_JUMP, [f64::from(target.0), f64::from(repeats), 0.0, 0.0])
    }

    /// `true` when x, y and z are latitude, longitude and height.
    pub fn has_position(&self) -> bool {
        self.frame.is_supported() && self.command.has_position().unwrap_or(self.frame != MavFrame::Mission)
    }

    /// Latitude, degrees; `None` when the command has no position or it is unset.
    pub fn lat_deg(&self) -> Option<f64> {
        self.params[4].filter(|_| self.has_position())
    }

    /// Longitude, degrees; `None` when the command has no position or it is unset.
    pub fn lon_deg(&self) -> Option<f64> {
        self.params[5].filter(|_| self.has_position())
    }

    /// Height in the item's frame, metres; `None` when the command has no position or it is unset.
    pub fn alt_m(&self) -> Option<f64> {
        self.params[6].filter(|_| self.has_position())
    }

    /// The position when there is one: not unset, on Earth, and not the 0/0 that means "here".
    pub fn point(&self) -> Option<GeoPoint> {
        let (lat_deg, lon_deg) = (self.lat_deg()?, self.lon_deg()?);
        if lat_deg == 0.0 && lon_deg == 0.0 {
            return None;
        }
        GeoPoint::new(lat_deg, lon_deg).ok()
    }

    /// Whether it needs a place other than the one where the plane is then.
    pub fn must_lie_somewhere(&self) -> bool {
        // DO_SET_HOME takes the plane's own position when parameter 1 is 1, else the one that is given.
        let is_home_elsewhere = self.command == Command::DO_SET_HOME && self.param(1) != Some(1.0);
        // 0/0 at height 0 ends the pointing at a place, in any frame (`Location::initialised` in ArduPlane's
        // commands_logic.cpp); at another height it is a place like others.
        let is_roi = matches!(self.command, Command::DO_SET_ROI | Command::DO_SET_ROI_LOCATION);
        let ends_roi = is_roi && self.alt_m().is_none_or(|alt_m| alt_m == 0.0);
        is_home_elsewhere || !ends_roi && !self.command.may_stay_in_place()
    }

    /// Whether its latitude or longitude is missing. Where the place may be left out, that is half a position: the
    /// other half would be sent as 0°.
    pub fn lacks_place(&self) -> bool {
        let must_be_told = self.must_lie_somewhere() || self.command == Command::DO_SET_ROI_LOCATION;
        let (has_lat, has_lon) = (self.lat_deg().is_some(), self.lon_deg().is_some());
        self.has_position() && (must_be_told && !(has_lat && has_lon) || has_lat != has_lon)
    }

    /// Parameter 1 to 7; `None` when unset or out of 1..=7.
    pub fn param(&self, number: usize) -> Option<f64> {
        self.params.get(number.checked_sub(1)?).copied().flatten()
    }

    /// The first value that may not be sent: not finite, more than the vehicle can make a whole number of where it
    /// keeps one, or a position off the Earth or in a frame that is not known. `None` when all may.
    pub fn unsendable(&self) -> Option<Unsendable> {
        let bad = |field, value, wanted| Some(Unsendable { field, value, wanted });
        for (field, value) in PARAM_NAMES.into_iter().zip(self.params) {
            let Some(value) = value else { continue };
            if !value.is_finite() || value.abs() > f64::from(f32::MAX) {
                return bad(field, value, Wanted::Finite);
            }
        }
        let infos = self.command.info().map(|info| info.params);
        for (index, info) in infos.iter().flatten().enumerate() {
            // x and y are whole numbers on the wire; a place has rules of its own.
            let is_other = matches!(index, 4 | 5) || (index == 6 && self.has_position());
            if let Some(value) = self.params[index].filter(|value| !is_other && !info.takes(*value)) {
                return bad(PARAM_NAMES[index], value, Wanted::WholeNumber);
            }
        }
        if self.has_position() {
            if let Some(lat_deg) = self.lat_deg().filter(|v| v.abs() > 90.0) {
                return bad("x", lat_deg, Wanted::Latitude);
            }
            if let Some(lon_deg) = self.lon_deg().filter(|v| v.abs() > 180.0) {
                return bad("y", lon_deg, Wanted::Longitude);
            }
            if let Some(alt_m) = self.alt_m().filter(|v| v.abs() >= MAX_ALT_M) {
                return bad("z", alt_m, Wanted::Height);
            }
        } else {
            for index in [4, 5] {
                let limit = f64::from(i32::MAX);
                if let Some(value) = self.params[index].filter(|v| v.abs() > limit) {
                    return bad(PARAM_NAMES[index], value, Wanted::WholeNumber);
                }
            }
        }
        if self.command.has_position() == Some(true) && !self.frame.is_supported() {
            return bad("frame", f64::from(self.frame.number()), Wanted::Frame);
        }
        None
    }

    /// Whether every value may be sent.
    ///
    /// # Errors
    /// [`FlightError::BadItem`] for the first value that may not ([`Self::unsendable`]).
    pub fn check_sendable(&self, seq: MissionSeq) -> Result<()> {
        self.unsendable().map_or(Ok(()), |Unsendable { field, value, wanted }| {
            Err(FlightError::BadItem { seq: seq.0, command: self.command, field, value, problem: wanted.problem() })
        })
    }

    /// The message that carries this item. Call [`MissionItem::check_sendable`] first: a value out of
    /// range is not an error here, it saturates.
    pub fn to_wire(&self, seq: MissionSeq, target: Address, kind: PlanKind, current: bool) -> MissionItemInt {
        let mut params = [0.0_f32; 4];
        for (index, param) in params.iter_mut().enumerate() {
            *param = match self.params[index] {
                Some(value) => value as f32,
                None if self.command.param_may_be_unset(index) => f32::NAN,
                None => 0.0,
            };
        }
        let scale = if self.has_position() { DEG_E7 } else { 1.0 };
        let whole = |value: Option<f64>| (value.unwrap_or(0.0) * scale).round() as i32;
        MissionItemInt {
            target,
            seq: seq.0,
            frame: self.frame.number(),
            command: self.command.0,
            current: u8::from(current),
            autocontinue: u8::from(self.autocontinue),
            params,
            x: whole(self.params[4]),
            y: whole(self.params[5]),
            z: self.params[6].unwrap_or(0.0) as f32,
            mission_type: kind.mission_type(),
        }
    }

    /// The item that a message carries.
    ///
    /// # Errors
    /// [`FlightError::BadItem`] for infinite values and for positions off the globe. NaN means unset.
    pub fn from_wire(wire: &MissionItemInt) -> Result<Self> {
        let command = Command(wire.command);
        let bad = |field, value, problem| Err(FlightError::BadItem { seq: wire.seq, command, field, value, problem });
        let mut item =
            Self { command, frame: wire.frame.into(), params: [None; 7], autocontinue: wire.autocontinue != 0 };
        for (index, value) in wire.params.into_iter().chain([wire.z]).enumerate() {
            let index = if index == 4 { 6 } else { index };
            if value.is_infinite() {
                return bad(PARAM_NAMES[index], f64::from(value), "which no vehicle can fly; send it again");
            }
            item.params[index] = (!value.is_nan()).then(|| f64_from_f32(value));
        }
        let has_position = item.has_position();
        for (index, value, limit_deg) in [(4, wire.x, 90.0), (5, wire.y, 180.0)] {
            item.params[index] = if !has_position {
                Some(f64::from(value))
            } else if value == i32::MAX {
                None // MAVLink: unset
            } else {
                let deg = f64::from(value) / DEG_E7;
                if deg.abs() > limit_deg {
                    return bad(PARAM_NAMES[index], deg, "which is not a position on Earth; send it again");
                }
                Some(deg)
            };
        }
        if has_position && let Some(alt_m) = item.params[6].filter(|v| v.abs() > 100.0 * MAX_ALT_M) {
            return bad("z", alt_m, "which is not a height; send it again");
        }
        if has_position {
            item.params[6] = item.params[6].map(|alt_m| whole_centimetres(wire.z).unwrap_or(alt_m));
        }
        Ok(item)
    }
}

/// A height that is whole centimetres but for the rounding of 32-bit floats, as whole centimetres; `None`
/// for others.
///
/// ArduPilot keeps centimetres and sends them multiplied by a 32-bit 0.01: 600.09 m arrives as 600.08997,
/// and sent back like that it would be cut to 600.08.
fn whole_centimetres(alt_m: f32) -> Option<f64> {
    let alt_m = f64::from(alt_m);
    let whole_m = (alt_m * 100.0).round() / 100.0;
    // error of the 32-bit 0.01, and half a unit in the last place of the product
    let tolerance_m = 0.75 * f64::from(f32::EPSILON) * alt_m.abs();
    ((whole_m - alt_m).abs() <= tolerance_m).then_some(whole_m)
}

/// The shortest decimal that a 32-bit float stands for, so that 77.76 read from a vehicle is shown and
/// saved as 77.76, not as 77.76000213623047. Converting back to `f32` gives the same bits.
pub(crate) fn f64_from_f32(value: f32) -> f64 {
    value.to_string().parse().unwrap_or_else(|_| f64::from(value))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const TARGET: Address = Address::new(1, 1);

    fn round_trip(item: &MissionItem) -> MissionItem {
        MissionItem::from_wire(&item.to_wire(MissionSeq(7), TARGET, PlanKind::Mission, false)).unwrap()
    }

    fn wire(command: Command) -> MissionItemInt {
        MissionItem::action(command, [0.0; 4]).to_wire(MissionSeq(1), TARGET, PlanKind::Mission, false)
    }

    #[test]
    fn int_frames_are_folded() {
        for (number, frame) in [
            (0, MavFrame::Global),
            (5, MavFrame::Global),
            (3, MavFrame::GlobalRelativeAlt),
            (6, MavFrame::GlobalRelativeAlt),
            (10, MavFrame::GlobalTerrainAlt),
            (11, MavFrame::GlobalTerrainAlt),
            (2, MavFrame::Mission),
            (8, MavFrame::Other(8)),
        ] {
            assert_eq!(MavFrame::from(number), frame);
        }
        assert_eq!(MavFrame::Other(8).number(), 8);
    }

    #[test]
    fn unset_is_nan_only_where_the_vehicle_takes_it() {
        let mut item = MissionItem::waypoint(40.0, -3.0, 50.0);
        item.params[0] = None;
        item.params[3] = None;
        let sent = item.to_wire(MissionSeq(1), TARGET, PlanKind::Mission, true);
        assert_eq!(sent.params[0], 0.0);
        assert!(sent.params[3].is_nan());
        // An ArduPlane before 4.6 refuses it there.
        let circle = MissionItem { params: item.params, ..MissionItem::loiter_unlimited(40.0, -3.0, 80.0, 0.0) };
        assert_eq!(circle.to_wire(MissionSeq(1), TARGET, PlanKind::Mission, true).params[3], 0.0);
        assert_eq!(sent.current, 1);
        assert_eq!(MissionItem::from_wire(&sent).unwrap().params[3], None);
    }

    /// ArduPilot's simulator ends at the first three of these; a board keeps anything.
    // fault 30: items with numbers that a vehicle cannot make whole ones of where it keeps such are refused, whatever
    // is checked
    #[test]
    fn what_no_whole_number_of_32_bits_can_be_made_of_is_not_sent_where_one_is_kept() {
        let action = |command: Command, index: usize, value: f64| {
            let mut item = MissionItem::action(command, [0.0; 4]);
            item.params[index] = Some(value);
            item.unsendable().map(|fault| (fault.field, fault.wanted))
        };
        let refused = |field| Some((field, Wanted::WholeNumber));
        assert_eq!(action(Command::NAV_ALTITUDE_WAIT, 2, 1.2e11), refused("param3"));
        assert_eq!(action(Command::DO_SET_HOME, 0, -1e30), refused("param1"));
        assert_eq!(action(Command::DO_ENGINE_CONTROL, 2, 3e7), refused("param3"), "kept in hundredths");
        assert_eq!(action(Command::DO_ENGINE_CONTROL, 2, 600.0), None);
        // The nearest 32-bit float is one more.
        assert_eq!(action(Command::DO_SET_HOME, 0, 2_147_483_647.0), refused("param1"));
        assert_eq!(action(Command::DO_REPEAT_SERVO, 3, 2.2e6), refused("param4"), "a time, counted in milliseconds");
    }

    #[test]
    fn raw_values_are_not_scaled() {
        let mut item = MissionItem::action(Command::DO_DIGICAM_CONTROL, [0.0; 4]);
        item.params[4] = Some(1.0);
        assert_eq!(item.to_wire(MissionSeq(1), TARGET, PlanKind::Mission, false).x, 1);
        assert_eq!(item.lat_deg(), None);
        assert_eq!(round_trip(&item), item);
    }

    #[test]
    fn impossible_messages_are_refused_by_field() {
        let check = |wire: MissionItemInt, field: &str| {
            let error = MissionItem::from_wire(&wire).unwrap_err();
            assert!(matches!(error, FlightError::BadItem { field: f, .. } if f == field), "{error}");
        };
        let base = MissionItemInt { frame: 3, ..wire(Command::NAV_WAYPOINT) };
        check(MissionItemInt { x: 900_000_001, ..base }, "x");
        check(MissionItemInt { y: -1_800_000_001, ..base }, "y");
        check(MissionItemInt { z: f32::INFINITY, ..base }, "z");
        check(MissionItemInt { params: [0.0, f32::NEG_INFINITY, 0.0, 0.0], ..base }, "param2");
        let unset = MissionItem::from_wire(&MissionItemInt { x: i32::MAX, y: i32::MAX, ..base }).unwrap();
        assert_eq!((unset.lat_deg(), unset.lon_deg(), unset.point()), (None, None, None));
    }

    #[test]
    fn nothing_impossible_is_sendable() {
        let sound = MissionItem::waypoint(40.0, -3.0, 50.0);
        assert_eq!(sound.check_sendable(MissionSeq(1)), Ok(()));
        for (index, value) in [(0, f64::NAN), (1, f64::INFINITY), (2, 1e39), (4, 90.1), (5, 181.0), (6, 83_000.0)] {
            let mut item = sound.clone();
            item.params[index] = Some(value);
            let error = item.check_sendable(MissionSeq(3)).unwrap_err();
            assert!(error.to_string().starts_with("item 3 (NAV_WAYPOINT): "), "{error}");
        }
        let mut local = sound;
        local.frame = MavFrame::Other(1);
        assert!(local.check_sendable(MissionSeq(1)).is_err());
        let mut raw = MissionItem::action(Command::DO_DIGICAM_CONTROL, [0.0; 4]);
        raw.params[4] = Some(1e10);
        assert!(raw.check_sendable(MissionSeq(1)).is_err());
    }

    #[test]
    fn heights_arrive_as_the_centimetres_that_the_vehicle_keeps() {
        let base = MissionItemInt { frame: 0, z: 600.089_97, ..wire(Command::NAV_WAYPOINT) };
        assert_eq!(MissionItem::from_wire(&base).unwrap().alt_m(), Some(600.09));
        for cm in [-1_600_001, -12_345, -1, 0, 1, 29, 7_777, 60_009, 1_234_567, 3_200_001] {
            let sent = MissionItemInt { z: cm as f32 * 0.01, ..base };
            let alt_m = MissionItem::from_wire(&sent).unwrap().alt_m().unwrap();
            assert_eq!(alt_m, f64::from(cm) / 100.0);
        }
        let half = MissionItemInt { z: 0.125, ..base };
        assert_eq!(MissionItem::from_wire(&half).unwrap().alt_m(), Some(0.125));
    }

    proptest! {
        #[test]
        fn any_sound_item_survives_the_wire(
            command in prop::sample::select(crate::plan::command::COMMANDS.iter().map(|info| info.command).collect::<Vec<_>>()),
            frame in prop::sample::select(vec![MavFrame::Global, MavFrame::GlobalRelativeAlt, MavFrame::GlobalTerrainAlt]),
            params in prop::array::uniform4(-1e6_f32..1e6), x in -900_000_000..=900_000_000_i32,
            y in -1_800_000_000..=1_800_000_000_i32, z_cm in -3_200_000..3_200_000_i32, autocontinue: bool,
        ) {
            let scale = if command.has_position() == Some(true) { 1e7 } else { 1.0 };
            let [p1, p2, p3, p4] = params.map(|v| Some(f64_from_f32(v)));
            // A measure beyond 2,147,483 is not sent.
            let z = if scale == 1.0 { f64_from_f32((z_cm / 2) as f32) } else { f64::from(z_cm) / 100.0 };
            let params = [p1, p2, p3, p4, Some(f64::from(x) / scale), Some(f64::from(y) / scale), Some(z)];
            let item = MissionItem { command, frame, params, autocontinue };
            prop_assert_eq!(item.check_sendable(MissionSeq(7)), Ok(()));
            prop_assert_eq!(round_trip(&item), item);
        }

        #[test]
        fn any_message_is_read_or_refused(
            command: u16, frame: u8, params in prop::array::uniform4(any::<f32>()), x: i32, y: i32, z: f32,
        ) {
            let wire = MissionItemInt { frame, params, x, y, z, ..wire(Command(command)) };
            if let Ok(item) = MissionItem::from_wire(&wire) {
                let again = round_trip(&item);
                prop_assert_eq!(again.command, item.command);
                let _ = crate::plan::ardupilot_stored(&item);
            }
        }
    }
}
