//! Who may act on an aircraft: decided on board only. No I/O; time is passed in, and is the clock on board.
//!
//! One operator at a time has the lease. Each grant increments the epoch, and an order of an older epoch, or of another
//! boot of the station on board, is fenced: it is not executed, however late the network delivers it. An order has an
//! id and is executed at most once: a repeated id gets the stored answer. And an order names the state that it was
//! based on, by the clock on board, so that no clocks need to agree. What the network does to orders (loss, repetition,
//! reordering, delay) changes when and whether they are executed, but none of the above; `schedules` tests it.
//!
//! A ground station is its key; programs that share one have control each for itself.
//!
//! Precedence: the pilot at the sticks (decided by the autopilot); an operator on board or at a direct link; a chief;
//! the operator who has the lease; one who asks.

use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use vencejo_proto::MonoTime;

use crate::payload::{Answer, Ask, End, Held, VERSION};
use crate::signature::PublicKey;
use crate::stamp::{Stamper, StateStamp};
use crate::state_source::millis;

/// How long a lease lasts without a sign of its holder.
pub const LEASE: Duration = Duration::from_secs(10);
/// How often its holder renews it.
pub const RENEW_EVERY: Duration = Duration::from_secs(2);
/// How long a request for control is shown to its holder without a sign of the station that asks.
pub const ASKS_FOR: Duration = Duration::from_secs(10);
/// The greatest age of the state that an order may be based on.
pub const FRESH: Duration = Duration::from_secs(5);
/// Why an order for another run is not done.
pub const STARTED_AGAIN: &str = "the station on board has started again since; look at the aircraft, then decide";
/// Why an order that comes later is not done.
pub const TOO_LATE: &str = "it came too late: more than 5 s after the state of the aircraft that it is based on; look at \
                            the aircraft, then give it again";
/// Why it is unknown whether such an order was done.
const FORGOTTEN: &str = "it came more than 5 s after the state of the aircraft that it is based on, and orders of that time \
                         are forgotten";
/// How far in the future that state may be: clocks are read in whole milliseconds.
const AHEAD: Duration = Duration::from_secs(1);
/// How much longer an order is remembered: the network may deliver it twice, and its sender may not have noticed that
/// the first delivery got no answer.
const OVERTAKEN: Duration = Duration::from_secs(1);
/// How long an answer is kept for repeated orders, at least.
pub const KEEPS_ANSWERS: Duration = Duration::from_secs(60);
/// Most answers kept. A fresh one is never dropped for another: then further orders are refused.
pub const MAX_ANSWERS: usize = 1024;

/// The role of a ground station's key.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "papers", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "lowercase"))]
pub enum Role {
    /// May watch, and read plans and parameters; never acts.
    Observer,
    /// Has to ask for control while another operator has it.
    Operator,
    /// May take control from an operator at once, if it wants to.
    Chief,
}

impl Role {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Observer, Self::Operator, Self::Chief];

    /// Its name.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Observer => "observer",
            Self::Operator => "operator",
            Self::Chief => "chief",
        }
    }

    /// The role of that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|role| role.as_str() == name)
    }
}

/// The sender of an order, whose signature was verified.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Caller {
    /// Its key.
    pub key: PublicKey,
    /// The number of its program: several may have one key.
    pub run: u32,
    /// Its name.
    pub name: String,
    /// Its role.
    pub role: Role,
}

impl Caller {
    fn is_same_program(&self, other: &Self) -> bool {
        (self.key, self.run) == (other.key, other.run)
    }
}

/// The purpose of an order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wish {
    /// Control.
    Ask(Ask),
    /// To keep it.
    Renew,
    /// To give it up, to the station that asks if there is one, or else to whom it was borrowed from; or to withdraw a
    /// request for it, or the claim to what was borrowed.
    Release,
    /// To decline the request of the station with this key.
    Keep(PublicKey),
    /// To do something.
    Act,
    /// To read something; needs no control.
    Read,
    /// To cancel an order of its own: one in progress, or one that the network delivers after this.
    Recall(u128),
}

