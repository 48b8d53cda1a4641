//! Orders of a ground station to one aircraft: delivered, followed, recalled.

use std::sync::Arc;
use std::time::Duration;

use prost::Message;
use tokio::task::JoinSet;
use vencejo_flight::plan::Mission;
use vencejo_proto::MonoTime;
use vencejo_station::{Carried, FarHeld, FarWish, Remote, RequestResult, Silence, StationError, Telling};
use vencejo_vehicle::modes::ModeFamily;
use vencejo_vehicle::{Danger, PlanState, Reply, Request, VehicleError};

use super::super::network::{self, Replies};
use super::known::{Followed, Requested};
use super::{CONTROL_PATIENCE, FarAircraft, Fleet};
use crate::act;
use crate::authority::{FRESH, STARTED_AGAIN};
use crate::content::{MAX_WITH_ORDER, Part, unpack_items, unpack_params};
use crate::deed::{Act, Deed, Nothing};
use crate::delivery::{self, AGAIN_AFTER, OrderDelivery, Step};
use crate::key::{Kind, key_of};
use crate::operator::random;
use crate::outcome::{Outcome, PlanOutcome};
use crate::payload::{Answer, Ask, BadPayload, End, Order, Signed, VERSION, Want};
use crate::state_source::millis;

/// The timeout of an act.
const ACT_PATIENCE: Duration = Duration::from_secs(20);
/// The timeout of a transfer without progress: as long as its answer is kept on board.
const TRANSFER_PATIENCE: Duration = Duration::from_secs(60);
/// Parts of a list that are sent at once.
const PARTS_AT_ONCE: usize = 3;

type OrderId = [u8; 16];

/// An order with a waiting caller: when the caller gives it up, it is recalled on board.
struct Waited {
    far: Arc<FarAircraft>,
    id: OrderId,
    operator: String,
    has_ended: bool,
}

impl Waited {
    fn new(far: &Arc<FarAircraft>, id: OrderId, operator: &str, telling: &Telling) -> Self {
        let followed = Followed { telling: telling.clone(), heard_at: MonoTime::ZERO };
        far.known().followed.insert(id.to_vec(), followed);
        Self { far: far.clone(), id, operator: operator.to_owned(), has_ended: false }
    }
}

impl Drop for Waited {
    fn drop(&mut self) {
        self.far.known().followed.remove(self.id.as_slice());
        // Closing the station is like a cut network: its orders go on.
        let is_open = self.far.fleet.upgrade().is_some_and(|fleet| !fleet.station.is_closed());
        if let (false, true, Ok(runtime)) = (self.has_ended, is_open, tokio::runtime::Handle::try_current()) {
            let (far, id, operator) = (self.far.clone(), self.id.to_vec(), self.operator.clone());
            runtime.spawn(async move {
                // If this is lost, the order goes on to its end.
                let _ = far.send(Want::Recall(id), &operator, 0, CONTROL_PATIENCE).await;
            });
        }
    }
}

fn is_transfer(request: &Request) -> bool {
    matches!(
        request,
        Request::UploadPlan { .. } | Request::ClearPlan { .. } | Request::DownloadPlan { .. } | Request::ParamList
    )
}

/// Whether this is the answer to an order from the boot that it is for: the others give their age.
fn decides(answer: &[u8], id: &OrderId) -> bool {
    Answer::read(answer).is_ok_and(|answer| answer.id == id && answer.boot_age_ms == 0)
}

/// Whether the order came too late, and was never done.
fn is_late(outcome: &delivery::Outcome) -> bool {
    matches!(outcome, delivery::Outcome::Answered(answer) if answer.end() == End::Stale && answer.boot_age_ms == 0)
}

/// Attempts of one order: when each was sent, and what came back.
type Attempts = JoinSet<(MonoTime, Replies)>;

/// The first answer to any of the attempts, or what else became of the newest one; an earlier one is not over because
/// its answer is late.
async fn first_answer(attempts: &mut Attempts, newest: MonoTime, wait: Duration) -> (MonoTime, Replies) {
    let first = async {
        while let Some(ended) = attempts.join_next().await {
            match ended {
                Ok((sent_at, heard)) if sent_at == newest || matches!(heard, Replies::Answers(_)) => {
                    return (sent_at, heard);
                }
                _ => {}
            }
        }
        (newest, Replies::Silence)
    };
    tokio::time::timeout(wait, first).await.unwrap_or((newest, Replies::Silence))
}

