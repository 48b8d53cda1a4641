//! The states of the plans on board, for ground stations: numbered on board, so that an operator cannot overwrite a
//! plan that he has not seen; received on the ground. No I/O.

use vencejo_flight::plan::PlanKind;
use vencejo_vehicle::{PlanState, Unknown};

use crate::content::Content;
use crate::wire::BadPayload;

/// The state of one plan on board.
#[derive(Clone, PartialEq, prost::Message)]
pub struct PlanTold {
    /// `MAV_MISSION_TYPE`.
    #[prost(uint32, tag = "1")]
    pub kind: u32,
    /// How certain it is.
    #[prost(enumeration = "Knowledge", tag = "2")]
    pub knowledge: i32,
    /// Items without home, where they were read.
    #[prost(uint32, tag = "3")]
    pub count: u32,
    /// Fingerprint of the items, where they were read.
    #[prost(fixed64, tag = "4")]
    pub hash: u64,
    /// Incremented whenever the plan may have changed.
    #[prost(uint64, tag = "5")]
    pub revision: u64,
    /// The items by name, where they were read and there are any.
    #[prost(message, optional, tag = "6")]
    pub list: Option<Content>,
}

/// The certainty about a plan on board.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, prost::Enumeration)]
#[repr(i32)]
pub enum Knowledge {
    /// Never sent.
    Unspecified = 0,
    /// It was never read.
    NeverRead = 1,
    /// A transfer runs.
    Transferring = 2,
    /// A transfer failed half-way.
    TransferFailed = 3,
    /// Another station's upload has not ended.
    SentElsewhere = 4,
    /// The record of it is damaged.
    RecordDamaged = 5,
    /// The vehicle restarted.
    Rebooted = 6,
    /// Another station changed it.
    ChangedElsewhere = 7,
    /// The plan is empty.
    Empty = 8,
    /// Read item by item.
    Verified = 9,
    /// Read item by item, and perhaps a mixture.
    Differs = 10,
}

impl PlanTold {
    /// The kind and state of the plan.
    ///
    /// # Errors
    /// [`BadPayload::Field`] for an invalid state.
    pub fn read(&self) -> Result<(PlanKind, PlanState), BadPayload> {
        let kind = kind_of(self.kind)?;
        let count = u16::try_from(self.count).map_err(|_| BadPayload::Field("count"))?;
        self.list.as_ref().map(Content::name).transpose()?;
        let hash = self.hash;
        let state = match Knowledge::try_from(self.knowledge).unwrap_or(Knowledge::NeverRead) {
            Knowledge::Unspecified | Knowledge::NeverRead => PlanState::Unknown(Unknown::NeverRead),
            Knowledge::Transferring => PlanState::Unknown(Unknown::Transferring),
            Knowledge::TransferFailed => PlanState::Unknown(Unknown::TransferFailed),
            Knowledge::SentElsewhere => PlanState::Unknown(Unknown::SentElsewhere),
            Knowledge::RecordDamaged => PlanState::Unknown(Unknown::RecordDamaged),
            Knowledge::Rebooted => PlanState::Unknown(Unknown::Rebooted),
            Knowledge::ChangedElsewhere => PlanState::Unknown(Unknown::ChangedElsewhere),
            Knowledge::Empty => PlanState::Empty,
            // A plan that was read has a list, without which it is not known on the ground.
            Knowledge::Verified | Knowledge::Differs if self.list.is_none() => return Err(BadPayload::Field("list")),
            Knowledge::Verified => PlanState::Verified { count, hash },
            Knowledge::Differs => PlanState::Differs { count, hash },
        };
        Ok((kind, state))
    }

    fn of(kind: PlanKind, state: PlanState, revision: u64, list: Option<Content>) -> Self {
        let (knowledge, count, hash) = match state {
            PlanState::Empty => (Knowledge::Empty, 0, 0),
            PlanState::Verified { count, hash } => (Knowledge::Verified, count, hash),
            PlanState::Differs { count, hash } => (Knowledge::Differs, count, hash),
            PlanState::Unknown(Unknown::Transferring) => (Knowledge::Transferring, 0, 0),
            PlanState::Unknown(Unknown::TransferFailed) => (Knowledge::TransferFailed, 0, 0),
            PlanState::Unknown(Unknown::SentElsewhere) => (Knowledge::SentElsewhere, 0, 0),
            PlanState::Unknown(Unknown::RecordDamaged) => (Knowledge::RecordDamaged, 0, 0),
            PlanState::Unknown(Unknown::Rebooted) => (Knowledge::Rebooted, 0, 0),
            PlanState::Unknown(Unknown::ChangedElsewhere) => (Knowledge::ChangedElsewhere, 0, 0),
            _ => (Knowledge::NeverRead, 0, 0),
        };
        let (count, kind) = (count.into(), kind.mission_type().into());
        Self { kind, knowledge: knowledge.into(), count, hash, revision, list: list.map(|list| list.at_most(0)) }
    }
}

