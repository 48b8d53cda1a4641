//! Owns the hub of all links: it counts, routes, forwards and records every frame and calls the listeners, in the task
//! that read it.

use std::collections::HashMap;
use std::fmt;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use smallvec::SmallVec;
use tokio::sync::watch;
use vencejo_proto::{
    Address, ComponentId, Frame, Header, MavVersion, Message, MonoTime, SigningKey, SigningTime, SystemId,
};

use crate::address::LinkAddress;
use crate::clock::Clock;
use crate::onward::Onward;
use crate::outlet::{Outlet, Peer, PeerId, To};
use crate::port::{LinkId, LinkOptions, LinkState, Port};
use crate::recorder::RecorderHandle;
use crate::router::{MAX_LINKS, Router, SETUP_SIGNING_ID, Slot, SlotSet, Verdict};
use crate::signing::{Admission, KeyId, SigningState, SigningTable, VehicleKeys};
use crate::stats::{LinkMeter, LinkStats, PortCounters};

/// Where a frame came from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Origin {
    /// The link.
    pub link: LinkId,
    /// The peer at its other end.
    pub peer: PeerId,
}

/// Where a frame of our own goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Route {
    /// By the message's target: to all links when it is a broadcast, otherwise to one link on which the target was
    /// heard. That link is kept while the target is heard on it; then the one on which it was heard last takes over.
    Target,
    /// To this system as if the message named it, for messages without a target field.
    System(SystemId),
    /// To this link only.
    Link(LinkId),
    /// To this peer of a link only; nowhere when it is gone.
    Peer(Origin),
    /// To all links.
    All,
}

/// The outcome of sending a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[must_use = "a command that went nowhere must fail loudly"]
pub struct SendReport {
    /// Links that took it.
    pub accepted: u32,
    /// Links that could not take it: not connected, or the queue is full.
    pub refused: u32,
}

impl SendReport {
    /// Whether at least one link took it.
    pub fn is_sent(self) -> bool {
        self.accepted > 0
    }
}

/// Which received frames a listener wants.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SinkScope {
    /// Every frame of every link, also those addressed to others. Copies (loops, redundant links) are delivered once.
    All,
    /// Broadcasts and frames addressed to one of our own addresses.
    ForUs,
}

/// A listener. Called in the task that read the frame: it must be quick and must not block. It may call the hub.
pub type FrameSink = Arc<dyn Fn(Origin, &Frame, MonoTime) + Send + Sync>;

/// Called in a link's task each time the link has opened and takes frames; quick, like a [`FrameSink`].
pub type OpenSink = Arc<dyn Fn(LinkId) + Send + Sync>;

/// Called in the reading task after all frames of one reading of a link have gone to the sinks.
pub type ReadSink = Arc<dyn Fn() + Send + Sync>;

/// One open link, as a list of links shows it.
#[derive(Debug, Clone)]
pub struct LinkInfo {
    /// Its id.
    pub id: LinkId,
    /// Its name.
    pub name: String,
    /// Its link string.
    pub address: LinkAddress,
    /// Whether it is a tee.
    pub forwards: bool,
    /// Whether unsigned frames are accepted over it.
    pub accepts_unsigned: bool,
    /// Its state.
    pub state: LinkState,
}

/// Why a link could not be opened. Conditions that may pass (no such device, no route) are not errors: the link is
/// opened and keeps trying.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LinkError {
    /// [`MAX_LINKS`] are open.
    #[error("{MAX_LINKS} links are open already; close one first")]
    TooManyLinks,
    /// There is no such link, or it was closed.
    #[error("{0} is not open; `links()` lists those that are")]
    UnknownLink(LinkId),
}

struct OpenLink {
    port: Arc<Port>,
    meter: LinkMeter,
    /// The number of the next frame that [`Hub::send_message`] writes for this link.
    next_sequence: u8,
}

type Sinks = Vec<(SinkScope, FrameSink)>;

struct Inner {
    links: Vec<Option<OpenLink>>,
    router: Router,
    signing: SigningTable,
    sinks: Arc<Sinks>,
    on_open: Option<OpenSink>,
    on_read: Option<ReadSink>,
    recorder: Option<RecorderHandle>,
    next_id: u32,
    /// The origin to which everything addressed to a component goes, whoever else uses its address.
    chosen: HashMap<Address, Origin>,
}