impl FarAircraft {
    fn new_id(&self) -> Result<OrderId, StationError> {
        random::<16>().map_err(|error| self.refused(&error.to_string()))
    }

    /// Delivers an order to the followed boot until it is answered or given up. Another computer of that name does not
    /// execute it: the order names the boot.
    pub(super) async fn send(
        &self,
        want: Want,
        operator: &str,
        epoch: u64,
        patience: Duration,
    ) -> Result<delivery::Outcome, StationError> {
        self.send_as(self.new_id()?, None, want, operator, epoch, patience).await
    }

    /// The same, to this boot: refused when another is followed now.
    async fn send_to(
        &self,
        boot: u64,
        want: Want,
        operator: &str,
        patience: Duration,
    ) -> Result<delivery::Outcome, StationError> {
        self.send_as(self.new_id()?, Some(boot), want, operator, 0, patience).await
    }

    async fn send_as(
        &self,
        id: OrderId,
        to: Option<u64>,
        want: Want,
        operator: &str,
        epoch: u64,
        patience: Duration,
    ) -> Result<delivery::Outcome, StationError> {
        let fleet = self.fleet.upgrade().ok_or(StationError::Closed)?;
        let now = fleet.station.now();
        let ((boot, based_on), round_trip) = {
            let known = self.known();
            let age = known.listener.age(now);
            let picture = known.listener.stamp().filter(|_| age < FRESH);
            (picture.ok_or(StationError::Vehicle(VehicleError::NotHeard { age }))?, known.round_trip)
        };
        if to.is_some_and(|to| to != boot) {
            return Err(self.refused(STARTED_AGAIN));
        }
        let is_answered_at_once = !matches!(want, Want::Act(_));
        let asks = matches!(want, Want::Ask(_));
        if asks {
            self.known().unanswered = Some(boot);
        }
        let order = Order {
            version: VERSION,
            org: fleet.org.to_string(),
            aircraft: self.name.to_string(),
            boot,
            epoch,
            id: id.to_vec(),
            based_on_ms: millis(based_on.at.as_duration()),
            operator: operator.to_owned(),
            mark: based_on.mark,
            run: fleet.own.run,
            want: Some(want),
        }
        .encode_to_vec();
        let signature = fleet.signer.sign(&order);
        let signed = Signed { key: fleet.signer.public().0.to_vec(), order, signature }.encode_to_vec();
        let key = key_of(&fleet.org, &self.name, Kind::Order);
        let mut delivery = OrderDelivery::new(patience, round_trip, now);
        let (mut step, mut attempts) = (delivery.start(), JoinSet::new());
        loop {
            let (after, wait) = match step {
                Step::Send { after, wait } => (after, wait),
                Step::End(outcome) => {
                    if asks && !matches!(outcome, delivery::Outcome::Unknown { .. }) {
                        self.known().unanswered = None;
                    }
                    if let delivery::Outcome::Answered(answer) = &outcome
                        && answer.end() == End::Granted
                    {
                        self.known().on_granted(boot, answer.epoch);
                    }
                    return Ok(outcome);
                }
            };
            tokio::time::sleep(after).await;
            let was_present = self.known().is_present;
            let (session, key, signed, sent_at) = (fleet.session(), key.clone(), signed.clone(), fleet.station.now());
            attempts.spawn(async move {
                let decides = |answer: &[u8]| decides(answer, &id);
                (sent_at, network::ask_for(&session, &key, signed, ACT_PATIENCE, wait, decides).await)
            });
            let (sent_at, heard) = first_answer(&mut attempts, sent_at, wait).await;
            let now = fleet.station.now();
            let heard_at = {
                let mut known = self.known();
                // Without the deciding one, the attempt was held open for it.
                if let (true, Replies::Answers(answers)) = (is_answered_at_once, &heard)
                    && answers.iter().any(|answer| decides(answer, &id))
                {
                    known.round_trip.on_answer(now.since(sent_at));
                }
                if let Some(followed) = known.followed.get(id.as_slice()) {
                    delivery.on_sign(followed.heard_at);
                }
                known.listener.heard_at(boot).unwrap_or_default()
            };
            let answers = match heard {
                Replies::Answers(answers) => answers,
                // If the aircraft was present when it was sent, it may have arrived, whatever the network reports when
                // it loses the route.
                Replies::Nobody if was_present => {
                    tokio::time::sleep(AGAIN_AFTER).await;
                    step = delivery.on_silence(now);
                    continue;
                }
                Replies::Nobody => {
                    step = delivery.on_nobody(now);
                    continue;
                }
                Replies::Silence => {
                    step = delivery.on_silence(now);
                    continue;
                }
            };
            let read = answers.iter().filter_map(|bytes| Answer::read(bytes).ok());
            // When an ending program and its successor both answer, the addressed one knows.
            step = match read.filter(|answer| answer.id == id).min_by_key(|answer| answer.boot_age_ms) {
                Some(answer) => delivery.on_answer(answer, heard_at, now),
                None => delivery.on_silence(now),
            };
        }
    }