/// The part of an order that the authority looks at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Claim {
    /// The boot that it is for.
    pub boot: u64,
    /// The epoch that it is for.
    pub epoch: u64,
    /// Its id.
    pub id: u128,
    /// The state that it is based on.
    pub based_on: StateStamp,
    /// Its purpose.
    pub wish: Wish,
}

/// The decision on an order.
#[derive(Debug, Clone, PartialEq)]
pub enum Verdict {
    /// Execute it, then call [`Authority::on_ended`].
    Execute,
    /// It is in progress: the answer comes when it ends.
    UnderWay,
    /// This is its answer.
    Answer(Box<Answer>),
}

#[derive(Debug, Clone)]
struct Lease {
    caller: Caller,
    until: MonoTime,
}

impl Lease {
    /// Renews it. The name is that of the person who acts there now; a renewal has no name.
    fn renew(&mut self, caller: &Caller, now: MonoTime) {
        self.until = now + LEASE;
        if !caller.name.is_empty() {
            self.caller.name.clone_from(&caller.name);
        }
    }
}

#[derive(Debug)]
struct Known {
    key: PublicKey,
    /// `None` for a reading, which goes on whoever has control.
    epoch: Option<u64>,
    /// Until when the same order would be fresh.
    fresh_until: MonoTime,
    keep_until: MonoTime,
    /// The order that it recalls.
    recalls: Option<u128>,
    /// `None` while in progress.
    answer: Option<Answer>,
}

/// Decides who may act on one aircraft.
#[derive(Debug)]
pub struct Authority {
    boot: u64,
    stamper: Stamper,
    /// When it started.
    began: MonoTime,
    epoch: u64,
    lease: Option<Lease>,
    asking: Option<Lease>,
    /// From whom the holder of the lease has borrowed it.
    lender: Option<Caller>,
    /// Name of the operator on board or at a direct link who has control.
    local: Option<String>,
    known: BTreeMap<u128, Known>,
    /// Ids of `known`, oldest first.
    ids: VecDeque<u128>,
    /// Until when the orders that are no longer known were fresh, at most.
    forgotten: MonoTime,
    fenced: Vec<u128>,
    recalled: Vec<u128>,
}

impl Authority {
    /// For a station that started at `began`. `boot` is a random number, so that orders to an earlier run are not
    /// executed. `stamper` stamps the states of this run.
    pub fn new(boot: u64, began: MonoTime, stamper: Stamper) -> Self {
        Self {
            boot,
            stamper,
            began,
            epoch: 0,
            lease: None,
            asking: None,
            lender: None,
            local: None,
            known: BTreeMap::new(),
            ids: VecDeque::new(),
            forgotten: MonoTime::ZERO,
            fenced: Vec::new(),
            recalled: Vec::new(),
        }
    }

    /// This boot's number.
    pub fn boot(&self) -> u64 {
        self.boot
    }

    /// The stamp of this moment, for orders to be based on.
    pub fn stamp(&self, now: MonoTime) -> StateStamp {
        self.stamper.stamp(millis(now.as_duration()))
    }

    /// Key of the remote operator who has control, and the epoch.
    pub fn lease(&self) -> Option<(PublicKey, u64)> {
        self.lease.as_ref().map(|lease| (lease.caller.key, self.epoch))
    }

    /// The remote operator who has control.
    pub fn holder(&self) -> Option<&Caller> {
        self.lease.as_ref().map(|lease| &lease.caller)
    }

