//! The judge, rule by rule: who may do what, and what is told of what came before.

use std::collections::{BTreeMap, BTreeSet};

use prost::Message as _;
use vencejo_flight::plan::{Mission, MissionItem};

use super::*;
use crate::content::{Content, Shelf, pack_items};
use crate::deed::{
    AbortLanding, Altitude, Climb, Course, Deed, Int, Long, NewParam, Nothing, PlanClear, PlanPut, Reposition,
};
use crate::payload::{Ask, VERSION};
use crate::signature::Signer;
use crate::stamp::Stamper;

const BOOT: u64 = 77;

/// An order as it goes out.
pub(super) fn signed(signer: &Signer, order: &Order) -> Vec<u8> {
    let order = order.encode_to_vec();
    let signature = signer.sign(&order);
    Signed { key: signer.public().0.to_vec(), order, signature }.encode_to_vec()
}

/// What is on board: any plan may be replaced.
#[derive(Default)]
pub(super) struct Aboard(Shelf);

impl OnBoard for Aboard {
    fn on_part(&mut self, _: PublicKey, part: &Part) -> Result<(), BadPayload> {
        self.0.put(&part.bytes);
        Ok(())
    }

    fn fill(&mut self, act: &mut Act) -> bool {
        let Some(Deed::PlanPut(PlanPut { list: Some(list), .. })) = &mut act.deed else { return true };
        let kept = list.name().ok().and_then(|(name, _)| self.0.get(&name));
        list.here = kept.map(|kept| kept.to_vec()).unwrap_or_default();
        !list.here.is_empty()
    }

    fn admit(&mut self, _: &Act) -> Result<(), String> {
        Ok(())
    }
}

struct Bench {
    trust: BTreeMap<PublicKey, Role>,
    authority: Authority,
    aboard: Aboard,
    now: MonoTime,
    ids: u128,
}

impl Bench {
    fn new() -> Self {
        let trust = [(2, Role::Observer), (3, Role::Operator), (4, Role::Chief), (5, Role::Operator)];
        let trust = trust.map(|(number, role)| (signer(number).public(), role)).into();
        let now = MonoTime::from_millis(100_000);
        Self {
            trust,
            authority: Authority::new(BOOT, MonoTime::ZERO, Stamper::new(&[7; 32])),
            aboard: Aboard::default(),
            now,
            ids: 0,
        }
    }

    fn order(&mut self, epoch: u64, want: Want) -> Order {
        self.ids += 1;
        Order {
            version: VERSION,
            org: "acme".into(),
            aircraft: "plane7".into(),
            boot: BOOT,
            epoch,
            id: self.ids.to_be_bytes().to_vec(),
            based_on_ms: 100_000,
            operator: "Ana".into(),
            mark: self.authority.stamp(self.now).mark,
            run: 0,
            want: Some(want),
        }
    }

    fn judge(&mut self, from: &Signer, order: &Order) -> Judged {
        let names = BTreeMap::from([(signer(4).public(), "tower".to_owned())]);
        let to = Addressee { org: "acme", aircraft: "plane7", trust: &self.trust, names: &names, has_list: true };
        judge(&signed(from, order), &to, &mut self.authority, &mut self.aboard, self.now)
    }

    fn tell(&mut self, signer: &Signer, epoch: u64, want: Want) -> Judged {
        let order = self.order(epoch, want);
        self.judge(signer, &order)
    }
}

fn signer(number: u8) -> Signer {
    Signer::from_seed(&[number; 32])
}

fn plan() -> Vec<u8> {
    pack_items(&Mission { home: None, items: vec![MissionItem::waypoint(40.0, -3.0, 80.0)] })
}

/// What reads, in the form of those that have none of their own.
const ASKS: &str = r#"{"request-message": {"message": 148}}"#;