    /// The epoch in which we have control, as far as is known.
    fn epoch(&self) -> Option<u64> {
        let own = self.fleet.upgrade()?.own;
        self.known().epoch(&own)
    }

    /// The epoch in which we have control of this boot; takes control that is free, or from whom we overrule. No request
    /// is made: that is [`Self::ask`]'s. An order that came too late is repeated once if `again`.
    async fn lease(self: &Arc<Self>, boot: u64, operator: &str, again: bool) -> Result<u64, StationError> {
        // Not behind an order for control that waits for its answer.
        if let Some(epoch) = self.epoch() {
            return Ok(epoch);
        }
        let _one = self.asking.lock().await;
        if let Some(epoch) = self.epoch() {
            return Ok(epoch);
        }
        let take = || self.send_to(boot, self.ask_for(true, operator), operator, CONTROL_PATIENCE);
        let mut outcome = take().await?;
        if again && is_late(&outcome) {
            self.look_again().await;
            outcome = take().await?;
        }
        match outcome {
            delivery::Outcome::Answered(answer) if answer.end() == End::Granted => Ok(answer.epoch),
            outcome => Err(self.not_done(outcome)),
        }
    }

    /// An order for control, for this operator.
    fn ask_for(&self, only_if_free: bool, operator: &str) -> Want {
        let ask = Ask { only_if_free, ..Ask::default() };
        let Some(fleet) = self.fleet.upgrade() else { return Want::Ask(ask) };
        let control = fleet.station.control();
        // A client that cannot see who has the aircraft takes it from nobody, nor does one that has gone meanwhile; a
        // program that somebody has stopped takes it back by asking, not with its next act.
        let (is_here, is_program) = (control.holder().as_deref() == Some(operator), control.yields());
        let is_stopped = only_if_free && is_program && self.known().has_lost;
        let overrules = fleet.overrules && is_here && !control.asks() && !is_stopped;
        // A person who takes it from a program stops it; a program only has its turn.
        Want::Ask(Ask { overrules, borrows: overrules && is_program, ..ask })
    }

    /// Requests a state that the next order can be based on.
    async fn look_again(self: &Arc<Self>) {
        if let Some(fleet) = self.fleet.upgrade() {
            self.ask_everything(&fleet).await;
        }
    }

    /// Waits, no longer than a transfer does, for a state that the next order can be based on.
    async fn wait_fresh(&self) {
        let fresh = async {
            while self.age() >= Some(FRESH) {
                tokio::time::sleep(AGAIN_AFTER).await;
            }
        };
        // Without one, sending fails.
        let _ = tokio::time::timeout(TRANSFER_PATIENCE, fresh).await;
    }

    /// Asks the holder for control, or takes it if it is free. The request stands until it is granted, declined or
    /// withdrawn, or nobody has control of our station.
    async fn ask(&self, boot: Option<u64>, operator: String) -> Result<(), StationError> {
        let boot = boot.ok_or_else(|| self.unreached())?;
        let _one = self.asking.lock().await;
        if self.epoch().is_some() {
            return Ok(());
        }
        match self.send_to(boot, self.ask_for(false, &operator), &operator, CONTROL_PATIENCE).await? {
            delivery::Outcome::Answered(answer) if answer.end() == End::Asked => {
                self.known().request = Some(Requested { boot, operator });
                Ok(())
            }
            delivery::Outcome::Answered(answer) if answer.end() == End::Granted => Ok(()),
            delivery::Outcome::Answered(answer) if answer.end() == End::Held => {
                let asking = Some(self.known().listener.held().asking.clone()).filter(|asking| !asking.is_empty());
                let is_first = |asking| format!("{asking} has asked for control already; wait until that is answered");
                let held = delivery::Outcome::Answered(answer);
                Err(asking.map_or_else(|| self.not_done(held), |asking| self.refused(&is_first(asking))))
            }
            outcome => Err(self.not_done(outcome)),
        }
    }

