//! The state of one remote aircraft on the ground.

use std::collections::BTreeMap;

use vencejo_proto::{Address, MonoTime};
use vencejo_station::Telling;
use vencejo_vehicle::VehicleId;

use crate::authority::LEASE;
use crate::delivery::RoundTrip;
use crate::payload::{Held, UnderWay};
use crate::plans::{PlanTold, PlansHeard};
use crate::signature::PublicKey;
use crate::state_source::Listener;

#[derive(Default)]
pub(super) struct Known {
    pub(super) listener: Listener,
    pub(super) is_present: bool,
    /// Whether a rival is shown.
    pub(super) is_contested: bool,
    /// Its id in our station, since it was adopted.
    pub(super) id: Option<VehicleId>,
    /// Its autopilot's MAVLink address, on board.
    pub(super) autopilot: Option<Address>,
    /// The epoch in which we have control, by boot: a boot may be followed again when the newer one was not its
    /// restart.
    pub(super) leases: BTreeMap<u64, u64>,
    /// Whether the last control that we had was taken from us, or given up.
    pub(super) has_lost: bool,
    /// The boot and the epoch in which control was last taken from us: it may have been borrowed.
    pub(super) lent: Option<(u64, u64)>,
    /// The boot to which an order for control went whose answer was not heard: it may be granted there, or stand as a
    /// request.
    pub(super) unanswered: Option<u64>,
    /// Our request for control of it, until it is granted or declined.
    pub(super) request: Option<Requested>,
    /// Whether its certificate was revoked.
    pub(super) is_revoked: bool,
    /// How long it takes to answer.
    pub(super) round_trip: RoundTrip,
    /// Whether missed events are being fetched.
    pub(super) is_catching_up: bool,
    /// The plans that it published, and those that are shown here.
    pub(super) plans: PlansHeard,
    pub(super) plans_shown: [Option<PlanTold>; 3],
    /// Whether plans are being fetched.
    pub(super) is_asking_plans: bool,
    /// Orders whose progress is reported, by id.
    pub(super) followed: BTreeMap<Vec<u8>, Followed>,
}

/// A request for control that we made.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Requested {
    /// The boot that it is of.
    pub(super) boot: u64,
    /// The operator who made it.
    pub(super) operator: String,
}

/// An order whose progress is reported.
pub(super) struct Followed {
    pub(super) telling: Telling,
    /// When its progress was heard last.
    pub(super) heard_at: MonoTime,
}

/// Who we are to an aircraft.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Own {
    pub(super) key: PublicKey,
    pub(super) run: u32,
}

impl Own {
    /// Whether it is we who ask for control by this.
    pub(super) fn asks(&self, held: &Held) -> bool {
        held.asking_key == self.key.0 && held.asking_run == self.run
    }

    /// Whether we have control by this.
    fn holds(&self, held: &Held) -> bool {
        held.key == self.key.0 && held.run == self.run
    }
}

impl Known {
    /// The boot that is followed.
    pub(super) fn boot(&self) -> Option<u64> {
        self.listener.stamp().map(|(boot, _)| boot)
    }

    /// The epoch in which we have control, as far as is known. A grant and its holder are published together, so a state
    /// with that epoch and another holder, or with a later epoch, is newer than the grant.
    pub(super) fn epoch(&mut self, own: &Own) -> Option<u64> {
        let (boot, held) = (self.boot()?, self.listener.held());
        let epoch = *self.leases.get(&boot)?;
        if held.epoch > epoch || (held.epoch == epoch && !own.holds(held)) {
            self.has_lost |= !held.key.is_empty() && !own.holds(held);
            self.leases.remove(&boot);
            self.lent = Some((boot, epoch));
            return None;
        }
        Some(epoch)
    }

    /// Our control in this epoch of the followed boot has ended: this holder has it, or nobody.
    pub(super) fn on_lost(&mut self, epoch: u64, holder: &str) {
        let boot = self.boot();
        let before = self.leases.len();
        self.leases.retain(|of, held| (Some(*of), *held) != (boot, epoch));
        if self.leases.len() < before {
            self.has_lost |= !holder.is_empty();
            self.lent = boot.map(|boot| (boot, epoch));
        }
    }

    /// Removes our lease of the followed boot, our request for it, or our claim to what was borrowed; returns the epoch
    /// for the release, 0 where we have no lease.
    pub(super) fn give_up(&mut self) -> Option<u64> {
        let boot = self.boot()?;
        let is_lent = self.lent.take().is_some_and(|(of, _)| of == boot);
        let is_unanswered = self.unanswered.take() == Some(boot);
        self.has_lost |= self.leases.contains_key(&boot);
        let is_asked_for = self.request.take().is_some_and(|request| request.boot == boot);
        self.leases.remove(&boot).or((is_asked_for || is_unanswered || is_lent).then_some(0))
    }

    /// Whether we have control, have asked for it, or may get it back.
    pub(super) fn is_claimed(&self) -> bool {
        !self.leases.is_empty() || self.request.is_some() || self.unanswered.is_some() || self.lent.is_some()
    }

