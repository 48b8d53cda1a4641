//! Carries out the outputs of the vehicles' state machines (messages, events, results, records) and starts their
//! requests.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use vencejo_link::{LinkAddress, LinkInfo, LinkState, LinkStats, Route, SendReport};
use vencejo_proto::{Counted, MavVersion, Message, MonoTime};
use vencejo_vehicle::telemetry::LOST_AFTER;
use vencejo_vehicle::{Output, RegistryEvent, RegistryOutput, Request, VehicleError, VehicleEvent, VehicleId};

use super::shared::{Core, RequestResult, Shared, Station, Waiting, is_heard};
use crate::error::StationError;
use crate::pending::Pending;
use crate::records;
use crate::subscriptions::Observed;

impl Shared {
    fn on_registry_event(self: &Arc<Self>, core: &mut Core, event: RegistryEvent) {
        match event {
            RegistryEvent::Appeared(id, address) => {
                tracing::info!(vehicle = %id, %address, "a vehicle is heard");
                self.greet(core, id);
                if !id.is_far() {
                    self.recall(core, id);
                }
            }
            RegistryEvent::Dropped(id, address) => {
                tracing::info!(vehicle = %id, "a vehicle is no longer followed");
                // Its queues end, and waiting callers look again.
                if core.adopted.remove(&id).is_none() {
                    self.hub.choose(address, None);
                }
                if let Some(watchers) = core.watchers.remove(&id) {
                    watchers.changes.notify();
                }
                let lost: Vec<_> = core.requests.keys().filter(|(of, _)| *of == id).copied().collect();
                for key in lost {
                    if let Some(finisher) = core.requests.remove(&key) {
                        finisher.finish(Err(VehicleError::NotHeard { age: LOST_AFTER }.into()));
                    }
                }
            }
            RegistryEvent::Full => {
                tracing::warn!("more vehicles are heard than can be followed; the others are ignored")
            }
            _ => {}
        }
    }

    /// Gives the records to a vehicle that was heard for the first time: those read when the station started at once,
    /// and those that another program may have written since when they are read.
    fn recall(self: &Arc<Self>, core: &mut Core, system: VehicleId) {
        let Some(folder) = self.records().as_ref().map(|records| records.folder().to_owned()) else { return };
        let (remembered, now) = (core.remembered.clone(), self.clock.now());
        if let Some(vehicle) = core.vehicles.get_mut(system) {
            vehicle.on_records(remembered, now);
        }
        let weak = Arc::downgrade(self);
        self.runtime.spawn_blocking(move || {
            let read = records::read_all(&folder);
            let Some(shared) = weak.upgrade() else { return };
            let now = shared.clock.now();
            let mut core = shared.core();
            if core.remembered != read {
                core.remembered.clone_from(&read);
                if let Some(vehicle) = core.vehicles.get_mut(system) {
                    vehicle.on_records(read, now);
                }
            }
            shared.settle(&mut core, now);
        });
    }

    /// A vehicle was heard for the first time.
    pub(crate) fn greet(self: &Arc<Self>, core: &mut Core, system: VehicleId) {
        core.watchers.entry(system).or_default();
        if core.waiting.is_empty() || !core.vehicles.get(system).is_some_and(is_heard) {
            return;
        }
        let (is_aside, name) = (core.is_aside(system), core.name_of(system).map(str::to_owned));
        let is_theirs = |waiting: &mut Waiting| waiting.wanted.is(system, is_aside, name.as_deref());
        for waiting in core.waiting.extract_if(.., is_theirs) {
            let station = Station { shared: self.clone() };
            waiting.finisher.finish(Ok(station.handle(system)));
        }
    }

    /// Carries out the vehicles' outputs, and delivers the results of requests that have ended.
    pub(crate) fn settle(self: &Arc<Self>, core: &mut Core, now: MonoTime) {
        self.carry_out(core, now);
        core.end_requests();
    }