    /// Keeps up a request for control.
    async fn keep_asking(&self) {
        // Its turn comes again.
        let Ok(_one) = self.asking.try_lock() else { return };
        let Some(Requested { boot, operator }) = self.known().request.clone() else { return };
        let sent = self.send_to(boot, self.ask_for(true, &operator), &operator, Duration::ZERO).await;
        let has_ended = match sent {
            // Whatever else it is, such as too late, it may stand on board. What is refused, as for a role that was
            // taken away, is not asked for until it is allowed.
            Ok(delivery::Outcome::Answered(answer)) => {
                matches!(answer.end(), End::Held | End::Granted | End::Refused)
            }
            Ok(_) | Err(StationError::Vehicle(_)) => false,
            // Another boot is followed.
            Err(_) => true,
        };
        if has_ended {
            self.known().request = None;
        }
    }

    /// Declines the request for our control, if that is the one of this name.
    async fn keep(&self, requested_by: Option<String>, operator: &str) -> Result<(), StationError> {
        let (epoch, held) = (self.epoch(), self.known().listener.held().clone());
        let is_meant = !held.asking.is_empty() && requested_by.is_none_or(|name| name == held.asking);
        let Some(epoch) = epoch.filter(|_| is_meant) else { return Ok(()) };
        match self.send(Want::Keep(held.asking_key), operator, epoch, CONTROL_PATIENCE).await? {
            delivery::Outcome::Answered(answer) if answer.end() == End::Done => Ok(()),
            outcome => Err(self.not_done(outcome)),
        }
    }

    /// The error of an order for control or of a part of a list.
    fn not_done(&self, outcome: delivery::Outcome) -> StationError {
        match outcome {
            delivery::Outcome::Answered(answer) if answer.boot_age_ms > 0 => self.refused(&answer.why),
            delivery::Outcome::Answered(answer) => match self.result_of(&answer, &Request::LoiterHere) {
                Err(error) => error,
                Ok(_) => self.unreached(),
            },
            delivery::Outcome::Unreached | delivery::Outcome::Unknown { .. } => self.unreached(),
        }
    }

    pub(super) fn unreached(&self) -> StationError {
        StationError::Vehicle(VehicleError::NotHeard { age: self.age().unwrap_or(FRESH) })
    }

    /// The age of its newest state; `None` when the fleet was left.
    fn age(&self) -> Option<Duration> {
        let now = self.fleet.upgrade()?.station.now();
        Some(self.known().listener.age(now))
    }

    pub(super) fn refused(&self, why: &str) -> StationError {
        StationError::RemoteRefused { name: self.name.to_string(), why: why.to_owned() }
    }

    fn result_of(&self, answer: &Answer, request: &Request) -> RequestResult {
        let id = self.known().id;
        let mode = self.fleet.upgrade().and_then(|fleet| fleet.station.vehicle(id?)?.telemetry().0.mode());
        let family = mode.map_or(ModeFamily::Other, |mode| mode.family);
        act::result_of(answer, request, self.name.as_str(), family)
    }