    /// The epoch in which the followed boot shows that we have control.
    pub(super) fn shown(&self, own: &Own) -> Option<u64> {
        let held = self.listener.held();
        own.holds(held).then_some(held.epoch)
    }

    /// The followed boot has granted us control in this epoch.
    pub(super) fn on_granted(&mut self, boot: u64, epoch: u64) {
        self.leases.insert(boot, epoch);
        (self.has_lost, self.lent) = (false, None);
        self.unanswered.take_if(|of| *of == boot);
        self.request.take_if(|request| request.boot == boot);
    }

    /// Takes what we had asked for, or was borrowed from us, once it is published that we have it: there is no other
    /// answer to a request that was granted later, and none to what was given back.
    pub(super) fn on_held(&mut self, own: &Own) {
        let (Some(boot), Some(epoch)) = (self.boot(), self.shown(own)) else { return };
        let is_asked_for = self.request.as_ref().is_some_and(|request| request.boot == boot);
        let is_back = self.lent.is_some_and(|(of, lent)| of == boot && epoch > lent);
        if is_asked_for || is_back || self.unanswered == Some(boot) {
            self.on_granted(boot, epoch);
        }
    }

    /// Forgets the leases that have expired on board.
    pub(super) fn forget_leases(&mut self, now: MonoTime) {
        let listener = &self.listener;
        self.leases.retain(|boot, _| listener.heard_at(*boot).is_some_and(|at| now.since(at) < LEASE));
    }

    /// Whether the published holder is us.
    pub(super) fn is_ours(&mut self, own: &Own) -> bool {
        self.epoch(own) == Some(self.listener.held().epoch)
    }

