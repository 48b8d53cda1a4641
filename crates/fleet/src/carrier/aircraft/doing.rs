//! Execution of orders on board: started, with progress reports, and answered at their end.

use vencejo_proto::Seconds;
use vencejo_station::{RequestResult, Silence};
use vencejo_vehicle::{Reply, Request, VehicleError};
use zenoh::query::Query;

use super::super::history::Entry;
use super::work::UnderWay;
use super::{Post, Reading};
use crate::act;
use crate::authority::{Authority, Claim};
use crate::judge::ToDo;
use crate::payload::{self, MAX_MESSAGES, State};

impl Post<'_> {
    /// The progress of orders that report it.
    pub(super) fn progress(&self) -> Vec<payload::UnderWay> {
        let told = self.under_way.iter().filter_map(|(id, under_way)| {
            let progress = under_way.progress()?;
            let id = id.to_be_bytes().to_vec();
            Some(payload::UnderWay { id, done: progress.done, total: progress.total })
        });
        told.take(MAX_MESSAGES).collect()
    }

    pub(super) fn execute(&mut self, query: Query, to_do: ToDo) {
        let ToDo { sender, claim, request, confirmed } = to_do;
        let vehicle = match &self.acting {
            Some(acting) => self.vehicle.acting_as(acting.operator.clone()),
            None => self.vehicle.clone(),
        };
        let under_way = UnderWay::new(&request, sender, query);
        let slot = under_way.slot();
        self.under_way.insert(claim.id, under_way);
        if request == Request::ParamList {
            let known = self.holdings.known_params(self.station.now());
            match &mut self.reading {
                _ if known.is_some() => {}
                Some(reading) => {
                    let begun = self.under_way.get(&reading.claims[0].id).map(UnderWay::slot);
                    reading.claims.push(claim);
                    if let (Some(under_way), Some(begun)) = (self.under_way.get_mut(&claim.id), begun) {
                        under_way.join(begun);
                    }
                    return;
                }
                none => *none = Some(Reading { id: claim.id, claims: vec![claim] }),
            }
            slot.end_with(known);
        }
        let ended = self.ended.clone();
        let doing = slot.start(vehicle, request, confirmed);
        tokio::spawn(async move {
            let result = doing.await;
            // Without a receiver the session has ended, and the order stays unanswered.
            let _ = ended.send((claim, result)).await;
        });
    }

    /// Cancels a recalled order, except a reading that others wait for too.
    pub(super) fn recall(&mut self, id: u128, authority: &mut Authority) {
        if let Some(reading) = self.reading.as_mut().filter(|reading| reading.claims.len() > 1)
            && let Some(index) = reading.claims.iter().position(|claim| claim.id == id)
        {
            let claim = reading.claims.remove(index);
            self.finish(&claim, &Err(VehicleError::Cancelled.into()), None, authority);
        } else if let Some(under_way) = self.under_way.get(&id) {
            under_way.cancel();
        }
    }

    /// A request has ended in this state of the aircraft.
    pub(super) fn on_end(&mut self, claim: &Claim, result: &RequestResult, state: &State, authority: &mut Authority) {
        let mut ended = vec![*claim];
        if let Some(reading) = self.reading.take_if(|reading| reading.id == claim.id) {
            ended = reading.claims;
            if let Ok(Reply::Parameters(params)) = result {
                self.holdings.on_params_read(params, self.station.now());
            }
        }
        // The autopilot's own message is processed at the next tick, maybe after the next order.
        if let Ok(Reply::Parameter(param)) = result {
            self.holdings.on_param_read(param);
        }
        self.holdings.look(self.vehicle);
        for claim in ended {
            self.finish(&claim, result, Some(state), authority);
        }
    }

    fn finish(&mut self, claim: &Claim, result: &RequestResult, state: Option<&State>, authority: &mut Authority) {
        let under_way = self.under_way.remove(&claim.id);
        let plan = under_way.as_ref().and_then(|under_way| under_way.plan);
        let mut answer = self.holdings.complete(act::answer_of(claim, result), plan);
        if let (Err(_), Some((_, Silence { lasts, links }))) = (result, self.silence()) {
            answer.reasons.push(format!("its autopilot has been silent on board for {}: {links}", Seconds(lasts)));
        }
        let is_act = under_way.as_ref().is_some_and(|under_way| under_way.is_act);
        answer.state = state.filter(|_| is_act).cloned().map(Box::new);
        authority.on_ended(claim.id, answer.clone(), self.station.now());
        if let Some((key, order)) = under_way.as_ref().map(|under_way| &under_way.order) {
            self.keep(&Entry::Order(&key.0, Some(order), &answer));
        }
        for query in under_way.into_iter().flat_map(|under_way| under_way.queries) {
            self.answer(query, &answer);
        }
    }
}