impl Inner {
    /// The link and peer chosen for the target of a frame.
    fn chosen_for(&self, frame: &Frame) -> Option<(Slot, PeerId)> {
        let target = frame.target();
        self.chosen_of(target.named_system()?, target.named_component())
    }

    /// The same for a system, or one of its components.
    fn chosen_of(&self, system: SystemId, component: Option<ComponentId>) -> Option<(Slot, PeerId)> {
        let is_it = |address: &Address| address.system == system && component.is_none_or(|it| it == address.component);
        let origin = self.chosen.iter().find(|(address, _)| is_it(address)).map(|(_, origin)| *origin)?;
        let link = self.find(origin.link).ok()?;
        Some((link.port.slot, origin.peer))
    }

    fn open_slots(&self) -> SlotSet {
        self.slots_where(|_| true)
    }

    fn slots_where(&self, is_it: impl Fn(&Port) -> bool) -> SlotSet {
        self.links.iter().flatten().map(|link| &link.port).filter(|port| is_it(port)).map(|port| port.slot).collect()
    }

    /// The links that get a frame of a recording: all tees, which are shown both sides of the recorded conversation.
    /// Nothing is forwarded to a system that is heard live: a recorded command would fly it.
    fn viewers_of_replay(&self, frame: &Frame) -> SlotSet {
        let tees = self.slots_where(|port| port.forwards && !port.is_replay());
        let Some(target) = frame.target().system else { return tees };
        let live = self.router.slots_of(target).without(self.slots_where(Port::is_replay));
        match target {
            SystemId::BROADCAST => tees.without(live),
            _ if live.is_empty() => tees,
            _ => SlotSet::EMPTY,
        }
    }

    fn link(&self, slot: Slot) -> Option<&OpenLink> {
        self.links.get(usize::from(slot))?.as_ref()
    }

    fn find(&self, id: LinkId) -> Result<&OpenLink, LinkError> {
        self.links.iter().flatten().find(|link| link.port.id == id).ok_or(LinkError::UnknownLink(id))
    }

    fn find_mut(&mut self, id: LinkId) -> Result<&mut OpenLink, LinkError> {
        self.links.iter_mut().flatten().find(|link| link.port.id == id).ok_or(LinkError::UnknownLink(id))
    }
}

struct Shared {
    inner: Mutex<Inner>,
    clock: Arc<dyn Clock>,
}

/// The hub of all links. Clones are handles of the same hub.
#[derive(Clone)]
pub struct Hub {
    shared: Arc<Shared>,
}

impl Hub {
    /// A hub without links. `locals` are our own addresses (on the ground usually 255/190).
    pub fn new(locals: Vec<Address>, clock: Arc<dyn Clock>) -> Self {
        let inner = Inner {
            links: Vec::new(),
            router: Router::new(locals),
            signing: SigningTable::default(),
            sinks: Arc::new(Vec::new()),
            on_open: None,
            on_read: None,
            recorder: None,
            next_id: 1,
            chosen: HashMap::new(),
        };
        Self { shared: Arc::new(Shared { inner: Mutex::new(inner), clock }) }
    }

    fn inner(&self) -> MutexGuard<'_, Inner> {
        self.shared.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The hub's clock.
    pub fn clock(&self) -> &Arc<dyn Clock> {
        &self.shared.clock
    }

    /// Adds a link.
    pub(crate) fn attach(
        &self,
        address: LinkAddress,
        options: LinkOptions,
        outlet: Arc<dyn Outlet>,
        state: watch::Receiver<LinkState>,
    ) -> Result<Arc<Port>, LinkError> {
        let mut inner = self.inner();
        let free = inner.links.iter().position(Option::is_none);
        let slot = match free {
            Some(slot) => slot,
            None if inner.links.len() < MAX_LINKS => {
                inner.links.push(None);
                inner.links.len() - 1
            }
            None => return Err(LinkError::TooManyLinks),
        };
        let id = LinkId(inner.next_id);
        inner.next_id += 1;
        let believed = AtomicBool::new(options.unsigned.believes(&address));
        let port = Arc::new(Port {
            id,
            slot: slot as Slot,
            name: options.name.unwrap_or_else(|| address.to_string()),
            address,
            forwards: options.forwards,
            unsigned: options.unsigned,
            believed,
            outlet,
            state,
            counters: PortCounters::default(),
        });
        inner.links[slot] = Some(OpenLink { port: port.clone(), meter: LinkMeter::new(), next_sequence: 0 });
        Ok(port)
    }

