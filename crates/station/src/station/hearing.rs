//! Received frames: which vehicle they belong to, and who else uses its id or our own.

use std::sync::Arc;

use vencejo_link::{LinkId, Origin, PeerId};
use vencejo_proto::{Address, Frame, Message, MonoTime, SystemId};
use vencejo_vehicle::{SourceId, Taken, Vehicle, VehicleEvent, VehicleId};

use super::shared::{Core, Shared, Watchers};
use crate::error::StationError;
use crate::subscriptions::Observed;

/// `TIMESYNC`: its answers give the round trip.
const TIMESYNC_ID: u32 = 111;

impl Core {
    /// Whether the followed source of a vehicle is a recording, which answers nothing.
    pub(super) fn is_replayed(&self, system: VehicleId) -> bool {
        is_played(self.watchers.get(&system).and_then(|watchers| watchers.sources.followed()))
    }

    /// Where a vehicle is heard, and no other that uses its id: first where it is followed.
    pub(crate) fn origins_of(&self, id: VehicleId, now: MonoTime) -> Vec<Origin> {
        self.watchers.get(&id).map(|watchers| watchers.sources.proven(now).map(origin_of).collect()).unwrap_or_default()
    }

    /// Admits a message to a vehicle. A recording is refused: its recorded messages would be taken for answers.
    pub(crate) fn admit(&self, id: VehicleId) -> Result<(), StationError> {
        let vehicle = match self.adopted.get(&id) {
            Some(adopted) if adopted.remote.is_recording() => adopted.name.to_string(),
            None if self.is_replayed(id) => id.to_string(),
            _ => return Ok(()),
        };
        Err(StationError::Replayed { vehicle })
    }
}

impl Shared {
    /// A frame from a link, in the task that read it.
    pub(crate) fn on_frame(self: &Arc<Self>, origin: Origin, frame: &Frame, now: MonoTime) {
        let link = origin.link;
        let Ok(message) = frame.decode() else { return };
        let from = frame.source();
        if from == self.config.address && !self.hub.is_ours(frame) && !self.hub.is_replay(link) {
            self.on_namesake(origin, now);
            return;
        }
        let mut core = self.core();
        let is_known = core.vehicles.get(from.system).is_some();
        let taken = self.whose(&mut core, origin, from, &message, now);
        if taken == Taken::No {
            return;
        }
        if core.vehicles.is_radio(from, &message) {
            let Core { vehicles, watchers, .. } = &mut *core;
            // A radio's frames come from the same source as its vehicle's: one port may have many bridges, each with a
            // radio.
            let is_there = |watchers: &Watchers| watchers.sources.followed().is_some_and(|at| origin_of(at) == origin);
            let there = watchers.iter().filter(|(_, watchers)| is_there(watchers)).map(|(id, _)| *id);
            vehicles.on_radio(there, &message, now);
        }
        match taken {
            Taken::Twice => {}
            Taken::Beside => drop(core.vehicles.on_beside(from.system.into(), &message, now)),
            _ => drop(core.vehicles.on_message(from, &message, now)),
        }
        core.vehicles.on_protocol_version(from, frame.version());
        if frame.message_id() == TIMESYNC_ID
            && let Some(round_trip) = core.vehicles.get(from.system).and_then(Vehicle::round_trip)
        {
            // The link may just have been closed; then its count does not matter.
            let _ = self.hub.note_round_trip(link, round_trip);
        }
        let version = core.vehicles.get(from.system).map(Vehicle::protocol_version);
        if version.is_some() {
            core.subscriptions.on_message(Some(link), frame, now);
        }
        if let Some(watchers) = core.watchers.get_mut(&from.system.into()) {
            watchers.version = version.unwrap_or_default();
            watchers.subscriptions.on_message(Some(link), frame, now);
            watchers.changes.notify();
        }
        self.carry_out(&mut core, now);
        if !is_known {
            // A new vehicle is followed where it was first heard.
            self.whose(&mut core, origin, from, &message, now);
        }
    }

    /// All frames of one read have been handled. Callers are notified of results only now, so that none sends the same
    /// command again before a second answer in the same read is handled: it would be taken for the next command's.
    pub(crate) fn on_read(&self) {
        self.core().end_requests();
    }