    async fn carry(
        self: Arc<Self>,
        boot: Option<u64>,
        request: Request,
        confirmed: Option<Danger>,
        operator: String,
        telling: Telling,
    ) -> RequestResult {
        let boot = boot.ok_or_else(|| self.unreached())?;
        if request.is_act() {
            self.settle().await;
        }
        let mut act = act::act_of(&request, confirmed).map_err(|why| self.refused(why))?;
        let list = self.prepare(&mut act).await?;
        let patience = if is_transfer(&request) { TRANSFER_PATIENCE } else { ACT_PATIENCE };
        // What changes the flight is given again by those who have looked at it again.
        let may_repeat = is_transfer(&request) || !request.is_act();
        let began = tokio::time::Instant::now();
        let (mut has_asked_again, mut has_sent_again, mut sends_list) = (false, false, true);
        loop {
            let control =
                async { if request.is_act() { self.lease(boot, &operator, may_repeat).await } else { Ok(0) } };
            let parts = if std::mem::take(&mut sends_list) { list.clone() } else { Vec::new() };
            let (epoch, ()) = tokio::try_join!(control, self.deliver(boot, parts, &operator))?;
            // It may have waited for long: it is not sent beside another who has our station's control since.
            let holder = self.fleet.upgrade().and_then(|fleet| fleet.station.control().holder());
            if let Some(holder) = holder.filter(|holder| request.is_act() && *holder != operator) {
                return Err(StationError::Control { holder, vehicle: None });
            }
            let mut waited = Waited::new(&self, self.new_id()?, &operator, &telling);
            let outcome = self.send_as(waited.id, Some(boot), Want::Act(act.clone()), &operator, epoch, patience).await;
            waited.has_ended = true;
            drop(waited);
            let outcome = outcome?;
            if may_repeat && is_late(&outcome) && began.elapsed() < patience {
                self.look_again().await;
                continue;
            }
            let mut answer = match outcome {
                delivery::Outcome::Answered(answer) => answer,
                delivery::Outcome::Unreached => return Err(self.unreached()),
                delivery::Outcome::Unknown { attempts, waited } => {
                    return Err(act::unknown_end(&request, self.name.as_str(), attempts, waited, Vec::new()));
                }
            };
            if let Some(state) = answer.state.take() {
                self.on_effects(&state);
            }
            match answer.end() {
                End::Held => {
                    self.known().on_lost(epoch, &answer.holder);
                    // The lease ran out, and is free.
                    if answer.holder.is_empty() && !std::mem::replace(&mut has_asked_again, true) {
                        continue;
                    }
                }
                End::ListMissing if !std::mem::replace(&mut has_sent_again, true) => {
                    sends_list = true;
                    continue;
                }
                _ => {}
            }
            if let Err(error) = self.result_of(&answer, &request) {
                // The answer does not have the state of the plan, which must be known before the next attempt.
                if is_transfer(&request) {
                    self.look_again().await;
                }
                return Err(error);
            }
            return self.reply(request, *answer, &telling).await;
        }
    }

    /// Waits until it is clear which computer the followed boot is of.
    async fn settle(&self) {
        let wait = self.fleet.upgrade().map(|fleet| self.known().listener.settled_at().since(fleet.station.now()));
        tokio::time::sleep(wait.unwrap_or_default()).await;
    }

    /// Fills in the plan revision that an order is based on; returns the parts of its list if they are sent separately.
    async fn prepare(self: &Arc<Self>, act: &mut Act) -> Result<Vec<Part>, StationError> {
        let (kind, revision) = match &mut act.deed {
            Some(Deed::PlanPut(put)) => (put.kind, &mut put.revision),
            Some(Deed::PlanClear(clear)) => (clear.kind, &mut clear.revision),
            _ => return Ok(Vec::new()),
        };
        let kind = crate::plans::kind_of(kind).map_err(|error| self.unreadable(&error))?;
        let seen = || self.known().plans.told(kind).map(|told| told.revision);
        if seen().is_none() {
            let fleet = self.fleet.upgrade().ok_or(StationError::Closed)?;
            self.ask_everything(&fleet).await;
        }
        *revision = seen().ok_or_else(|| self.unreached())?;
        let Some(Deed::PlanPut(put)) = &mut act.deed else { return Ok(Vec::new()) };
        let Some(list) = put.list.as_mut().filter(|list| list.here.len() > MAX_WITH_ORDER) else {
            return Ok(Vec::new());
        };
        Ok(Part::all_of(&std::mem::take(&mut list.here)))
    }

    /// Delivers the parts of a list.
    async fn deliver(self: &Arc<Self>, boot: u64, parts: Vec<Part>, operator: &str) -> Result<(), StationError> {
        let (mut parts, mut on_their_way) = (parts.into_iter(), JoinSet::new());
        loop {
            while on_their_way.len() < PARTS_AT_ONCE
                && let Some(part) = parts.next()
            {
                let (far, operator) = (self.clone(), operator.to_owned());
                on_their_way
                    .spawn(async move { far.send_to(boot, Want::Part(part), &operator, TRANSFER_PATIENCE).await });
            }
            match on_their_way.join_next().await {
                None => return Ok(()),
                Some(Ok(outcome)) => match outcome? {
                    // The network may have been cut until now.
                    delivery::Outcome::Answered(answer) if answer.end() == End::Done => self.wait_fresh().await,
                    outcome => return Err(self.not_done(outcome)),
                },
                Some(Err(_)) => return Err(StationError::Closed),
            }
        }
    }