    /// Removes a link and the routes over it.
    pub(crate) fn detach(&self, port: &Port) {
        let mut inner = self.inner();
        inner.links[usize::from(port.slot)] = None;
        inner.router.forget(port.slot);
        inner.signing.forget_link(port.slot);
    }

    /// Adds a listener.
    pub fn add_sink(&self, scope: SinkScope, sink: FrameSink) {
        let mut inner = self.inner();
        let mut sinks = inner.sinks.as_ref().clone();
        sinks.push((scope, sink));
        inner.sinks = Arc::new(sinks);
    }

    /// Sets the callback for openings of links.
    pub fn set_on_open(&self, on_open: OpenSink) {
        self.inner().on_open = Some(on_open);
    }

    /// Sets the callback for the end of a reading of a link.
    pub fn set_on_read(&self, on_read: ReadSink) {
        self.inner().on_read = Some(on_read);
    }

    /// Sets the recorder, or stops recording.
    pub fn set_recorder(&self, recorder: Option<RecorderHandle>) {
        self.inner().recorder = recorder;
    }

    /// Sets our own addresses.
    pub fn set_locals(&self, locals: Vec<Address>) {
        self.inner().router.set_locals(locals);
    }

    /// Our own addresses.
    pub fn locals(&self) -> Vec<Address> {
        self.inner().router.locals().to_vec()
    }

    /// Sends everything addressed to a component to one origin, whoever else uses its address; `None`: by the routing
    /// rules. An origin whose link is closed is ignored.
    pub fn choose(&self, address: Address, origin: Option<Origin>) {
        let mut inner = self.inner();
        match origin {
            Some(origin) => inner.chosen.insert(address, origin),
            None => inner.chosen.remove(&address),
        };
    }

    /// Adds a key; `resumed` is the latest time at which it may have been used before.
    pub fn add_signing_key(&self, id: KeyId, key: SigningKey, resumed: SigningTime) {
        self.inner().signing.add_key(id, key, resumed);
    }

    /// Sets a vehicle's keys. A key that no vehicle has is forgotten.
    pub fn set_vehicle_keys(&self, system: SystemId, keys: VehicleKeys) {
        self.inner().signing.set_vehicle(system, keys);
    }

    /// How a vehicle signs; `None` when it has no key.
    pub fn signing(&self, system: SystemId) -> Option<SigningState> {
        self.inner().signing.vehicle(system).cloned()
    }

    /// The vehicles that have keys.
    pub fn signing_vehicles(&self) -> Vec<(SystemId, SigningState)> {
        self.inner().signing.vehicles().map(|(system, state)| (system, state.clone())).collect()
    }

    /// For each key the latest time used with it, and the time to store on disk: see [`KeyUse`](vencejo_proto::KeyUse).
    pub fn signing_times(&self) -> Vec<(KeyId, SigningTime, SigningTime)> {
        let unix_us = self.shared.clock.unix_us();
        self.inner().signing.reserve(unix_us)
    }

    /// The initial time stamp of a new key.
    pub fn next_signing_time(&self, id: KeyId) -> Option<SigningTime> {
        let unix_us = self.shared.clock.unix_us();
        self.inner().signing.next_time(id, unix_us)
    }

    /// Sends a frame as it is. Never waits: frames that do not fit are refused and reported.
    pub fn send(&self, frame: &Frame, route: Route) -> SendReport {
        let now = self.shared.clock.now();
        let (ports, recorder) = {
            let mut inner = self.inner();
            let ports = own_ports(&mut inner, frame, route, now);
            if !ports.0.is_empty() {
                inner.router.on_sent(frame, now);
            }
            (ports, inner.recorder.clone())
        };
        send_to(&ports.0, ports.1, frame, recorder.as_ref(), now)
    }

