//! What an ArduPlane that lands must not be sent: a new altitude, from which it would flare, and another start of the
//! landing.

use vencejo_flight::plan::Command;
use vencejo_proto::{Message, MonoTime};

use super::Vehicle;
use super::steps::{Fallback, Step};
use crate::command::CommandMessage;
use crate::conduct::leads_to_landing;
use crate::error::VehicleError;
use crate::modes::ModeFamily;
use crate::telemetry::Freshness;

/// `current` of a mission item that is a new altitude for the present target.
const NEW_ALTITUDE: u8 = 3;

/// Whether a message gives the present target another altitude, in any mode that navigates. ArduPlane takes the other
/// ways to change it in GUIDED only.
fn changes_altitude(message: &Message) -> bool {
    match message {
        Message::CommandLong(long) => long.command == Command::DO_CHANGE_ALTITUDE.0,
        Message::CommandInt(int) => int.command == Command::DO_CHANGE_ALTITUDE.0,
        Message::MissionItemInt(item) => item.current == NEW_ALTITUDE,
        Message::MissionItemFloat(item) => item.current == NEW_ALTITUDE,
        _ => false,
    }
}

impl Vehicle {
    /// Whether a message may go out while the vehicle lands, or may land.
    ///
    /// ArduPlane changes `next_WP_loc`, whatever the mode (`handle_command_int_DO_CHANGE_ALTITUDE`). On final that is
    /// the landing point, and the height above it decides on the flare, in which the motor stops
    /// (`type_slope_verify_land`).
    ///
    /// # Errors
    /// [`VehicleError::Landing`] for a new altitude.
    pub(super) fn guard_landing(&self, message: &Message) -> Result<(), VehicleError> {
        let is_plane = self.family() == Some(ModeFamily::ArduPlane);
        if !is_plane || !message.target().includes(self.address) || !changes_altitude(message) {
            return Ok(());
        }
        let conduct = self.conduct();
        let is_known = conduct.is_landing == Some(true);
        let may_land = conduct.is_landing.is_none() && conduct.follows_mission == Some(true);
        if is_known || may_land {
            return Err(VehicleError::Landing { action: "changing its altitude", is_known });
        }
        Ok(())
    }

    /// [`Self::guard_landing`] for what a step sends.
    pub(super) fn guard_landing_by(&self, step: &Step) -> Result<(), VehicleError> {
        let command = |command: &CommandMessage| self.guard_landing(&command.to_message());
        match step {
            Step::Command { message, fallback, .. } => {
                command(message)?;
                match fallback {
                    Some(Fallback::Command(older)) => command(older),
                    Some(Fallback::Message(message, _)) => self.guard_landing(message),
                    None => Ok(()),
                }
            }
            Step::Tell { message, .. } | Step::Send(message) => self.guard_landing(message),
            _ => Ok(()),
        }
    }

    /// Whether it flies a landing of its mission already, approach included: another `DO_LAND_START` would break that
    /// off and turn away without climbing, however low it is (`AP_Mission::jump_to_landing_sequence`).
    pub(super) fn is_landing_already(&self, now: MonoTime) -> bool {
        let is_fresh = |freshness| freshness == Freshness::Fresh;
        let Some(heartbeat) = self.telemetry.heartbeat.filter(|told| is_fresh(told.freshness(now))) else {
            return false;
        };
        let Some(current) = self.telemetry.mission.filter(|told| is_fresh(told.freshness(now))) else { return false };
        if self.conduct().is_landing == Some(true) {
            return true;
        }
        let index = current.value.seq.checked_sub(self.first_seq()).map(usize::from);
        let is_flown = heartbeat.value.is_armed && heartbeat.value.mode.follows_mission();
        is_flown
            && self.telemetry.is_on_ground() != Some(true)
            && self.mission().zip(index).is_some_and(|(mission, index)| leads_to_landing(mission, index))
    }
}