    /// Carries out the vehicles' outputs, and wakes the driver where a deadline is earlier than its alarm.
    pub(super) fn carry_out(self: &Arc<Self>, core: &mut Core, now: MonoTime) {
        let mut unkept = Vec::new();
        while let Some(output) = core.vehicles.poll_output() {
            let (system, output) = match output {
                RegistryOutput::Vehicle(system, output) => (system, output),
                RegistryOutput::Event(event) => {
                    self.on_registry_event(core, event);
                    continue;
                }
            };
            match output {
                // No link reaches a vehicle far away.
                Output::Send(_) if core.adopted.contains_key(&system) => {}
                Output::Send(message) => {
                    let version = core.watchers.get(&system).map_or(MavVersion::V2, |watchers| watchers.version);
                    let report = self.hub.send_message(&message, self.config.address, version, Route::Target);
                    if !report.is_sent() {
                        tracing::debug!(vehicle = %system, message = message.name(), "not sent: no link is open to the vehicle");
                    }
                }
                Output::Progress { id, done, total } => {
                    if let Some(finisher) = core.requests.get(&(system, id)) {
                        finisher.progress(done, total);
                    }
                }
                Output::Finished { id, result } => {
                    if let Some(finisher) = core.requests.remove(&(system, id)) {
                        core.ended.push((finisher, result.map_err(StationError::from)));
                    }
                }
                Output::Event(VehicleEvent::Unreached | VehicleEvent::Reached) if core.is_replayed(system) => {}
                Output::Event(_) if core.is_shown_past(system) => {}
                Output::Event(event) => {
                    match event {
                        VehicleEvent::Unreached => {
                            tracing::warn!(vehicle = %system, "the vehicle is heard, but answers nothing: it does not hear us");
                        }
                        VehicleEvent::Reached => tracing::info!(vehicle = %system, "the vehicle answers again"),
                        _ => {}
                    }
                    if let Some(watchers) = core.watchers.get(&system) {
                        watchers.subscriptions.on_event(&Observed { event, at: now });
                        watchers.changes.notify();
                    }
                }
                // A recording that is played changes no records.
                Output::Keep { ticket, stored } => {
                    match self.records().as_ref().filter(|_| !core.is_replayed(system)) {
                        Some(records) => records.keep(system, ticket, stored),
                        None => unkept.push((system, ticket)),
                    }
                }
                _ => {}
            }
            // No records are kept (any more): waiting callers are released.
            for (system, ticket) in std::mem::take(&mut unkept) {
                if let Some(vehicle) = core.vehicles.get_mut(system) {
                    vehicle.on_kept(ticket, now);
                }
            }
        }
        if core
            .vehicles
            .deadline()
            .is_some_and(|deadline| deadline.as_micros() < self.driver_alarm_us.load(Ordering::Relaxed))
        {
            self.wake_driver.notify_one();
        }
    }

    /// A record is on the disk, or could not be written.
    pub(super) fn on_kept(self: &Arc<Self>, system: VehicleId, ticket: u64) {
        let now = self.clock.now();
        let mut core = self.core();
        if let Some(vehicle) = core.vehicles.get_mut(system) {
            vehicle.on_kept(ticket, now);
        }
        self.settle(&mut core, now);
    }

    /// Admits a change of control of a vehicle: of one that is there, and not in a recording.
    pub(crate) fn admit_control(&self, id: VehicleId) -> Result<(), StationError> {
        let core = self.core();
        if *self.closing.borrow() {
            return Err(StationError::Closed);
        }
        core.admit(id)?;
        core.vehicles.get(id).map(drop).ok_or(StationError::Vehicle(VehicleError::NotHeard { age: LOST_AFTER }))
    }

