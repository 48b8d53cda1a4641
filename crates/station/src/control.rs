//! The control lease of a station: who may act on its vehicles. Every client (browser, HTTP, Python, Ice) has an
//! [`Operator`] here, and acts in its name. Sans-IO: time is passed in.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tokio::sync::watch;
use vencejo_proto::{MonoTime, plain};

/// How long control stays with an operator that is not attached and does nothing.
pub const GRACE: Duration = Duration::from_secs(5);
/// How long an operator whose request was declined does not ask again by acting.
const DECLINED_FOR: Duration = Duration::from_secs(5 * 60);
/// Characters of an operator's name.
const MAX_NAME: usize = 40;

/// Identifies an operator of a station.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct OperatorId(u64);

/// Why control was not given.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum NotTaken {
    /// Another operator, with this name, holds it.
    Held(String),
    /// The operator was dismissed.
    Dismissed,
}

#[derive(Debug)]
struct Entry {
    name: String,
    /// Number of attachments that show its presence: WebSockets, connections, a running program.
    attached: u32,
    last_used: MonoTime,
    /// Whether control is handed over on request, because no person is there to confirm.
    yields: bool,
    /// Whether a refusal counts as a request for control: for clients that cannot request it.
    asks: bool,
}

impl Entry {
    fn is_alive(&self, now: MonoTime) -> bool {
        self.attached > 0 || now.since(self.last_used) <= GRACE
    }
}

#[derive(Debug, Default)]
struct State {
    operators: BTreeMap<OperatorId, Entry>,
    enlisted: u64,
    holder: Option<OperatorId>,
    asking: Option<OperatorId>,
    /// Those whose requests the present holder has declined, and when.
    declined: BTreeMap<OperatorId, MonoTime>,
    /// The latest time passed in.
    now: MonoTime,
}

/// The lease. Clones are handles to the same.
#[derive(Debug, Clone, Default)]
pub struct Control {
    shared: Arc<(Mutex<State>, watch::Sender<u64>)>,
}

/// A client that may act. Gives control up when it is dropped.
pub struct Operator {
    control: Control,
    id: OperatorId,
}

impl Control {
    /// A new operator. It does not hold control yet; `name` is shown to the others, and is generated when it is empty.
    pub fn enlist(&self, name: &str, now: MonoTime) -> Operator {
        let id = self.change(now, |state| {
            state.enlisted += 1;
            let id = OperatorId(state.enlisted);
            let name = plain(name, MAX_NAME);
            let name =
                if name.trim().is_empty() { format!("station {}", state.enlisted) } else { name.trim().to_owned() };
            state.operators.insert(id, Entry { name, attached: 0, last_used: now, yields: false, asks: false });
            id
        });
        Operator { control: self.clone(), id }
    }

    /// Advances time: an operator that is gone loses control, or its request for it.
    pub fn expire(&self, now: MonoTime) {
        self.change(now, |_| ());
    }

    /// Name of the operator that holds control.
    pub fn holder(&self) -> Option<String> {
        let state = self.state();
        state.holder.and_then(|id| state.name(id))
    }

    /// Whether an attached operator has control, not one that made a single act and keeps it for [`GRACE`].
    pub fn is_attended(&self) -> bool {
        self.state().of_holder(|holder| holder.attached > 0)
    }

    /// Whether the operator that has control hands it over to any that requests it.
    pub fn yields(&self) -> bool {
        self.state().of_holder(|holder| holder.yields)
    }

    /// Whether the operator that has control requests it by acting, and cannot see who else has a vehicle.
    pub fn asks(&self) -> bool {
        self.state().of_holder(|holder| holder.asks)
    }

    /// Name of the operator that requests control.
    pub fn requested_by(&self) -> Option<String> {
        let state = self.state();
        state.asking.and_then(|id| state.name(id))
    }

