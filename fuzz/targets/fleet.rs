//! Data from the network of a fleet: arbitrary payloads, read or refused, and the states and decisions that follow from
//! readable ones.
#![no_main]

use libfuzzer_sys::fuzz_target;
use vencejo_fleet::act::{act_of, request_of, result_of};
use vencejo_fleet::authority::{Authority, Caller, Claim, Role, Verdict, Wish, answer};
use vencejo_fleet::content::{Tray, unpack_items, unpack_params};
use vencejo_fleet::payload::{Answer, End, Event, Order, Signed, State, Want};
use vencejo_fleet::plans::PlansHeard;
use vencejo_fleet::signature::PublicKey;
use vencejo_fleet::stamp::{Stamper, StateStamp};
use vencejo_fleet::state_source::Listener;
use vencejo_proto::MonoTime;
use vencejo_vehicle::Request;
use vencejo_vehicle::modes::ModeFamily;

mod quick;
use quick::quick;

fuzz_target!(|data: &[u8]| quick(|| {
    let mut listener = Listener::default();
    let mut authority = Authority::new(1, MonoTime::ZERO, Stamper::new(&[7; 32]));
    let mut heard = PlansHeard::default();
    let mut rest = data;
    let mut now = MonoTime::from_millis(10_000);
    // A sequence of payloads, each preceded by its kind and length.
    while let Some((&[kind, high, low], tail)) = rest.split_first_chunk::<3>() {
        let length = usize::from(u16::from_be_bytes([high & 0x3f, low])).min(tail.len());
        let (bytes, tail) = tail.split_at(length);
        rest = tail;
        now += std::time::Duration::from_millis(u64::from(high) * 16);
        match kind % 5 {
            0 => {
                if let Ok(state) = State::read(bytes) {
                    heard.on_state(state.boot, state.plans_version, &state.plans);
                    let news = listener.on_state(&state, now);
                    assert!(news.said.iter().all(|(_, at)| *at <= now), "said in the future");
                }
            }
            1 => {
                if let Ok(event) = Event::read(bytes) {
                    drop(listener.on_event(&event, now));
                }
            }
            2 => drop(Order::read(bytes).map(|order| ordered(&mut authority, &order, kind, now))),
            3 => {
                if let Ok(answer) = Answer::read(bytes) {
                    drop(result_of(&answer, &Request::Land, "plane7", ModeFamily::ArduPlane));
                }
            }
            _ => drop(Signed::read(bytes)),
        }
        drop((listener.stamp(), listener.age(now), authority.held(), authority.take_fenced()));
    }
}));

fn ordered(authority: &mut Authority, order: &Order, kind: u8, now: MonoTime) {
    let key = |key: &[u8]| PublicKey(key.try_into().unwrap_or_default());
    let wish = match &order.want {
        Some(Want::Ask(how)) => Wish::Ask(*how),
        Some(Want::Renew(_)) => Wish::Renew,
        Some(Want::Release(_)) => Wish::Release,
        Some(Want::Keep(of)) => Wish::Keep(key(of)),
        Some(Want::Act(act)) => {
            if let Ok((request, confirmed)) = request_of(act) {
                let same = act_of(&request, confirmed).map(|act| request_of(&act));
                // Compared as Debug text, since NaN is not equal to itself.
                assert_eq!(format!("{same:?}"), format!("{:?}", Ok::<_, &str>(Ok::<_, ()>((request, confirmed)))));
            }
            Wish::Act
        }
        Some(Want::Part(part)) => {
            if let Ok(Some(packed)) = Tray::default().on_part(PublicKey([1; 32]), part) {
                drop((unpack_items(&packed), unpack_params(&packed)));
            }
            Wish::Read
        }
        Some(Want::Recall(id)) => Wish::Recall(id.as_slice().try_into().map_or(0, u128::from_be_bytes)),
        None => Wish::Act,
    };
    let at = MonoTime::from_millis(order.based_on_ms);
    // Nobody guesses a 64-bit mark, so half of the orders are given the right one.
    let based_on = if kind & 128 == 128 { authority.stamp(at) } else { StateStamp { at, mark: order.mark } };
    let claim = Claim { boot: order.boot % 3, epoch: order.epoch, id: order.id(), based_on, wish };
    let role = if kind & 64 == 64 { Role::Chief } else { Role::Operator };
    let caller = Caller { key: PublicKey([kind >> 3 & 3; 32]), run: order.run & 1, name: order.operator.clone(), role };
    let held = authority.lease();
    let holder = authority.holder().cloned();
    match authority.on_order(&caller, &claim, now) {
        Verdict::Execute if wish == Wish::Read => {}
        Verdict::Execute => {
            assert_eq!(authority.stamp(at), based_on, "done by who has not seen it");
            assert_eq!(held, Some((caller.key, order.epoch)), "done without a lease");
            assert_eq!(holder.map(|holder| holder.run), Some(caller.run), "done for another");
            authority.on_ended(claim.id, answer(&claim, End::Done, ""), now);
        }
        Verdict::UnderWay | Verdict::Answer(_) => {}
    }
}
