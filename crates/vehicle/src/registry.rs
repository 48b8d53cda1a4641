//! The vehicles that are heard on links or hosted for another station, and the assignment of messages to them.
//!
//! A vehicle is a system with an autopilot's heartbeat. Ground stations, cameras, radios, noise and our own echoed
//! messages are not.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::ops::RangeInclusive;

use vencejo_proto::dialect::MavMessage;
use vencejo_proto::{Address, MavVersion, Message, MonoTime, SystemId};

use crate::error::VehicleError;
use crate::heartbeat::is_autopilot;
use crate::id::VehicleId;
use crate::request::Output;
use crate::streams::StreamConfig;
use crate::telemetry::Group;
use crate::vehicle::{Vehicle, VehicleConfig};

/// Most vehicles at links followed at once: room for the 50 of one port that the benchmarks fly, and a bound on the
/// memory that a flood of ids costs. When the registry is full, lost vehicles are replaced, longest silent first; else
/// a newcomer is ignored.
pub const MAX_VEHICLES: usize = 64;
/// Most remote vehicles followed at once. Their station knows them by name, so noise cannot create one.
pub const MAX_FAR: usize = 1024;

/// The ids of vehicles at links, and of remote ones.
const AT_LINKS: RangeInclusive<VehicleId> = VehicleId::new(0)..=VehicleId::new(VehicleId::FIRST_FAR - 1);
const FAR: RangeInclusive<VehicleId> = VehicleId::new(VehicleId::FIRST_FAR)..=VehicleId::new(u16::MAX);

/// An event of the registry.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum RegistryEvent {
    /// A vehicle is heard for the first time.
    Appeared(VehicleId, Address),
    /// A vehicle is no longer followed: a lost one made room for another, or its replay was closed. Its requests were
    /// cancelled.
    Dropped(VehicleId, Address),
    /// The registry is full. Reported once until a place is free.
    Full,
}

/// Outputs of the vehicles for their owner.
#[derive(Debug, Clone, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "moved once, from the queue to the link")]
pub enum RegistryOutput {
    /// Of one vehicle.
    Vehicle(VehicleId, Output),
    /// About all.
    Event(RegistryEvent),
}

/// All vehicles of a station, by id.
#[derive(Debug)]
pub struct Vehicles {
    our: Address,
    config: VehicleConfig,
    vehicles: BTreeMap<VehicleId, Vehicle>,
    /// Events, and last outputs of dropped vehicles: a few for each message received; drained after every call.
    outputs: VecDeque<RegistryOutput>,
    /// Vehicles that may have output: those accessed since they were last drained. With dozens of vehicles, polling all
    /// of them after each message would cost more than handling the message.
    touched: Vec<VehicleId>,
    /// At or before the earliest deadline of the others.
    rest_until: Option<MonoTime>,
    /// Hosted vehicles whose time is another one than the station's.
    replayed: BTreeSet<VehicleId>,
    is_full: bool,
}

impl Vehicles {
    /// An empty registry. We are `our`; each vehicle gets `config`.
    pub fn new(our: Address, config: VehicleConfig) -> Self {
        Self {
            our,
            config,
            vehicles: BTreeMap::new(),
            outputs: VecDeque::new(),
            touched: Vec::new(),
            rest_until: None,
            replayed: BTreeSet::new(),
            is_full: false,
        }
    }

    /// A vehicle.
    pub fn get(&self, id: impl Into<VehicleId>) -> Option<&Vehicle> {
        self.vehicles.get(&id.into())
    }

    /// A vehicle, for a request.
    pub fn get_mut(&mut self, id: impl Into<VehicleId>) -> Option<&mut Vehicle> {
        let id = id.into();
        let vehicle = self.vehicles.get_mut(&id)?;
        touch(&mut self.touched, id);
        Some(vehicle)
    }