    /// Grows whenever control changes hands or is requested.
    pub fn news(&self) -> watch::Receiver<u64> {
        self.shared.1.subscribe()
    }

    /// The count of [`Self::news`] now.
    pub fn version(&self) -> u64 {
        *self.shared.1.borrow()
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.shared.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn change<T>(&self, now: impl Into<Option<MonoTime>>, change: impl FnOnce(&mut State) -> T) -> T {
        let mut state = self.state();
        let before = (state.holder, state.asking);
        state.now = now.into().unwrap_or(state.now);
        state.expire();
        let result = change(&mut state);
        if before.0 != state.holder {
            state.declined.clear();
        }
        if before != (state.holder, state.asking) {
            self.shared.1.send_modify(|version| *version += 1);
        }
        result
    }
}

impl State {
    /// Whether this operator asks by acting, and may: it takes no other request's place, and was not declined just now.
    fn may_ask(&self, id: OperatorId) -> bool {
        let asks = self.operators.get(&id).is_some_and(|entry| entry.asks);
        let is_declined = self.declined.get(&id).is_some_and(|at| self.now.since(*at) < DECLINED_FOR);
        asks && self.asking.is_none_or(|asking| asking == id) && !is_declined
    }

    fn of_holder(&self, is_so: impl FnOnce(&Entry) -> bool) -> bool {
        self.holder.and_then(|id| self.operators.get(&id)).is_some_and(is_so)
    }

    fn name(&self, id: OperatorId) -> Option<String> {
        self.operators.get(&id).map(|entry| entry.name.clone())
    }

    fn is_alive(&self, id: OperatorId) -> bool {
        self.operators.get(&id).is_some_and(|entry| entry.is_alive(self.now))
    }

    fn expire(&mut self) {
        if self.asking.is_some_and(|id| !self.is_alive(id)) {
            self.asking = None;
        }
        if self.holder.is_some_and(|id| !self.is_alive(id)) {
            self.hand_on();
        }
    }

    fn hand_on(&mut self) {
        self.holder = self.asking.take().filter(|id| self.is_alive(*id));
    }

    fn release(&mut self, id: OperatorId) {
        self.asking.take_if(|asking| *asking == id);
        if self.holder == Some(id) {
            self.hand_on();
        }
    }

    fn take(&mut self, id: OperatorId) -> Result<(), NotTaken> {
        if let Some(holder) = self.holder
            && holder != id
        {
            return Err(NotTaken::Held(self.name(holder).unwrap_or_default()));
        }
        self.holder = Some(id);
        self.asking.take_if(|asking| *asking == id);
        Ok(())
    }
}

impl Operator {
    /// An operator that hands control over to any that requests it: a program that does not watch for requests.
    #[must_use]
    pub fn yielding(self) -> Self {
        self.with(|entry| entry.yields = true)
    }

    /// An operator that yields, and requests control when it is refused: for clients that can do neither.
    #[must_use]
    pub fn asking(self) -> Self {
        self.yielding().with(|entry| entry.asks = true)
    }

    fn with(self, set: impl FnOnce(&mut Entry)) -> Self {
        if let Some(entry) = self.control.state().operators.get_mut(&self.id) {
            set(entry);
        }
        self
    }

    /// Which one it is.
    pub fn id(&self) -> OperatorId {
        self.id
    }

    /// Its name.
    pub fn name(&self) -> String {
        self.control.state().name(self.id).unwrap_or_default()
    }

    /// The lease.
    pub fn control(&self) -> &Control {
        &self.control
    }

    /// Whether it holds control.
    pub fn has_control(&self) -> bool {
        self.control.state().holder == Some(self.id)
    }

    /// Notes that it is present.
    pub fn touch(&self, now: MonoTime) {
        self.used(now, |_| ());
    }

    /// Marks it present until [`Self::detach`] has been called as often.
    pub fn attach(&self, now: MonoTime) {
        self.used(now, |entry| entry.attached += 1);
    }