    /// Encodes a message with each link's own frame counter, so that receivers see no false loss, signs it where
    /// signing is required, and sends it. Never waits.
    pub fn send_message(&self, message: &Message, source: Address, version: MavVersion, route: Route) -> SendReport {
        let now = self.shared.clock.now();
        let unnumbered = message.encode(Header { sequence: 0, source, version });
        let mut outgoing: SmallVec<[(Arc<Port>, Frame); 4]> = SmallVec::new();
        let (recorder, to) = {
            let mut inner = self.inner();
            if !inner.signing.is_empty() {
                return self.send_signed(&mut inner, message, &unnumbered, route, now);
            }
            let (ports, to) = own_ports(&mut inner, &unnumbered, route, now);
            for port in ports {
                let Some(link) = inner.links[usize::from(port.slot)].as_mut() else { continue };
                let sequence = link.next_sequence;
                link.next_sequence = sequence.wrapping_add(1);
                let frame = if sequence == 0 {
                    unnumbered.clone()
                } else {
                    message.encode(Header { sequence, source, version })
                };
                inner.router.on_sent(&frame, now);
                outgoing.push((port, frame));
            }
            (inner.recorder.clone(), to)
        };
        let mut report = SendReport::default();
        for (port, frame) in outgoing {
            let one = send_to(&[port], to, &frame, recorder.as_ref(), now);
            report.accepted += one.accepted;
            report.refused += one.refused;
        }
        report
    }

    /// Signs and sends under the lock: a signed frame that overtakes another one makes receivers drop the other as
    /// replayed.
    fn send_signed(
        &self,
        inner: &mut Inner,
        message: &Message,
        unnumbered: &Frame,
        route: Route,
        now: MonoTime,
    ) -> SendReport {
        let unix_us = self.shared.clock.unix_us();
        let (source, version, target) = (unnumbered.source(), unnumbered.version(), unnumbered.target().named_system());
        let recorder = inner.recorder.clone();
        let mut report = SendReport::default();
        let (ports, to) = own_ports(inner, unnumbered, route, now);
        for port in ports {
            let write = |inner: &mut Inner, version: MavVersion, key: Option<KeyId>| {
                let Some(link) = inner.links[usize::from(port.slot)].as_mut() else { return false };
                let frame = message.encode(Header { sequence: link.next_sequence, source, version });
                link.next_sequence = link.next_sequence.wrapping_add(1);
                let frame = match key {
                    // A frame that cannot be signed is sent unsigned: receivers that require a signature drop it.
                    Some(key) => inner.signing.sign(key, &frame, port.slot, unix_us).unwrap_or(frame),
                    None => frame,
                };
                inner.router.on_sent(&frame, now);
                let one = send_to(std::slice::from_ref(&port), to, &frame, recorder.as_ref(), now);
                one.is_sent()
            };
            let keys = inner.signing.keys_for(target, port.slot);
            let mut sent = false;
            for key in &keys {
                sent |= write(inner, MavVersion::V2, Some(*key));
            }
            // Unsigned besides, for MAVLink 1 receivers.
            if keys.is_empty() || (target.is_none() && version == MavVersion::V1) {
                sent |= write(inner, version, None);
            }
            report.accepted += u32::from(sent);
            report.refused += u32::from(!sent);
        }
        report
    }

    /// The links on which a system was heard and when, best first: the first is the one that [`Route::Target`] takes.
    pub fn links_of(&self, system: SystemId) -> Vec<(LinkId, MonoTime)> {
        let now = self.shared.clock.now();
        let mut inner = self.inner();
        let mut links = inner.router.links_of(system, now);
        if let Some((chosen, _)) = inner.chosen_of(system, None) {
            links.sort_by_key(|(slot, _)| *slot != chosen);
        }
        links.into_iter().filter_map(|(slot, heard)| Some((inner.link(slot)?.port.id, heard))).collect()
    }

    /// An origin as text: the link, and the peer's address where the link has several peers.
    pub fn describe(&self, origin: Origin) -> String {
        let inner = self.inner();
        let Ok(link) = inner.find(origin.link) else { return origin.link.to_string() };
        let port = &link.port;
        port.outlet
            .address(origin.peer)
            .map_or_else(|| port.name.clone(), |address| format!("{address} on {}", port.name))
    }

