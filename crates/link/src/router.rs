//! Owns the routing rules: which systems were heard on which links, where a frame is forwarded, and which frames are
//! copies of earlier ones. Pure: it sees frames and slots (small numbers that stand for links), no sockets and no
//! clock.
//!
//! The rules are those of mavlink.io, "Routing", and where it leaves a choice, ArduPilot's:
//!
//! | target | handled here | forwarded to |
//! |---|---|---|
//! | none, or system 0 | yes | every other link |
//! | another system | no | every link on which that system was heard; nowhere when it never was |
//! | our system, our component | yes | links on which that very address was heard (a namesake) |
//! | our system, no component | yes | links on which a component of our system was heard |
//! | our system, another component | only when it was heard nowhere | links on which it was heard |
//!
//! A frame never goes back to the link that it came from. Only frames with a good checksum teach a route. Messages that
//! the dialect does not have count as untargeted, because their target cannot be read. `RADIO_STATUS` and `RADIO`
//! describe one radio link and stay on it; they teach no route either. `SETUP_SIGNING` carries a key and is never
//! forwarded.
//!
//! A frame that was handled less than a second ago is a *copy*: it came around a loop, over a second link to the same
//! vehicle, or it is our own coming back. A copy teaches its route and goes nowhere else, so loops die out.

use std::collections::VecDeque;
use std::time::Duration;

use vencejo_proto::{Address, Frame, MavVersion, MonoTime, SystemId};

use crate::address_index::AddressIndex;

/// Most open links.
pub const MAX_LINKS: usize = 64;
/// Addresses remembered individually; of further ones only the system is.
const MAX_SOURCES: usize = 512;
/// A frame that comes again within this time is a copy …
const COPY_WINDOW_MS: u32 = 1000;
/// … unless its sender has sent so many frames since that its counter may have wrapped.
const COPY_FRAMES: u16 = 200;
/// Our own frames that are recognised when they come back, and for how long: no loop delays longer.
const OWN_FRAMES: usize = 4096;
const OWN_WINDOW_MS: u32 = 30_000;
/// A link on which a system was heard this recently keeps carrying what we send to it.
const FRESH: Duration = Duration::from_millis(2500);

/// `RADIO_STATUS`, from the radio at our end of the link or the other.
pub(crate) const RADIO_STATUS_ID: u32 = 109;
/// `RADIO`, its older form.
pub(crate) const RADIO_ID: u32 = 166;
/// `SETUP_SIGNING`: carries the secret key.
pub(crate) const SETUP_SIGNING_ID: u32 = 256;

/// The index of a link in the hub's table.
pub(crate) type Slot = u8;

/// Marks frames of our own in the table of recent frames.
const OURSELVES: Slot = Slot::MAX;

/// A set of slots.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct SlotSet(pub(crate) u64);

impl SlotSet {
    pub(crate) const EMPTY: Self = Self(0);

    pub(crate) const fn one(slot: Slot) -> Self {
        Self(1 << slot)
    }

    pub(crate) const fn is_empty(self) -> bool {
        self.0 == 0
    }

    pub(crate) const fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    pub(crate) fn iter(self) -> impl Iterator<Item = Slot> {
        let mut rest = self.0;
        std::iter::from_fn(move || {
            (rest != 0).then(|| {
                let slot = rest.trailing_zeros() as Slot;
                rest &= rest - 1;
                slot
            })
        })
    }
}

impl FromIterator<Slot> for SlotSet {
    fn from_iter<T: IntoIterator<Item = Slot>>(slots: T) -> Self {
        Self(slots.into_iter().fold(0, |set, slot| set | Self::one(slot).0))
    }
}

/// What becomes of a received frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// It was handled before.
    Copy,
    /// It is new.
    Handle {
        /// Links to forward it to, before the links' own settings apply.
        forward: SlotSet,
        /// Whether it is addressed to us, or to everyone.
        for_us: bool,
    },
}

/// A recently handled frame.
#[derive(Debug, Clone, Copy)]
struct Recent {
    identity: u64,
    at_ms: u32,
    progress: u16,
    slot: Slot,
    used: bool,
}

impl Recent {
    const UNUSED: Self = Self { identity: 0, at_ms: 0, progress: 0, slot: 0, used: false };
}