    /// What is published of it.
    pub fn held(&self) -> Held {
        let name = |lease: &Option<Lease>| lease.as_ref().map(|lease| lease.caller.name.clone()).unwrap_or_default();
        let key = |lease: &Option<Lease>| lease.as_ref().map(|lease| lease.caller.key.0.to_vec()).unwrap_or_default();
        let run = |lease: &Option<Lease>| lease.as_ref().map_or(0, |lease| lease.caller.run);
        Held {
            epoch: self.epoch,
            holder: self.local.clone().unwrap_or_else(|| name(&self.lease)),
            key: key(&self.lease),
            asking: name(&self.asking),
            asking_key: key(&self.asking),
            run: run(&self.lease),
            asking_run: run(&self.asking),
        }
    }

    /// Sets the operator on board or at a direct link who has control. It ends the lease.
    pub fn set_local(&mut self, local: Option<String>) {
        if local.is_some() && self.local.is_none() {
            self.lease = None;
            self.asking = None;
            self.fence();
        }
        self.local = local;
    }

    /// Applies changed roles: control, or a request for it, ends for stations that may no longer act.
    pub fn on_roles(&mut self, role_of: impl Fn(&PublicKey) -> Option<Role>) {
        let may_act = |caller: &mut Caller| {
            let role = role_of(&caller.key).filter(|role| *role != Role::Observer);
            caller.role = role.unwrap_or(caller.role);
            role.is_some()
        };
        self.asking.take_if(|asking| !may_act(&mut asking.caller));
        self.lender.take_if(|lender| !may_act(lender));
        if self.lease.take_if(|lease| !may_act(&mut lease.caller)).is_some() {
            self.fence();
        }
    }

    /// Ends what has expired.
    pub fn on_time(&mut self, now: MonoTime) {
        self.lease.take_if(|lease| lease.until <= now);
        self.asking.take_if(|asking| asking.until <= now);
        self.pass_on();
    }

    /// Control that has become free goes to the station that asks for it, before any other takes it: for as long as its
    /// request would stand, so that control never outlasts a sign of life by more than [`LEASE`].
    fn pass_on(&mut self) {
        if self.lease.is_none()
            && self.local.is_none()
            && let Some(asking) = self.asking.take()
        {
            self.lease = Some(asking);
            self.fence();
        }
    }

    /// The decision on an order that came before; `None` for a new one.
    pub fn on_known(&self, caller: &Caller, claim: &Claim) -> Option<Verdict> {
        let known = self.known.get(&claim.id)?;
        if known.key != caller.key {
            return Some(refused(claim, "this id is another operator's"));
        }
        Some(match &known.answer {
            Some(answer) => Verdict::Answer(Box::new(answer.clone())),
            None => Verdict::UnderWay,
        })
    }

    /// The answer to an order for another run than this one; `None` for one for this run.
    pub fn of_other_boot(&self, claim: &Claim, now: MonoTime) -> Option<Answer> {
        // It is unknown what the other run did with it; its sender may know, by how long this run has lasted.
        let boot_age_ms = millis(now.since(self.began)).max(1);
        (claim.boot != self.boot).then(|| Answer { boot_age_ms, ..answer(claim, End::Unknown, STARTED_AGAIN) })
    }

