//! Targets for guided flight: positions, altitudes, courses, velocities; and their substitutes on old firmware.

use std::collections::VecDeque;

use vencejo_flight::plan::Command;
use vencejo_proto::dialect::{MavFrame, MavMessage, PositionTargetTypemask, SET_POSITION_TARGET_LOCAL_NED_DATA};
use vencejo_proto::{CommandInt, Message, MissionItemFloat};

use super::{Context, Effect, REPOSITION_CHANGE_MODE, Step};
use crate::choice::{AltFrame, SpeedKind, Turn};
use crate::command::CommandMessage;
use crate::error::VehicleError;
use crate::modes::{Action, FlightMode, ModeFamily};
use crate::vehicle::raw::{height, in_range, invalid};

impl Context<'_> {
    /// An altitude and its frame as the vehicle reads them in a command. PX4 reads altitudes above mean sea level
    /// whatever the frame, and accepts what it misreads: its receiver drops the frame (`handle_message_command_int`,
    /// PX4 issue 10246).
    pub(super) fn as_counted(&self, alt_m: f64, alt_frame: AltFrame) -> Result<(f64, AltFrame), VehicleError> {
        match alt_frame {
            _ if self.family()? != ModeFamily::Px4 => Ok((alt_m, alt_frame)),
            AltFrame::Amsl => Ok((alt_m, alt_frame)),
            AltFrame::RelHome => {
                height("alt_m", alt_m)?;
                let home = self.telemetry.home.ok_or(VehicleError::HomeUnknown)?.value;
                Ok((home.alt_amsl_m + alt_m, AltFrame::Amsl))
            }
            AltFrame::Terrain => {
                Err(invalid("alt_frame", "terrain", "home or amsl: PX4 takes no height above terrain in a command"))
            }
        }
    }

    /// Refuses 0/0: the position of fields that were never filled in, which ArduPilot takes for "here".
    pub(super) fn chosen(lat_deg: f64, lon_deg: f64, expected: &'static str) -> Result<(), VehicleError> {
        // As it is sent: what rounds to 0/0 is 0/0.
        let is_zero = |degrees: f64| (degrees * 1e7).round() == 0.0;
        if is_zero(lat_deg) && is_zero(lon_deg) {
            return Err(invalid("lat_deg", "0, as lon_deg", expected));
        }
        Ok(())
    }

    /// A COMMAND_INT with a checked position.
    pub(super) fn at_position(
        &self,
        command: Command,
        frame: u8,
        params: [f32; 4],
        (lat_deg, lon_deg, alt_m): (f64, f64, f64),
    ) -> Result<CommandMessage, VehicleError> {
        in_range("lat_deg", lat_deg, -90.0..=90.0, "a latitude, -90 to 90 degrees")?;
        in_range("lon_deg", lon_deg, -180.0..=180.0, "a longitude, -180 to 180 degrees")?;
        let z = height("alt_m", alt_m)?;
        Ok(CommandMessage::Int(CommandInt {
            target: self.vehicle,
            frame,
            command: command.0,
            current: 0,
            autocontinue: 0,
            params,
            x: (lat_deg * 1e7).round() as i32,
            y: (lon_deg * 1e7).round() as i32,
            z,
        }))
    }

    /// Go-to of a fixed wing with PX4. Its DO_REPOSITION has no circle, which DO_ORBIT has, and a change to AUTO_LOITER drops
    /// the speed of both; it is an airspeed (v1.17.0, `navigator_main.cpp`, `loiter.cpp`).
    pub(super) fn go_to_px4(
        &self,
        (lat_deg, lon_deg, alt_m): (f64, f64, f64),
        alt_frame: AltFrame,
        circle: Option<(f32, Turn)>,
        speed_m_s: Option<f64>,
    ) -> Result<VecDeque<Step>, VehicleError> {
        let (command, params) = match circle {
            None => (Command::DO_REPOSITION, [-1.0, REPOSITION_CHANGE_MODE, 0.0, f32::NAN]),
            Some((0.0, _)) => {
                let expected = "a radius: a PX4 takes the sense of a circle with its radius alone";
                return Err(invalid("radius_m", "missing", expected));
            }
            Some((radius, Turn::Clockwise)) => (Command::DO_ORBIT, [radius, f32::NAN, f32::NAN, f32::NAN]),
            Some((radius, Turn::CounterClockwise)) => (Command::DO_ORBIT, [-radius, f32::NAN, f32::NAN, f32::NAN]),
        };
        let (alt_m, alt_frame) = self.as_counted(alt_m, alt_frame)?;
        let message = self.at_position(command, alt_frame.mav_frame(), params, (lat_deg, lon_deg, alt_m))?;
        let speed = speed_m_s.map(|speed_m_s| self.speed_of_go_to(speed_m_s as f32));
        Ok([Step::command(message).unless_objected()].into_iter().chain(speed).collect())
    }

    /// The airspeed of a plane that was sent to a position, m/s. It follows, since the change of mode drops the one before
    /// (`Mode::enter` of ArduPlane, `navigator_main.cpp` of PX4); in a mode that a pilot has chosen meanwhile it is not
    /// repeated, which would be that mode's speed.
    pub(super) fn speed_of_go_to(&self, speed_m_s: f32) -> Step {
        self.speed(SpeedKind::Airspeed, speed_m_s).unless_objected().waiting(Effect::Unobjected)
    }

    /// A change of speed, m/s.
    pub(super) fn speed(&self, kind: SpeedKind, speed_m_s: f32) -> Step {
        let kind = match kind {
            SpeedKind::Airspeed => 0.0,
            SpeedKind::Groundspeed => 1.0,
        };
        // −1: throttle unchanged.
        Step::command(self.long(Command::DO_CHANGE_SPEED, [kind, speed_m_s, -1.0, 0.0, 0.0, 0.0, 0.0]))
    }

    /// A mission item that ArduPlane takes as a guided target (`current` = 2) or altitude (3). All versions take
    /// MISSION_ITEM, but it is less safe to repeat than a command, so it is used only for those without COMMAND_INT.
    fn guided(
        &self,
        (lat_deg, lon_deg, alt_m): (f64, f64, f64),
        alt_frame: AltFrame,
        current: u8,
    ) -> Result<Message, VehicleError> {
        if alt_frame == AltFrame::Terrain {
            return Err(VehicleError::TooOld {
                what: "heights above terrain",
                instead: "give the height above home or above mean sea level",
            });
        }
        Ok(Message::MissionItemFloat(MissionItemFloat {
            target: self.vehicle,
            seq: 0,
            frame: alt_frame.mav_frame(),
            command: Command::NAV_WAYPOINT.0,
            current,
            autocontinue: 0,
            params: [0.0; 4],
            x: in_range("lat_deg", lat_deg, -90.0..=90.0, "a latitude, -90 to 90 degrees")?,
            y: in_range("lon_deg", lon_deg, -180.0..=180.0, "a longitude, -180 to 180 degrees")?,
            z: height("alt_m", alt_m)?,
            mission_type: 0,
        }))
    }

    /// Go-to for firmware without COMMAND_INT. It enters GUIDED by itself, so without `change_mode` it must be there
    /// already; it circles in its default sense and radius.
    pub(super) fn guided_item(
        &self,
        place: (f64, f64, f64),
        alt_frame: AltFrame,
        is_plain: bool,
        change_mode: bool,
    ) -> Result<VecDeque<Step>, VehicleError> {
        let guided =
            Action::Guided.mode(self.family()?).ok_or(VehicleError::NoModeFor { action: Action::Guided.name() })?;
        if !is_plain {
            return Err(VehicleError::TooOld {
                what: "a radius, sense or speed of its own for a go-to",
                instead: "leave them out, and set WP_LOITER_RAD or TRIM_ARSPD_CM where the vehicle needs others",
            });
        }
        if !change_mode && self.telemetry.mode() != Some(guided) {
            return Err(VehicleError::TooOld {
                what: "a go-to that leaves the mode as it is",
                instead: "enter GUIDED first, or allow the change of mode",
            });
        }
        let message = self.guided(place, alt_frame, 2)?;
        let command = self.long(Command::NAV_WAYPOINT, [0.0; 7]);
        Ok([Step::Tell { command, message, effect: Effect::Mode(guided) }].into())
    }

    /// Change of altitude for firmware without DO_CHANGE_ALTITUDE.
    pub(super) fn guided_height(&self, alt_m: f64, alt_frame: AltFrame) -> Result<VecDeque<Step>, VehicleError> {
        let message = self.guided((0.0, 0.0, alt_m), alt_frame, 3)?;
        let command = self.long(Command::DO_CHANGE_ALTITUDE, [0.0; 7]);
        Ok([Step::Tell { command, message, effect: Effect::Acknowledged }].into())
    }

    /// A target that only exists in ArduPlane's GUIDED. Checked here, because ArduPlane's answer in another mode says
    /// only FAILED.
    pub(super) fn in_guided(
        &self,
        command: Command,
        frame: u8,
        params: [f32; 4],
        z: f32,
    ) -> Result<Step, VehicleError> {
        let guided = Action::Guided.mode(ModeFamily::ArduPlane);
        self.require_mode(guided, "GUIDED, of an ArduPlane, for a course or climb; enter it first")?;
        if !self.has_command_int {
            return Err(VehicleError::TooOld { what: "courses and climbs", instead: "send it to a position instead" });
        }
        Ok(Step::command(CommandMessage::Int(CommandInt {
            target: self.vehicle,
            frame,
            command: command.0,
            current: 0,
            autocontinue: 0,
            params,
            x: 0,
            y: 0,
            z,
        })))
    }

    pub(super) fn require_mode(&self, mode: Option<FlightMode>, expected: &'static str) -> Result<(), VehicleError> {
        self.family()?;
        let shown = self.telemetry.mode();
        if mode.is_some() && shown == mode {
            return Ok(());
        }
        Err(invalid("the mode", shown.map_or_else(|| "unknown".to_owned(), |mode| mode.to_string()), expected))
    }

    pub(super) fn velocity(&self, body_m_s: [f64; 3], yaw_rate_rad_s: f64) -> Result<Step, VehicleError> {
        let family = self.family()?;
        let (mode, frame) = match family {
            // ArduCopter rotates this frame by the heading alone, so that "down" is vertical at any tilt.
            ModeFamily::ArduCopter => (Action::Guided.mode(family), MavFrame::MAV_FRAME_BODY_OFFSET_NED),
            ModeFamily::Px4 => (family.parse("OFFBOARD").ok(), MavFrame::MAV_FRAME_BODY_NED),
            _ => (None, MavFrame::MAV_FRAME_BODY_NED),
        };
        self.require_mode(mode, "GUIDED (PX4: OFFBOARD), of a vehicle that hovers, for a velocity; enter it first")?;
        let speed = |field, value| in_range(field, value, -50.0..=50.0, "a speed, -50 to 50 m/s");
        let ignored = [
            PositionTargetTypemask::POSITION_TARGET_TYPEMASK_X_IGNORE,
            PositionTargetTypemask::POSITION_TARGET_TYPEMASK_Y_IGNORE,
            PositionTargetTypemask::POSITION_TARGET_TYPEMASK_Z_IGNORE,
            PositionTargetTypemask::POSITION_TARGET_TYPEMASK_AX_IGNORE,
            PositionTargetTypemask::POSITION_TARGET_TYPEMASK_AY_IGNORE,
            PositionTargetTypemask::POSITION_TARGET_TYPEMASK_AZ_IGNORE,
            PositionTargetTypemask::POSITION_TARGET_TYPEMASK_YAW_IGNORE,
        ];
        let data = SET_POSITION_TARGET_LOCAL_NED_DATA {
            time_boot_ms: u32::try_from(self.now.as_duration().as_millis()).unwrap_or_default(),
            target_system: self.vehicle.system.0,
            target_component: self.vehicle.component.0,
            coordinate_frame: frame,
            type_mask: ignored.into_iter().collect(),
            vx: speed("forward_m_s", body_m_s[0])?,
            vy: speed("right_m_s", body_m_s[1])?,
            vz: speed("down_m_s", body_m_s[2])?,
            yaw_rate: in_range("yaw_rate_rad_s", yaw_rate_rad_s, -10.0..=10.0, "a turn rate, -10 to 10 rad/s")?,
            ..Default::default()
        };
        Ok(Step::Send(Message::Dialect(MavMessage::SET_POSITION_TARGET_LOCAL_NED(data))))
    }
}
