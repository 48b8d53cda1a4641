//! Which aircraft the vehicle is, as far as it has told, and which one a doubt is about.

use std::time::Duration;

use vencejo_proto::MonoTime;

use crate::plan_record::{Doubt, HardwareIds, PlanRecord, VehicleKey};

/// A vehicle that has not told the id of its hardware for this long is taken for the aircraft before, or known by its
/// system id.
const IDENTIFIED_WITHIN: Duration = Duration::from_secs(5);

/// Which aircraft a doubt is about.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Whose {
    /// The one whose record is kept.
    Known,
    /// The one that is there now.
    Present,
    /// The one that is there now, or the one whose record is kept.
    Either,
    /// The one with this record, until the vehicle is identified.
    Stored(VehicleKey),
}

/// A doubt about the mission on board.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Doubted {
    pub(crate) doubt: Doubt,
    pub(crate) whose: Whose,
}

/// Which aircraft the vehicle is, as far as it has told.
#[derive(Debug)]
pub(crate) struct Identity {
    /// Whose record is kept; `None` until the vehicle is identified.
    pub(crate) key: Option<VehicleKey>,
    /// What it has told of its hardware, in all its messages.
    pub(super) hardware: HardwareIds,
    /// `None`: it has told who it is.
    pub(super) unsure: Option<Unsure>,
}

/// What is remembered while it may be another aircraft.
#[derive(Debug)]
pub(crate) struct Unsure {
    /// When the first message came that may be of another aircraft.
    pub(super) since: MonoTime,
    /// Whether a restart was noticed then.
    pub(super) has_restarted: bool,
    /// Until when its id is waited for; `None` when that is over.
    pub(super) waits_until: Option<MonoTime>,
    /// The record of the aircraft before, as it was then, where that one is known by its hardware.
    pub(super) aside: Option<PlanRecord>,
    /// Whether a doubt has ended since, so that one of an earlier run does not count any more.
    pub(super) has_ended_doubt: bool,
}

impl Identity {
    pub(crate) fn new(now: MonoTime) -> Self {
        Self { key: None, hardware: HardwareIds::default(), unsure: Some(Unsure::new(now, false, None, now)) }
    }

    /// Until when the vehicle's id is waited for.
    pub(crate) fn waits_until(&self) -> Option<MonoTime> {
        self.unsure.as_ref().and_then(|unsure| unsure.waits_until)
    }

    /// Whose a doubt is that begins now.
    pub(crate) fn present(&self) -> Whose {
        if self.unsure.is_some() { Whose::Present } else { Whose::Known }
    }

    pub(crate) fn on_doubt_ended(&mut self) {
        if let Some(unsure) = &mut self.unsure {
            unsure.has_ended_doubt = true;
        }
    }

    /// Whether a doubt has ended since it may be another aircraft.
    pub(super) fn has_ended_doubt(&self) -> bool {
        self.unsure.as_ref().is_some_and(|unsure| unsure.has_ended_doubt)
    }

    /// The doubt that the recorded aircraft may still have although none is known of the one that is there.
    pub(crate) fn aside(&self) -> Option<&Doubt> {
        self.unsure.as_ref()?.aside.as_ref()?.doubt.as_ref()
    }
}

impl Unsure {
    pub(super) fn new(since: MonoTime, has_restarted: bool, aside: Option<PlanRecord>, now: MonoTime) -> Self {
        let waits_until = Some(now + IDENTIFIED_WITHIN);
        Self { since, has_restarted, waits_until, aside, has_ended_doubt: false }
    }
}