    /// Whether a message is from the vehicle that is followed under its id, not from another with the same id, and how
    /// to handle it.
    fn whose(&self, core: &mut Core, origin: Origin, from: Address, message: &Message, now: MonoTime) -> Taken {
        let Some(autopilot) = core.vehicles.get(from.system).map(Vehicle::address) else {
            // Another station, a radio: recorded messages were sent to the recorded vehicle, not to a live one.
            let target = message.target().system.filter(|target| core.vehicles.get(*target).is_some());
            let is_elsewhere = |target: SystemId| core.is_replayed(target.into()) != self.hub.is_replay(origin.link);
            return if target.is_some_and(is_elsewhere) { Taken::No } else { Taken::Yes };
        };
        let Some(watchers) = core.watchers.get_mut(&from.system.into()) else { return Taken::Yes };
        let is_recording = self.hub.is_replay(origin.link);
        let id = SourceId { link: origin.link.0, peer: origin.peer.0, is_recording };
        if autopilot != from {
            // Cameras and radios have no boot clock to compare; those of a known stranger are not the vehicle's.
            return if watchers.sources.is_rival(id) { Taken::No } else { Taken::Yes };
        }
        let before = watchers.sources.followed();
        let taken = watchers.sources.on_message(id, message, now);
        if watchers.sources.followed() != before {
            // The one that is followed is where this message came from: only a message makes another one that.
            self.hub.choose(from, Some(origin));
        }
        if matches!(taken, Taken::No | Taken::Replaced) {
            self.tell_contest(watchers, from.system.into(), now);
        }
        if taken == Taken::Replaced
            && let Some(vehicle) = core.vehicles.get_mut(from.system)
        {
            vehicle.on_replaced(is_played(before), now);
        }
        taken
    }

    /// Reports when another vehicle starts or stops using a vehicle's id or name.
    pub(super) fn tell_contest(&self, watchers: &mut Watchers, system: VehicleId, now: MonoTime) {
        let is_contested = watchers.rival(now).is_some();
        if is_contested == watchers.is_contested {
            return;
        }
        watchers.is_contested = is_contested;
        let event = match watchers.rival(now) {
            Some(Rival::Near(rival)) => {
                let place = self.hub.describe(origin_of(rival));
                tracing::warn!(vehicle = %system, %place, "another vehicle uses the same system id: it is not followed, and nothing is sent to it");
                VehicleEvent::Contested
            }
            Some(Rival::Far(place)) => {
                tracing::warn!(vehicle = %system, %place, "two computers use one aircraft name: the one heard first is shown, and orders go to it alone");
                VehicleEvent::Contested
            }
            None => {
                tracing::info!(vehicle = %system, "the other vehicle with the same system id or name is not heard any more");
                VehicleEvent::Uncontested
            }
        };
        watchers.subscriptions.on_event(&Observed { event, at: now });
        watchers.changes.notify();
    }

    /// Another station uses our own address.
    fn on_namesake(&self, origin: Origin, now: MonoTime) {
        if self.core().namesake.on_frame(origin, now) {
            let place = self.hub.describe(origin);
            tracing::warn!(address = %self.config.address, %place, "another station uses our MAVLink address; give one of the two another system id");
        }
    }

    /// Whether a vehicle hears us; `None` for a recording.
    pub(crate) fn is_reached(&self, system: VehicleId) -> Option<bool> {
        let now = self.clock.now();
        let core = self.core();
        let reached = core.vehicles.get(system)?.is_reached(now);
        reached.filter(|_| !core.is_replayed(system))
    }

    /// The other place where a vehicle's id or name is used, in words.
    pub(crate) fn rival(&self, system: VehicleId) -> Option<String> {
        let now = self.clock.now();
        let rival = match self.core().watchers.get(&system)?.rival(now)? {
            Rival::Near(rival) => rival,
            Rival::Far(place) => return Some(place.to_owned()),
        };
        Some(self.hub.describe(origin_of(rival)))
    }

    /// Another computer uses the name of a remote vehicle, at this place, and counts as present until then; `None`: no
    /// longer.
    pub(crate) fn on_far_rival(&self, system: VehicleId, rival: Option<(String, MonoTime)>) {
        let now = self.clock.now();
        let mut core = self.core();
        if let Some(watchers) = core.watchers.get_mut(&system) {
            watchers.far_rival = rival;
            self.tell_contest(watchers, system, now);
        }
    }

    /// Follows the other vehicle with that id; whether there is one.
    pub(crate) fn follow_rival(self: &Arc<Self>, system: VehicleId) -> bool {
        let now = self.clock.now();
        let mut core = self.core();
        let Some(autopilot) = core.vehicles.get(system).map(Vehicle::address) else { return false };
        let Some(watchers) = core.watchers.get_mut(&system) else { return false };
        let before = watchers.sources.followed();
        let has_changed = watchers.sources.follow_rival(now);
        if has_changed {
            self.hub.choose(autopilot, watchers.sources.followed().map(origin_of));
            if let Some(vehicle) = core.vehicles.get_mut(system) {
                vehicle.on_replaced(is_played(before), now);
            }
            self.settle(&mut core, now);
        }
        has_changed
    }
}

/// Another vehicle that uses a vehicle's id, or its name.
enum Rival<'a> {
    /// At a link.
    Near(SourceId),
    /// Remote, at this place.
    Far(&'a str),
}

impl Watchers {
    fn rival(&self, now: MonoTime) -> Option<Rival<'_>> {
        let far = || self.far_rival.as_ref().filter(|(_, until)| *until > now).map(|(place, _)| Rival::Far(place));
        self.sources.rival(now).map(Rival::Near).or_else(far)
    }
}

/// Whether it is a recording that was followed.
fn is_played(source: Option<SourceId>) -> bool {
    source.is_some_and(|source| source.is_recording)
}

fn origin_of(source: SourceId) -> Origin {
    Origin { link: LinkId(source.link), peer: PeerId(source.peer) }
}