/// One component that was heard.
struct Source {
    address: Address,
    slots: SlotSet,
    /// Recent frames by their number.
    recent: Box<[Recent; 256]>,
    /// Frames that it has sent, lost ones included, modulo 2^16.
    progress: u16,
    last_sequence: u8,
    /// Whether its counter changes: a sender that always writes the same number cannot be told from a loop by it.
    counts: bool,
}

impl Source {
    fn new(address: Address, sequence: u8) -> Self {
        Self {
            address,
            slots: SlotSet::EMPTY,
            recent: Box::new([Recent::UNUSED; 256]),
            progress: 0,
            last_sequence: sequence,
            counts: false,
        }
    }
}

/// The links on which a system was heard.
#[derive(Clone, Copy, Default)]
struct SystemRoutes {
    slots: SlotSet,
    /// The link that we send to it over while it is fresh.
    preferred: Slot,
}

pub(crate) struct Router {
    /// Our own addresses.
    locals: Vec<Address>,
    systems: Box<[SystemRoutes; 256]>,
    sources: Vec<Source>,
    index: AddressIndex,
    /// When each system was last heard on each link, in milliseconds; by slot × 256 + system.
    heard_ms: Vec<u64>,
    /// Recent frames of senders without an entry: unknown messages, floods.
    strays: Box<[Recent; 256]>,
    /// Our newest frames and when they were sent.
    own: VecDeque<(u64, u8, u32)>,
}

impl Router {
    pub(crate) fn new(locals: Vec<Address>) -> Self {
        Self {
            locals,
            systems: Box::new([SystemRoutes::default(); 256]),
            sources: Vec::new(),
            index: AddressIndex::new(),
            heard_ms: vec![0; MAX_LINKS * 256],
            strays: Box::new([Recent::UNUSED; 256]),
            own: VecDeque::new(),
        }
    }

    pub(crate) fn set_locals(&mut self, locals: Vec<Address>) {
        self.locals = locals;
    }

    pub(crate) fn locals(&self) -> &[Address] {
        &self.locals
    }

    /// Learns the route of a received frame and decides what becomes of it. `all` are the open links.
    pub(crate) fn on_received(
        &mut self,
        origin: Slot,
        frame: &Frame,
        known: bool,
        all: SlotSet,
        now: MonoTime,
    ) -> Verdict {
        self.learn_from(origin, frame, known, now);
        if self.is_copy(origin, frame, now) {
            return Verdict::Copy;
        }
        self.remember(origin, frame, now);
        let id = frame.message_id();
        if matches!(id, RADIO_STATUS_ID | RADIO_ID | SETUP_SIGNING_ID) {
            return Verdict::Handle {
                forward: SlotSet::EMPTY,
                for_us: frame.target().named_system().is_none_or(|system| self.is_our_system(system)),
            };
        }
        let (forward, for_us) = self.decide(frame, all);
        Verdict::Handle { forward: forward.without(SlotSet::one(origin)), for_us }
    }

    /// Learns from a frame for which [`Self::is_copy`] holds.
    pub(crate) fn on_copy(&mut self, origin: Slot, frame: &Frame, known: bool, now: MonoTime) -> Verdict {
        self.learn_from(origin, frame, known, now);
        Verdict::Copy
    }

    /// Remembers a frame that we send, to recognise it when it comes back.
    pub(crate) fn on_sent(&mut self, frame: &Frame, now: MonoTime) {
        if !self.is_copy(OURSELVES, frame, now) {
            self.remember(OURSELVES, frame, now);
        }
        if self.own.len() >= OWN_FRAMES {
            self.own.pop_front();
        }
        self.own.push_back((identity(frame), frame.sequence(), now_ms(now)));
    }

    /// Whether a frame with our own address is one that we sent; otherwise another station uses our address.
    pub(crate) fn is_ours(&self, frame: &Frame, now: MonoTime) -> bool {
        let (identity, sequence, now_ms) = (identity(frame), frame.sequence(), now_ms(now));
        self.own.iter().any(|(id, number, at_ms)| {
            *id == identity && *number == sequence && now_ms.wrapping_sub(*at_ms) < OWN_WINDOW_MS
        })
    }