    /// Processes the progress of orders.
    pub(super) fn follow(&mut self, under_way: &[UnderWay], now: MonoTime) {
        for told in under_way {
            if let Some(followed) = self.followed.get_mut(&told.id) {
                followed.heard_at = now;
                (followed.telling)(told.done, told.total);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::payload::State;

    #[test]
    fn control_that_another_is_shown_to_have_is_not_ours() {
        let own = Own { key: PublicKey([1; 32]), run: 5 };
        let shown = |(key, run): (u8, u32), epoch| {
            let held = Held { epoch, holder: "somebody".into(), key: vec![key; 32], run, ..Held::default() };
            let state = State { boot: 7, held: Some(held), ..State::default() };
            let mut known = Known { leases: BTreeMap::from([(7, 3)]), ..Known::default() };
            known.listener.on_state(&state, MonoTime::ZERO);
            (known.is_ours(&own), known.epoch(&own))
        };
        let (us, beside, another) = ((1, 5), (1, 6), (2, 5));
        assert_eq!(shown(us, 3), (true, Some(3)));
        assert_eq!(shown(another, 2), (false, Some(3)), "from before the grant");
        assert_eq!(shown(us, 2), (false, Some(3)));
        assert_eq!(shown(another, 4), (false, None), "another has it since");
        assert_eq!(shown(beside, 4), (false, None), "or another program with our key");
        assert_eq!(shown(us, 4), (false, None), "in an epoch of which we have no answer");
        assert_eq!(shown(another, 3), (false, None), "ours ran out");
        let asks = |key: u8, asking_run| own.asks(&Held { asking_key: vec![key; 32], asking_run, ..Held::default() });
        assert_eq!(
            [asks(1, 5), asks(1, 6), asks(2, 5)],
            [true, false, false],
            "a request, whatever is known of it here"
        );
    }

    #[test]
    fn that_control_was_lost_is_known_by_each_way_until_it_is_had_again() {
        let own = Own { key: PublicKey([1; 32]), run: 5 };
        let has_lost = |lose: &dyn Fn(&mut Known)| {
            let mut known = Known { leases: BTreeMap::from([(7, 3)]), ..Known::default() };
            let held = Held { epoch: 3, holder: "Ana".into(), key: vec![1; 32], run: 5, ..Held::default() };
            let state = State { boot: 7, clock_ms: 1, sequence: 1, held: Some(held), ..State::default() };
            known.listener.on_state(&state, MonoTime::ZERO);
            lose(&mut known);
            let lost = known.has_lost;
            known.on_granted(7, 9);
            (lost, known.has_lost)
        };
        assert_eq!(has_lost(&|known| known.on_lost(3, "Luis")), (true, false), "an order was answered so");
        assert_eq!(has_lost(&|known| known.on_lost(2, "Luis")), (false, false), "that was of an earlier one");
        assert_eq!(has_lost(&|known| known.on_lost(3, "")), (false, false), "it ran out, and nobody took it");
        assert_eq!(has_lost(&|known| assert_eq!(known.give_up(), Some(3))), (true, false));
        let shown = |known: &mut Known| {
            let held = Held { epoch: 4, holder: "Luis".into(), key: vec![2; 32], run: 5, ..Held::default() };
            let state = State { boot: 7, clock_ms: 2, sequence: 2, held: Some(held), ..State::default() };
            known.listener.on_state(&state, MonoTime::from_millis(1));
            assert_eq!(known.epoch(&own), None);
        };
        assert_eq!(has_lost(&shown), (true, false));
        assert_eq!(has_lost(&|_| ()), (false, false));
    }

    #[test]
    fn control_that_was_asked_for_is_ours_once_it_is_shown() {
        let own = Own { key: PublicKey([1; 32]), run: 5 };
        let mut known = Known::default();
        let shows = |known: &mut Known, (key, run): (u8, u32), epoch| {
            let held = Held { epoch, holder: "somebody".into(), key: vec![key; 32], run, ..Held::default() };
            let state = State { boot: 7, clock_ms: epoch, sequence: epoch, held: Some(held), ..State::default() };
            known.listener.on_state(&state, MonoTime::from_millis(epoch));
            known.on_held(&own);
            known.epoch(&own)
        };
        assert_eq!(shows(&mut known, (1, 5), 3), None, "nobody here asked for it");
        known.request = Some(Requested { boot: 7, operator: "Ana".into() });
        assert_eq!((shows(&mut known, (2, 5), 4), known.request.is_some()), (None, true));
        assert_eq!((shows(&mut known, (1, 6), 5), known.request.is_some()), (None, true), "another program has it");
        assert_eq!((shows(&mut known, (1, 5), 6), known.request.is_some()), (Some(6), false));
        assert_eq!((known.give_up(), known.give_up()), (Some(6), None));
        known.request = Some(Requested { boot: 7, operator: "Ana".into() });
        assert_eq!((known.give_up(), known.is_claimed()), (Some(0), false));
    }

    #[test]
    fn what_was_borrowed_is_ours_once_it_is_shown_to_be_back() {
        let own = Own { key: PublicKey([1; 32]), run: 5 };
        let shown = |lose: &dyn Fn(&mut Known), epochs: &[(u32, u64)]| {
            let mut known = Known { leases: BTreeMap::from([(7, 3)]), ..Known::default() };
            let shows = |known: &mut Known, run, epoch, sequence| {
                let held = Held { epoch, holder: "it".into(), key: vec![1; 32], run, ..Held::default() };
                let state = State { boot: 7, clock_ms: sequence, sequence, held: Some(held), ..State::default() };
                known.listener.on_state(&state, MonoTime::from_millis(sequence));
                known.on_held(&own);
                known.epoch(&own)
            };
            assert_eq!(shows(&mut known, 5, 3, 1), Some(3));
            lose(&mut known);
            let mut last = None;
            for (sequence, (run, epoch)) in (2..).zip(epochs) {
                last = shows(&mut known, *run, *epoch, sequence);
            }
            (last, known.has_lost)
        };
        assert_eq!(shown(&|_| (), &[(6, 4), (5, 5)]), (Some(5), false));
        assert_eq!(shown(&|known| known.on_lost(3, "it"), &[(5, 3)]), (None, true), "from before it was lost");
        assert_eq!(shown(&|known| known.on_lost(3, "it"), &[(5, 5)]), (Some(5), false));
        assert_eq!(shown(&|known| assert_eq!(known.give_up(), Some(3)), &[(6, 4), (5, 5)]), (None, true));
        let waives = |known: &mut Known| {
            known.on_lost(3, "it");
            assert!(known.is_claimed());
            assert_eq!((known.give_up(), known.is_claimed(), known.give_up()), (Some(0), false, None));
        };
        assert_eq!(shown(&waives, &[(5, 5)]), (None, true));
        let is_not_answered = |known: &mut Known| (known.leases, known.unanswered) = (BTreeMap::new(), Some(7));
        assert_eq!(shown(&is_not_answered, &[(5, 4)]), (Some(4), false), "an answer that was not heard");
        let withdraws = |known: &mut Known| {
            is_not_answered(known);
            assert_eq!((known.is_claimed(), known.give_up(), known.is_claimed()), (true, Some(0), false));
        };
        assert_eq!(shown(&withdraws, &[(5, 4)]), (None, false));
    }

    #[test]
    fn control_of_a_computer_outlives_another_one_of_its_name() {
        let own = Own { key: PublicKey([1; 32]), run: 5 };
        let mut known = Known { leases: BTreeMap::from([(7, 3)]), ..Known::default() };
        let mut says = |boot, clock_ms, now_ms| {
            let now = MonoTime::from_millis(now_ms);
            let ours = || Held { epoch: 3, key: own.key.0.to_vec(), run: own.run, ..Held::default() };
            let held = if boot == 7 { ours() } else { Held::default() };
            known.listener.on_state(&State { boot, clock_ms, held: Some(held), ..State::default() }, now);
            known.forget_leases(now);
            known.epoch(&own)
        };
        assert_eq!(says(7, 50_000, 1_000), Some(3));
        assert_eq!(says(8, 9_000, 1_500), None, "no order to the one is meant for the other");
        assert_eq!(says(7, 52_000, 3_000), Some(3), "it never went");
        assert_eq!(says(9, 1_000, 3_500), None);
        assert_eq!((says(9, 9_000, 11_500), says(9, 10_500, 13_000)), (None, None));
        assert!(known.leases.is_empty(), "it ran out");
    }
}
