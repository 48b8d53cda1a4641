//! Orders from far away: judged, and what follows from that.

use std::sync::Arc;

use prost::Message;
use vencejo_station::VehicleHandle;
use zenoh::query::Query;

use super::super::history::Told;
use super::super::network;
use super::holdings::Holdings;
use super::{AGAIN, Acting, Post};
use crate::act;
use crate::authority::Authority;
use crate::content::Part;
use crate::deed::Act;
use crate::judge::{Addressee, Judged, OnBoard, judge};
use crate::payload::{Answer, BadPayload, Order, Want};
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
        let is_ours = self.acting.as_ref().is_some_and(|acting| acting.operator.has_control());
        authority.set_local(self.station.control().holder().filter(|_| !is_ours));
        let name = authority.held().holder;
        match authority.lease() {
            Some((key, _)) if self.acting.as_ref().is_none_or(|acting| acting.key != key || acting.name != name) => {
                let operator = Arc::new(self.station.enlist(&name).yielding());
                operator.attach(now);
                // The one before gives up first, also where something is done in its name still.
                if let Some(before) = self.acting.take() {
                    before.operator.release(now);
                }
                if operator.take(now).is_err() {
                    // Somebody here was faster: the next tick says so.
                    tracing::debug!("control was taken on board");
                }
                self.acting = Some(Acting { key, name, operator });
            }
            Some(_) => {}
            None => self.acting = None,
        }
        // Who came for one act alone is not waited for: the failsafe would follow upon the act.
        self.station.set_heartbeat(authority.lease().is_some() || self.station.control().is_attended());
        for id in authority.take_recalled() {
            self.recall(id, authority);
        }
        for id in authority.take_fenced() {
            // A plan that is being written is written to its end, unless its sender gives it up: half of it would be worse.
            if let Some(under_way) = self.under_way.get(&id).filter(|under_way| !under_way.writes_plan()) {
                under_way.cancel();
            }
        }
    }

    /// An order came over the network: from anybody.
    pub(super) fn on_order(&mut self, query: Query, authority: &mut Authority) {
        let to = Addressee {
            org: self.config.org.as_str(),
            aircraft: self.config.name.as_str(),
            trust: &self.trust,
            has_list: self.place.is_some(),
        };
        let mut on_board = (&mut self.holdings, self.vehicle);
        let judged = judge(&network::bytes_of(query.payload()), &to, authority, &mut on_board, self.station.now());
        if !matches!(judged, Judged::OfStranger(..)) {
            // Who has control now acts from now on, and nobody else.
            self.keep_order(authority);
        }
        match judged {
            Judged::OfStranger(key, answer) => self.refuse(query, &key, &answer),
            Judged::OfList(answer) => self.answer(query, &answer),
            Judged::Ended((key, order), answer) => {
                self.keep(&Told::Order(&key.0, Some(&order), &answer));
                self.answer(query, &answer);
            }
            Judged::UnderWay(id) => {
                if let Some(under_way) = self.under_way.get_mut(&id) {
                    under_way.queries.push(query);
                }
            }
            Judged::Execute(to_do) => {
                let (_, order) = &to_do.sender;
                tracing::info!(operator = order.operator, order = brief(order), "an order from far away");
                self.execute(query, *to_do);
            }
        }
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

/// What an order is about, for the log.
fn brief(order: &Order) -> Option<String> {
    match &order.want {
        Some(Want::Act(act)) => Some(act::brief(act)),
        _ => None,
    }
}

impl OnBoard for (&mut Holdings, &VehicleHandle) {
    fn on_part(&mut self, of: PublicKey, part: &Part) -> Result<(), BadPayload> {
        self.0.on_part(of, part)
    }

    fn fill(&mut self, act: &mut Act) -> bool {
        self.0.fill(act)
    }

    fn admit(&mut self, act: &Act) -> Result<(), String> {
        // What it is based on is looked at now: in the last tick it may have been another plan.
        self.0.look(self.1);
        self.0.admit(act)
    }
}