    /// Removes one attachment.
    pub fn detach(&self, now: MonoTime) {
        self.used(now, |entry| entry.attached = entry.attached.saturating_sub(1));
    }

    /// Takes control if no other operator has it. Every act does this.
    ///
    /// # Errors
    /// [`NotTaken::Held`] by another operator, [`NotTaken::Dismissed`].
    pub fn take(&self, now: MonoTime) -> Result<(), NotTaken> {
        self.change(now, |state| state.take(self.id))
    }

    /// Takes control to act. If another operator has it, an [`asking`](Self::asking) operator has requested it now,
    /// unless that one has declined its last request within five minutes, or another operator's is open.
    ///
    /// # Errors
    /// [`NotTaken::Held`] by another operator, [`NotTaken::Dismissed`].
    pub fn act(&self, now: MonoTime) -> Result<(), NotTaken> {
        let taken = self.take(now);
        if taken.is_err() && self.change(now, |state| Ok(state.may_ask(self.id))).unwrap_or(false) {
            self.request(now);
        }
        taken
    }

    /// Takes control if it is free or held by the operator with this name.
    ///
    /// # Errors
    /// [`NotTaken::Held`] by an operator of another name, [`NotTaken::Dismissed`].
    pub fn take_over(&self, holder: &str, now: MonoTime) -> Result<(), NotTaken> {
        self.change(now, |state| {
            let is_named = state.holder.and_then(|id| state.name(id)).is_some_and(|name| name == holder);
            if is_named {
                state.holder = None;
            }
            state.take(self.id)
        })
    }

    /// Requests control; takes it when it is free or its holder yields. Returns whether it has control now.
    pub fn request(&self, now: MonoTime) -> bool {
        let is_taken = self.change(now, |state| {
            let asks = state.operators.get(&self.id).is_some_and(|entry| entry.asks);
            if !asks && state.of_holder(|holder| holder.yields) {
                state.holder = None;
            }
            let is_taken = state.take(self.id).is_ok();
            if !is_taken {
                state.asking = Some(self.id);
                state.declined.remove(&self.id);
            }
            Ok(is_taken)
        });
        is_taken.unwrap_or(false)
    }

    /// Declines the request of the operator with this name, even if another's has taken its place since; without a
    /// name, the present request. Without control it does nothing.
    pub fn keep(&self, requested_by: Option<&str>, now: MonoTime) {
        self.control.change(now, |state| {
            if state.holder != Some(self.id) {
                return;
            }
            let is_meant = |(id, entry): &(&OperatorId, &Entry)| match requested_by {
                Some(name) => **id != self.id && entry.name == name,
                None => state.asking == Some(**id),
            };
            let declined: Vec<_> = state.operators.iter().filter(is_meant).map(|(id, _)| *id).collect();
            state.asking.take_if(|asking| declined.contains(asking));
            state.declined.extend(declined.into_iter().map(|id| (id, now)));
        });
    }

    /// Gives control up, to the operator that requests it if there is one. One that only requests it withdraws its
    /// request.
    pub fn release(&self, now: MonoTime) {
        self.control.change(now, |state| state.release(self.id));
    }

    /// Ends the operator, even if handles to it remain: it gives control up and never gets it again.
    pub fn dismiss(&self) {
        // A drop has no time at hand; the latest one will do.
        self.control.change(None, |state| {
            state.release(self.id);
            state.operators.remove(&self.id);
            state.declined.remove(&self.id);
        });
    }

    /// Marks it present and applies a change of control, unless it was dismissed.
    fn change<T>(&self, now: MonoTime, change: impl FnOnce(&mut State) -> Result<T, NotTaken>) -> Result<T, NotTaken> {
        self.touch(now);
        self.control.change(now, |state| {
            if state.operators.contains_key(&self.id) { change(state) } else { Err(NotTaken::Dismissed) }
        })
    }

