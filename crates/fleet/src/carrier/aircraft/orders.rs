//! Orders from far away: whose count, what the authority makes of them, and their answers.

use std::sync::Arc;

use prost::Message;
use vencejo_proto::MonoTime;
use zenoh::query::Query;

use super::super::history::Told;
use super::super::network;
use super::work::UnderWay;
use super::{AGAIN, Post};
use crate::act;
use crate::authority::{Authority, Caller, Claim, Verdict, Wish, answer};
use crate::payload::{Answer, End, Order, Signed, Want};
use crate::signature::PublicKey;

impl Post<'_> {
    /// The list of ground stations has changed: whoever is not on it any more has no control from now on.
    pub(super) fn on_trust(&mut self, authority: &mut Authority) {
        self.trust = self.trusted();
        tracing::info!(stations = self.trust.len(), "the ground stations whose orders count");
        authority.on_roles(|key| self.trust.get(key).copied());
        self.keep_order(authority);
    }

    /// Brings the station's own lease and heartbeat in step with the authority.
    pub(super) fn keep_order(&mut self, authority: &mut Authority) {
        let now = self.station.now();
        let is_ours = self.acting.as_ref().is_some_and(|(_, operator)| operator.has_control());
        authority.set_local(self.station.control().holder().filter(|_| !is_ours));
        match authority.lease() {
            Some((key, _)) if self.acting.as_ref().is_none_or(|(acting, _)| *acting != key) => {
                let operator = Arc::new(self.station.enlist(&authority.held().holder).yielding());
                operator.attach(now);
                // The one before gives up first.
                self.acting = None;
                if operator.take(now).is_err() {
                    // Somebody here was faster: the next tick says so.
                    tracing::debug!("control was taken on board");
                }
                self.acting = Some((key, operator));
            }
            Some(_) => {}
            None => self.acting = None,
        }
        self.station.set_heartbeat(authority.is_manned());
        let recalled = authority.take_recalled();
        for id in recalled.iter().chain(&authority.take_fenced()) {
            // A plan that is being written is written to its end, unless its sender gives it up: half of it would be worse.
            let may_stop = |under_way: &&UnderWay| !under_way.writes_plan() || recalled.contains(id);
            if let Some(under_way) = self.under_way.get(id).filter(may_stop) {
                under_way.cancel();
            }
        }
    }

    /// An order came over the network: from anybody.
    pub(super) fn on_order(&mut self, query: Query, authority: &mut Authority) {
        let signed = Signed::read(&network::bytes_of(query.payload()));
        let order = signed.as_ref().map_err(Clone::clone).and_then(|signed| Order::read(&signed.order));
        let (signed, order) = match (signed, order) {
            (Ok(signed), Ok(order)) => (signed, order),
            (_, Err(error)) | (Err(error), _) => {
                let nobody = Claim { boot: 0, epoch: 0, id: 0, based_on: MonoTime::ZERO, wish: Wish::Act };
                return self.refuse(query, &[], &answer(&nobody, End::Refused, &error.to_string()));
            }
        };
        let (mut wish, mut deed) = match order.want.clone() {
            Some(Want::Ask(_)) => (Wish::Ask, None),
            Some(Want::Renew(_)) => (Wish::Renew, None),
            Some(Want::Release(_)) => (Wish::Release, None),
            Some(Want::Grant(key)) => (Wish::Grant(PublicKey(key.as_slice().try_into().unwrap_or_default())), None),
            Some(Want::Act(act)) => (Wish::Act, Some(act)),
            Some(Want::Recall(id)) => (Wish::Recall(id.as_slice().try_into().map_or(0, u128::from_be_bytes)), None),
            // Taking it does nothing, and may be done twice.
            Some(Want::Part(_)) => (Wish::Read, None),
            None => (Wish::Act, None),
        };
        let based_on = MonoTime::from_millis(order.based_on_ms);
        let claim = Claim { boot: order.boot, epoch: order.epoch, id: order.id(), based_on, wish };
        let refuse = |why: &str| answer(&claim, End::Refused, why);
        let key = signed.key.as_slice().try_into().ok().map(PublicKey);
        let trusted = key.and_then(|key| Some((key, *self.trust.get(&key)?)));
        let Some((key, role)) = trusted else {
            let key = key.map(|key| key.to_string()).unwrap_or_default();
            let why = match self.place {
                Some(_) => format!(
                    "it takes no orders of the key {key}, which is on its fleet's list of ground stations no more, or never was"
                ),
                None => format!("it takes no orders of the key {key}: start it with --trust {key}"),
            };
            return self.refuse(query, &signed.key, &refuse(&why));
        };
        if !key.verifies(&signed.order, &signed.signature) {
            return self.refuse(query, &signed.key, &refuse("its signature is wrong"));
        }
        if (order.org.as_str(), order.aircraft.as_str()) != (self.config.org.as_str(), self.config.name.as_str()) {
            return self.end(query, &key, &order, &refuse("it is for another aircraft"));
        }
        if let Some(Want::Part(part)) = &order.want {
            let taken = self.holdings.on_part(key, part);
            return self.answer(query, &taken.map_or_else(|error| refuse(&error.to_string()), |()| done(&claim)));
        }
        if !deed.as_mut().is_none_or(|deed| self.holdings.fill(deed)) {
            return self.answer(query, &answer(&claim, End::ListMissing, ""));
        }
        let request = deed.as_ref().map(act::request_of).transpose();
        let request = match request {
            Ok(None) if wish == Wish::Act => return self.end(query, &key, &order, &refuse("it says nothing to do")),
            Ok(request) => request,
            Err(error) => return self.end(query, &key, &order, &refuse(&error.to_string())),
        };
        if request.as_ref().is_some_and(|(request, _)| !request.is_act()) {
            wish = Wish::Read;
        }
        let claim = Claim { wish, ..claim };
        let caller = Caller { key, name: order.operator.clone(), role };
        match authority.on_order(&caller, &claim, self.station.now()) {
            Verdict::Answer(answer) => {
                // Who has control now acts from now on, and nobody else.
                self.keep_order(authority);
                self.end(query, &key, &order, &answer);
            }
            Verdict::UnderWay => {
                if let Some(under_way) = self.under_way.get_mut(&claim.id) {
                    under_way.queries.push(query);
                }
            }
            Verdict::Execute => {
                tracing::info!(operator = caller.name, order = deed.as_ref().map(act::brief), "an order from far away");
                // What it is based on is looked at now: in the last tick it may have been another plan.
                self.holdings.look(self.vehicle);
                let admitted = deed.as_ref().map_or(Ok(()), |deed| self.holdings.admit(deed));
                match (request, admitted) {
                    (Some((request, confirmed)), Ok(())) => {
                        self.execute(query, (key, order), claim, request, confirmed);
                    }
                    (_, Err(why)) => {
                        let refused = refuse(&why);
                        authority.on_ended(claim.id, refused.clone(), self.station.now());
                        self.end(query, &key, &order, &refused);
                    }
                    (None, Ok(())) => {}
                }
            }
        }
    }

    /// Answers an order of somebody who is trusted, and keeps both.
    fn end(&self, query: Query, key: &PublicKey, order: &Order, answer: &Answer) {
        self.keep(&Told::Order(&key.0, Some(order), answer));
        self.answer(query, answer);
    }

    /// Refuses an order that anybody may have sent. Of such floods one a second is kept.
    fn refuse(&mut self, query: Query, key: &[u8], answer: &Answer) {
        let now = self.station.now();
        if now >= self.stranger_due {
            self.stranger_due = now + AGAIN;
            self.keep(&Told::Order(&key[..key.len().min(32)], None, answer));
        }
        self.answer(query, answer);
    }

    pub(super) fn answer(&self, query: Query, answer: &Answer) {
        network::reply(query, self.order_key.clone(), vec![answer.encode_to_vec()]);
    }
}

fn done(claim: &Claim) -> Answer {
    answer(claim, End::Done, "")
}
