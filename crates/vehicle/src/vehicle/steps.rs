//! The steps of a request: commands with the effect that proves them, parameters, transfers. Values are checked here.

use std::collections::VecDeque;

use vencejo_flight::plan::{Command, Mission, PlanKind, items_to_wire};
use vencejo_proto::dialect::{MISSION_SET_CURRENT_DATA, MavMessage, MavModeFlag, SET_MODE_DATA};
use vencejo_proto::{Address, CommandInt, Message, MonoTime};

use super::raw::{self, height, in_range, invalid};
use crate::autopilot::AutopilotType;
use crate::choice::{AltFrame, MessageId, ModeChoice, SpeedKind, Turn};
use crate::command::CommandMessage;
use crate::error::VehicleError;
use crate::kind::FIXED_WING;
use crate::modes::{Action, FlightMode, ModeFamily};
use crate::preparation::FlightPreparation;
use crate::request::Request;
use crate::streams::interval_params;
use crate::telemetry::{Freshness, MissionCurrent, MissionState, Severity, Telemetry};
use crate::transfer::ParamName;

mod bounds;
mod guided;
mod step;

pub(super) use self::step::{Effect, Fallback, Step};

/// Arms or disarms in spite of all checks (param 2 of MAV_CMD_COMPONENT_ARM_DISARM).
const FORCE_MAGIC: f32 = 21_196.0;
/// `MAV_DO_REPOSITION_FLAGS_CHANGE_MODE`.
const REPOSITION_CHANGE_MODE: f32 = 1.0;
/// Altitude of ArduPlane's take-off in mode TAKEOFF, metres above home.
const TAKEOFF_ALT_PARAM: &str = "TKOFF_ALT";

/// Why a PX4 has to circle already.
const PX4_LOITERS: &str = "AUTO_LOITER, of a PX4: in any other mode it would leave that and circle; change to it first";

/// Most characters of a note.
const MAX_NOTE: usize = 500;

/// The state of the vehicle when a request is made.
pub(super) struct Context<'a> {
    pub vehicle: Address,
    pub telemetry: &'a Telemetry,
    /// When its last heartbeat came; before the first, when anything was received.
    pub heartbeat_at: MonoTime,
    pub preparation: Option<FlightPreparation>,
    /// Seq of the first navigation item (`Vehicle::first_nav`).
    pub first_nav: u16,
    /// Whether it flies a landing of its mission already (`Vehicle::is_landing_already`).
    pub is_landing: bool,
    /// Seq at which a landing of its mission begins that has no `DO_LAND_START` (`Vehicle::unmarked_landing`).
    pub unmarked_landing: Option<u16>,
    /// Whether the mission on board has a landing; `None` while it is not known.
    pub has_landing: Option<bool>,
    /// Whether it is on its way down to land (`Conduct::is_landing`).
    pub lands: Option<bool>,
    /// Whether its mission is complete (`ProgressTracker::is_complete`).
    pub is_complete: bool,
    /// The item at which a PX4 left its mission to return (`Interrupted::left_at`).
    pub left_at: Option<u16>,
    /// Whether COMMAND_INT may be sent.
    pub has_command_int: bool,
    pub now: MonoTime,
}

