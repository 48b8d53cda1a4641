//! Decision on an order from the network: its sender, its addressee, and whether it may be executed. No I/O; time is
//! passed in.
//!
//! The network is untrusted: it may read, delay, repeat, change and mix orders, and forge some. Executed is only what a
//! trusted operator signed for this aircraft, this boot and this epoch, seconds ago, and once. `lies` tests it.

use std::collections::BTreeMap;

use vencejo_proto::MonoTime;
use vencejo_vehicle::{Danger, Request};

use crate::act;
use crate::authority::{Authority, Caller, Claim, Role, Verdict, Wish, answer};
use crate::content::Part;
use crate::deed::Act;
use crate::payload::{Answer, BadPayload, End, Order, Signed, Want};
use crate::signature::PublicKey;
use crate::stamp::StateStamp;

/// The aircraft that judges, and the keys that it trusts.
#[derive(Debug, Clone, Copy)]
pub struct Addressee<'a> {
    /// The organisation.
    pub org: &'a str,
    /// The aircraft's name there.
    pub aircraft: &'a str,
    /// The keys whose orders count.
    pub trust: &'a BTreeMap<PublicKey, Role>,
    /// The names of ground stations by key, as far as the fleet's authority has signed them.
    pub names: &'a BTreeMap<PublicKey, String>,
    /// Whether these are from a list that the fleet's authority signs, or were all configured on board.
    pub has_list: bool,
}

/// The state on board that orders refer to.
pub trait OnBoard {
    /// Receives a part of a list for a later order.
    ///
    /// # Errors
    /// [`BadPayload`] for one that fits no list.
    fn on_part(&mut self, of: PublicKey, part: &Part) -> Result<(), BadPayload>;
    /// Fills the list into an order that has it by name only; whether it is there.
    fn fill(&mut self, act: &mut Act) -> bool;
    /// Whether the plan that an order is to replace or remove is the one that its sender has seen.
    ///
    /// # Errors
    /// The reason, as text.
    fn admit(&mut self, act: &Act) -> Result<(), String>;
}

/// The decision on an order.
#[derive(Debug, Clone, PartialEq)]
pub enum Judged {
    /// Refused; its sender is not authenticated, and claims this key.
    OfStranger(Vec<u8>, Answer),
    /// It was a part of a list, or lacks its list; this is the answer.
    OfList(Answer),
    /// This is its answer.
    Ended(Sender, Box<Answer>),
    /// The order of this id is in progress: the answer comes when it ends.
    UnderWay(u128),
    /// It is to be executed; call [`Authority::on_ended`] when it ends.
    Execute(Box<ToDo>),
}

/// The key that an order was signed with, and the order.
pub type Sender = (PublicKey, Order);

/// An order to execute.
#[derive(Debug, Clone, PartialEq)]
pub struct ToDo {
    /// Its sender.
    pub sender: Sender,
    /// The order as the authority knows it.
    pub claim: Claim,
    /// The request.
    pub request: Request,
    /// The danger that a person has confirmed.
    pub confirmed: Option<Danger>,
}