    fn used(&self, now: MonoTime, change: impl FnOnce(&mut Entry)) {
        // Before anything expires: an operator that is active in time keeps what it has.
        let mut state = self.control.state();
        if let Some(entry) = state.operators.get_mut(&self.id) {
            entry.last_used = entry.last_used.max(now);
            change(entry);
        }
    }
}

impl Drop for Operator {
    fn drop(&mut self) {
        self.dismiss();
    }
}

impl fmt::Debug for Operator {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Operator({}, {:?})", self.id.0, self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(s: u64) -> MonoTime {
        MonoTime::from_millis(s * 1000)
    }

    #[test]
    fn the_first_who_acts_has_it_until_it_goes() {
        let control = Control::default();
        let (ana, script) = (control.enlist("Ana", at(0)), control.enlist("script", at(0)));
        assert_eq!(control.holder(), None, "to be there is not to act");
        script.attach(at(0));
        assert!(!control.is_attended());
        assert_eq!(script.take(at(1)), Ok(()));
        assert!(control.is_attended());
        assert_eq!(ana.take(at(1)), Err(NotTaken::Held("script".into())));
        control.expire(at(1000));
        assert!(script.has_control(), "a program that runs is there");
        script.detach(at(1000));
        control.expire(at(1005));
        assert!(script.has_control() && !control.is_attended(), "five seconds to come back");
        control.expire(at(1006));
        assert_eq!(control.holder(), None);
        assert_eq!(ana.take(at(1006)), Ok(()));
        drop(ana);
        assert_eq!(control.holder(), None, "control ends with who held it");
    }

    #[test]
    fn it_is_asked_for_given_up_and_taken_over_by_name() {
        let control = Control::default();
        let (ana, ice, script) =
            (control.enlist("Ana", at(0)), control.enlist("Ice", at(0)), control.enlist("s", at(0)));
        let news = control.version();
        ana.take(at(0)).expect("free");
        assert!(!ice.request(at(1)));
        assert_eq!(control.requested_by().as_deref(), Some("Ice"));
        ana.release(at(2));
        assert!(ice.has_control(), "it goes to the one that asked");
        assert_eq!(script.take_over("Ana", at(3)), Err(NotTaken::Held("Ice".into())), "not the one that was named");
        assert_eq!(script.take_over("Ice", at(3)), Ok(()));
        assert!(script.has_control() && !ice.has_control());
        assert!(control.version() >= news + 4, "everybody can know");
    }

    #[test]
    fn one_that_cannot_ask_asks_by_acting() {
        let control = Control::default();
        let (ana, ice) = (control.enlist("Ana", at(0)), control.enlist("Ice", at(0)).asking());
        assert_eq!(ice.act(at(0)), Ok(()), "nobody has it");
        ice.release(at(0));
        ana.take(at(0)).expect("free");
        assert_eq!(ice.act(at(1)), Err(NotTaken::Held("Ana".into())));
        assert_eq!(control.requested_by().as_deref(), Some("Ice"));
        ana.release(at(2));
        assert_eq!(ice.act(at(3)), Ok(()));
        assert_eq!(ana.take(at(3)), Err(NotTaken::Held("Ice".into())), "it is not just taken");
        assert!(ana.request(at(3)), "who asks a program that cannot answer has it");
        let script = control.enlist("script", at(3)).yielding();
        assert!(!script.request(at(3)) && script.take_over("Ana", at(3)).is_ok());
        assert!(
            ice.act(at(4)).is_err() && script.has_control(),
            "two programs do not take it from each other by acting"
        );
        assert!(ana.request(at(4)));
        // Declined, it does not ask again by itself; a person may ask for it, and another holder is asked anew.
        assert!(ice.act(at(5)).is_err());
        ana.keep(None, at(5));
        assert!(ice.act(at(6)).is_err());
        assert_eq!(control.requested_by(), None);
        assert!(!ice.request(at(7)));
        assert_eq!(control.requested_by().as_deref(), Some("Ice"));
        ana.keep(None, at(7));
        script.take_over("Ana", at(8)).expect("Ana has it");
        assert!(ice.act(at(8)).is_err());
        assert_eq!(control.requested_by().as_deref(), Some("Ice"));
    }