impl Context<'_> {
    fn long(&self, command: Command, params: [f32; 7]) -> CommandMessage {
        CommandMessage::long(self.vehicle, command, params)
    }

    fn autopilot(&self) -> Result<AutopilotType, VehicleError> {
        self.telemetry.autopilot_type().ok_or_else(|| self.unheard())
    }

    fn family(&self) -> Result<ModeFamily, VehicleError> {
        self.autopilot().map(AutopilotType::family)
    }

    /// Whether its missions begin with home as item 0.
    pub fn is_ardupilot(&self) -> Result<bool, VehicleError> {
        self.autopilot().map(AutopilotType::is_ardupilot)
    }

    fn unheard(&self) -> VehicleError {
        VehicleError::NotHeard { age: self.now.since(self.heartbeat_at) }
    }

    fn set_mode(&self, mode: FlightMode) -> Step {
        self.set_mode_proved(mode, false)
    }

    /// `has_begun`: a mission that the mode flies has to run.
    fn set_mode_proved(&self, mode: FlightMode, has_begun: bool) -> Step {
        let (main, sub) = mode.command_params();
        let custom_flag = MavModeFlag::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED;
        let command = self.long(Command::DO_SET_MODE, [f32::from(custom_flag.bits()), main, sub, 0.0, 0.0, 0.0, 0.0]);
        // Vehicles from before DO_SET_MODE take the message SET_MODE.
        let message = Message::Dialect(MavMessage::SET_MODE(SET_MODE_DATA {
            custom_mode: mode.custom_mode,
            target_system: self.vehicle.system.0,
            base_mode: custom_flag,
        }));
        let effect = match mode.family {
            ModeFamily::ArduPlane if mode.follows_mission() => Effect::MissionMode { mode, has_begun },
            _ => Effect::Mode(mode),
        };
        Step::command(command).proved_by(effect).or(Fallback::Message(message, effect))
    }

    fn mode_for(&self, action: Action) -> Result<Step, VehicleError> {
        let mode = action.mode(self.family()?).ok_or(VehicleError::NoModeFor { action: action.name() })?;
        Ok(self.set_mode_proved(mode, action == Action::Mission))
    }

    fn arm(&self, is_armed: bool, force: bool) -> Step {
        let force = if force { FORCE_MAGIC } else { 0.0 };
        let command =
            self.long(Command::COMPONENT_ARM_DISARM, [f32::from(u8::from(is_armed)), force, 0.0, 0.0, 0.0, 0.0, 0.0]);
        Step::command(command).proved_by(Effect::Armed(is_armed))
    }

    pub fn set_current(&self, seq: u16) -> Step {
        let command = self.long(Command::DO_SET_MISSION_CURRENT, [f32::from(seq), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        let message = Message::Dialect(MavMessage::MISSION_SET_CURRENT(MISSION_SET_CURRENT_DATA {
            seq,
            target_system: self.vehicle.system.0,
            target_component: self.vehicle.component.0,
        }));
        // It begins the item anew each time. Where the item is current already, nothing would show that it was done.
        let shown = self.telemetry.mission.map(|mission| mission.value.seq).filter(|shown| *shown != seq);
        let once = Step::command(command);
        let step = match shown {
            Some(from) => once.proved_by(Effect::JumpedTo { from, to: seq }),
            None => once,
        };
        step.or(Fallback::Message(message, Effect::Current(seq)))
    }

    /// Sets the mission back to its beginning: for ArduPilot 0, which resets the jump counters too.
    fn rewind(&self) -> Step {
        let command = self.long(Command::DO_SET_MISSION_CURRENT, [0.0; 7]);
        let message = Message::Dialect(MavMessage::MISSION_SET_CURRENT(MISSION_SET_CURRENT_DATA {
            seq: 0,
            target_system: self.vehicle.system.0,
            target_component: self.vehicle.component.0,
        }));
        Step::command(command).repeated().or(Fallback::Message(message, Effect::AtBeginning(self.first_nav)))
    }

    /// What follows the change to AUTO where the mission is to go on from an item: with MIS_RESTART 1 an ArduPlane
    /// begins its mission anew at each change to AUTO, whatever item it was set to before.
    fn go_on_from(&self, seq: u16) -> Option<Step> {
        let is_plane = self.family().ok() == Some(ModeFamily::ArduPlane);
        (is_plane && seq > self.first_nav).then_some(Step::GoOnFrom(seq))
    }

    /// Seq on the wire of an item counted from 1: an ArduPilot's missions begin with home as item 0.
    fn seq_of(&self, field: &'static str, item: u16) -> Result<u16, VehicleError> {
        if !(1..=65_534).contains(&item) {
            return Err(invalid(field, item, "1 to 65,534; the items of a mission are counted from 1"));
        }
        Ok(item - u16::from(!self.is_ardupilot()?))
    }

    /// Sets home to a position, or to the vehicle's own.
    fn set_home(
        &self,
        lat_deg: Option<f64>,
        lon_deg: Option<f64>,
        alt_amsl_m: Option<f64>,
    ) -> Result<CommandMessage, VehicleError> {
        let given = [("lat_deg", lat_deg), ("lon_deg", lon_deg), ("alt_amsl_m", alt_amsl_m)];
        let is_here = given.iter().all(|(_, value)| value.is_none());
        if let Some((field, _)) = given.iter().find(|(_, value)| value.is_none()).filter(|_| !is_here) {
            let expected =
                "given with the others of lat_deg, lon_deg and alt_amsl_m, or none of them for where the vehicle is";
            return Err(invalid(field, "missing", expected));
        }
        let [lat_deg, lon_deg, alt_m] = given.map(|(_, value)| value.unwrap_or_default());
        height("alt_amsl_m", alt_m)?;
        if !is_here {
            Self::chosen(lat_deg, lon_deg, "a position that was chosen; leave it out for where the vehicle is")?;
            self.in_reach(lat_deg, lon_deg)?;
        }
        let params = [f32::from(u8::from(is_here)), 0.0, 0.0, 0.0];
        let command = self.at_position(Command::DO_SET_HOME, 0, params, (lat_deg, lon_deg, alt_m))?;
        if self.has_command_int {
            return Ok(command);
        }
        // Older firmware reads the position from floats, with an error of about a metre.
        let position = [lat_deg as f32, lon_deg as f32, alt_m as f32];
        Ok(self.long(Command::DO_SET_HOME, [params[0], 0.0, 0.0, 0.0, position[0], position[1], position[2]]))
    }

    /// Requires a fresh heartbeat that shows it disarmed.
    fn require_disarmed(&self, action: &'static str) -> Result<(), VehicleError> {
        let heartbeat = self.telemetry.heartbeat.filter(|heartbeat| heartbeat.freshness(self.now) == Freshness::Fresh);
        let heartbeat = heartbeat.ok_or_else(|| self.unheard())?;
        if heartbeat.value.is_armed { Err(VehicleError::Armed { action }) } else { Ok(()) }
    }

    fn prepare_flight(&self) -> Result<VecDeque<Step>, VehicleError> {
        const ACTION: &str = "preparing a flight";
        self.require_disarmed(ACTION)?;
        if self.telemetry.is_on_ground() == Some(false) {
            return Err(VehicleError::InTheAir { action: ACTION });
        }
        let preparation = self.preparation.ok_or_else(|| self.unheard())?;
        let warning = self.note_on_height_control();
        let note = Step::Note(Severity::INFO, format!("Preparing a flight: {preparation}"));
        let mode = preparation.mode.map(|mode| self.set_mode(mode));
        let rewind = preparation.rewinds_mission.then(|| self.rewind());
        Ok(warning.into_iter().chain([note]).chain(mode).chain(rewind).collect())
    }

    /// PX4 1.17 begins with the height control of a fixed wing at 0 m above the sea where it boots into a mode that flies by
    /// itself, and lets it climb to the true height at FW_T_CLMB_R_SP (PX4 pull request 27670).
    fn note_on_height_control(&self) -> Option<Step> {
        const CLIMB_M_S: f64 = 3.0;
        let is_px4_plane = self.autopilot().is_ok_and(|it| it.is_px4() && it.mav_type == FIXED_WING);
        let version = self.telemetry.version?.value.flight_sw;
        let time = self.telemetry.system_time?;
        let on_for_s = f64::from(time.value.boot_ms) / 1e3 + self.now.since(time.at).as_secs_f64();
        let alt_amsl_m = self.telemetry.position?.value.alt_amsl_m?;
        let settled_s = alt_amsl_m / CLIMB_M_S;
        let text = format!(
            "Switched on {on_for_s:.0} s ago at {alt_amsl_m:.0} m above the sea: until {settled_s:.0} s the height control of PX4 \
             1.17 may count from 0 m and sink after the take-off; wait {:.0} s",
            settled_s - on_for_s
        );
        let is_early = is_px4_plane && (version.major, version.minor) == (1, 17) && on_for_s < settled_s;
        is_early.then_some(Step::Note(Severity::WARNING, text))
    }

    /// A PX4 acknowledges every abort of a landing. It may land in AUTO_RTL too.
    fn note_on_abort(&self) -> Option<Step> {
        let mode = self.telemetry.mode()?;
        let may_land = self.lands != Some(false) || Action::ReturnToLaunch.mode(mode.family) == Some(mode);
        let text = "It was not landing: there was nothing to abort";
        (mode.family == ModeFamily::Px4 && !may_land).then(|| Step::Note(Severity::WARNING, text.to_owned()))
    }

    fn takeoff(&self, alt_rel_home_m: f64) -> Result<VecDeque<Step>, VehicleError> {
        let alt = in_range("alt_rel_home_m", alt_rel_home_m, 1.0..=10_000.0, "1 to 10,000 m above home")?;
        let family = self.family()?;
        if family == ModeFamily::ArduPlane && self.autopilot()?.mav_type == FIXED_WING {
            let name = ParamName::new(TAKEOFF_ALT_PARAM).map_err(crate::transfer::TransferError::from)?;
            return Ok([Step::ParamSet(name, alt_rel_home_m), self.mode_for(Action::Takeoff)?].into());
        }
        let params = if family == ModeFamily::Px4 {
            // PX4 takes NaN for "here".
            let (alt_m, _) = self.as_counted(alt_rel_home_m, AltFrame::RelHome)?;
            [0.0, 0.0, 0.0, f32::NAN, f32::NAN, f32::NAN, alt_m as f32]
        } else {
            [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, alt]
        };
        let step = Step::command(self.long(Command::NAV_TAKEOFF, params)).proved_by(Effect::Airborne);
        // A PX4 accepts it on the ground too, disarmed.
        let waits = family == ModeFamily::Px4 && self.telemetry.is_armed() == Some(false);
        let note = waits.then(|| Step::Note(Severity::WARNING, "It takes off as soon as it is armed".to_owned()));
        Ok([step].into_iter().chain(note).collect())
    }

    /// A fixed wing lands on the landing of its mission: mode AUTO_LAND of a PX4 brings it down in circles where it is.
    fn land(&self) -> Result<VecDeque<Step>, VehicleError> {
        let family = self.family()?;
        let is_px4_plane = family == ModeFamily::Px4 && self.autopilot()?.mav_type == FIXED_WING;
        if family != ModeFamily::ArduPlane && !is_px4_plane {
            return Ok([self.mode_for(Action::Land)?].into());
        }
        // ArduPlane jumps to the landing and changes to AUTO, armed or not (`MAV_CMD_DO_LAND_START`).
        let not_flying = |consequence| VehicleError::NotFlying { action: "landing", consequence };
        let is_armed = self.telemetry.is_armed();
        if is_armed == Some(false) && !is_px4_plane {
            return Err(not_flying("it would fly the landing of its mission as soon as it is armed"));
        }
        let follows_mission = self.telemetry.mode().is_some_and(FlightMode::follows_mission);
        // In AUTO_LAND it may still be sent to the landing of its mission.
        if self.is_landing && (follows_mission || !is_px4_plane) {
            return Ok([Step::Note(Severity::INFO, "It is landing already: nothing was sent".to_owned())].into());
        }
        let is_flying = is_armed == Some(true) && self.telemetry.is_on_ground() != Some(true);
        if is_px4_plane && !is_flying {
            // It takes DO_LAND_START for MISSION_START, which arms (v1.17.0, `navigator_main.cpp`, `Commander.cpp`).
            return Err(not_flying("it would arm and take off"));
        }
        if is_px4_plane && self.has_landing == Some(false) {
            return Err(invalid(
                "the mission",
                "one without a landing",
                "one with a landing, on which \"land\" lands this plane; return to launch instead, or set mode \
                 AUTO_LAND, which brings it down in circles where it is",
            ));
        }
        if let Some(seq) = self.unmarked_landing.filter(|_| family == ModeFamily::ArduPlane) {
            // DO_LAND_START, by which ArduPlane finds a landing, would be refused.
            let steps = [self.set_current(seq), self.mode_for(Action::Mission)?];
            return Ok(steps.into_iter().chain(self.go_on_from(seq)).collect());
        }
        let before = self.telemetry.mission.map(|mission| mission.value.seq);
        let effect = match Action::Mission.mode(family) {
            // A PX4 acknowledges the jump before it changes the mode.
            Some(mode) if is_px4_plane && !follows_mission => Effect::Mode(mode),
            _ => Effect::JumpedFrom(before),
        };
        Ok([Step::command(self.long(Command::DO_LAND_START, [0.0; 7])).proved_by(effect)].into())
    }

    /// The steps of a request.
    pub fn steps(&self, request: Request) -> Result<VecDeque<Step>, VehicleError> {
        let step = match request {
            Request::Arm { force } => self.arm(true, force),
            Request::Disarm { force } => self.arm(false, force),
            Request::SetMode { mode: choice } => {
                let family = self.family()?;
                self.set_mode(match choice {
                    ModeChoice::Name(name) => family.parse(&name)?,
                    ModeChoice::Custom(custom_mode) => FlightMode { family, custom_mode },
                })
            }
            Request::Takeoff { alt_rel_home_m } => return self.takeoff(alt_rel_home_m),
            Request::Reposition {
                lat_deg,
                lon_deg,
                alt_m,
                alt_frame,
                radius_m,
                turn,
                speed_m_s,
                change_mode,
                below_home,
            } => {
                let speed = match speed_m_s {
                    Some(speed) => in_range("speed_m_s", speed, 0.1..=200.0, "0.1 to 200 m/s")?,
                    None => -1.0,
                };
                let radius = match radius_m {
                    Some(radius) => in_range("radius_m", radius, 1.0..=30_000.0, "1 to 30,000 m")?,
                    None => 0.0,
                };
                Self::chosen(lat_deg, lon_deg, "a position that was chosen")?;
                self.in_reach(lat_deg, lon_deg)?;
                self.above_ground(alt_m, alt_frame, Some((lat_deg, lon_deg)), below_home)?;
                if !self.has_command_int {
                    let is_plain = radius_m.is_none() && speed_m_s.is_none() && turn == Turn::Clockwise;
                    return self.guided_item((lat_deg, lon_deg, alt_m), alt_frame, is_plain, change_mode);
                }
                let family = self.family()?;
                let (is_plane, is_px4) = (family == ModeFamily::ArduPlane, family == ModeFamily::Px4);
                if is_px4 && !change_mode {
                    self.require_mode(Action::Loiter.mode(family), PX4_LOITERS)?;
                }
                if is_px4 && self.autopilot()?.mav_type == FIXED_WING {
                    let circle = (radius_m.is_some() || turn == Turn::CounterClockwise).then_some((radius, turn));
                    return self.go_to_px4((lat_deg, lon_deg, alt_m), alt_frame, circle, speed_m_s);
                }
                // ArduPlane reads the sense from param 4, where others have a heading; PX4 from the sign of the radius.
                let (radius, yaw) = match turn {
                    _ if is_plane => (radius, f32::from(u8::from(turn == Turn::CounterClockwise))),
                    Turn::Clockwise => (radius, f32::NAN),
                    Turn::CounterClockwise => (-radius, f32::NAN),
                };
                // In GUIDED the change of mode is not requested: a repetition cannot take the vehicle from a pilot.
                let guided = Action::Guided.mode(family);
                // Without it a PX4 flies there in AUTO_LOITER, and answers that it does not know the command.
                let enters = is_px4 || change_mode && guided.is_none_or(|guided| self.telemetry.mode() != Some(guided));
                let flags = if enters { REPOSITION_CHANGE_MODE } else { 0.0 };
                let params = [speed, flags, radius, yaw];
                let (alt_m, alt_frame) = self.as_counted(alt_m, alt_frame)?;
                if alt_frame != AltFrame::Amsl && self.is_ardupilot()? {
                    raw::new_height(alt_m)?;
                }
                let place = (lat_deg, lon_deg, alt_m);
                let step =
                    Step::command(self.at_position(Command::DO_REPOSITION, alt_frame.mav_frame(), params, place)?);
                let step = match guided.filter(|_| enters) {
                    Some(guided) => step.proved_by(Effect::Mode(guided)),
                    None if is_px4 => step.unless_objected(),
                    None => step,
                };
                // ArduPlane does not read the speed (`handle_command_int_do_reposition`).
                let airspeed = speed_m_s.filter(|_| is_plane).map(|_| self.speed_of_go_to(speed));
                return Ok([step].into_iter().chain(airspeed).collect());
            }
            Request::ChangeSpeed { kind, speed_m_s } => {
                let speed = in_range("speed_m_s", speed_m_s, 0.1..=200.0, "0.1 to 200 m/s")?;
                let is_px4_plane = || self.autopilot().map(|it| it.is_px4() && it.mav_type == FIXED_WING);
                if kind == SpeedKind::Groundspeed && is_px4_plane()? {
                    return Err(invalid("kind", "a ground speed", "airspeed, which a fixed wing with PX4 takes alone"));
                }
                self.speed(kind, speed)
            }
            Request::ChangeAltitude { alt_m, alt_frame, below_home } => {
                let family = self.family()?;
                self.above_ground(alt_m, alt_frame, None, below_home)?;
                let (alt_m, alt_frame) = self.as_counted(alt_m, alt_frame)?;
                let alt = raw::new_height(alt_m)?;
                if family == ModeFamily::Px4 {
                    self.require_mode(Action::Loiter.mode(family), PX4_LOITERS)?;
                }
                let frame = alt_frame.mav_frame();
                if !self.has_command_int {
                    return self.guided_height(alt_m, alt_frame);
                }
                let older = CommandMessage::Int(CommandInt {
                    target: self.vehicle,
                    frame,
                    command: Command::GUIDED_CHANGE_ALTITUDE.0,
                    current: 0,
                    autocontinue: 0,
                    params: [0.0; 4],
                    x: 0,
                    y: 0,
                    z: alt,
                });
                let command = self.long(Command::DO_CHANGE_ALTITUDE, [alt, f32::from(frame), 0.0, 0.0, 0.0, 0.0, 0.0]);
                let step = Step::command(command).or(Fallback::Command(older));
                if family == ModeFamily::Px4 { step.unless_objected() } else { step }
            }
            Request::GuidedCourse { course_deg, accel_m_s2 } => {
                if !(0.0..360.0).contains(&course_deg) {
                    return Err(invalid("course_deg", course_deg, "a course, 0 to below 360 degrees from true north"));
                }
                let accel = in_range("accel_m_s2", accel_m_s2, 0.05..=20.0, "an acceleration, 0.05 to 20 m/s²")?;
                // HEADING_TYPE_COURSE_OVER_GROUND. Rounding to 32 bits must not reach 360.
                let course = (course_deg as f32).min(359.999);
                self.in_guided(Command::GUIDED_CHANGE_HEADING, 0, [0.0, course, accel, 0.0], 0.0)?
            }
            Request::GuidedClimb { alt_m, alt_frame, rate_m_s, below_home } => {
                self.above_ground(alt_m, alt_frame, None, below_home)?;
                let alt = height("alt_m", alt_m)?;
                if alt == 0.0 || alt == -1.0 {
                    return Err(invalid("alt_m", alt_m, "a height that ArduPlane takes; it does not take 0 and -1"));
                }
                // 0: as fast as it can.
                let rate = rate_m_s.map(|rate| in_range("rate_m_s", rate, 0.01..=50.0, "a rate, 0.01 to 50 m/s"));
                let rate = rate.transpose()?.unwrap_or_default();
                let params = [0.0, 0.0, rate, 0.0];
                self.in_guided(Command::GUIDED_CHANGE_ALTITUDE, alt_frame.mav_frame(), params, alt)?
            }
            Request::Velocity { forward_m_s, right_m_s, down_m_s, yaw_rate_rad_s } => {
                self.velocity([forward_m_s, right_m_s, down_m_s], yaw_rate_rad_s)?
            }
            Request::LoiterHere | Request::MissionPause => self.mode_for(Action::Loiter)?,
            Request::ReturnToLaunch => self.mode_for(Action::ReturnToLaunch)?,
            Request::Land => return self.land(),
            Request::AbortLanding { alt_rel_home_m: Some(alt) } if self.family()? == ModeFamily::Px4 => {
                let expected = "left out: a PX4 climbs to MIS_LND_ABRT_ALT above the landing point";
                return Err(invalid("alt_rel_home_m", alt, expected));
            }
            Request::AbortLanding { alt_rel_home_m } => {
                let alt = match alt_rel_home_m {
                    Some(alt) => in_range("alt_rel_home_m", alt, 1.0..=10_000.0, "1 to 10,000 m above home")?,
                    None => 0.0,
                };
                // It has to arrive at once, and a second one changes nothing (`Plane::trigger_land_abort`).
                let abort = self.long(Command::DO_GO_AROUND, [alt, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
                let abort = Step::command(abort).repeated();
                return Ok([abort].into_iter().chain(self.note_on_abort()).collect());
            }
            Request::PrepareFlight => return self.prepare_flight(),
            Request::MissionStart { from_item } => {
                let seq = from_item.map(|item| self.seq_of("from_item", item)).transpose()?;
                let to_item = seq.map(|seq| if from_item == Some(1) { self.rewind() } else { self.set_current(seq) });
                let mut steps: VecDeque<_> = to_item.into_iter().collect();
                steps.push_back(self.mode_for(Action::Mission)?);
                steps.extend(seq.and_then(|seq| self.go_on_from(seq)));
                if self.family()? == ModeFamily::ArduCopter {
                    // A copter on the ground waits for this in AUTO.
                    let start = Step::command(self.long(Command::MISSION_START, [0.0; 7]));
                    steps.push_back(start.proved_by(Effect::Airborne));
                }
                return Ok(steps);
            }
            Request::MissionResume => {
                let is_fresh = self.telemetry.mission.filter(|mission| mission.freshness(self.now) == Freshness::Fresh);
                // A mission that is complete begins anew. One reported in AUTO is being flown, or was reported before
                // AUTO was left, which sets a landing back to its beginning.
                let is_flown = self.telemetry.mode().is_none_or(FlightMode::follows_mission);
                let is_interrupted = |reported: &MissionCurrent| {
                    let is_complete = reported.state.map_or(self.is_complete, |state| state == MissionState::Complete);
                    !is_flown && !is_complete && reported.in_mission_mode != Some(true)
                };
                let interrupted = is_fresh.map(|mission| mission.value).filter(is_interrupted);
                let mode = self.mode_for(Action::Mission)?;
                let go_on = interrupted.and_then(|reported| self.go_on_from(reported.seq));
                let back = self.left_at.map(|seq| self.set_current(seq));
                return Ok([mode].into_iter().chain(go_on).chain(back).collect());
            }
            Request::SetCurrentItem { item } => self.set_current(self.seq_of("item", item)?),
            Request::SetHome { lat_deg, lon_deg, alt_amsl_m } => {
                Step::command(self.set_home(lat_deg, lon_deg, alt_amsl_m)?)
            }
            Request::RawCommandLong(mut long) => {
                long.target = self.or_vehicle(long.target);
                Step::command(raw::checked(CommandMessage::Long(long), self.telemetry.is_ardupilot())?)
            }
            Request::RawCommandInt(mut int) => {
                int.target = self.or_vehicle(int.target);
                Step::command(raw::checked(CommandMessage::Int(int), self.telemetry.is_ardupilot())?)
            }
            Request::RequestMessage { message } => {
                let command =
                    self.long(Command::REQUEST_MESSAGE, [message_number(message)?, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
                Step::command(command).waiting(Effect::Received(message.0))
            }
            Request::SetMessageRate { message, rate_hz } => {
                message_number(message)?;
                let command = self.long(Command::SET_MESSAGE_INTERVAL, interval_params(message.0, rate_hz.checked()?));
                Step::command(command).waiting(Effect::Acknowledged)
            }
            Request::UploadPlan { kind: PlanKind::Mission, .. }
            | Request::DownloadPlan { kind: PlanKind::Mission }
            | Request::ClearPlan { kind: PlanKind::Mission }
                if self.telemetry.autopilot_type().is_none() =>
            {
                // It is not known whether its missions begin with home.
                return Err(self.unheard());
            }
            Request::UploadPlan { kind, items, .. } if items.is_empty() => Step::Clear(kind),
            Request::UploadPlan { kind: PlanKind::Mission, items, home, .. } => {
                let home = home.or(self.telemetry.home.map(|home| home.value));
                let wire = Mission { home, items }.to_wire(self.vehicle, self.is_ardupilot()?)?;
                Step::Upload(PlanKind::Mission, wire)
            }
            Request::UploadPlan { kind, items, .. } => Step::Upload(kind, items_to_wire(&items, self.vehicle, kind)?),
            Request::DownloadPlan { kind } => Step::Download(kind),
            Request::ClearPlan { kind } => Step::Clear(kind),
            Request::ParamList => Step::ParamList,
            Request::ParamRead { name } => Step::ParamRead(param_name(&name)?),
            Request::ParamSet { name, value } => {
                if !value.is_finite() {
                    return Err(invalid("value", value, "a finite number"));
                }
                // The encoding of integers depends on the family.
                self.family()?;
                Step::ParamSet(param_name(&name)?, value)
            }
            Request::Note { severity, .. } if severity.0 > 7 => {
                return Err(invalid("severity", severity.0, "0, an emergency, to 7, debug"));
            }
            Request::Note { severity, text } => Step::Note(severity, text.chars().take(MAX_NOTE).collect()),
            Request::SwitchFence { .. } if self.family().ok() == Some(ModeFamily::Px4) => {
                let expected = "parameter GF_ACTION, 0 for no action, by which a PX4 switches its fence";
                return Err(invalid("the fence's switch", "a command", expected));
            }
            Request::SwitchFence { on } => {
                let on = f32::from(u8::from(on));
                Step::command(self.long(Command::DO_FENCE_ENABLE, [on, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]))
            }
            Request::DespiteMixedPlan(request) => return self.steps(*request),
            Request::Reboot => {
                self.require_disarmed("rebooting it")?;
                let command = self.long(Command::PREFLIGHT_REBOOT_SHUTDOWN, [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
                Step::command(command).proved_by(Effect::Restarted)
            }
        };
        Ok([step].into())
    }

    fn or_vehicle(&self, target: Address) -> Address {
        if target.system.0 == 0 { self.vehicle } else { target }
    }
}

fn param_name(name: &str) -> Result<ParamName, VehicleError> {
    Ok(ParamName::new(name).map_err(crate::transfer::TransferError::from)?)
}

/// Message ids have 24 bits, which a float holds exactly.
fn message_number(MessageId(id): MessageId) -> Result<f32, VehicleError> {
    if id >= 1 << 24 {
        return Err(invalid("message", id, "a message's number, below 2^24"));
    }
    Ok(id as f32)
}