/// Judges a received order: a [`Signed`], from an unauthenticated sender.
pub fn judge(
    bytes: &[u8],
    to: &Addressee<'_>,
    authority: &mut Authority,
    on_board: &mut impl OnBoard,
    now: MonoTime,
) -> Judged {
    let signed = Signed::read(bytes);
    let order = signed.as_ref().map_err(Clone::clone).and_then(|signed| Order::read(&signed.order));
    let (signed, order) = match (signed, order) {
        (Ok(signed), Ok(order)) => (signed, order),
        (_, Err(error)) | (Err(error), _) => {
            let nobody = Claim { boot: 0, epoch: 0, id: 0, based_on: StateStamp::default(), wish: Wish::Act };
            return Judged::OfStranger(Vec::new(), answer(&nobody, End::Refused, &error.to_string()));
        }
    };
    let claim = claim_of(&order);
    // Before anything else: another computer of this name may be the one that it is for.
    let of_other_boot = authority.of_other_boot(&claim, now);
    let refuse = |why: &str| of_other_boot.clone().unwrap_or_else(|| answer(&claim, End::Refused, why));
    let key = signed.key.as_slice().try_into().ok().map(PublicKey);
    let Some((key, role)) = key.and_then(|key| Some((key, *to.trust.get(&key)?))) else {
        let key = key.map(|key| key.to_string()).unwrap_or_default();
        let why = if to.has_list {
            format!(
                "this ground station (its key begins with {}) is not on its list of the fleet's ground stations. A new list \
                 arrives within seconds: try again; if it stays so, the station was revoked",
                &key[..key.len().min(8)]
            )
        } else {
            format!("it takes no orders of this ground station: start it with --trust {key}")
        };
        return Judged::OfStranger(signed.key, refuse(&why));
    };
    if !key.verifies(&signed.order, &signed.signature) {
        return Judged::OfStranger(signed.key, refuse("its signature is wrong"));
    }
    if (order.org.as_str(), order.aircraft.as_str()) != (to.org, to.aircraft) {
        return Judged::Ended((key, order), Box::new(refuse("it is for another aircraft")));
    }
    if let Some(answer) = &of_other_boot {
        return Judged::Ended((key, order), Box::new(answer.clone()));
    }
    let caller = Caller { key, run: order.run, name: named(to.names.get(&key), &order.operator), role };
    if let Some(known) = authority.on_known(&caller, &claim) {
        return ended(known, (key, order), &claim);
    }
    let mut act = match &order.want {
        Some(Want::Part(part)) => {
            let taken = on_board.on_part(key, part);
            return Judged::OfList(
                taken.map_or_else(|error| refuse(&error.to_string()), |()| answer(&claim, End::Done, "")),
            );
        }
        Some(Want::Act(act)) => act.clone(),
        Some(_) => return ended(authority.on_order(&caller, &claim, now), (key, order), &claim),
        None => return Judged::Ended((key, order), Box::new(refuse("it says nothing to do"))),
    };
    if !on_board.fill(&mut act) {
        return Judged::OfList(answer(&claim, End::ListMissing, ""));
    }
    let (request, confirmed) = match act::request_of(&act) {
        Ok(request) => request,
        Err(error) => return Judged::Ended((key, order), Box::new(refuse(&error.to_string()))),
    };
    let claim = Claim { wish: if request.is_act() { Wish::Act } else { Wish::Read }, ..claim };
    match authority.on_order(&caller, &claim, now) {
        Verdict::Execute => {}
        verdict => return ended(verdict, (key, order), &claim),
    }
    if let Err(why) = on_board.admit(&act) {
        let refused = answer(&claim, End::Refused, &why);
        authority.on_ended(claim.id, refused.clone(), now);
        return Judged::Ended((key, order), Box::new(refused));
    }
    Judged::Execute(Box::new(ToDo { sender: (key, order), claim, request, confirmed }))
}

fn claim_of(order: &Order) -> Claim {
    let wish = match &order.want {
        Some(Want::Ask(how)) => Wish::Ask(*how),
        Some(Want::Renew(_)) => Wish::Renew,
        Some(Want::Release(_)) => Wish::Release,
        Some(Want::Keep(key)) => Wish::Keep(key_of(key)),
        Some(Want::Recall(id)) => Wish::Recall(id.as_slice().try_into().map_or(0, u128::from_be_bytes)),
        Some(Want::Act(_) | Want::Part(_)) | None => Wish::Act,
    };
    let based_on = StateStamp { at: MonoTime::from_millis(order.based_on_ms), mark: order.mark };
    Claim { boot: order.boot, epoch: order.epoch, id: order.id(), based_on, wish }
}

/// What an operator is called to others: by its ground station, whose name the authority has signed, and the name that
/// it has there, which several may have. Empty for a renewal, which is nobody's.
fn named(station: Option<&String>, operator: &str) -> String {
    match station {
        Some(station) if !operator.is_empty() && operator != station => format!("{station} · {operator}"),
        _ => operator.to_owned(),
    }
}

fn key_of(bytes: &[u8]) -> PublicKey {
    PublicKey(bytes.try_into().unwrap_or_default())
}

/// What has an answer, or will have one.
fn ended(verdict: Verdict, sender: Sender, claim: &Claim) -> Judged {
    match verdict {
        Verdict::Answer(answer) => Judged::Ended(sender, answer),
        Verdict::UnderWay => Judged::UnderWay(claim.id),
        Verdict::Execute => Judged::Ended(sender, Box::new(answer(claim, End::Refused, "it says nothing to do"))),
    }
}

#[cfg(test)]
mod lies;
#[cfg(test)]
mod tests;