    /// Starts a request to a vehicle.
    pub(crate) fn request(self: &Arc<Self>, system: VehicleId, request: Request) -> Pending<RequestResult> {
        let now = self.clock.now();
        let mut core = self.core();
        // Checked under the lock: closing ends the requests that it finds there.
        if *self.closing.borrow() {
            return Pending::ended(Err(StationError::Closed));
        }
        // A note is not sent to the vehicle, so that it needs no permission.
        if !matches!(request, Request::Note { .. })
            && let Err(refused) = core.admit(system)
        {
            return Pending::ended(Err(refused));
        }
        let Some(vehicle) = core.vehicles.get_mut(system) else {
            return Pending::ended(Err(StationError::Vehicle(VehicleError::NotHeard { age: LOST_AFTER })));
        };
        let id = vehicle.request(request, now);
        let shared = Arc::downgrade(self);
        let (finisher, pending) = Pending::new(move || {
            let Some(shared) = shared.upgrade() else { return };
            let now = shared.clock.now();
            let mut core = shared.core();
            if let Some(vehicle) = core.vehicles.get_mut(system) {
                vehicle.cancel(id, now);
            }
            shared.settle(&mut core, now);
        });
        core.requests.insert((system, id), finisher);
        self.settle(&mut core, now);
        pending
    }

    /// Sends a raw message over a vehicle's link, unless the guard of an addressed vehicle holds it back.
    pub(crate) fn send(
        self: &Arc<Self>,
        system: VehicleId,
        message: &Message,
        despite_mixed_plan: bool,
    ) -> Result<SendReport, StationError> {
        let now = self.clock.now();
        let mut core = self.core();
        core.admit(system)?;
        let guarded = core.vehicles.on_sending(message, despite_mixed_plan, now);
        self.settle(&mut core, now);
        guarded?;
        let version = core.watchers.get(&system).map(|watchers| watchers.version).unwrap_or_default();
        Ok(self.hub.send_message(message, self.config.address, version, Route::Target))
    }

    /// Sends a vehicle what it requested itself, over its link alone; `None` for one far away.
    pub(crate) fn answer(&self, id: VehicleId, message: &Message) -> Option<SendReport> {
        let version = self.core().watchers.get(&id).map(|watchers| watchers.version).unwrap_or_default();
        Some(self.hub.send_message(message, self.config.address, version, Route::System(id.system()?)))
    }

    pub(super) fn no_vehicle(&self, waiting: &Waiting) -> StationError {
        StationError::NoVehicle {
            wanted: waiting.wanted.clone(),
            waited: self.clock.now().since(waiting.since),
            links: self.describe_links(),
            heard: self.names_heard(),
        }
    }

    /// The links and their states, for an error message.
    pub(crate) fn describe_links(&self) -> String {
        let links = self.hub.links();
        let links: Vec<_> =
            links.iter().filter_map(|link| Some(describe(link, &self.hub.stats(link.id).ok()?))).collect();
        if links.is_empty() { "no link".into() } else { links.join(", ") }
    }

    /// The vehicles that were heard, by name or id.
    fn names_heard(&self) -> Vec<String> {
        let core = self.core();
        let name = |id: VehicleId| core.name_of(id).map_or_else(|| id.to_string(), str::to_owned);
        core.vehicles.iter().filter(|(_, vehicle)| is_heard(vehicle)).map(|(id, _)| name(id)).collect()
    }
}

/// A link and its state.
pub(super) fn describe(link: &LinkInfo, stats: &LinkStats) -> String {
    let state = match &link.state {
        LinkState::Connecting { last_error: Some(error), .. } => format!("not open: {error}"),
        LinkState::Connecting { last_error: None, .. } => "not open yet".into(),
        LinkState::Up { .. } if stats.rates.frames_hz > 0.0 => "open, MAVLink from others only".into(),
        LinkState::Up { .. } if stats.received.frames > 0 => "open".into(),
        LinkState::Up { .. } if stats.refused > 0 => {
            format!("open, {} refused: signature missing, wrong or old", Counted(stats.refused, "frame"))
        }
        LinkState::Up { .. } if stats.received.bytes == 0 => "open, nothing received".into(),
        LinkState::Up { .. } => {
            let remedy = match link.address {
                LinkAddress::Serial { .. } => ": another baud rate?",
                _ => "",
            };
            format!("open, no MAVLink in {}{remedy}", Counted(stats.received.bytes, "byte"))
        }
        LinkState::Down => "closed".into(),
        LinkState::Ended { .. } => "played to its end".into(),
    };
    format!("{} ({state})", link.address)
}