    /// Whether a frame with our own address is an echo of one that we sent; otherwise another station uses our address.
    pub fn is_ours(&self, frame: &Frame) -> bool {
        let now = self.shared.clock.now();
        self.inner().router.is_ours(frame, now)
    }

    /// Whether a link plays a recording.
    pub fn is_replay(&self, id: LinkId) -> bool {
        self.inner().find(id).is_ok_and(|link| link.port.is_replay())
    }

    /// All open links, in the order they were opened.
    pub fn links(&self) -> Vec<LinkInfo> {
        let mut links: Vec<_> = self
            .inner()
            .links
            .iter()
            .flatten()
            .map(|link| {
                let port = &link.port;
                LinkInfo {
                    id: port.id,
                    name: port.name.clone(),
                    address: port.address.clone(),
                    forwards: port.forwards,
                    accepts_unsigned: port.is_believed(),
                    state: port.state.borrow().clone(),
                }
            })
            .collect();
        links.sort_by_key(|link| link.id);
        links
    }

    /// The statistics of a link.
    ///
    /// # Errors
    /// [`LinkError::UnknownLink`] when it is closed.
    pub fn stats(&self, id: LinkId) -> Result<LinkStats, LinkError> {
        let now = self.shared.clock.now();
        let inner = self.inner();
        let link = inner.find(id)?;
        Ok(link.meter.snapshot(&link.port.counters, now))
    }

    /// Records a round-trip time measured on this link (by TIMESYNC).
    ///
    /// # Errors
    /// [`LinkError::UnknownLink`] when it is closed.
    pub fn note_round_trip(&self, id: LinkId, round_trip: Duration) -> Result<(), LinkError> {
        let now = self.shared.clock.now();
        self.inner().find_mut(id)?.meter.on_round_trip(round_trip, now);
        Ok(())
    }

    /// A link has connected or reconnected.
    pub(crate) fn on_connected(&self, port: &Port) {
        port.look_at_address();
        if let Some(link) = self.inner().links[usize::from(port.slot)].as_mut() {
            link.meter.on_connected();
        }
    }

    /// A link takes frames.
    pub(crate) fn on_open(&self, port: &Port) {
        // Called without the lock: the listener sends.
        let on_open = self.inner().on_open.clone();
        if let Some(on_open) = on_open {
            on_open(port.id);
        }
    }