    /// The reply of an answer.
    async fn reply(self: &Arc<Self>, request: Request, answer: Answer, telling: &Telling) -> RequestResult {
        let unreadable = |error: BadPayload| self.unreadable(&error);
        Ok(match answer.outcome {
            None | Some(Outcome::Fault(_)) => Reply::Done,
            Some(Outcome::Acknowledged(result_param2)) => Reply::Acknowledged { result_param2 },
            Some(Outcome::Message(said)) => {
                let message = said.message().ok_or_else(|| unreadable(BadPayload::Field("message")))?;
                Reply::Message(Box::new(message))
            }
            Some(Outcome::Param(param)) => {
                let param = param.read().map_err(unreadable)?;
                self.on_params(&[param]);
                Reply::Parameter(param)
            }
            Some(Outcome::Params(content)) => {
                let packed = self.fetch(&content, Some(telling)).await?;
                let params = unpack_params(&packed).map_err(unreadable)?;
                self.on_params(&params);
                Reply::Parameters(params)
            }
            Some(Outcome::Plan(plan)) => self.plan_reply(request, plan, telling).await?,
        })
    }

    fn on_params(&self, params: &[vencejo_vehicle::Param]) {
        let id = self.known().id;
        if let (Some(fleet), Some(id)) = (self.fleet.upgrade(), id) {
            fleet.station.on_remote_parameters(id, params);
        }
    }

    /// A plan as the vehicle has it; shown here before the caller continues.
    async fn plan_reply(self: &Arc<Self>, request: Request, plan: PlanOutcome, telling: &Telling) -> RequestResult {
        let told = plan.told.ok_or_else(|| self.unreadable(&BadPayload::Field("told")))?;
        let (kind, state) = told.read().map_err(|error| self.unreadable(&error))?;
        self.known().plans.on_told(&told);
        let list = match &plan.list {
            None => Ok(Mission::default()),
            Some(content) => self
                .fetch(content, Some(telling))
                .await
                .and_then(|packed| unpack_items(&packed).map_err(|error| self.unreadable(&error))),
        };
        let Mission { items, home } = match (list, request) {
            (Ok(list), _) => {
                let (id, is_known) = {
                    let known = self.known();
                    (known.id, known.plans.told(kind).is_some_and(|known| known.revision > told.revision))
                };
                if let (false, Some(fleet), Some(id)) = (is_known, self.fleet.upgrade(), id) {
                    let has_list = !matches!(state, PlanState::Empty | PlanState::Unknown(_));
                    fleet.station.on_remote_plan(id, kind, state, has_list.then(|| list.clone()));
                }
                list
            }
            // The vehicle has it: it was compared on board.
            (Err(_), Request::UploadPlan { items, home, .. }) => Mission { items, home },
            (Err(error), _) => return Err(error),
        };
        Ok(Reply::Plan { kind, items, home, state, position_error_m: plan.position_error_m })
    }

    pub(super) async fn renew(&self) {
        let Some(epoch) = self.epoch() else { return };
        let renewed = self.send(Want::Renew(Nothing {}), "", epoch, Duration::ZERO).await;
        if let Ok(delivery::Outcome::Answered(answer)) = renewed
            && answer.end() == End::Held
        {
            self.known().on_lost(epoch, &answer.holder);
        }
    }

    /// Gives control up, to the station that asks for it if there is one; or withdraws our request. What is lost of this
    /// expires on board by itself.
    ///
    /// # Errors
    /// When it was not delivered.
    pub(super) async fn release(self: &Arc<Self>, patience: Duration) -> Result<(), StationError> {
        // What keeps a request up would take control that has become free, and one that is under way would stand.
        let _one = tokio::time::timeout(patience, self.asking.lock()).await.ok();
        let Some(epoch) = self.known().give_up() else { return Ok(()) };
        let give_up = |epoch| self.send(Want::Release(Nothing {}), "", epoch, patience);
        let mut outcome = give_up(epoch).await?;
        let is_held = matches!(&outcome, delivery::Outcome::Answered(answer) if answer.end() == End::Held);
        if epoch == 0 && is_held {
            // It may have been granted before it was withdrawn.
            let _ = tokio::time::timeout(patience, self.look_again()).await;
            let own = self.fleet.upgrade().ok_or(StationError::Closed)?.own;
            let granted = self.known().shown(&own);
            if let Some(epoch) = granted {
                outcome = give_up(epoch).await?;
            }
        }
        match outcome {
            // Held: another has it already, or it is free.
            delivery::Outcome::Answered(answer) if matches!(answer.end(), End::Done | End::Held) => Ok(()),
            outcome => Err(self.not_done(outcome)),
        }
    }
}