/// The plan with this number on the wire.
///
/// # Errors
/// [`BadPayload::Field`].
pub fn kind_of(number: u32) -> Result<PlanKind, BadPayload> {
    let kind = u8::try_from(number).ok().and_then(|number| PlanKind::try_from(number).ok());
    kind.ok_or(BadPayload::Field("kind of plan"))
}

/// The plans on board, numbered.
#[derive(Debug)]
pub struct Plans {
    version: u32,
    states: [PlanState; 3],
    told: [PlanTold; 3],
    /// The last known fingerprints; of an empty list when there were no items.
    known: [Option<Option<u64>>; 3],
}

impl Default for Plans {
    /// Nothing is known yet.
    fn default() -> Self {
        let state = PlanState::Unknown(Unknown::NeverRead);
        let told = PlanKind::ALL.map(|kind| PlanTold::of(kind, state, 1, None));
        Self { version: 1, states: [state; 3], told, known: [None; 3] }
    }
}

impl Plans {
    /// Sets the state of a plan; `list` returns its items if there are any. Whether it is new.
    pub fn on_state(&mut self, kind: PlanKind, state: PlanState, list: impl FnOnce() -> Option<Content>) -> bool {
        let place = kind as usize;
        if std::mem::replace(&mut self.states[place], state) == state {
            return false;
        }
        let read = match state {
            PlanState::Empty => Some(None),
            PlanState::Verified { hash, .. } | PlanState::Differs { hash, .. } => Some(Some(hash)),
            _ => None,
        };
        let was_unread =
            matches!(Knowledge::try_from(self.told[place].knowledge), Ok(Knowledge::NeverRead | Knowledge::Rebooted));
        // The same plan became known, or was read again.
        let is_same = match state {
            PlanState::Unknown(Unknown::NeverRead | Unknown::Rebooted) => true,
            PlanState::Verified { .. } | PlanState::Empty => {
                was_unread && self.known[place].is_none_or(|known| Some(known) == read)
            }
            _ => false,
        };
        let revision = self.told[place].revision + u64::from(!is_same);
        self.known[place] = read.or(self.known[place]);
        let list = if matches!(state, PlanState::Verified { .. } | PlanState::Differs { .. }) { list() } else { None };
        self.told[place] = PlanTold::of(kind, state, revision, list);
        self.version += 1;
        true
    }

    /// The version: incremented with each change.
    pub fn version(&self) -> u32 {
        self.version
    }

    /// The states of the plans.
    pub fn told(&self) -> &[PlanTold; 3] {
        &self.told
    }

    /// Whether a plan may be replaced by an operator who has seen this revision.
    ///
    /// # Errors
    /// The reason, as text.
    pub fn admit(&self, kind: PlanKind, seen: u64) -> Result<(), String> {
        if self.told[kind as usize].revision == seen {
            return Ok(());
        }
        Err(format!("the {kind} on board has changed since it was looked at; look at it again, then decide"))
    }
}

/// The received plans of a remote aircraft.
#[derive(Debug, Default)]
pub struct PlansHeard {
    boot: Option<u64>,
    version: u32,
    told: [Option<PlanTold>; 3],
}

impl PlansHeard {
    /// Processes the plans of a state: whether there are changes, or changes that were missed and are to be requested.
    pub fn on_state(&mut self, boot: u64, version: u32, plans: &[PlanTold]) -> Freshness {
        if self.boot != Some(boot) {
            *self = Self { boot: Some(boot), ..Self::default() };
        }
        if version <= self.version {
            return Freshness::Nothing;
        }
        if plans.is_empty() {
            return Freshness::Missed;
        }
        self.version = version;
        for told in plans {
            self.on_told(told);
        }
        Freshness::News
    }

    /// Processes the state of a plan from a state or an answer: the newer one counts, whichever comes first.
    pub fn on_told(&mut self, told: &PlanTold) {
        let Ok((kind, _)) = told.read() else { return };
        let known = &mut self.told[kind as usize];
        if known.as_ref().is_none_or(|known| known.revision <= told.revision) {
            *known = Some(told.clone());
        }
    }

    /// The newest state of a plan.
    pub fn told(&self, kind: PlanKind) -> Option<&PlanTold> {
        self.told[kind as usize].as_ref()
    }
}

