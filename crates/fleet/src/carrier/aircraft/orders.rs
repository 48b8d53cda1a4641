//! Orders from the network: judged, and the consequences.

use std::sync::Arc;

use prost::Message;
use vencejo_station::VehicleHandle;
use zenoh::query::Query;

use super::super::history::Entry;
use super::super::network;
use super::holdings::Holdings;
use super::{AGAIN, Acting, Post};
use crate::act;
use crate::authority::Authority;
use crate::content::Part;
use crate::deed::Act;
use crate::judge::{Addressee, Judged, OnBoard, judge};
use crate::payload::{Answer, BadPayload, End, Order, Want};
use crate::signature::PublicKey;

impl Post<'_> {
    /// The list of ground stations has changed: stations that are not on it any more lose control.
    pub(super) fn on_trust(&mut self, authority: &mut Authority) {
        (self.trust, self.names) = self.trusted();
        tracing::info!(stations = self.trust.len(), "the ground stations whose orders count");
        authority.on_roles(|key| self.trust.get(key).copied());
        self.keep_order(authority);
    }

    /// Synchronises the station's own lease and heartbeat with the authority.
    pub(super) fn keep_order(&mut self, authority: &mut Authority) {
        let now = self.station.now();
        let is_ours = self.acting.as_ref().is_some_and(|acting| acting.operator.has_control());
        authority.set_local(self.station.control().holder().filter(|_| !is_ours));
        let name = authority.held().holder;
        match authority.lease() {
            Some((key, _)) if self.acting.as_ref().is_none_or(|acting| acting.key != key || acting.name != name) => {
                let operator = Arc::new(self.station.enlist(&name).yielding());
                operator.attach(now);
                // The previous holder releases first, even if an order of it is still in progress.
                if let Some(before) = self.acting.take() {
                    before.operator.release(now);
                }
                if operator.take(now).is_err() {
                    // An operator on board was faster: the next tick reports it.
                    tracing::debug!("control was taken on board");
                }
                self.acting = Some(Acting { key, name, operator });
            }
            Some(_) => {}
            None => self.acting = None,
        }
        // Not for a caller of a single act: the failsafe would follow the act.
        self.station.set_heartbeat(authority.lease().is_some() || self.station.control().is_attended());
        for id in authority.take_recalled() {
            self.recall(id, authority);
        }
        for id in authority.take_fenced() {
            // A plan upload is completed unless its sender recalls it: half a plan would be worse.
            if let Some(under_way) = self.under_way.get(&id).filter(|under_way| !under_way.writes_plan()) {
                under_way.cancel();
            }
        }
    }

    /// Processes an order from the network, whose sender is not authenticated yet.
    pub(super) fn on_order(&mut self, query: Query, authority: &mut Authority) {
        let to = Addressee {
            org: self.config.org.as_str(),
            aircraft: self.config.name.as_str(),
            trust: &self.trust,
            names: &self.names,
            has_list: self.place.is_some(),
        };
        let mut on_board = (&mut self.holdings, self.vehicle);
        let judged = judge(&network::bytes_of(query.payload()), &to, authority, &mut on_board, self.station.now());
        if !matches!(judged, Judged::OfStranger(..)) {
            // Control may have changed hands.
            self.keep_order(authority);
        }
        match judged {
            Judged::OfStranger(key, answer) => self.refuse(query, &key, &answer),
            Judged::OfList(answer) => self.answer(query, &answer),
            Judged::Ended((key, order), answer) => {
                // Of the renewals, one each two seconds, those that were refused.
                if !(matches!(order.want, Some(Want::Renew(_))) && answer.end() == End::Done) {
                    self.keep(&Entry::Order(&key.0, Some(&order), &answer));
                }
                self.answer(query, &answer);
            }
            Judged::UnderWay(id) => {
                if let Some(under_way) = self.under_way.get_mut(&id) {
                    under_way.wait(query);
                }
            }
            Judged::Execute(to_do) => {
                let (_, order) = &to_do.sender;
                tracing::info!(operator = order.operator, order = brief(order), "an order from far away");
                self.execute(query, *to_do);
            }
        }
    }

    /// Refuses an unauthenticated order. Of a flood one a second is kept.
    fn refuse(&mut self, query: Query, key: &[u8], answer: &Answer) {
        let now = self.station.now();
        if now >= self.stranger_due {
            self.stranger_due = now + AGAIN;
            self.keep(&Entry::Order(&key[..key.len().min(32)], None, answer));
        }
        self.answer(query, answer);
    }

    pub(super) fn answer(&self, query: Query, answer: &Answer) {
        network::reply(query, self.order_key.clone(), vec![answer.encode_to_vec()]);
    }
}

/// An order in brief, for the log.
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
        // The plan may have changed since the last tick.
        self.0.look(self.1);
        self.0.admit(act)
    }
}