    /// Processes a frame that a link's task has read. It is forwarded at [`Self::end_reading`] at the latest.
    pub(crate) fn receive(&self, port: &Port, peer: Peer<'_>, frame: &Frame, now: MonoTime, onward: &mut Onward) {
        let known = frame.is_known();
        let mut to = To::target_of(frame);
        let (verdict, ports, sinks, recorder) = {
            let mut inner = self.inner();
            let all = SlotSet(mask(inner.links.len()));
            let Some(link) = inner.links.get_mut(usize::from(port.slot)).and_then(Option::as_mut) else { return };
            if link.port.id != port.id {
                return;
            }
            // Carries a secret key: not even listeners get it.
            if frame.message_id() == SETUP_SIGNING_ID {
                return link.meter.on_refused();
            }
            // A signature is valid once. What was admitted and comes over a second link is a copy, not a replay attack.
            let is_copy = !inner.signing.is_empty() && frame.is_signed() && inner.router.is_copy(port.slot, frame, now);
            let admission = if inner.signing.is_empty() || port.is_replay() || is_copy {
                Admission::Unverified
            } else {
                let unix_us = self.shared.clock.unix_us();
                inner.signing.admit(frame, port.slot, port.is_believed(), unix_us, now)
            };
            let Some(link) = inner.links.get_mut(usize::from(port.slot)).and_then(Option::as_mut) else { return };
            if admission == Admission::Refused {
                return link.meter.on_refused();
            }
            link.meter.on_frame(peer.id, frame, known, now);
            if let Some(systems) = peer.systems.filter(|_| known) {
                systems.insert(frame.source().system);
            }
            let verdict = if is_copy {
                inner.router.on_copy(port.slot, frame, known, now)
            } else {
                inner.router.on_received(port.slot, frame, known, all, now)
            };
            let mut ports: SmallVec<[Arc<Port>; 8]> = SmallVec::new();
            match verdict {
                Verdict::Handle { forward, .. } => {
                    let forward = match inner.chosen_for(frame) {
                        _ if port.is_replay() => inner.viewers_of_replay(frame),
                        Some((slot, peer)) if slot != port.slot && !forward.is_empty() => {
                            to.peer = Some(peer);
                            SlotSet::one(slot)
                        }
                        _ => forward,
                    };
                    // Links whose far end requires signatures do not get what came in unverified.
                    let guarded = if admission == Admission::Verified || port.is_believed() || port.is_replay() {
                        SlotSet::EMPTY
                    } else {
                        inner.signing.guarded()
                    };
                    let forward = forward.without(guarded);
                    let ready = forward.iter().filter_map(|slot| inner.link(slot)).map(|link| &link.port);
                    ports.extend(ready.filter(|other| other.forwards || port.forwards).cloned());
                }
                Verdict::Copy => {
                    if let Some(link) = inner.links[usize::from(port.slot)].as_mut() {
                        link.meter.on_copy();
                    }
                }
            }
            (verdict, ports, inner.sinks.clone(), inner.recorder.clone())
        };
        if let Some(recorder) = &recorder {
            recorder.record(port.id, frame, now);
        }
        let Verdict::Handle { for_us, .. } = verdict else { return };
        for (scope, sink) in sinks.iter() {
            if for_us || *scope == SinkScope::All {
                sink(Origin { link: port.id, peer: peer.id }, frame, now);
            }
        }
        onward.add(frame, to, ports);
    }

    /// Ends one reading of a link: forwards what it brought.
    pub(crate) fn end_reading(&self, onward: &mut Onward) {
        onward.send();
        // Called without the lock: the listener may send.
        let on_read = self.inner().on_read.clone();
        if let Some(on_read) = on_read {
            on_read();
        }
    }
}

impl fmt::Debug for Hub {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Hub").field("links", &self.links()).finish_non_exhaustive()
    }
}

/// The lowest `count` slots.
fn mask(count: usize) -> u64 {
    if count >= 64 { u64::MAX } else { (1 << count) - 1 }
}

fn own_ports(inner: &mut Inner, frame: &Frame, route: Route, now: MonoTime) -> (SmallVec<[Arc<Port>; 4]>, To) {
    let all = inner.open_slots();
    let mut to = To::target_of(frame);
    let chosen = match route {
        Route::Target => inner.chosen_for(frame),
        Route::System(system) => {
            to.system = Some(system);
            inner.chosen_of(system, None)
        }
        Route::Peer(origin) => {
            to = To { system: None, peer: Some(origin.peer) };
            None
        }
        Route::All | Route::Link(_) => None,
    };
    let slots = match (route, chosen) {
        (_, Some((slot, peer))) => {
            to.peer = Some(peer);
            SlotSet::one(slot)
        }
        (Route::Target, None) => inner.router.route_own(frame, all, now),
        (Route::System(system), None) => {
            inner.router.links_of(system, now).first().map_or_else(SlotSet::default, |(slot, _)| SlotSet::one(*slot))
        }
        (Route::All, _) => all,
        (Route::Link(id) | Route::Peer(Origin { link: id, .. }), _) => {
            return (inner.find(id).map(|link| link.port.clone()).into_iter().collect(), to);
        }
    };
    (slots.iter().filter_map(|slot| inner.link(slot)).map(|link| link.port.clone()).collect(), to)
}

fn send_to(ports: &[Arc<Port>], to: To, frame: &Frame, recorder: Option<&RecorderHandle>, now: MonoTime) -> SendReport {
    let mut report = SendReport::default();
    for port in ports {
        if port.send(frame, to) {
            if report.accepted == 0
                && let Some(recorder) = recorder
            {
                recorder.record(port.id, frame, now);
            }
            report.accepted += 1;
        } else {
            report.refused += 1;
        }
    }
    report
}

#[cfg(test)]
mod tests;