    /// All vehicles, by id.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = (VehicleId, &Vehicle)> {
        self.vehicles.iter().map(|(id, vehicle)| (*id, vehicle))
    }

    /// Number of vehicles.
    pub fn len(&self) -> usize {
        self.vehicles.len()
    }

    /// Whether no vehicle was heard yet.
    pub fn is_empty(&self) -> bool {
        self.vehicles.is_empty()
    }

    /// A message from the link. Returns whose telemetry changed, and which group.
    pub fn on_message(&mut self, source: Address, message: &Message, now: MonoTime) -> Option<(VehicleId, Group)> {
        if source == self.our || source.system == SystemId::BROADCAST {
            return None;
        }
        if let Message::Heartbeat(heartbeat) = message
            && !self.vehicles.contains_key(&source.system.into())
            && is_autopilot(heartbeat)
        {
            self.welcome(source, now);
        }
        if let Some(vehicle) = self.get_mut(source.system) {
            let group = vehicle.on_message(source.component, message, now);
            return group.map(|group| (source.system.into(), group));
        }
        if let Some(target) = message.target().system
            && let Some(vehicle) = self.get_mut(target)
        {
            vehicle.on_foreign(source, message, now);
        }
        None
    }

    /// Whether the sender is a link's radio, under a system id of its own.
    pub fn is_radio(&self, source: Address, message: &Message) -> bool {
        !self.vehicles.contains_key(&source.system.into())
            && matches!(message, Message::Dialect(MavMessage::RADIO_STATUS(_) | MavMessage::RADIO(_)))
    }

    /// A message of a vehicle's autopilot over another link than the one over which it is followed: see
    /// [`Vehicle::on_beside`].
    pub fn on_beside(&mut self, id: VehicleId, message: &Message, now: MonoTime) -> Option<Group> {
        self.get_mut(id)?.on_beside(message, now)
    }

    /// The state of a link's radio, for the vehicles that are followed on that link.
    pub fn on_radio(&mut self, followed: impl IntoIterator<Item = VehicleId>, message: &Message, now: MonoTime) {
        for id in followed {
            if let Some(vehicle) = self.get_mut(id) {
                vehicle.on_radio(message, now);
            }
        }
    }

    /// Whether a raw message may be sent: [`Vehicle::on_sending`] for each vehicle that it addresses.
    ///
    /// # Errors
    /// As there.
    pub fn on_sending(
        &mut self,
        message: &Message,
        despite_mixed_plan: bool,
        now: MonoTime,
    ) -> Result<(), VehicleError> {
        self.vehicles.range_mut(AT_LINKS).try_for_each(|(system, vehicle)| {
            touch(&mut self.touched, *system);
            vehicle.on_sending(message, despite_mixed_plan, now)
        })
    }

    /// Notes the protocol version of a frame from `source`. Only an autopilot's own frames count: a camera of the same
    /// system may be older.
    pub fn on_protocol_version(&mut self, source: Address, version: MavVersion) {
        if let Some(vehicle) = self.get_mut(source.system)
            && vehicle.address() == source
        {
            vehicle.on_protocol_version(version);
        }
    }

    fn welcome(&mut self, source: Address, now: MonoTime) {
        if !self.make_room(AT_LINKS, MAX_VEHICLES, now) {
            return;
        }
        let mut config = self.config.clone();
        // Sessions of two vehicles do not share numbers, so that a log distinguishes them.
        config.seed = config.seed.wrapping_add(u32::from(source.system.0) * 7);
        self.insert(source.system.into(), source, config, now);
    }

    /// Makes room for one more vehicle within a limit, dropping a lost one if needed; returns whether there is room.
    fn make_room(&mut self, among: RangeInclusive<VehicleId>, most: usize, now: MonoTime) -> bool {
        if self.vehicles.range(among.clone()).count() >= most {
            let is_lost =
                |(id, vehicle): &(&VehicleId, &Vehicle)| !self.replayed.contains(id) && !vehicle.is_heard(now);
            let lost = self.vehicles.range(among).filter(is_lost);
            let Some((system, vehicle)) = lost.min_by_key(|(_, vehicle)| vehicle.heard_at()) else {
                if !self.is_full {
                    self.is_full = true;
                    self.outputs.push_back(RegistryOutput::Event(RegistryEvent::Full));
                }
                return false;
            };
            let (system, address) = (*system, vehicle.address());
            if let Some(mut vehicle) = self.vehicles.remove(&system) {
                vehicle.close(now);
                while let Some(output) = vehicle.poll_output() {
                    self.outputs.push_back(RegistryOutput::Vehicle(system, output));
                }
            }
            self.outputs.push_back(RegistryOutput::Event(RegistryEvent::Dropped(system, address)));
        }
        self.is_full = false;
        true
    }

    /// Adds a remote vehicle, by the address of its autopilot and its name. Its messages are passed to
    /// [`Self::on_hosted`], and nothing is sent to it. `None`: the registry is full.
    pub fn host(&mut self, source: Address, name: &str, now: MonoTime) -> Option<VehicleId> {
        if !self.make_room(FAR, MAX_FAR, now) {
            return None;
        }
        let id = VehicleId::of_name(name).find(|id| !self.vehicles.contains_key(id))?;
        self.insert(id, source, self.silent(), now);
        Some(id)
    }

    /// The configuration of a vehicle to which nothing is sent.
    fn silent(&self) -> VehicleConfig {
        VehicleConfig {
            streams: StreamConfig::listen_only(),
            reads_back: false,
            is_hosted: true,
            keeps_records: false,
            ..self.config.clone()
        }
    }

    /// Begins a hosted vehicle anew, as one of a recording: nothing of it is known, and from now on its time is that of
    /// its messages and of [`Self::on_replay_time`], not that of [`Self::on_time`].
    pub fn begin_replay(&mut self, id: VehicleId, now: MonoTime) {
        let Some(address) = self.vehicles.get(&id).map(Vehicle::address) else { return };
        self.replayed.insert(id);
        self.vehicles.insert(id, Vehicle::new(address, self.our, self.silent(), now));
        touch(&mut self.touched, id);
    }

    /// Advances the time of a vehicle of a recording.
    pub fn on_replay_time(&mut self, id: VehicleId, now: MonoTime) {
        if let Some(vehicle) = self.get_mut(id) {
            vehicle.on_time(now);
        }
    }

    /// Forgets a hosted vehicle.
    pub fn dismiss(&mut self, id: VehicleId) {
        if let Some(vehicle) = self.vehicles.remove(&id) {
            self.replayed.remove(&id);
            self.outputs.push_back(RegistryOutput::Event(RegistryEvent::Dropped(id, vehicle.address())));
        }
    }

    /// The deadline of a vehicle by the station's time.
    fn deadline_of(&self, id: VehicleId) -> Option<MonoTime> {
        self.vehicles.get(&id).filter(|_| !self.replayed.contains(&id))?.deadline()
    }

    /// A message of a hosted vehicle's autopilot.
    pub fn on_hosted(&mut self, id: VehicleId, message: &Message, now: MonoTime) -> Option<Group> {
        let vehicle = self.get_mut(id)?;
        vehicle.on_message(vehicle.address().component, message, now)
    }

    fn insert(&mut self, id: VehicleId, source: Address, config: VehicleConfig, now: MonoTime) {
        self.vehicles.insert(id, Vehicle::new(source, self.our, config, now));
        touch(&mut self.touched, id);
        self.outputs.push_back(RegistryOutput::Event(RegistryEvent::Appeared(id, source)));
    }

    /// Advances time for vehicles whose deadline has passed.
    pub fn on_time(&mut self, now: MonoTime) {
        self.rest_until = None;
        for (system, vehicle) in self.vehicles.iter_mut().filter(|(id, _)| !self.replayed.contains(id)) {
            let deadline = vehicle.deadline();
            if deadline.is_some_and(|deadline| now >= deadline) {
                touch(&mut self.touched, *system);
                vehicle.on_time(now);
            } else {
                self.rest_until = earlier(self.rest_until, deadline);
            }
        }
    }

    /// Latest time for the next [`Self::on_time`]; there may be nothing to do yet.
    pub fn deadline(&self) -> Option<MonoTime> {
        let touched = self.touched.iter().filter_map(|system| self.deadline_of(*system)).min();
        earlier(self.rest_until, touched)
    }

    /// The next thing that the owner must do. Drain it after every call.
    pub fn poll_output(&mut self) -> Option<RegistryOutput> {
        if let Some(output) = self.outputs.pop_front() {
            return Some(output);
        }
        while let Some(system) = self.touched.last().copied() {
            let vehicle = self.vehicles.get_mut(&system);
            if let Some(output) = vehicle.and_then(Vehicle::poll_output) {
                return Some(RegistryOutput::Vehicle(system, output));
            }
            self.touched.pop();
            self.rest_until = earlier(self.rest_until, self.deadline_of(system));
        }
        None
    }
}