    /// Decides on an order.
    pub fn on_order(&mut self, caller: &Caller, claim: &Claim, now: MonoTime) -> Verdict {
        self.on_time(now);
        if let Some(known) = self.on_known(caller, claim) {
            return known;
        }
        if let Some(answer) = self.of_other_boot(claim, now) {
            return Verdict::Answer(Box::new(answer));
        }
        if claim.based_on.at > now + AHEAD || self.stamp(claim.based_on.at) != claim.based_on {
            return refused(claim, "it is based on a state that was never sent");
        }
        let fresh_until = claim.based_on.at + FRESH + OVERTAKEN;
        if now.since(claim.based_on.at) > FRESH {
            // If it had been done, its answer would be known, or forgotten since.
            let (end, why) =
                if fresh_until > self.forgotten { (End::Stale, TOO_LATE) } else { (End::Unknown, FORGOTTEN) };
            return ended(claim, end, why);
        }
        if !self.make_room(now) {
            return refused(claim, "too many orders came at once; wait some seconds");
        }
        let verdict = match claim.wish {
            Wish::Ask(_) | Wish::Renew | Wish::Release | Wish::Keep(_) | Wish::Act if caller.role == Role::Observer => {
                refused(claim, "this ground station is an observer: it may look and read, not act")
            }
            Wish::Act | Wish::Read if self.is_recalled(caller, claim.id) => {
                refused(claim, "its sender gave it up before it came")
            }
            Wish::Ask(how) => self.on_ask(caller, how, claim, now),
            Wish::Release if self.asking.take_if(|asking| asking.caller.is_same_program(caller)).is_some() => {
                ended(claim, End::Done, "")
            }
            Wish::Release if self.lender.take_if(|lender| lender.is_same_program(caller)).is_some() => {
                ended(claim, End::Done, "")
            }
            Wish::Read => Verdict::Execute,
            Wish::Recall(id) => {
                // Only an order in progress can be recalled.
                let is_own = |known: &Known| known.key == caller.key && known.answer.is_none();
                self.recalled.extend(self.known.get(&id).filter(|known| is_own(known)).map(|_| id));
                ended(claim, End::Done, "")
            }
            Wish::Renew | Wish::Release | Wish::Keep(_) | Wish::Act => self.on_holders(caller, claim, now),
        };
        let answer = match &verdict {
            Verdict::Execute => None,
            // A renewal is idempotent and frequent: not stored.
            _ if claim.wish == Wish::Renew => return verdict,
            Verdict::Answer(answer) => Some((**answer).clone()),
            Verdict::UnderWay => return verdict,
        };
        let epoch = (claim.wish != Wish::Read).then_some(self.epoch);
        let recalls = if let Wish::Recall(id) = claim.wish { Some(id) } else { None };
        let known = Known { key: caller.key, epoch, fresh_until, keep_until: now + KEEPS_ANSWERS, recalls, answer };
        self.known.insert(claim.id, known);
        self.ids.push_back(claim.id);
        verdict
    }

    /// Whether its sender has recalled an order. That is remembered as long as the order would be fresh: it is based on
    /// no later state than its recall.
    fn is_recalled(&self, caller: &Caller, id: u128) -> bool {
        self.known.values().any(|known| known.recalls == Some(id) && known.key == caller.key)
    }

    fn on_ask(&mut self, caller: &Caller, how: Ask, claim: &Claim, now: MonoTime) -> Verdict {
        if self.local.is_some() {
            return self.held_by(claim, End::Held);
        }
        let Some(lease) = &mut self.lease else {
            return self.grant(caller.clone(), claim, now);
        };
        if lease.caller.is_same_program(caller) {
            lease.renew(caller, now);
            return Verdict::Answer(Box::new(Answer { epoch: self.epoch, ..answer(claim, End::Granted, "") }));
        }
        let is_above = caller.role == Role::Chief && lease.caller.role != Role::Chief;
        if how.overrules && (is_above || lease.caller.key == caller.key) {
            // Whoever had it before all who borrowed it.
            let lender = self.lender.take().unwrap_or_else(|| lease.caller.clone());
            let granted = self.grant(caller.clone(), claim, now);
            self.lender = Some(lender).filter(|lender| how.borrows && !lender.is_same_program(caller));
            return granted;
        }
        match &mut self.asking {
            Some(asking) if asking.caller.is_same_program(caller) => asking.until = now + ASKS_FOR,
            None if !how.only_if_free => {
                self.asking = Some(Lease { caller: caller.clone(), until: now + ASKS_FOR });
            }
            _ => return self.held_by(claim, End::Held),
        }
        self.held_by(claim, End::Asked)
    }