    /// The links for one of our own frames by its target: all links for a broadcast, otherwise one link on which the
    /// target was heard, so that a command never arrives twice.
    pub(crate) fn route_own(&mut self, frame: &Frame, all: SlotSet, now: MonoTime) -> SlotSet {
        let target = frame.target();
        let Some(system) = target.named_system() else { return all };
        let mut slots = self.systems[usize::from(system.0)].slots;
        if self.is_our_system(system)
            && let Some(component) = target.named_component()
        {
            slots = self.source(Address { system, component }).map_or(SlotSet::EMPTY, |source| source.slots);
        }
        self.best(system, SlotSet(slots.0 & all.0), now).map_or(SlotSet::EMPTY, SlotSet::one)
    }

    /// The links on which `system` was heard, best first.
    pub(crate) fn links_of(&mut self, system: SystemId, now: MonoTime) -> Vec<(Slot, MonoTime)> {
        let slots = self.systems[usize::from(system.0)].slots;
        let best = self.best(system, slots, now);
        let mut links: Vec<_> =
            slots.iter().map(|slot| (slot, MonoTime::from_millis(self.heard_at(slot, system)))).collect();
        links.sort_by_key(|(slot, heard)| (Some(*slot) != best, std::cmp::Reverse(*heard)));
        links
    }

    /// Removes the routes over a closed link.
    pub(crate) fn forget(&mut self, slot: Slot) {
        let gone = SlotSet::one(slot);
        for routes in self.systems.iter_mut() {
            routes.slots = routes.slots.without(gone);
        }
        for source in &mut self.sources {
            source.slots = source.slots.without(gone);
        }
        for source in self.sources.extract_if(.., |source| source.slots.is_empty()) {
            self.index.remove(source.address);
        }
        for (number, source) in self.sources.iter().enumerate() {
            self.index.set(source.address, number);
        }
        let heard = usize::from(slot) * 256;
        self.heard_ms[heard..heard + 256].fill(0);
    }

    /// The links on which a system was heard; of every system for [`SystemId::BROADCAST`].
    pub(crate) fn slots_of(&self, system: SystemId) -> SlotSet {
        match system {
            SystemId::BROADCAST => SlotSet(self.systems.iter().fold(0, |all, routes| all | routes.slots.0)),
            SystemId(system) => self.systems[usize::from(system)].slots,
        }
    }

    fn source(&self, address: Address) -> Option<&Source> {
        self.index.get(address).map(|number| &self.sources[number])
    }

    fn is_our_system(&self, system: SystemId) -> bool {
        self.locals.iter().any(|local| local.system == system)
    }

    fn decide(&self, frame: &Frame, all: SlotSet) -> (SlotSet, bool) {
        let target = frame.target();
        let Some(system) = target.named_system() else { return (all, true) };
        let of_system = SlotSet(self.systems[usize::from(system.0)].slots.0 & all.0);
        if !self.is_our_system(system) {
            return (of_system, false);
        }
        let Some(component) = target.named_component() else { return (of_system, true) };
        let address = Address { system, component };
        let of_component = self.source(address).map_or(SlotSet::EMPTY, |source| SlotSet(source.slots.0 & all.0));
        (of_component, self.locals.contains(&address) || of_component.is_empty())
    }

    fn learn_from(&mut self, origin: Slot, frame: &Frame, known: bool, now: MonoTime) {
        let is_radio = matches!(frame.message_id(), RADIO_STATUS_ID | RADIO_ID);
        let source = frame.source();
        // Address 0 is invalid as a source, and our own echo teaches nothing.
        if known && !is_radio && source.system != SystemId::BROADCAST && !self.is_own_echo(frame, now) {
            self.learn(origin, source, frame.sequence(), now);
        }
    }

    fn learn(&mut self, origin: Slot, address: Address, sequence: u8, now: MonoTime) {
        let routes = &mut self.systems[usize::from(address.system.0)];
        if routes.slots.is_empty() {
            routes.preferred = origin;
        }
        routes.slots.0 |= SlotSet::one(origin).0;
        self.heard_ms[heard_index(origin, address.system)] = now.as_micros() / 1000;
        let number = match self.index.get(address) {
            Some(number) => number,
            None if self.sources.len() == MAX_SOURCES => return,
            None => {
                self.sources.push(Source::new(address, sequence));
                self.index.set(address, self.sources.len() - 1);
                self.sources.len() - 1
            }
        };
        let source = &mut self.sources[number];
        source.slots.0 |= SlotSet::one(origin).0;
        let ahead = sequence.wrapping_sub(source.last_sequence);
        source.counts |= ahead != 0;
        if ahead < 128 {
            source.last_sequence = sequence;
            source.progress = source.progress.wrapping_add(u16::from(ahead));
        }
    }