fn touch(touched: &mut Vec<VehicleId>, id: VehicleId) {
    if !touched.contains(&id) {
        touched.push(id);
    }
}

fn earlier(one: Option<MonoTime>, other: Option<MonoTime>) -> Option<MonoTime> {
    one.into_iter().chain(other).min()
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use rand::rngs::SmallRng;
    use rand::{Rng, SeedableRng};
    use vencejo_proto::dialect::{ATTITUDE_DATA, RADIO_STATUS_DATA};
    use vencejo_proto::{CommandAck, CommandLong, FrameDecoder, Header, Heartbeat, StatusText};

    use super::*;
    use crate::request::{Request, VehicleEvent};
    use crate::telemetry::LOST_AFTER;
    use vencejo_flight::plan::Command;

    const OUR: Address = Address::new(255, 190);

    fn vehicles() -> Vehicles {
        Vehicles::new(OUR, VehicleConfig::default())
    }

    fn heartbeat(mav_type: u8, autopilot: u8) -> Message {
        Message::Heartbeat(Heartbeat { mav_type, autopilot, mavlink_version: 3, ..Heartbeat::default() })
    }

    fn at(ms: u64) -> MonoTime {
        MonoTime::from_millis(ms)
    }

    fn drain(vehicles: &mut Vehicles) -> Vec<RegistryOutput> {
        std::iter::from_fn(|| vehicles.poll_output()).collect()
    }

    #[test]
    fn autopilots_are_vehicles_and_others_are_not() {
        let mut vehicles = vehicles();
        vehicles.on_message(OUR, &heartbeat(1, 3), at(0));
        vehicles.on_message(Address::new(0, 1), &heartbeat(1, 3), at(0));
        vehicles.on_message(Address::new(254, 190), &heartbeat(6, 8), at(0));
        vehicles.on_message(Address::new(2, 191), &heartbeat(18, 8), at(0));
        vehicles.on_message(Address::new(3, 154), &heartbeat(26, 8), at(0));
        let attitude = Message::Dialect(MavMessage::ATTITUDE(ATTITUDE_DATA::default()));
        vehicles.on_message(Address::new(4, 1), &attitude, at(0));
        assert!(vehicles.is_empty() && drain(&mut vehicles).is_empty());
        vehicles.on_message(Address::new(7, 1), &heartbeat(1, 3), at(0));
        assert_eq!(vehicles.len(), 1);
        let appeared = RegistryOutput::Event(RegistryEvent::Appeared(SystemId(7).into(), Address::new(7, 1)));
        assert_eq!(drain(&mut vehicles)[0], appeared);
    }

    #[test]
    fn each_message_reaches_its_vehicle() {
        let mut vehicles = vehicles();
        for system in [1, 2] {
            vehicles.on_message(Address::new(system, 1), &heartbeat(1, 3), at(0));
        }
        drain(&mut vehicles);
        let attitude =
            |roll| Message::Dialect(MavMessage::ATTITUDE(ATTITUDE_DATA { roll, ..ATTITUDE_DATA::default() }));
        let changed = vehicles.on_message(Address::new(1, 1), &attitude(0.5), at(1));
        assert_eq!(changed, Some((SystemId(1).into(), Group::Attitude)));
        // A gimbal on board has an attitude of its own.
        assert_eq!(vehicles.on_message(Address::new(1, 154), &attitude(1.5), at(1)), None);
        let roll = |vehicles: &Vehicles, system| {
            vehicles.get(SystemId(system)).and_then(|v| v.telemetry().attitude).and_then(|a| a.value.roll_rad)
        };
        assert_eq!((roll(&vehicles, 1), roll(&vehicles, 2)), (Some(0.5), None));
        let text = Message::StatusText(StatusText { severity: 6, text: "hello".into(), id: 0, chunk_seq: 0 });
        vehicles.on_message(Address::new(2, 154), &text, at(2));
        assert_eq!(vehicles.get(SystemId(2)).expect("vehicle").texts().total(), 1);
        assert_eq!(vehicles.get(SystemId(1)).expect("vehicle").texts().total(), 0);
        // The radio reports for the vehicles on its link.
        let radio = RADIO_STATUS_DATA { rssi: 180, ..RADIO_STATUS_DATA::default() };
        let radio = Message::Dialect(MavMessage::RADIO_STATUS(radio));
        assert!(vehicles.is_radio(Address::new(51, 68), &radio) && !vehicles.is_radio(Address::new(1, 68), &radio));
        vehicles.on_radio([SystemId(2).into()], &radio, at(3));
        let has_radio = |system| vehicles.get(SystemId(system)).expect("vehicle").telemetry().radio.is_some();
        assert_eq!((has_radio(1), has_radio(2)), (false, true));
        assert_eq!(vehicles.len(), 2);
    }

    #[test]
    fn nobodys_deadline_is_missed() {
        let mut vehicles = vehicles();
        for ms in (0..20_000).step_by(50) {
            let now = at(ms);
            if ms % 500 == 0 {
                vehicles.on_message(Address::new((ms / 500 % 5 + 1) as u8, 1), &heartbeat(1, 3), now);
            }
            if ms == 5000 {
                vehicles.get_mut(SystemId(3)).expect("vehicle").request(Request::ParamList, now);
            }
            let earliest = |vehicles: &Vehicles| vehicles.iter().filter_map(|(_, vehicle)| vehicle.deadline()).min();
            assert!(vehicles.deadline().expect("one") <= earliest(&vehicles).expect("one"), "at {ms} ms");
            drain(&mut vehicles);
            assert!(vehicles.deadline().expect("one") <= earliest(&vehicles).expect("one"), "drained at {ms} ms");
            vehicles.on_time(now);
            drain(&mut vehicles);
            assert_eq!(vehicles.deadline(), earliest(&vehicles), "at {ms} ms");
        }
    }

    #[test]
    fn an_answer_of_one_vehicle_is_not_taken_for_anothers() {
        let mut vehicles = vehicles();
        for system in [1, 2] {
            vehicles.on_message(Address::new(system, 1), &heartbeat(1, 3), at(0));
        }
        drain(&mut vehicles);
        let vehicle = vehicles.get_mut(SystemId(1)).expect("vehicle");
        let go_around = CommandLong {
            target: Address::new(0, 0),
            command: Command::DO_GO_AROUND.0,
            confirmation: 0,
            params: [0.0; 7],
        };
        vehicle.request(Request::RawCommandLong(go_around), at(0));
        let ack = Message::CommandAck(CommandAck {
            command: Command::DO_GO_AROUND.0,
            result: 0,
            progress: 0,
            result_param2: 0,
            target: OUR,
        });
        let ended = |outputs: Vec<RegistryOutput>| {
            outputs
                .into_iter()
                .filter(|output| matches!(output, RegistryOutput::Vehicle(id, Output::Finished { .. }) if *id == SystemId(1).into()))
                .count()
        };
        vehicles.on_message(Address::new(2, 1), &ack, at(1));
        assert_eq!(ended(drain(&mut vehicles)), 0);
        vehicles.on_message(Address::new(1, 1), &ack, at(1));
        assert_eq!(ended(drain(&mut vehicles)), 1);
    }

    // fault 25: 40 floods of 759 ids: ≤ 64 vehicles, told once, the heard one stays
    #[test]
    fn a_flood_of_ids_displaces_nobody_who_is_heard() {
        let mut vehicles = vehicles();
        let mut full = 0;
        for round in 0..40u64 {
            vehicles.on_message(Address::new(1, 1), &heartbeat(1, 3), at(round * 1_000));
            for system in 2..=254 {
                for component in [1, 2, 99] {
                    vehicles.on_message(Address::new(system, component), &heartbeat(1, 3), at(round * 1_000 + 1));
                    assert!(vehicles.len() <= MAX_VEHICLES);
                }
            }
            let outputs = drain(&mut vehicles);
            full += outputs.iter().filter(|output| **output == RegistryOutput::Event(RegistryEvent::Full)).count();
        }
        assert_eq!(full, 1, "told once");
        assert!(vehicles.get(SystemId(1)).is_some());
        // The flood is over: lost vehicles make room, and their requests end.
        let lost = vehicles.iter().map(|(system, _)| system).find(|id| id.number() != 1).expect("another");
        let now = at(60_000);
        vehicles.on_message(Address::new(1, 1), &heartbeat(1, 3), now);
        for (system, _) in vehicles.iter().map(|(system, vehicle)| (system, vehicle.heard_at())).collect::<Vec<_>>() {
            vehicles.get_mut(system).expect("vehicle").request(Request::ParamList, now);
        }
        drain(&mut vehicles);
        vehicles.on_message(Address::new(200, 1), &heartbeat(1, 3), now + Duration::from_millis(1));
        assert!(vehicles.get(SystemId(200)).is_some() && vehicles.get(SystemId(1)).is_some());
        let outputs = drain(&mut vehicles);
        assert!(outputs.iter().any(|output| matches!(output, RegistryOutput::Event(RegistryEvent::Dropped(..)))));
        assert!(outputs.iter().any(|output| matches!(output, RegistryOutput::Vehicle(_, Output::Finished { .. }))));
        assert!(vehicles.get(lost).is_none() || vehicles.len() == MAX_VEHICLES);
    }

    #[test]
    fn of_one_far_away_nothing_is_asked_and_no_time_is_wanted_until_it_is_silent() {
        let mut vehicles = vehicles();
        let id = vehicles.host(Address::new(1, 1), "plane7", at(0)).expect("there is room");
        drain(&mut vehicles);
        for second in 1..=30 {
            let now = at(second * 1_000);
            vehicles.on_hosted(id, &heartbeat(1, 3), now);
            let asked = drain(&mut vehicles).into_iter().filter(|output| {
                matches!(output, RegistryOutput::Vehicle(_, Output::Send(_) | Output::Event(VehicleEvent::Unreached)))
            });
            assert_eq!(asked.count(), 0);
            let wanted = vehicles.get(id).and_then(Vehicle::deadline).expect("its silence is looked for");
            // Once it is looked who it is, five seconds after it came.
            assert!(wanted.since(now) >= LOST_AFTER || second <= 5, "{wanted:?} at {now:?}");
            while let Some(wanted) = vehicles.deadline().filter(|wanted| *wanted < now + Duration::from_secs(1)) {
                vehicles.on_time(wanted);
                drain(&mut vehicles);
            }
        }
        assert_eq!(
            vehicles.get(id).and_then(|plane| plane.is_reached(at(30_000))),
            None,
            "a station on board knows that"
        );
    }

    #[test]
    fn one_of_a_recording_has_a_time_of_its_own_and_begins_anew_at_each_place() {
        let mut vehicles = vehicles();
        let id = vehicles.host(Address::new(1, 1), "flight", at(0)).expect("there is room");
        vehicles.begin_replay(id, at(500_000));
        vehicles.on_hosted(id, &heartbeat(1, 3), at(500_000));
        let lost = |vehicles: &mut Vehicles| {
            let is_lost = |output: &RegistryOutput| {
                matches!(output, RegistryOutput::Vehicle(_, Output::Event(VehicleEvent::Lost)))
            };
            drain(vehicles).iter().any(is_lost)
        };
        assert_eq!((lost(&mut vehicles), vehicles.deadline()), (false, None), "the station's time is none of it");
        vehicles.on_time(at(900_000));
        assert!(!lost(&mut vehicles));
        vehicles.on_replay_time(id, at(506_000));
        assert!(lost(&mut vehicles), "it was silent for six seconds of the recording");
        vehicles.begin_replay(id, at(100_000));
        assert!(
            vehicles
                .get(id)
                .is_some_and(|plane| plane.telemetry().heartbeat.is_none() && plane.heard_at() == at(100_000))
        );
        vehicles.dismiss(id);
        let dropped = RegistryOutput::Event(RegistryEvent::Dropped(id, Address::new(1, 1)));
        assert!(drain(&mut vehicles).contains(&dropped) && vehicles.get(id).is_none());
    }

    #[test]
    fn those_far_away_have_room_and_numbers_of_their_own() {
        let mut vehicles = vehicles();
        let (own, now) = (Address::new(1, 1), at(0));
        let far: Vec<_> =
            (0..MAX_FAR).map(|n| vehicles.host(own, &format!("plane{n}"), now).expect("there is room")).collect();
        assert_eq!(vehicles.host(own, "one-more", now), None, "none of them is lost yet");
        for system in 1..=100 {
            vehicles.on_message(Address::new(system, 1), &heartbeat(1, 3), now);
        }
        drain(&mut vehicles);
        assert_eq!(vehicles.len(), MAX_FAR + MAX_VEHICLES, "a flood of ids takes no place of theirs");
        assert!(far.iter().all(|id| id.is_far() && vehicles.get(*id).is_some()));
        // Messages from a link belong to vehicles at links, whatever system id a remote plane has.
        let attitude = Message::Dialect(MavMessage::ATTITUDE(ATTITUDE_DATA { roll: 1.0, ..ATTITUDE_DATA::default() }));
        assert_eq!(vehicles.on_message(own, &attitude, now), Some((SystemId(1).into(), Group::Attitude)));
        let radio = RADIO_STATUS_DATA { rssi: 180, ..RADIO_STATUS_DATA::default() };
        vehicles.on_message(Address::new(200, 68), &Message::Dialect(MavMessage::RADIO_STATUS(radio)), now);
        let telemetry = |id: VehicleId| *vehicles.get(id).expect("hosted").telemetry();
        assert!(far.iter().all(|id| telemetry(*id).attitude.is_none() && telemetry(*id).radio.is_none()));
        assert_eq!(vehicles.on_hosted(far[3], &attitude, now), Some(Group::Attitude));
        assert!(vehicles.get(far[3]).is_some_and(|plane| plane.telemetry().attitude.is_some()));
        drain(&mut vehicles);
        // Heard once and silent since: it is replaced.
        let late = at(60_000);
        for id in &far[1..] {
            vehicles.on_hosted(*id, &heartbeat(1, 3), late);
        }
        drain(&mut vehicles);
        assert!(vehicles.host(own, "one-more", late).is_some_and(|_| vehicles.get(far[0]).is_none()));
    }

    // fault 23 (1 seed): 100,000 messages from other ids, id 0 and our own echo: 0 changes of state, 0 vehicles more, 0
    // answers
    #[test]
    fn messages_of_other_ids_and_our_own_echo_change_nothing() {
        let mut vehicles = vehicles();
        vehicles.on_message(Address::new(1, 1), &heartbeat(1, 3), at(0));
        drain(&mut vehicles);
        let before = *vehicles.get(SystemId(1)).expect("vehicle").telemetry();
        let mut rng = SmallRng::seed_from_u64(23);
        let strangers = [OUR, Address::new(0, 0), Address::new(0, 1), Address::new(2, 1), Address::new(254, 190)];
        let strangers = [&strangers[..], &[Address::new(1, 0), Address::new(1, 154), Address::new(1, 191)]].concat();
        for n in 0..100_000_u32 {
            let from = strangers[rng.random_range(0..strangers.len())];
            let ack = CommandAck { command: 400, result: 0, progress: 0, result_param2: 0, target: OUR };
            let message = match n % 6 {
                // Our own heartbeat echoed, and those of components that are not autopilots.
                0 if from == OUR => Message::Heartbeat(Heartbeat::default()),
                0 => heartbeat(if from.component.0 == 154 { 26 } else { 6 }, 8),
                1 => Message::Dialect(MavMessage::ATTITUDE(ATTITUDE_DATA { roll: 1.0, ..ATTITUDE_DATA::default() })),
                2 => Message::CommandAck(ack),
                3 => Message::CommandLong(CommandLong { target: OUR, command: 400, confirmation: 0, params: [1.0; 7] }),
                4 => Message::MissionAck(vencejo_proto::MissionAck {
                    target: OUR,
                    result: 0,
                    mission_type: 0,
                    opaque_id: 0,
                }),
                _ => Message::Dialect(MavMessage::SYSTEM_TIME(vencejo_proto::dialect::SYSTEM_TIME_DATA {
                    time_unix_usec: u64::from(n),
                    time_boot_ms: n,
                })),
            };
            vehicles.on_message(from, &message, at(1));
            assert!(drain(&mut vehicles).is_empty(), "{from}: {message:?}");
        }
        assert_eq!(vehicles.len(), 1);
        assert_eq!(*vehicles.get(SystemId(1)).expect("vehicle").telemetry(), before);
    }

    #[test]
    fn noise_changes_nothing() {
        let mut vehicles = vehicles();
        vehicles.on_message(Address::new(1, 1), &heartbeat(1, 3), at(0));
        drain(&mut vehicles);
        let before = *vehicles.get(SystemId(1)).expect("vehicle").telemetry();
        let mut rng = SmallRng::seed_from_u64(3);
        let mut decoder = FrameDecoder::new();
        for _ in 0..100_000 {
            // A frame that is whole but for one byte.
            let message =
                Message::Dialect(MavMessage::ATTITUDE(ATTITUDE_DATA { roll: 1.0, ..ATTITUDE_DATA::default() }));
            let frame = message.encode(Header { sequence: 0, source: Address::new(1, 1), version: MavVersion::V2 });
            let mut bytes = frame.bytes().to_vec();
            let place = rng.random_range(1..bytes.len());
            bytes[place] ^= rng.random_range(1..=255u8);
            decoder.push(&bytes);
            while let Some(frame) = decoder.next_frame() {
                if let Ok(message) = frame.decode() {
                    vehicles.on_message(frame.source(), &message, at(1));
                }
            }
        }
        assert!(decoder.stats().bad_crc > 50_000, "{:?}", decoder.stats());
        assert_eq!(vehicles.len(), 1);
        assert_eq!(*vehicles.get(SystemId(1)).expect("vehicle").telemetry(), before);
    }
}