    /// Decides on an order that needs the lease.
    fn on_holders(&mut self, caller: &Caller, claim: &Claim, now: MonoTime) -> Verdict {
        let epoch = self.epoch;
        let holds = |lease: &&mut Lease| lease.caller.is_same_program(caller) && claim.epoch == epoch;
        let Some(lease) = self.lease.as_mut().filter(holds) else {
            return self.held_by(claim, End::Held);
        };
        lease.renew(caller, now);
        match claim.wish {
            Wish::Act => return Verdict::Execute,
            Wish::Release => {
                self.lease = None;
                let lender = self.lender.take();
                self.pass_on();
                if let Some(lender) = lender.filter(|_| self.lease.is_none()) {
                    self.give(lender, now);
                }
            }
            Wish::Keep(key) => {
                self.asking.take_if(|asking| asking.caller.key == key);
            }
            Wish::Renew | Wish::Ask(_) | Wish::Read | Wish::Recall(_) => {}
        }
        ended(claim, End::Done, "")
    }

    fn grant(&mut self, caller: Caller, claim: &Claim, now: MonoTime) -> Verdict {
        self.give(caller, now);
        Verdict::Answer(Box::new(Answer { epoch: self.epoch, ..answer(claim, End::Granted, "") }))
    }

    fn give(&mut self, caller: Caller, now: MonoTime) {
        self.asking.take_if(|asking| asking.caller.is_same_program(&caller));
        self.lease = Some(Lease { caller, until: now + LEASE });
        self.fence();
    }

    /// Begins a new epoch: orders of earlier epochs in progress are to be cancelled.
    fn fence(&mut self) {
        self.lender = None;
        let epoch = self.epoch;
        let under_way =
            self.known.iter().filter(|(_, known)| known.answer.is_none() && known.epoch.is_some_and(|of| of <= epoch));
        self.fenced.extend(under_way.map(|(id, _)| *id));
        self.epoch += 1;
    }

    fn held_by(&self, claim: &Claim, end: End) -> Verdict {
        let holder = self.held().holder;
        let why = if holder.is_empty() { "nobody has control: ask for it" } else { "" };
        Verdict::Answer(Box::new(Answer { holder, ..answer(claim, end, why) }))
    }

    /// Takes the orders in progress that lost their epoch and are to be cancelled.
    pub fn take_fenced(&mut self) -> Vec<u128> {
        std::mem::take(&mut self.fenced)
    }

    /// Takes the orders in progress that were recalled and are to be cancelled.
    pub fn take_recalled(&mut self) -> Vec<u128> {
        std::mem::take(&mut self.recalled)
    }

    /// An executed order has ended with this answer.
    pub fn on_ended(&mut self, id: u128, answer: Answer, now: MonoTime) {
        if let Some(known) = self.known.get_mut(&id) {
            known.answer = Some(answer);
            known.keep_until = now + KEEPS_ANSWERS;
        }
    }

    /// Drops expired answers; whether there is room for one more.
    fn make_room(&mut self, now: MonoTime) -> bool {
        while let Some(id) = self.ids.front() {
            let is_full = self.ids.len() >= MAX_ANSWERS;
            let may_go = |known: &Known| {
                known.answer.is_some() && known.fresh_until < now && (is_full || known.keep_until < now)
            };
            if !self.known.get(id).is_none_or(may_go) {
                break;
            }
            if let Some(gone) = self.known.remove(id) {
                self.forgotten = self.forgotten.max(gone.fresh_until);
            }
            self.ids.pop_front();
        }
        self.ids.len() < MAX_ANSWERS
    }
}

/// An answer to an order.
pub fn answer(claim: &Claim, end: End, why: &str) -> Answer {
    Answer {
        version: VERSION,
        id: claim.id.to_be_bytes().to_vec(),
        end: end.into(),
        why: why.to_owned(),
        ..Answer::default()
    }
}

fn ended(claim: &Claim, end: End, why: &str) -> Verdict {
    Verdict::Answer(Box::new(answer(claim, end, why)))
}

fn refused(claim: &Claim, why: &str) -> Verdict {
    ended(claim, End::Refused, why)
}

#[cfg(test)]
mod schedules;
#[cfg(test)]
mod tests;
