//! Owns who must sign: which keys belong to which vehicle, what becomes of a frame that should be signed and is not,
//! and with which key our own frames go out. Pure but for the keys' own state ([`KeyUse`]).
//!
//! A vehicle *must sign* from the moment that it has shown that it has the key. From then on a frame in its name is
//! believed when its signature is right, when it came over a private link (USB, loopback, or as the
//! link's options say), or when it is the report of a radio, which has no key. Everything else is counted and goes
//! nowhere: not to the listeners, not to other links, and it teaches no route. That holds too when the key itself is
//! missing: who lost it hears nothing, rather than everything.
//!
//! We sign for a vehicle with the key that it showed last. What is for everyone goes to each link once with every key
//! that was seen there.

use std::collections::HashMap;

use smallvec::SmallVec;
use vencejo_proto::{Frame, KeyUse, MonoTime, SignatureFault, SigningKey, SigningTime, SystemId};

use crate::address::LinkAddress;
use crate::router::{RADIO_ID, RADIO_STATUS_ID, Slot, SlotSet};

/// A vehicle that has shown a newer key is not taken to have gone back to an older one by a frame that was under way so
/// long.
const UNDER_WAY: std::time::Duration = std::time::Duration::from_secs(2);

/// Names a key; the number says nothing of what is in it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct KeyId(pub u32);

/// Whether a link is believed without signatures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum UnsignedPolicy {
    /// By its address: USB and loopback are, all others are not.
    #[default]
    ByAddress,
    /// It is.
    Accept,
    /// It is not.
    Refuse,
}

impl UnsignedPolicy {
    /// Whether a link to this address is believed, as the address is now.
    pub(crate) fn believes(self, address: &LinkAddress) -> bool {
        match self {
            Self::ByAddress => address.is_private(),
            Self::Accept => true,
            Self::Refuse => false,
        }
    }
}

/// What is known of a vehicle's signing.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct VehicleKeys {
    /// The keys whose signatures are believed, oldest first: more than one while a change is under way.
    pub keys: Vec<KeyId>,
    /// The key that we sign with for it: the one that it showed last.
    pub signs_with: Option<KeyId>,
    /// Whether what it does not sign is refused.
    pub must_sign: bool,
}

/// Counts of how a vehicle's frames were signed since the station started.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SigningCounts {
    /// Right signature, newer than all before.
    pub verified: u64,
    /// Not signed and accepted: it need not sign, or the link accepts unsigned frames.
    pub unsigned_accepted: u64,
    /// Refused: not signed.
    pub unsigned: u64,
    /// Refused: signed with another key, or changed on the way.
    pub wrong_key: u64,
    /// Refused: not later than what was accepted before.
    pub replayed: u64,
    /// Refused: the first of its stream, older than a minute.
    pub old: u64,
    /// Refused: its time lies in the future.
    pub future: u64,
}

impl SigningCounts {
    /// All refused frames.
    pub fn refused(self) -> u64 {
        self.unsigned + self.wrong_key + self.replayed + self.old + self.future
    }

    fn note_refused(&mut self, fault: SignatureFault) {
        match fault {
            SignatureFault::Unsigned => self.unsigned += 1,
            SignatureFault::Replayed => self.replayed += 1,
            SignatureFault::Old => self.old += 1,
            SignatureFault::Future => self.future += 1,
            _ => self.wrong_key += 1,
        }
    }
}

/// The signing state of a vehicle.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct SigningState {
    /// Its keys.
    pub keys: VehicleKeys,
    /// Counts.
    pub counts: SigningCounts,
    /// The key of its newest verified frame, and when that came.
    pub shown: Option<(KeyId, MonoTime)>,
    /// Unsigned frames in its name since the newest verified one, accepted or not.
    pub unsigned_run: u64,
    /// When a frame was refused last.
    pub refused_at: Option<MonoTime>,
    /// Incremented when `keys` changes because of what the vehicle shows.
    pub changes: u64,
}

/// Whether a received frame is admitted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Admission {
    /// Verified: its sender has the key.
    Verified,
    /// Not verified, and a signature is not required.
    Unverified,
    /// Refused: it is dropped.
    Refused,
}

struct Key {
    id: KeyId,
    used: KeyUse,
    /// Links on which a peer has proven to have it.
    links: SlotSet,
}

/// The keys and the vehicles that have them.
#[derive(Default)]
pub(crate) struct SigningTable {
    keys: Vec<Key>,
    vehicles: HashMap<SystemId, SigningState>,
}

impl SigningTable {
    /// Whether no vehicle has keys.
    pub(crate) fn is_empty(&self) -> bool {
        self.vehicles.is_empty() && self.keys.is_empty()
    }

    pub(crate) fn add_key(&mut self, id: KeyId, key: SigningKey, resumed: SigningTime) {
        if self.key_mut(id).is_none() {
            self.keys.push(Key { id, used: KeyUse::new(key, resumed), links: SlotSet::EMPTY });
        }
    }

    /// Sets a vehicle's keys. A vehicle without keys that need not sign is forgotten, and so are keys that no vehicle has.
    pub(crate) fn set_vehicle(&mut self, system: SystemId, keys: VehicleKeys) {
        if keys == VehicleKeys::default() {
            self.vehicles.remove(&system);
        } else {
            let state = self.vehicles.entry(system).or_default();
            state.keys = keys;
            state.unsigned_run = 0;
        }
        let vehicles = &self.vehicles;
        self.keys.retain(|key| vehicles.values().any(|state| state.keys.keys.contains(&key.id)));
    }