impl Fleet {
    /// Renews control of aircraft, and requests for it, while an operator is here; releases it otherwise.
    pub(super) fn renew(&self) {
        let is_manned = self.station.control().holder().is_some();
        let aircraft: Vec<_> = self.aircraft().values().filter(|far| far.known().is_claimed()).cloned().collect();
        for far in aircraft {
            tokio::spawn(async move {
                if !is_manned {
                    // If it is lost, it expires on board by itself.
                    let _ = far.release(CONTROL_PATIENCE).await;
                } else if far.known().request.is_some() {
                    far.keep_asking().await;
                } else {
                    far.renew().await;
                }
            });
        }
    }
}

impl Remote for FarAircraft {
    fn request(
        self: Arc<Self>,
        request: Request,
        confirmed: Option<Danger>,
        operator: String,
        telling: Telling,
    ) -> Carried {
        // It is for the computer whose state is shown now.
        let boot = self.known().boot();
        Box::pin(self.carry(boot, request, confirmed, operator, telling))
    }

    fn control(self: Arc<Self>, wish: FarWish, operator: String) -> Carried {
        let boot = self.known().boot();
        Box::pin(async move {
            match wish {
                FarWish::Request => self.ask(boot, operator).await?,
                FarWish::Release => self.release(CONTROL_PATIENCE).await?,
                FarWish::Keep { requested_by } => self.keep(requested_by, &operator).await?,
            }
            // Who has it now is shown before the caller goes on.
            if let Some(fleet) = self.fleet.upgrade() {
                self.ask_everything(&fleet).await;
            }
            Ok(Reply::Done)
        })
    }

    fn held(&self) -> FarHeld {
        let Some(own) = self.fleet.upgrade().map(|fleet| fleet.own) else { return FarHeld::default() };
        let mut known = self.known();
        let some = |text: &String| Some(text.clone()).filter(|text| !text.is_empty());
        let held = known.listener.held();
        let (holder, requested_by) = (some(&held.holder), some(&held.asking));
        let is_request_ours = requested_by.is_some() && own.asks(held);
        FarHeld { is_ours: holder.is_some() && known.is_ours(&own), holder, requested_by, is_request_ours }
    }

    fn is_revoked(&self) -> bool {
        self.known().is_revoked
    }

    fn silence(&self) -> Option<Silence> {
        let now = self.fleet.upgrade()?.station.now();
        self.known().listener.silence(now)
    }
}

#[cfg(test)]
mod tests {
    use tokio::sync::oneshot;

    use super::*;

    #[tokio::test]
    async fn an_answer_to_an_earlier_attempt_counts_and_its_end_does_not() {
        let mut attempts = Attempts::new();
        let attempt = |attempts: &mut Attempts, sent_at| {
            let (end, ended) = oneshot::channel();
            attempts.spawn(async move { (sent_at, ended.await.expect("it ends")) });
            end
        };
        let [first, second, third] = [0, 500, 1_500].map(MonoTime::from_millis);
        let end_first = attempt(&mut attempts, first);
        let heard = first_answer(&mut attempts, first, Duration::ZERO).await;
        assert!(matches!(heard, (_, Replies::Silence)), "{heard:?}");
        let end_second = attempt(&mut attempts, second);
        end_first.send(Replies::Answers(vec![vec![1]])).expect("awaited");
        let (sent_at, heard) = first_answer(&mut attempts, second, ACT_PATIENCE).await;
        assert!(sent_at == first && matches!(heard, Replies::Answers(_)), "{heard:?}");
        let end_third = attempt(&mut attempts, third);
        end_second.send(Replies::Nobody).expect("awaited");
        end_third.send(Replies::Silence).expect("awaited");
        let (sent_at, heard) = first_answer(&mut attempts, third, ACT_PATIENCE).await;
        assert!(sent_at == third && matches!(heard, Replies::Silence), "{heard:?}");
    }
}