    fn heard_at(&self, slot: Slot, system: SystemId) -> u64 {
        self.heard_ms[heard_index(slot, system)]
    }

    fn best(&mut self, system: SystemId, slots: SlotSet, now: MonoTime) -> Option<Slot> {
        let newest = slots.iter().max_by_key(|slot| (self.heard_at(*slot, system), std::cmp::Reverse(*slot)))?;
        let preferred = self.systems[usize::from(system.0)].preferred;
        let is_there = !SlotSet(slots.0 & SlotSet::one(preferred).0).is_empty();
        let heard = MonoTime::from_millis(self.heard_at(preferred, system));
        if is_there && (preferred == newest || now.since(heard) < FRESH) {
            return Some(preferred);
        }
        self.systems[usize::from(system.0)].preferred = newest;
        Some(newest)
    }

    /// Whether this is a frame that [`Self::on_sent`] remembered.
    fn is_own_echo(&self, frame: &Frame, now: MonoTime) -> bool {
        let (recent, progress) = match self.source(frame.source()) {
            Some(known) => (&known.recent[usize::from(frame.sequence())], known.progress),
            None => (&self.strays[stray_index(frame)], 0),
        };
        recent.slot == OURSELVES && is_same(recent, frame, progress, now)
    }

    /// Whether the frame was handled within the last second.
    pub(crate) fn is_copy(&self, origin: Slot, frame: &Frame, now: MonoTime) -> bool {
        let (recent, progress, counts) = match self.source(frame.source()) {
            Some(source) => (&source.recent[usize::from(frame.sequence())], source.progress, source.counts),
            None => (&self.strays[stray_index(frame)], 0, true),
        };
        let may_repeat = recent.slot == origin && !counts;
        !may_repeat && is_same(recent, frame, progress, now)
    }

    fn remember(&mut self, origin: Slot, frame: &Frame, now: MonoTime) {
        let (recent, progress) = match self.index.get(frame.source()) {
            Some(number) => {
                let source = &mut self.sources[number];
                (&mut source.recent[usize::from(frame.sequence())], source.progress)
            }
            None => (&mut self.strays[stray_index(frame)], 0),
        };
        *recent = Recent { identity: identity(frame), at_ms: now_ms(now), progress, slot: origin, used: true };
    }
}

fn is_same(recent: &Recent, frame: &Frame, progress: u16, now: MonoTime) -> bool {
    recent.used
        && recent.identity == identity(frame)
        && now_ms(now).wrapping_sub(recent.at_ms) < COPY_WINDOW_MS
        && progress.wrapping_sub(recent.progress) < COPY_FRAMES
}

fn now_ms(now: MonoTime) -> u32 {
    (now.as_micros() / 1000) as u32
}

fn heard_index(slot: Slot, system: SystemId) -> usize {
    usize::from(slot) * 256 + usize::from(system.0)
}

fn stray_index(frame: &Frame) -> usize {
    let source = frame.source();
    usize::from(frame.sequence() ^ source.system.0.wrapping_mul(31) ^ source.component.0.wrapping_mul(101))
}

/// Tells frames of one sender with one number apart: the checksum, which covers header and payload, the message id, and
/// the end of the signature.
fn identity(frame: &Frame) -> u64 {
    let bytes = frame.bytes();
    let header = if frame.version() == MavVersion::V1 { 6 } else { 10 };
    let at = header + usize::from(bytes[1]);
    let checksum = u16::from_le_bytes([bytes[at], bytes[at + 1]]);
    let signature = bytes.last_chunk().filter(|_| frame.is_signed()).map_or(0, |end| u32::from_le_bytes(*end));
    let frame = u32::from(checksum) | (frame.message_id() << 16) ^ (u32::from(bytes[1]) << 24);
    u64::from(frame) | u64::from(signature) << 32
}

#[cfg(test)]
mod tests {
    use vencejo_proto::{CommandLong, FrameDecoder, Header, Message};

    use super::*;
    use crate::testing::{heartbeat, radio_status, setup_signing, unknown};

