//! What becomes of an order that came over the network: whose it is, whom it is for, whether it may be done. No I/O; time comes in.
//!
//! Whoever carries orders may read them, hold them back, repeat, change and mix them, and make some of its own: what is done is what a
//! trusted operator signed for this aircraft, this boot and this epoch, seconds ago, once. `lies` tries it.

use std::collections::BTreeMap;

use vencejo_proto::MonoTime;
use vencejo_vehicle::{Danger, Request};

use crate::act;
use crate::authority::{Authority, Caller, Claim, Role, Verdict, Wish, answer};
use crate::content::Part;
use crate::deed::Act;
use crate::payload::{Answer, BadPayload, End, Order, Signed, Want};
use crate::seal::Picture;
use crate::signature::PublicKey;

/// Who is asked to do it, and whose orders count there.
#[derive(Debug, Clone, Copy)]
pub struct Addressee<'a> {
    /// The organisation.
    pub org: &'a str,
    /// The aircraft's name there.
    pub aircraft: &'a str,
    /// The keys whose orders count.
    pub trust: &'a BTreeMap<PublicKey, Role>,
    /// Whether these are from a list that the fleet's authority signs, or were all given on board.
    pub has_list: bool,
}

/// What is on board that orders are about.
pub trait OnBoard {
    /// Takes a part of a list that an order will be about.
    ///
    /// # Errors
    /// [`BadPayload`] for one that fits no list.
    fn on_part(&mut self, of: PublicKey, part: &Part) -> Result<(), BadPayload>;
    /// Puts the list into an order that has it by its name alone; whether it is there.
    fn fill(&mut self, act: &mut Act) -> bool;
    /// Whether the plan that an order is to replace or remove is the one that its sender has seen.
    ///
    /// # Errors
    /// Why not, for people.
    fn admit(&mut self, act: &Act) -> Result<(), String>;
}

/// What becomes of an order now.
#[derive(Debug, Clone, PartialEq)]
pub enum Judged {
    /// Anybody may have sent it, in the name of this key: refused.
    OfStranger(Vec<u8>, Answer),
    /// It was about a list on its way, and has this answer.
    OfList(Answer),
    /// This is its answer.
    Ended(Sender, Box<Answer>),
    /// The order of this id is being done: the answer comes with its end.
    UnderWay(u128),
    /// It is to be done; at its end [`Authority::on_ended`] is to hear of it.
    Execute(Box<ToDo>),
}

/// The key that an order was signed with, and the order.
pub type Sender = (PublicKey, Order);

/// What is to be done.
#[derive(Debug, Clone, PartialEq)]
pub struct ToDo {
    /// Whose order it is.
    pub sender: Sender,
    /// The order as the authority knows it.
    pub claim: Claim,
    /// What.
    pub request: Request,
    /// The danger that a person has confirmed.
    pub confirmed: Option<Danger>,
}

/// Judges an order as it came: a [`Signed`], from anybody.
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
            let nobody = Claim { boot: 0, epoch: 0, id: 0, based_on: Picture::default(), wish: Wish::Act };
            return Judged::OfStranger(Vec::new(), answer(&nobody, End::Refused, &error.to_string()));
        }
    };
    let claim = claim_of(&order);
    let refuse = |why: &str| answer(&claim, End::Refused, why);
    let key = signed.key.as_slice().try_into().ok().map(PublicKey);
    let Some((key, role)) = key.and_then(|key| Some((key, *to.trust.get(&key)?))) else {
        let key = key.map(|key| key.to_string()).unwrap_or_default();
        let why = if to.has_list {
            format!(
                "it takes no orders of the key {key}, which is on its fleet's list of ground stations no more, or never was"
            )
        } else {
            format!("it takes no orders of the key {key}: start it with --trust {key}")
        };
        return Judged::OfStranger(signed.key, refuse(&why));
    };
    if !key.verifies(&signed.order, &signed.signature) {
        return Judged::OfStranger(signed.key, refuse("its signature is wrong"));
    }
    if (order.org.as_str(), order.aircraft.as_str()) != (to.org, to.aircraft) {
        return Judged::Ended((key, order), Box::new(refuse("it is for another aircraft")));
    }
    let caller = Caller { key, name: order.operator.clone(), role };
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
        Some(Want::Ask(_)) => Wish::Ask,
        Some(Want::Renew(_)) => Wish::Renew,
        Some(Want::Release(_)) => Wish::Release,
        Some(Want::Grant(key)) => Wish::Grant(PublicKey(key.as_slice().try_into().unwrap_or_default())),
        Some(Want::Recall(id)) => Wish::Recall(id.as_slice().try_into().map_or(0, u128::from_be_bytes)),
        Some(Want::Act(_) | Want::Part(_)) | None => Wish::Act,
    };
    let based_on = Picture { at: MonoTime::from_millis(order.based_on_ms), mark: order.mark };
    Claim { boot: order.boot, epoch: order.epoch, id: order.id(), based_on, wish }
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