    #[test]
    fn all_that_were_declined_stay_so_until_control_changes_hands_or_for_some_minutes() {
        let control = Control::default();
        let [ana, luis] = ["Ana", "Luis"].map(|name| control.enlist(name, at(0)));
        let [ice, ros] = ["Ice", "ROS 2"].map(|name| control.enlist(name, at(0)).asking());
        ana.attach(at(0));
        ana.take(at(0)).expect("free");
        // Each acts, in turn; what Ana is asked.
        let asked = |second| {
            let mut asked = Vec::new();
            for operator in [&ice, &ros] {
                assert_eq!(operator.act(at(second)), Err(NotTaken::Held("Ana".into())));
                asked.extend(control.requested_by());
            }
            asked
        };
        assert_eq!(asked(1), ["Ice", "Ice"], "who asks by acting does not push a request aside");
        ana.keep(None, at(1));
        assert_eq!(asked(2), ["ROS 2"]);
        ice.keep(Some("ROS 2"), at(2));
        ana.keep(Some("nobody"), at(2));
        assert_eq!(control.requested_by().as_deref(), Some("ROS 2"));
        // A person asks while Ana reads who does: it is the program that she declines.
        assert!(!luis.request(at(2)));
        ana.keep(Some("ROS 2"), at(2));
        assert_eq!(control.requested_by().as_deref(), Some("Luis"));
        luis.release(at(2));
        assert_eq!((asked(3), asked(300)), (vec![], vec![]));
        assert_eq!(asked(301), ["Ice", "Ice"], "five minutes after it was declined");
        ana.keep(None, at(301));
        assert_eq!(asked(302), ["ROS 2"]);
        ana.keep(None, at(302));
        ana.release(at(303));
        ice.act(at(303)).expect("free");
        assert!(ana.request(at(304)), "a program hands it over");
        assert_eq!(asked(305), ["Ice", "Ice"], "it had control since");
    }

    #[test]
    fn a_request_ends_with_who_made_it() {
        let control = Control::default();
        let (ana, gone) = (control.enlist("Ana", at(0)), control.enlist("gone", at(0)));
        ana.attach(at(0));
        ana.take(at(0)).expect("free");
        assert!(!gone.request(at(0)));
        ana.release(at(10));
        assert_eq!((control.holder(), control.requested_by()), (None, None));
    }

    #[test]
    fn one_that_was_dismissed_gets_nothing_more() {
        let control = Control::default();
        let (ana, over) = (control.enlist("Ana", at(0)), control.enlist("over", at(0)));
        over.take(at(0)).expect("free");
        over.dismiss();
        assert_eq!(control.holder(), None, "it gave control up");
        let all_refused = |now| {
            assert_eq!(over.take(now), Err(NotTaken::Dismissed));
            assert_eq!(over.act(now), Err(NotTaken::Dismissed));
            assert_eq!(over.take_over("Ana", now), Err(NotTaken::Dismissed));
            assert!(!over.request(now));
        };
        all_refused(at(1));
        ana.take(at(1)).expect("free");
        all_refused(at(1));
        let yielding = ana.yielding();
        all_refused(at(1));
        assert!(yielding.has_control(), "nor does it take anything from others");
        assert_eq!(control.requested_by(), None);
    }

    #[test]
    fn names_are_short_and_clean() {
        let control = Control::default();
        let name = control.enlist(&format!("\u{1b}[31m{}", "x".repeat(99)), at(0)).name();
        assert!(name.chars().count() <= MAX_NAME && !name.contains('\u{1b}'), "{name}");
        assert_eq!(control.enlist("  ", at(0)).name(), "station 2");
    }
}
