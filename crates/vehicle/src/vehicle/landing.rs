//! What an ArduPlane that lands must not be sent: a new altitude, from which it would flare, and what turns it away from
//! its final without climbing first. An abort and another mode are never held back.

use vencejo_flight::plan::Command;
use vencejo_proto::{Message, MonoTime};

use super::Vehicle;
use super::guard::Act;
use super::steps::{Fallback, Step};
use crate::command::CommandMessage;
use crate::conduct::leads_to_landing;
use crate::error::VehicleError;
use crate::modes::ModeFamily;
use crate::telemetry::Freshness;

/// `current` of a mission item that is a new altitude for the present target.
const NEW_ALTITUDE: u8 = 3;

/// What a message does to a landing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Disturbance {
    /// Gives the present target another altitude, in any mode that navigates. ArduPlane changes `next_WP_loc`
    /// (`handle_command_int_DO_CHANGE_ALTITUDE`), which is the landing point on final: the height above it decides on
    /// the flare, in which the motor stops (`type_slope_verify_land`).
    NewAltitude,
    /// Starts the landing sequence again (`AP_Mission::jump_to_landing_sequence`), from AUTOLAND too.
    Restart,
    /// Jumps in the mission. In AUTO, an ArduPlane turns at once and climbs only as the new leg does
    /// (`Plane::setup_alt_slope`); an abort climbs straight ahead first (`type_slope_verify_abort_landing`).
    Jump,
}

impl Disturbance {
    fn action(self) -> &'static str {
        match self {
            Self::NewAltitude => "changing its altitude",
            Self::Restart => "starting the landing again",
            Self::Jump => "jumping in the mission",
        }
    }

    fn consequence(self) -> &'static str {
        match self {
            Self::NewAltitude => {
                "ArduPlane takes a new altitude for that of the landing point, and would flare and stop its motor in the air"
            }
            Self::Restart | Self::Jump => {
                "ArduPlane would turn away at once, however low it is, without climbing first"
            }
        }
    }
}

/// ArduPlane takes the other ways to change its altitude in GUIDED only.
fn disturbance_of_command(command: u16) -> Option<Disturbance> {
    match Command(command) {
        Command::DO_CHANGE_ALTITUDE => Some(Disturbance::NewAltitude),
        Command::DO_LAND_START => Some(Disturbance::Restart),
        _ => None,
    }
}

impl Vehicle {
    fn disturbance_of(&self, message: &Message) -> Option<Disturbance> {
        let is_new_altitude = match message {
            Message::MissionItemInt(item) => item.current == NEW_ALTITUDE,
            Message::MissionItemFloat(item) => item.current == NEW_ALTITUDE,
            _ => false,
        };
        let known = match message {
            Message::CommandLong(long) => disturbance_of_command(long.command),
            Message::CommandInt(int) => disturbance_of_command(int.command),
            _ => is_new_altitude.then_some(Disturbance::NewAltitude),
        };
        known.or_else(|| (self.act_of(message) == Some(Act::Jump)).then_some(Disturbance::Jump))
    }

    /// Whether a message may go out while the vehicle lands, or may land.
    ///
    /// # Errors
    /// [`VehicleError::Landing`] for one that would disturb the landing.
    pub(super) fn guard_landing(&self, message: &Message, now: MonoTime) -> Result<(), VehicleError> {
        let is_plane = self.family() == Some(ModeFamily::ArduPlane);
        if !is_plane || !message.target().includes(self.address) {
            return Ok(());
        }
        let Some(disturbance) = self.disturbance_of(message) else { return Ok(()) };
        let conduct = self.conduct();
        let is_landing = conduct.is_landing == Some(true);
        let (is_known, may_land) = match disturbance {
            Disturbance::NewAltitude => {
                (is_landing, conduct.is_landing.is_none() && conduct.follows_mission == Some(true))
            }
            Disturbance::Restart => (self.is_landing_already(now), false),
            Disturbance::Jump => {
                let is_reported = self.flown_item(now).is_some() && conduct.follows_mission == Some(true);
                (is_landing && is_reported, false)
            }
        };
        if is_known || may_land {
            let (action, consequence) = (disturbance.action(), disturbance.consequence());
            return Err(VehicleError::Landing { action, consequence, is_known });
        }
        Ok(())
    }

    /// [`Self::guard_landing`] for what a step sends.
    pub(super) fn guard_landing_by(&self, step: &Step, now: MonoTime) -> Result<(), VehicleError> {
        let command = |command: &CommandMessage| self.guard_landing(&command.to_message(), now);
        match step {
            Step::Command { message, fallback, .. } => {
                command(message)?;
                match fallback {
                    Some(Fallback::Command(older)) => command(older),
                    Some(Fallback::Message(message, _)) => self.guard_landing(message, now),
                    None => Ok(()),
                }
            }
            Step::Tell { message, .. } | Step::Send(message) => self.guard_landing(message, now),
            _ => Ok(()),
        }
    }

    /// Seq of the item at which the landing of its mission begins, where no `DO_LAND_START` marks one: the item with a
    /// position before it, where its last leg begins, else the landing itself. `None` also while its mission is not
    /// known.
    pub(super) fn unmarked_landing(&self) -> Option<u16> {
        let items = &self.mission()?.items;
        let land = items.iter().position(|item| item.command == Command::NAV_LAND)?;
        if items.iter().any(|item| item.command == Command::DO_LAND_START) {
            return None;
        }
        let before = items[..land].iter().rposition(|item| item.command.is_nav());
        let is_leg = |&index: &usize| items[index].command != Command::NAV_TAKEOFF && items[index].has_position();
        let index = before.filter(is_leg).unwrap_or(land);
        Some(u16::try_from(index).ok()?.saturating_add(self.first_seq()))
    }

    /// The present item of its mission, where both its mode and that item were reported lately.
    fn flown_item(&self, now: MonoTime) -> Option<u16> {
        let is_fresh = |freshness| freshness == Freshness::Fresh;
        self.telemetry.heartbeat.filter(|heartbeat| is_fresh(heartbeat.freshness(now)))?;
        Some(self.telemetry.mission.filter(|mission| is_fresh(mission.freshness(now)))?.value.seq)
    }

    /// Whether it flies a landing of its mission already, approach included: another `DO_LAND_START` would break that
    /// off.
    pub(super) fn is_landing_already(&self, now: MonoTime) -> bool {
        let Some(seq) = self.flown_item(now) else { return false };
        if self.conduct().is_landing == Some(true) {
            return true;
        }
        let index = seq.checked_sub(self.first_seq()).map(usize::from);
        let is_flown = self.telemetry.is_armed() == Some(true) && self.conduct().follows_mission == Some(true);
        is_flown
            && self.telemetry.is_on_ground() != Some(true)
            && self.mission().zip(index).is_some_and(|(mission, index)| leads_to_landing(mission, index))
    }
}