    const ALL: SlotSet = SlotSet(0b1111);
    const T0: MonoTime = MonoTime::from_millis(1000);
    const US: Address = Address::new(255, 190);

    fn router() -> Router {
        Router::new(vec![US])
    }

    fn command(source: (u8, u8), target: (u8, u8), sequence: u8) -> Frame {
        let message = Message::CommandLong(CommandLong {
            target: Address::new(target.0, target.1),
            command: 400,
            confirmation: 0,
            params: [0.0; 7],
        });
        message.encode(Header { sequence, source: Address::new(source.0, source.1), version: MavVersion::V2 })
    }

    /// (forwarded to, for us); panics on a copy.
    fn received(router: &mut Router, origin: Slot, frame: &Frame) -> (Vec<Slot>, bool) {
        match router.on_received(origin, frame, frame.is_known(), ALL, T0) {
            Verdict::Handle { forward, for_us } => (forward.iter().collect(), for_us),
            Verdict::Copy => panic!("taken for a copy"),
        }
    }

    #[test]
    fn broadcast_goes_everywhere_but_back() {
        assert_eq!(received(&mut router(), 1, &heartbeat(1, 1, 0)), (vec![0, 2, 3], true));
        assert_eq!(received(&mut router(), 0, &command((254, 1), (0, 0), 0)), (vec![1, 2, 3], true));
        assert_eq!(received(&mut router(), 2, &unknown(9, 9, 0)), (vec![0, 1, 3], true));
    }

    #[test]
    fn targeted_goes_where_the_system_was_heard() {
        let mut router = router();
        assert_eq!(received(&mut router, 0, &command((254, 1), (1, 1), 0)), (vec![], false), "unknown: nowhere");
        received(&mut router, 1, &heartbeat(1, 1, 0));
        received(&mut router, 3, &heartbeat(1, 154, 0));
        assert_eq!(received(&mut router, 0, &command((254, 1), (1, 1), 1)), (vec![1, 3], false), "by system");
        assert_eq!(received(&mut router, 1, &command((254, 1), (1, 0), 2)), (vec![3], false), "never back");
    }

    #[test]
    fn ours_stays_with_us_and_reaches_namesakes() {
        let mut router = router();
        received(&mut router, 1, &heartbeat(1, 1, 0));
        assert_eq!(received(&mut router, 1, &command((1, 1), (255, 190), 1)), (vec![], true));
        received(&mut router, 2, &heartbeat(255, 190, 0));
        assert_eq!(received(&mut router, 1, &command((1, 1), (255, 190), 2)), (vec![2], true), "another 255/190");
        assert_eq!(received(&mut router, 1, &command((1, 1), (255, 0), 3)), (vec![2], true));
        assert_eq!(
            received(&mut router, 1, &command((1, 1), (255, 77), 4)),
            (vec![], true),
            "unknown component of ours"
        );
    }

    #[test]
    fn on_board_components_of_our_system_are_told_apart() {
        let mut router = Router::new(vec![Address::new(1, 191)]);
        received(&mut router, 0, &heartbeat(1, 1, 0));
        received(&mut router, 1, &heartbeat(1, 154, 0));
        received(&mut router, 2, &heartbeat(255, 190, 0));
        assert_eq!(received(&mut router, 2, &command((255, 190), (1, 1), 1)), (vec![0], false));
        assert_eq!(received(&mut router, 2, &command((255, 190), (1, 0), 2)), (vec![0, 1], true));
        assert_eq!(received(&mut router, 2, &command((255, 190), (1, 191), 3)), (vec![], true));
        let own = command((1, 191), (1, 154), 0);
        assert_eq!(router.route_own(&own, ALL, T0), SlotSet::one(1));
    }

    #[test]
    fn radio_status_and_signing_keys_stay_where_they_are() {
        let mut router = router();
        assert_eq!(received(&mut router, 1, &radio_status(0)), (vec![], true));
        assert_eq!(
            received(&mut router, 0, &command((254, 1), (51, 68), 0)),
            (vec![], false),
            "the radio is no destination"
        );
        received(&mut router, 1, &heartbeat(1, 1, 0));
        assert_eq!(received(&mut router, 0, &setup_signing((254, 1), (1, 1), 1)).0, Vec::<Slot>::new());
    }