    pub(crate) fn vehicle(&self, system: SystemId) -> Option<&SigningState> {
        self.vehicles.get(&system)
    }

    pub(crate) fn vehicles(&self) -> impl Iterator<Item = (SystemId, &SigningState)> {
        self.vehicles.iter().map(|(system, state)| (*system, state))
    }

    /// For each key the latest time stamp signed or accepted, and the time reserved for it now.
    pub(crate) fn reserve(&mut self, unix_us: u64) -> Vec<(KeyId, SigningTime, SigningTime)> {
        self.keys.iter_mut().map(|key| (key.id, key.used.latest(), key.used.reserve(unix_us))).collect()
    }

    /// The initial time stamp of a new key.
    pub(crate) fn next_time(&mut self, id: KeyId, unix_us: u64) -> Option<SigningTime> {
        self.key_mut(id)?.used.next_time(unix_us).ok()
    }

    pub(crate) fn forget_link(&mut self, slot: Slot) {
        for key in &mut self.keys {
            key.links = key.links.without(SlotSet::one(slot));
        }
    }

    /// The links whose far end has a key: unverified frames are not forwarded to them.
    pub(crate) fn guarded(&self) -> SlotSet {
        SlotSet(self.keys.iter().fold(0, |all, key| all | key.links.0))
    }

    /// Decides on a received frame. `believed`: whether its link accepts unsigned frames.
    pub(crate) fn admit(
        &mut self,
        frame: &Frame,
        slot: Slot,
        believed: bool,
        unix_us: u64,
        now: MonoTime,
    ) -> Admission {
        let system = frame.source().system;
        let result = if frame.is_signed() { self.check(frame, slot, unix_us) } else { Err(SignatureFault::Unsigned) };
        let Some(state) = self.vehicles.get_mut(&system) else {
            return if result.is_ok() { Admission::Verified } else { Admission::Unverified };
        };
        match result {
            Ok(id) => {
                state.counts.verified += 1;
                state.unsigned_run = 0;
                let place = |id: KeyId| state.keys.keys.iter().position(|known| *known == id);
                let goes_back = state.keys.signs_with.is_some_and(|present| place(id) < place(present));
                let newer_is_fresh = goes_back && state.shown.is_some_and(|(_, at)| now.since(at) < UNDER_WAY);
                if !newer_is_fresh {
                    if state.keys.signs_with != Some(id) || !state.keys.must_sign {
                        state.keys.signs_with = Some(id);
                        state.keys.must_sign = true;
                        state.changes += 1;
                    }
                    state.shown = Some((id, now));
                }
                Admission::Verified
            }
            Err(fault) => {
                state.unsigned_run += u64::from(fault == SignatureFault::Unsigned);
                let is_radio = matches!(frame.message_id(), RADIO_STATUS_ID | RADIO_ID);
                // A vehicle that need not sign is accepted as before.
                if believed || is_radio || !state.keys.must_sign {
                    state.counts.unsigned_accepted += 1;
                    Admission::Unverified
                } else {
                    state.counts.note_refused(fault);
                    state.refused_at = Some(now);
                    Admission::Refused
                }
            }
        }
    }

    /// The key that a frame's signature is valid for.
    fn check(&mut self, frame: &Frame, slot: Slot, unix_us: u64) -> Result<KeyId, SignatureFault> {
        let keys_of = |system: SystemId| self.vehicles.get(&system).map(|state| &state.keys.keys);
        // A vehicle signs with its own keys, a ground station with those of the vehicle that it addresses; otherwise it
        // may be any key.
        let own = keys_of(frame.source().system)
            .or_else(|| frame.target().named_system().and_then(keys_of))
            .map(|keys| keys.iter().copied().collect::<SmallVec<[KeyId; 4]>>());
        let mut fault = SignatureFault::WrongKey;
        for key in self.keys.iter_mut().filter(|key| own.as_ref().is_none_or(|own| own.contains(&key.id))) {
            let result = key.used.accept(frame, unix_us);
            if result.err().is_none_or(SignatureFault::has_key) {
                key.links.0 |= SlotSet::one(slot).0;
                match result {
                    Ok(()) => return Ok(key.id),
                    Err(its) => fault = its,
                }
            }
        }
        Err(fault)
    }

    /// The keys to sign one of our own frames with on a link: one for a vehicle, for a broadcast each key seen there.
    pub(crate) fn keys_for(&self, target: Option<SystemId>, slot: Slot) -> SmallVec<[KeyId; 4]> {
        match target.and_then(|system| self.vehicles.get(&system)) {
            Some(state) => state.keys.signs_with.into_iter().collect(),
            None if target.is_some() => SmallVec::new(),
            None => self
                .keys
                .iter()
                .filter(|key| key.links.0 & SlotSet::one(slot).0 != 0)
                .filter(|key| self.vehicles.values().any(|state| state.keys.signs_with == Some(key.id)))
                .map(|key| key.id)
                .collect(),
        }
    }

    /// Signs a frame that is sent now.
    pub(crate) fn sign(&mut self, id: KeyId, frame: &Frame, slot: Slot, unix_us: u64) -> Option<Frame> {
        match self.key_mut(id)?.used.sign(frame, slot, unix_us) {
            Ok(signed) => signed,
            Err(error) => {
                tracing::error!(%error, "a frame could not be signed");
                None
            }
        }
    }

    fn key_mut(&mut self, id: KeyId) -> Option<&mut Key> {
        self.keys.iter_mut().find(|key| key.id == id)
    }
}