/// One of each.
fn deeds() -> Vec<Deed> {
    let nothing = Nothing {};
    let place = Reposition { lat_deg: 40.0, lon_deg: -3.0, alt_m: 80.0, frame: 3, ..Reposition::default() };
    let put = PlanPut { kind: 0, revision: 1, list: Some(Content::of(plan())), despite_findings: false };
    vec![
        Deed::Arm(false),
        Deed::Disarm(true),
        Deed::Mode("RTL".into()),
        Deed::ModeNumber(11),
        Deed::Takeoff(50.0),
        Deed::Reposition(place),
        Deed::Airspeed(14.0),
        Deed::Groundspeed(14.0),
        Deed::Altitude(Altitude { alt_m: 80.0, frame: 3, below_home: false }),
        Deed::LoiterHere(nothing),
        Deed::ReturnToLaunch(nothing),
        Deed::Land(nothing),
        Deed::AbortLanding(AbortLanding { alt_rel_home_m: None }),
        Deed::PrepareFlight(nothing),
        Deed::MissionPause(nothing),
        Deed::MissionResume(nothing),
        Deed::Long(Long { command: 400, params: vec![1.0; 7] }),
        Deed::Int(Int { command: 192, frame: 3, params: vec![0.0; 5], x: 1, y: 2 }),
        Deed::Course(Course { course_deg: 90.0, accel_m_s2: 2.0 }),
        Deed::Climb(Climb { alt_m: 80.0, frame: 3, rate_m_s: Some(2.0), below_home: false }),
        Deed::Reboot(nothing),
        Deed::PlanPut(put),
        Deed::PlanClear(PlanClear { kind: 1, revision: 1 }),
        Deed::PlanRead(0),
        Deed::ParamList(nothing),
        Deed::ParamRead("WP_RADIUS".into()),
        Deed::ParamSet(NewParam { name: "WP_RADIUS".into(), value: 90.0 }),
        Deed::Other(ASKS.into()),
        Deed::Other(r#"{"set-message-rate": {"message": 30, "rate_hz": 2.0}}"#.into()),
        Deed::Other(r#"{"mission/current": {"item": 2}}"#.into()),
    ]
}

/// How an order was taken, in a word.
fn word(judged: &Judged) -> String {
    match judged {
        Judged::OfStranger(..) => "stranger".into(),
        Judged::OfList(answer) => format!("{:?}", answer.end()),
        Judged::Ended(_, answer) => format!("{:?}", answer.end()),
        Judged::UnderWay(_) => "UnderWay".into(),
        Judged::Execute(_) => "does".into(),
    }
}

/// What each role may: to the left without control, to the right with it. Whoever is on no list may nothing, an
/// observer never has control.
#[test]
fn each_role_may_what_it_may_of_all_that_can_be_ordered() {
    // As it is written on the wire, so that none is forgotten.
    let tags: BTreeSet<_> = deeds()
        .into_iter()
        .map(|deed| {
            let bytes = Act { deed: Some(deed), ..Act::default() }.encode_to_vec();
            prost::encoding::decode_key(&mut bytes.as_slice()).expect("a field").0
        })
        .collect();
    assert!(tags.into_iter().eq((3..=35).filter(|tag| ![17, 20, 23, 27, 28].contains(tag))), "every deed");
    let nothing = Nothing {};
    let part = Part::all_of(&plan()).remove(0);
    // What has control, stranger, observer, operator, chief; then operator and chief with it.
    let mut rows = vec![
        (Want::Ask(Ask::default()), ["stranger", "Refused", "Asked", "Asked", "Granted", "Granted"]),
        (
            Want::Ask(Ask { only_if_free: true, overrules: true, borrows: true }),
            ["stranger", "Refused", "Held", "Granted", "Granted", "Granted"],
        ),
        (Want::Renew(nothing), ["stranger", "Refused", "Held", "Held", "Done", "Done"]),
        (Want::Release(nothing), ["stranger", "Refused", "Held", "Held", "Done", "Done"]),
        // To somebody who does not ask.
        (Want::Keep(vec![9; 32]), ["stranger", "Refused", "Held", "Held", "Done", "Done"]),
        (Want::Recall(vec![9; 16]), ["stranger", "Done", "Done", "Done", "Done", "Done"]),
        (Want::Part(part.clone()), ["stranger", "Done", "Done", "Done", "Done", "Done"]),
    ];
    for deed in deeds() {
        let reads = matches!(deed, Deed::PlanRead(_) | Deed::ParamList(_) | Deed::ParamRead(_))
            || deed == Deed::Other(ASKS.into());
        let row = if reads {
            ["stranger", "does", "does", "does", "does", "does"]
        } else {
            ["stranger", "Refused", "Held", "Held", "does", "does"]
        };
        rows.push((Want::Act(Act { deed: Some(deed), ..Act::default() }), row));
    }
    assert_eq!(rows.len(), 37);
    for (want, expected) in rows {
        let asked = [(1, false), (2, false), (3, false), (4, false), (3, true), (4, true)];
        let taken = asked.map(|(number, has_control)| {
            let mut bench = Bench::new();
            bench.aboard.0.put(&plan());
            let holder = signer(if has_control { number } else { 5 });
            let Judged::Ended(_, granted) = bench.tell(&holder, 0, Want::Ask(Ask::default())) else {
                panic!("not granted")
            };
            word(&bench.tell(&signer(number), granted.epoch, want.clone()))
        });
        assert_eq!(taken, expected, "{want:?}");
    }
}

#[test]
fn an_operator_is_called_by_its_station_as_far_as_that_is_known() {
    let holder = |number| {
        let mut bench = Bench::new();
        bench.tell(&signer(number), 0, Want::Ask(Ask::default()));
        bench.authority.held().holder
    };
    assert_eq!((holder(3), holder(4)), ("Ana".to_owned(), "tower · Ana".to_owned()));
    let tower = "tower".to_owned();
    assert_eq!(named(Some(&tower), "tower"), "tower", "a program that is called like its station");
    assert_eq!(named(Some(&tower), ""), "", "a renewal is nobody's");
}

#[test]
fn an_order_that_comes_again_has_its_answer_although_its_list_has_made_room() {
    let (mut bench, ana) = (Bench::new(), signer(3));
    let Judged::Ended(_, granted) = bench.tell(&ana, 0, Want::Ask(Ask::default())) else { panic!("not granted") };
    let list = Some(Content::of(plan()).at_most(0));
    let deed = Deed::PlanPut(PlanPut { kind: 0, revision: 1, list, despite_findings: false });
    let put = bench.order(granted.epoch, Want::Act(Act { deed: Some(deed), ..Act::default() }));
    assert_eq!(word(&bench.judge(&ana, &put)), "ListMissing");
    bench.aboard.0.put(&plan());
    let Judged::Execute(to_do) = bench.judge(&ana, &put) else { panic!("it is all there") };
    bench.aboard = Aboard::default();
    assert_eq!(bench.judge(&ana, &put), Judged::UnderWay(to_do.claim.id));
    bench.authority.on_ended(to_do.claim.id, answer(&to_do.claim, End::Done, ""), bench.now);
    assert_eq!(word(&bench.judge(&ana, &put)), "Done", "it was done, and is not told as what was not");
}

/// Another computer of this aircraft's name may be the one that it is for.
#[test]
fn an_order_for_another_boot_is_answered_as_such_whatever_it_is() {
    let part = Part::all_of(&plan()).remove(0);
    let put = PlanPut { list: Some(Content::of(plan()).at_most(0)), ..PlanPut::default() };
    let put = Want::Act(Act { deed: Some(Deed::PlanPut(put)), ..Act::default() });
    for (number, want) in
        [(3, Want::Part(part)), (3, put), (3, Want::Ask(Ask::default())), (1, Want::Ask(Ask::default()))]
    {
        let mut bench = Bench::new();
        let order = Order { boot: BOOT + 1, ..bench.order(0, want) };
        let answer = match bench.judge(&signer(number), &order) {
            Judged::OfStranger(_, answer) if number == 1 => answer,
            Judged::Ended(_, answer) => *answer,
            other => panic!("{other:?}"),
        };
        assert_eq!((answer.end(), answer.boot_age_ms), (End::Unknown, 100_000), "{order:?}");
    }
}

#[test]
fn what_is_not_signed_or_is_for_others_is_refused_in_words() {
    let (mut bench, ana, eve) = (Bench::new(), signer(3), signer(1));
    let arm = bench.order(1, Want::Act(Act { deed: Some(Deed::Arm(false)), ..Act::default() }));
    let mut says = |bytes: &[u8], has_list, what: &str| {
        let names = BTreeMap::new();
        let to = Addressee { org: "acme", aircraft: "plane7", trust: &bench.trust, names: &names, has_list };
        let answer = match judge(bytes, &to, &mut bench.authority, &mut bench.aboard, bench.now) {
            Judged::OfStranger(_, answer) => answer,
            Judged::Ended(_, answer) => *answer,
            other => panic!("{other:?}"),
        };
        assert_eq!(answer.end(), End::Refused);
        assert!(answer.why.contains(what), "{}", answer.why);
    };
    says(&signed(&eve, &arm), true, "is not on its list of the fleet's ground stations");
    says(&signed(&eve, &arm), false, &format!("--trust {}", eve.public()));
    let ours = Signed::decode(signed(&ana, &arm).as_slice()).expect("read");
    let theirs = Signed { key: eve.public().0.to_vec(), ..ours.clone() };
    says(&theirs.encode_to_vec(), true, "is not on its list of the fleet's ground stations");
    let changed = Order { epoch: 2, ..arm.clone() }.encode_to_vec();
    says(&Signed { order: changed, ..ours }.encode_to_vec(), true, "signature is wrong");
    says(&signed(&ana, &Order { aircraft: "plane8".into(), ..arm.clone() }), true, "another aircraft");
    says(&signed(&ana, &Order { org: "other".into(), ..arm.clone() }), true, "another aircraft");
    says(&signed(&ana, &Order { want: None, ..arm.clone() }), true, "nothing to do");
    says(&signed(&ana, &Order { version: 2, ..arm }), true, "version");
    says(b"\xff", true, "");
}