/// Whether a state had news of plans.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Freshness {
    /// Nothing new.
    Nothing,
    /// Something new.
    News,
    /// Something new that is not in the state.
    Missed,
}

#[cfg(test)]
mod schedules;
#[cfg(test)]
mod tests {
    use super::*;

    const MISSION: PlanKind = PlanKind::Mission;

    fn verified(hash: u64) -> PlanState {
        PlanState::Verified { count: 3, hash }
    }

    fn list() -> Option<Content> {
        Some(Content::of(b"list".to_vec()))
    }

    #[test]
    fn every_state_is_told_as_it_is() {
        let unknown = [
            Unknown::NeverRead,
            Unknown::Transferring,
            Unknown::TransferFailed,
            Unknown::SentElsewhere,
            Unknown::RecordDamaged,
            Unknown::Rebooted,
            Unknown::ChangedElsewhere,
        ];
        let known = [PlanState::Empty, verified(7), PlanState::Differs { count: 9, hash: 8 }];
        for state in unknown.map(PlanState::Unknown).into_iter().chain(known) {
            for kind in PlanKind::ALL {
                let told = PlanTold::of(kind, state, 4, list());
                assert_eq!(told.read(), Ok((kind, state)));
            }
        }
        let bare = PlanTold::of(MISSION, verified(7), 4, None);
        assert_eq!(bare.read(), Err(BadPayload::Field("list")), "known to nobody far away");
        assert!(PlanTold { kind: 3, ..PlanTold::default() }.read().is_err());
        assert!(PlanTold { count: 65_536, ..PlanTold::default() }.read().is_err());
    }

    #[test]
    fn a_revision_grows_when_the_plan_may_be_another_one_and_not_when_it_is_read() {
        let mut plans = Plans::default();
        let mut on = |state| {
            plans.on_state(MISSION, state, list);
            plans.told()[0].revision
        };
        let unknown = PlanState::Unknown;
        assert_eq!(on(unknown(Unknown::NeverRead)), 1);
        assert_eq!(on(verified(1)), 1, "it was there all along");
        assert_eq!(on(unknown(Unknown::Rebooted)), 1);
        assert_eq!(on(verified(1)), 1, "the same as before the restart");
        assert_eq!(on(unknown(Unknown::Rebooted)), 1);
        assert_eq!(on(verified(2)), 2, "another one");
        assert_eq!(on(unknown(Unknown::Transferring)), 3);
        assert_eq!(on(verified(3)), 4);
        assert_eq!(on(unknown(Unknown::ChangedElsewhere)), 5);
        assert_eq!(on(unknown(Unknown::Rebooted)), 5);
        assert_eq!(on(PlanState::Empty), 6);
        assert_eq!(plans.told()[1].revision, 1, "each for itself");
        assert_eq!(plans.admit(MISSION, 6), Ok(()));
        assert!(plans.admit(MISSION, 5).is_err_and(|why| why.contains("mission on board has changed")));
    }

    #[test]
    fn what_was_missed_is_noticed_and_what_was_overtaken_is_not_believed() {
        let (mut plans, mut heard) = (Plans::default(), PlansHeard::default());
        let tell = |plans: &Plans, heard: &mut PlansHeard, is_whole: bool| {
            let told = if is_whole { plans.told().to_vec() } else { Vec::new() };
            heard.on_state(5, plans.version(), &told)
        };
        let first = (plans.version(), plans.told().to_vec());
        assert_eq!(tell(&plans, &mut heard, false), Freshness::Missed);
        assert_eq!(tell(&plans, &mut heard, true), Freshness::News);
        assert_eq!(tell(&plans, &mut heard, true), Freshness::Nothing);
        assert!(plans.on_state(MISSION, verified(1), list) && !plans.on_state(MISSION, verified(1), list));
        assert_eq!(tell(&plans, &mut heard, true), Freshness::News);
        assert_eq!(heard.on_state(5, first.0, &first.1), Freshness::Nothing);
        assert_eq!(heard.told(MISSION).map(PlanTold::read), Some(Ok((MISSION, verified(1)))));
        plans.on_state(MISSION, verified(2), list);
        let answered = plans.told()[0].clone();
        heard.on_told(&answered);
        heard.on_told(&first.1[0]);
        assert_eq!(heard.told(MISSION), Some(&answered), "an answer may be faster than the state");
        assert_eq!(heard.on_state(6, 1, &[]), Freshness::Missed, "another boot begins anew");
        assert_eq!(heard.told(MISSION), None);
        assert_eq!(heard.on_state(7, 0, &[]), Freshness::Nothing, "an older version's");
    }
}
