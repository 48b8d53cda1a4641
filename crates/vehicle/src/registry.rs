//! The vehicles that are heard on a link, and which message belongs to which.
//!
//! A vehicle is a system with an autopilot's heartbeat. Ground stations, cameras, radios and noise are none; neither are
//! we, when our own messages come back.

use std::collections::BTreeMap;

use vencejo_proto::dialect::MavMessage;
use vencejo_proto::{Address, Message, MonoTime, SystemId};

use crate::heartbeat::is_autopilot;
use crate::request::Output;
use crate::telemetry::Group;
use crate::vehicle::{Vehicle, VehicleConfig};

/// Vehicles that are followed at once. When there are more, those that are lost make room, longest silent first; a newcomer
/// for whom there is no room is ignored.
pub const MAX_VEHICLES: usize = 32;

/// Something about a link's vehicles as a whole.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum RegistryEvent {
    /// A vehicle is heard for the first time.
    Appeared(Address),
    /// A lost vehicle made room for another; its requests ended without a result.
    Dropped(Address),
    /// There is no room for another vehicle. Told once until there is room again.
    Full,
}

/// What the vehicles want of their owner.
#[derive(Debug, Clone, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "moved once, from the queue to the link")]
pub enum RegistryOutput {
    /// Of one vehicle.
    Vehicle(SystemId, Output),
    /// About all.
    Event(RegistryEvent),
}

/// All vehicles of a link, by system id.
#[derive(Debug)]
pub struct Vehicles {
    our: Address,
    config: VehicleConfig,
    vehicles: BTreeMap<SystemId, Vehicle>,
    /// At most two for each message received; drained after every call.
    events: Vec<RegistryEvent>,
    is_full: bool,
}

impl Vehicles {
    /// None yet. We are `our`; each vehicle gets `config`.
    #[must_use]
    pub fn new(our: Address, config: VehicleConfig) -> Self {
        Self { our, config, vehicles: BTreeMap::new(), events: Vec::new(), is_full: false }
    }

    /// One of them.
    #[must_use]
    pub fn get(&self, system: SystemId) -> Option<&Vehicle> {
        self.vehicles.get(&system)
    }

    /// One of them, to ask something of it.
    pub fn get_mut(&mut self, system: SystemId) -> Option<&mut Vehicle> {
        self.vehicles.get_mut(&system)
    }

    /// All of them, by system id.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = (SystemId, &Vehicle)> {
        self.vehicles.iter().map(|(system, vehicle)| (*system, vehicle))
    }

    /// How many there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.vehicles.len()
    }

    /// Whether none was heard yet.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.vehicles.is_empty()
    }

    /// A message from the link. Returns whose telemetry changed, and which group.
    pub fn on_message(&mut self, source: Address, message: &Message, now: MonoTime) -> Option<(SystemId, Group)> {
        if source == self.our || source.system == SystemId::BROADCAST {
            return None;
        }
        if let Message::Heartbeat(heartbeat) = message
            && !self.vehicles.contains_key(&source.system)
            && is_autopilot(heartbeat)
        {
            self.welcome(source, now);
        }
        if let Some(vehicle) = self.vehicles.get_mut(&source.system) {
            let group = vehicle.on_message(source.component, message, now);
            return group.map(|group| (source.system, group));
        }
        if let Message::Dialect(MavMessage::RADIO_STATUS(_) | MavMessage::RADIO(_)) = message {
            // A radio speaks for the link, under a system id of its own.
            let mut changed = None;
            for (system, vehicle) in &mut self.vehicles {
                changed = vehicle.on_radio(message, now).map(|group| (*system, group)).or(changed);
            }
            return changed;
        }
        if let Some(target) = message.target().system
            && let Some(vehicle) = self.vehicles.get_mut(&target)
        {
            vehicle.on_foreign(source, message, now);
        }
        None
    }

    fn welcome(&mut self, source: Address, now: MonoTime) {
        if self.vehicles.len() >= MAX_VEHICLES {
            let lost = self.vehicles.iter().filter(|(_, vehicle)| !vehicle.is_heard(now));
            let Some((system, vehicle)) = lost.min_by_key(|(_, vehicle)| vehicle.heard_at()) else {
                if !self.is_full {
                    self.is_full = true;
                    self.events.push(RegistryEvent::Full);
                }
                return;
            };
            let (system, address) = (*system, vehicle.address());
            self.vehicles.remove(&system);
            self.events.push(RegistryEvent::Dropped(address));
        }
        self.is_full = false;
        let mut config = self.config.clone();
        // Sessions of two vehicles do not share numbers, so that a log tells them apart.
        config.seed = config.seed.wrapping_add(u32::from(source.system.0) * 7);
        self.vehicles.insert(source.system, Vehicle::new(source, self.our, config, now));
        self.events.push(RegistryEvent::Appeared(source));
    }

    /// Lets time pass for those that want it.
    pub fn on_time(&mut self, now: MonoTime) {
        for vehicle in self.vehicles.values_mut() {
            if vehicle.deadline().is_some_and(|deadline| now >= deadline) {
                vehicle.on_time(now);
            }
        }
    }

    /// When [`Self::on_time`] is wanted.
    #[must_use]
    pub fn deadline(&self) -> Option<MonoTime> {
        self.vehicles.values().filter_map(Vehicle::deadline).min()
    }

    /// The next thing that the owner must do. Drain it after every call.
    pub fn poll_output(&mut self) -> Option<RegistryOutput> {
        if !self.events.is_empty() {
            return Some(RegistryOutput::Event(self.events.remove(0)));
        }
        self.vehicles
            .iter_mut()
            .find_map(|(system, vehicle)| Some(RegistryOutput::Vehicle(*system, vehicle.poll_output()?)))
    }
}