    #[test]
    fn a_copy_over_another_link_is_dropped_but_teaches_the_route() {
        let mut router = router();
        let first = heartbeat(1, 1, 7);
        received(&mut router, 0, &first);
        assert_eq!(router.on_received(1, &first, true, ALL, T0), Verdict::Copy);
        assert_eq!(received(&mut router, 2, &command((254, 1), (1, 1), 0)).0, vec![0, 1]);
    }

    #[test]
    fn a_loop_dies_out_also_on_the_link_of_origin() {
        let mut router = router();
        received(&mut router, 0, &heartbeat(1, 1, 6));
        let frame = heartbeat(1, 1, 7);
        received(&mut router, 0, &frame);
        for _ in 0..5 {
            assert_eq!(router.on_received(0, &frame, true, ALL, T0 + Duration::from_millis(900)), Verdict::Copy);
        }
        let stray = unknown(77, 1, 3);
        received(&mut router, 0, &stray);
        assert_eq!(
            router.on_received(1, &stray, false, ALL, T0),
            Verdict::Copy,
            "unknown messages do not storm either"
        );
    }

    #[test]
    fn equal_frames_of_a_fast_or_simple_sender_are_no_copies() {
        let mut router = router();
        // 10,000 equal heartbeats within a second, counted: the number goes round.
        for n in 0..10_000u32 {
            received(&mut router, 0, &heartbeat(1, 1, n as u8));
        }
        // The same when most of them are lost.
        for n in (0..10_000u32).filter(|n| n % 7 == 0) {
            received(&mut router, 0, &heartbeat(3, 1, n as u8));
        }
        // A sender that does not count.
        for _ in 0..100 {
            received(&mut router, 0, &heartbeat(2, 1, 0));
        }
        assert_eq!(
            router.on_received(1, &heartbeat(2, 1, 0), true, ALL, T0),
            Verdict::Copy,
            "but over another link they are"
        );
    }

    #[test]
    fn our_own_frames_coming_back_are_known() {
        let mut router = router();
        // The second as one on board sends it, whose own address is another.
        for own in [heartbeat(255, 190, 4), heartbeat(252, 191, 5)] {
            router.on_sent(&own, T0);
            assert_eq!(router.on_received(2, &own, true, ALL, T0 + Duration::from_millis(300)), Verdict::Copy);
            assert!(router.links_of(own.source().system, T0).is_empty(), "an echo teaches no route");
        }
    }

    // fault 14: 2.5 s after the last frame
    #[test]
    fn own_frames_take_one_link_and_change_when_it_falls_silent() {
        let mut router = router();
        let own = command((255, 190), (1, 1), 0);
        assert_eq!(router.route_own(&own, ALL, T0), SlotSet::EMPTY, "never heard: nowhere");
        for n in 0..20u8 {
            let now = T0 + Duration::from_millis(u64::from(n) * 250);
            // Link 0 falls silent after 2 s.
            if n < 8 {
                router.on_received(0, &heartbeat(1, 1, n), true, ALL, now);
            }
            router.on_received(1, &heartbeat(1, 1, n), true, ALL, now + Duration::from_millis(1));
            let expected = if n < 17 { 0 } else { 1 };
            assert_eq!(router.route_own(&own, ALL, now), SlotSet::one(expected), "at step {n}");
        }
        assert_eq!(router.route_own(&heartbeat(255, 190, 0), ALL, T0), ALL, "broadcast");
        router.forget(1);
        assert_eq!(router.route_own(&own, ALL, T0 + Duration::from_secs(9)), SlotSet::one(0));
    }

    #[test]
    fn a_flood_of_addresses_is_bounded() {
        let mut router = router();
        for system in 1..=255u8 {
            for component in 1..=255u8 {
                router.on_received(0, &heartbeat(system, component, 1), true, ALL, T0);
            }
        }
        assert_eq!(router.sources.len(), MAX_SOURCES);
        assert_eq!(received(&mut router, 1, &command((254, 9), (200, 200), 7)).0, vec![0], "systems are all known");
    }

    #[test]
    fn the_frame_of_the_decoder_has_the_same_identity() {
        let frame = heartbeat(3, 4, 5);
        let mut decoder = FrameDecoder::new();
        decoder.push(frame.bytes());
        assert_eq!(identity(&decoder.next_frame().unwrap()), identity(&frame));
    }
}
