//! The authority, rule by rule.

use super::*;

const BOOT: u64 = 77;
/// As from a page.
const ASK: Wish = Wish::Ask(Ask { only_if_free: false, overrules: true, borrows: false });
const TAKE: Wish = Wish::Ask(Ask { only_if_free: true, overrules: true, borrows: false });

fn at(ms: u64) -> MonoTime {
    MonoTime::from_millis(ms)
}

fn caller(number: u8, role: Role) -> Caller {
    Caller { key: PublicKey([number; 32]), run: 0, name: format!("operator {number}"), role }
}

/// An authority, and orders based on the present moment.
struct Bench {
    authority: Authority,
    now: MonoTime,
    ids: u128,
}

impl Bench {
    fn new() -> Self {
        Self { authority: Authority::new(BOOT, at(99_000), Stamper::new(&[7; 32])), now: at(100_000), ids: 0 }
    }

    fn claim(&mut self, wish: Wish, epoch: u64) -> Claim {
        self.ids += 1;
        Claim { boot: BOOT, epoch, id: self.ids, based_on: self.authority.stamp(self.now), wish }
    }

    fn order(&mut self, caller: &Caller, wish: Wish, epoch: u64) -> Verdict {
        let claim = self.claim(wish, epoch);
        self.authority.on_order(caller, &claim, self.now)
    }

    fn end(&mut self, caller: &Caller, wish: Wish, epoch: u64) -> (End, Answer) {
        match self.order(caller, wish, epoch) {
            Verdict::Answer(answer) => (answer.end(), *answer),
            other => panic!("{other:?}"),
        }
    }

    fn granted(&mut self, caller: &Caller) -> u64 {
        let (end, answer) = self.end(caller, ASK, 0);
        assert_eq!(end, End::Granted);
        answer.epoch
    }

    fn pass(&mut self, s: f64) {
        self.now += Duration::from_secs_f64(s);
        self.authority.on_time(self.now);
    }
}

#[test]
fn the_one_who_asks_first_acts_and_the_other_is_told_who() {
    let (mut bench, ana, ben) = (Bench::new(), caller(1, Role::Operator), caller(2, Role::Operator));
    assert_eq!(bench.end(&ana, Wish::Act, 0).0, End::Held, "nothing is done without control");
    let epoch = bench.granted(&ana);
    assert_eq!(bench.order(&ana, Wish::Act, epoch), Verdict::Execute);
    let (end, answer) = bench.end(&ben, Wish::Act, epoch);
    assert_eq!((end, answer.holder.as_str()), (End::Held, "operator 1"), "the epoch alone is no key");
    assert_eq!(bench.granted(&ana), epoch, "to ask again is to renew");
}

#[test]
fn a_lease_ends_by_itself_and_renewals_keep_it() {
    let (mut bench, ana, ben) = (Bench::new(), caller(1, Role::Operator), caller(2, Role::Operator));
    let epoch = bench.granted(&ana);
    for _ in 0..10 {
        bench.pass(9.9);
        assert_eq!(bench.end(&ana, Wish::Renew, epoch).0, End::Done);
    }
    bench.pass(9.9);
    assert_eq!(bench.order(&ana, Wish::Act, epoch), Verdict::Execute, "an act renews too");
    assert!(bench.authority.lease().is_some());
    bench.pass(10.0);
    assert!(bench.authority.lease().is_none(), "the autopilot hears of no ground station any more");
    assert_eq!(bench.end(&ana, Wish::Act, epoch).0, End::Held);
    let epoch = bench.granted(&ben);
    // To the one who asks, although another acts first.
    bench.pass(5.0);
    assert_eq!(bench.end(&ana, ASK, 0).0, End::Asked);
    bench.pass(5.0);
    assert_eq!(bench.end(&caller(3, Role::Operator), TAKE, 0).0, End::Held);
    assert_eq!(bench.authority.lease(), Some((ana.key, epoch + 1)));
    bench.pass(5.0);
    assert!(bench.authority.lease().is_none(), "her last sign of life was her request");
    bench.granted(&ana);
    // As from one who may not act any more.
    assert_eq!(bench.end(&ben, ASK, 0).0, End::Asked);
    bench.authority.on_roles(|key| (*key != ana.key).then_some(Role::Operator));
    bench.pass(0.05);
    assert_eq!(bench.authority.lease().map(|(key, _)| key), Some(ben.key));
}

#[test]
fn control_is_asked_for_and_given() {
    let (mut bench, ana, ben, eve) =
        (Bench::new(), caller(1, Role::Operator), caller(2, Role::Operator), caller(3, Role::Operator));
    let epoch = bench.granted(&ana);
    assert_eq!(bench.end(&ben, ASK, 0).0, End::Asked);
    assert_eq!(bench.end(&eve, ASK, 0).0, End::Held, "one at a time");
    assert_eq!(bench.authority.held().asking, "operator 2");
    assert_eq!(bench.end(&ana, Wish::Release, epoch).0, End::Done);
    assert_eq!(bench.authority.lease(), Some((ben.key, epoch + 1)));
    assert_eq!(bench.end(&ana, Wish::Act, epoch).0, End::Held);
    assert_eq!(bench.end(&ana, ASK, 0).0, End::Asked);
    assert_eq!(bench.end(&ben, Wish::Release, epoch + 1).0, End::Done);
    assert_eq!(bench.authority.lease(), Some((ana.key, epoch + 2)), "it goes to the one who asks");
    bench.end(&ben, ASK, 0);
    bench.pass(9.0);
    bench.end(&ana, Wish::Renew, epoch + 2);
    bench.pass(1.0);
    assert_eq!(bench.authority.held().asking, "", "nobody waits for ever");
}

#[test]
fn an_act_takes_what_is_free_and_a_request_is_kept_up_declined_or_withdrawn() {
    let (mut bench, ana, ben, eve) =
        (Bench::new(), caller(1, Role::Operator), caller(2, Role::Operator), caller(3, Role::Operator));
    let epoch = bench.granted(&ana);
    assert_eq!(bench.end(&ben, TAKE, 0).0, End::Held);
    assert_eq!(bench.authority.held().asking, "", "to act is not to ask");
    assert_eq!(bench.end(&ben, ASK, 0).0, End::Asked);
    for _ in 0..3 {
        bench.pass(6.0);
        assert_eq!(bench.end(&ana, Wish::Renew, epoch).0, End::Done);
        assert_eq!(bench.end(&ben, TAKE, 0).0, End::Asked);
    }
    assert_eq!(bench.end(&ana, Wish::Keep(eve.key), epoch).0, End::Done);
    assert_eq!(bench.authority.held().asking, "operator 2", "it was meant for another");
    assert_eq!(bench.end(&ben, Wish::Keep(ben.key), epoch).0, End::Held, "only the holder declines");
    assert_eq!(bench.end(&ana, Wish::Keep(ben.key), epoch).0, End::Done);
    assert_eq!(bench.end(&ben, TAKE, 0).0, End::Held);
    assert_eq!(bench.end(&ben, ASK, 0).0, End::Asked, "who was declined may ask again");
    assert_eq!(bench.end(&eve, Wish::Release, 0).0, End::Held);
    assert_eq!(bench.end(&ben, Wish::Release, 0).0, End::Done);
    assert_eq!(bench.authority.lease(), Some((ana.key, epoch)), "it was the request that was given up");
    assert_eq!(bench.end(&ana, Wish::Release, epoch).0, End::Done);
    assert_eq!(bench.authority.lease(), None, "who has gone gets nothing");
    assert_eq!(bench.end(&ben, TAKE, 0).0, End::Granted);
}

#[test]
fn who_acts_at_a_ground_station_now_is_the_holder() {
    let (mut bench, ana) = (Bench::new(), caller(1, Role::Operator));
    let named = |name: &str| Caller { name: name.into(), ..ana.clone() };
    let epoch = bench.granted(&ana);
    assert_eq!(bench.order(&named("Ben"), Wish::Act, epoch), Verdict::Execute);
    assert_eq!(bench.authority.held().holder, "Ben");
    assert_eq!(bench.end(&named(""), Wish::Renew, epoch).0, End::Done);
    assert_eq!(bench.authority.held().holder, "Ben", "a renewal is the station's");
    assert_eq!(bench.granted(&named("Eve")), epoch, "and nothing that is under way is given up");
    assert_eq!(bench.authority.held().holder, "Eve");
    assert_eq!(bench.end(&ana, Wish::Act, epoch - 1).0, End::Held);
    assert_eq!(bench.authority.held().holder, "Eve", "what is too late changes nothing");
}

/// Such as a script beside a ground station.
#[test]
fn programs_of_one_key_have_control_each_for_itself() {
    let (mut bench, ana) = (Bench::new(), caller(1, Role::Operator));
    let script = Caller { run: 77, name: "script".into(), ..ana.clone() };
    let (ask, take) = (Wish::Ask(Ask::default()), Wish::Ask(Ask { only_if_free: true, ..Ask::default() }));
    let epoch = bench.granted(&ana);
    assert_eq!(bench.end(&script, Wish::Act, epoch).0, End::Held, "also with her epoch");
    assert_eq!(bench.end(&script, Wish::Release, epoch).0, End::Held);
    assert_eq!(bench.end(&script, take, 0).0, End::Held);
    assert_eq!(bench.end(&script, ask, 0).0, End::Asked);
    assert_eq!(bench.end(&ana, Wish::Release, epoch).0, End::Done, "it is hers that she gives up");
    assert_eq!((bench.authority.held().holder.as_str(), bench.authority.held().run), ("script", 77));
    assert_eq!(bench.end(&ana, TAKE, 0).0, End::Granted);
    assert_eq!(bench.end(&script, Wish::Act, epoch + 1).0, End::Held);
    assert_eq!(bench.end(&caller(2, Role::Operator), TAKE, 0).0, End::Held, "only from what has its key");
    assert_eq!(bench.authority.lease(), Some((ana.key, epoch + 2)));
}

#[test]
fn what_was_borrowed_goes_back_to_who_had_it() {
    let (mut bench, ana, ben) = (Bench::new(), caller(1, Role::Operator), caller(2, Role::Operator));
    let script = |run| Caller { run, name: format!("script {run}"), ..ana.clone() };
    let (first, second) = (script(77), script(78));
    let borrow = Wish::Ask(Ask { only_if_free: true, overrules: true, borrows: true });
    let epoch = bench.granted(&ana);
    let holder = |bench: &Bench| bench.authority.held().holder;
    // One after the other: it is hers when the last has ended, as long as she shows that she is there.
    assert_eq!([&first, &second].map(|script| bench.end(script, borrow, 0).0), [End::Granted; 2]);
    assert_eq!(bench.end(&second, Wish::Release, epoch + 2).0, End::Done);
    assert_eq!(holder(&bench), ana.name);
    assert_eq!(bench.end(&ana, Wish::Act, epoch + 2).0, End::Held, "in an epoch of its own");
    assert_eq!(bench.order(&ana, Wish::Act, epoch + 3), Verdict::Execute);
    bench.now += LEASE;
    bench.authority.on_time(bench.now);
    assert_eq!(holder(&bench), "");

    let given_up = |asks: Option<&Caller>, meanwhile: &dyn Fn(&mut Bench)| {
        let mut bench = Bench::new();
        bench.granted(&ana);
        assert_eq!(bench.end(&first, borrow, 0).0, End::Granted);
        if let Some(asking) = asks {
            assert_eq!(bench.end(asking, Wish::Ask(Ask::default()), 0).0, End::Asked);
        }
        meanwhile(&mut bench);
        let epoch = bench.authority.held().epoch;
        bench.end(&first, Wish::Release, epoch);
        holder(&bench)
    };
    assert_eq!(given_up(None, &|_| ()), ana.name);
    assert_eq!(given_up(Some(&ben), &|_| ()), ben.name, "who asks for it comes first");
    assert_eq!(given_up(None, &|bench| bench.authority.on_roles(|_| None)), "", "she may not act any more");
    let takes_it_herself = |bench: &mut Bench| assert_eq!(bench.end(&ana, TAKE, 0).0, End::Granted);
    assert_eq!(given_up(None, &takes_it_herself), ana.name);
    let waives_it = |bench: &mut Bench| assert_eq!(bench.end(&ana, Wish::Release, 0).0, End::Done);
    assert_eq!(given_up(None, &waives_it), "", "she has gone");
    let lapses = |bench: &mut Bench| {
        bench.now += LEASE;
        bench.authority.on_time(bench.now);
        assert_eq!(bench.end(&first, borrow, 0).0, End::Granted);
    };
    assert_eq!(given_up(None, &lapses), "", "it was free in between");
}

#[test]
fn a_chief_takes_control_and_what_was_under_way_is_given_up() {
    let (mut bench, ana, chief) = (Bench::new(), caller(1, Role::Operator), caller(9, Role::Chief));
    let epoch = bench.granted(&ana);
    let take = Wish::Ask(Ask { only_if_free: true, ..Ask::default() });
    assert_eq!(bench.end(&chief, take, 0).0, End::Held, "a script of a chief does not take it");
    let act = bench.claim(Wish::Act, epoch);
    assert_eq!(bench.authority.on_order(&ana, &act, bench.now), Verdict::Execute);
    assert_eq!(bench.granted(&chief), epoch + 1);
    assert_eq!(bench.authority.take_fenced(), [act.id]);
    assert!(bench.authority.take_fenced().is_empty());
    assert_eq!(bench.end(&ana, ASK, 0).0, End::Asked, "and not the other way round");
    assert_eq!(bench.end(&caller(8, Role::Chief), ASK, 0).0, End::Held, "nor among chiefs");
}

#[test]
fn the_operator_beside_the_aircraft_comes_first() {
    let (mut bench, ana, chief) = (Bench::new(), caller(1, Role::Operator), caller(9, Role::Chief));
    let epoch = bench.granted(&ana);
    bench.authority.set_local(Some("Field".into()));
    for who in [&ana, &chief] {
        let (end, answer) = bench.end(who, ASK, 0);
        assert_eq!((end, answer.holder.as_str()), (End::Held, "Field"));
    }
    assert_eq!(bench.end(&ana, Wish::Act, epoch).0, End::Held);
    bench.authority.set_local(None);
    assert_eq!(bench.end(&ana, Wish::Act, epoch).0, End::Held, "it does not come back by itself");
    assert_eq!(bench.granted(&ana), epoch + 2);
}

#[test]
fn an_order_is_done_at_most_once() {
    let (mut bench, ana, ben) = (Bench::new(), caller(1, Role::Operator), caller(2, Role::Operator));
    let epoch = bench.granted(&ana);
    let act = bench.claim(Wish::Act, epoch);
    let answer = answer(&act, End::Done, "");
    assert_eq!(bench.authority.on_order(&ana, &act, bench.now), Verdict::Execute);
    assert_eq!(bench.authority.on_order(&ana, &act, bench.now), Verdict::UnderWay);
    assert!(
        matches!(bench.authority.on_order(&ben, &act, bench.now), Verdict::Answer(answer) if answer.end() == End::Refused)
    );
    bench.authority.on_ended(act.id, answer.clone(), bench.now);
    for _ in 0..3 {
        assert_eq!(bench.authority.on_order(&ana, &act, bench.now), Verdict::Answer(Box::new(answer.clone())));
        bench.pass(15.0);
    }
    bench.pass(60.0);
    let epoch = bench.granted(&ana);
    let late = Claim { epoch, ..act };
    let verdict = bench.authority.on_order(&ana, &late, bench.now);
    let Verdict::Answer(forgotten) = verdict else { panic!("{verdict:?}") };
    assert_eq!(forgotten.end(), End::Unknown, "forgotten, and too old");
    assert!(!forgotten.why.contains("again"), "given again, it may be done twice: {}", forgotten.why);
    let late = bench.claim(Wish::Act, epoch);
    bench.pass(5.1);
    let verdict = bench.authority.on_order(&ana, &late, bench.now);
    assert!(
        matches!(verdict, Verdict::Answer(answer) if answer.end() == End::Stale),
        "never done, for what was is known"
    );
}

#[test]
fn what_was_seen_too_long_ago_or_in_another_boot_is_no_ground_to_act() {
    let (mut bench, ana) = (Bench::new(), caller(1, Role::Operator));
    let epoch = bench.granted(&ana);
    let of = |ms| Stamper::new(&[7; 32]).stamp(ms);
    let other = Claim { boot: 1, ..bench.claim(Wish::Act, epoch) };
    let verdict = bench.authority.on_order(&ana, &other, bench.now);
    assert!(matches!(verdict, Verdict::Answer(answer) if answer.boot_age_ms == 1_000), "since when it can know");
    let end = |bench: &mut Bench, change: &dyn Fn(&mut Claim)| {
        let mut claim = bench.claim(Wish::Act, epoch);
        change(&mut claim);
        match bench.authority.on_order(&ana, &claim, bench.now) {
            Verdict::Answer(answer) => Some(answer.end()),
            _ => None,
        }
    };
    assert_eq!(end(&mut bench, &|claim| claim.based_on = of(95_000)), None, "five seconds are fresh");
    assert_eq!(end(&mut bench, &|claim| claim.based_on = of(94_999)), Some(End::Stale));
    assert_eq!(end(&mut bench, &|claim| claim.based_on = of(101_001)), Some(End::Refused));
    // Told by somebody else, or of another moment.
    let unmarked = |claim: &mut Claim| claim.based_on.at = at(99_999);
    assert_eq!(end(&mut bench, &unmarked), Some(End::Refused));
    assert_eq!(end(&mut bench, &|claim| claim.boot = 1), Some(End::Unknown));
    assert_eq!(end(&mut bench, &|claim| claim.epoch -= 1), Some(End::Held));
    assert_eq!(end(&mut bench, &|claim| claim.epoch += 1), Some(End::Held), "nor one that is not there yet");
}

#[test]
fn a_flood_is_refused_and_forgets_nothing_that_is_fresh() {
    let (mut bench, ana) = (Bench::new(), caller(1, Role::Operator));
    let epoch = bench.granted(&ana);
    let first = bench.claim(Wish::Act, epoch);
    bench.authority.on_order(&ana, &first, bench.now);
    bench.authority.on_ended(first.id, answer(&first, End::Done, ""), bench.now);
    let executed = (0..2 * MAX_ANSWERS).filter(|_| bench.order(&ana, Wish::Act, epoch) == Verdict::Execute).count();
    assert_eq!(executed, MAX_ANSWERS - 2, "the grant and the first are kept");
    let again = bench.authority.on_order(&ana, &first, bench.now);
    assert!(matches!(again, Verdict::Answer(answer) if answer.end() == End::Done));
}

#[test]
fn to_read_nobody_needs_control_and_its_end_stops_no_reading() {
    let (mut bench, ana, chief) = (Bench::new(), caller(1, Role::Operator), caller(9, Role::Chief));
    let read = bench.claim(Wish::Read, 0);
    assert_eq!(bench.authority.on_order(&ana, &read, bench.now), Verdict::Execute);
    assert_eq!(bench.authority.on_order(&ana, &read, bench.now), Verdict::UnderWay, "once, as everything");
    assert_eq!(bench.authority.lease(), None);
    bench.granted(&ana);
    bench.granted(&chief);
    assert!(bench.authority.take_fenced().is_empty());
}

#[test]
fn an_order_is_given_up_by_its_sender_alone() {
    let (mut bench, ana, ben) = (Bench::new(), caller(1, Role::Operator), caller(2, Role::Operator));
    let epoch = bench.granted(&ana);
    let act = bench.claim(Wish::Act, epoch);
    bench.authority.on_order(&ana, &act, bench.now);
    assert_eq!(bench.end(&ben, Wish::Recall(act.id), 0).0, End::Done);
    assert_eq!(bench.end(&ana, Wish::Recall(77), 0).0, End::Done);
    assert!(bench.authority.take_recalled().is_empty());
    bench.pass(30.0);
    assert_eq!(bench.end(&ana, Wish::Recall(act.id), 0).0, End::Done, "whoever has control meanwhile");
    assert_eq!(bench.authority.take_recalled(), [act.id]);
    bench.authority.on_ended(act.id, answer(&act, End::Done, ""), bench.now);
    bench.end(&ana, Wish::Recall(act.id), 0);
    assert!(bench.authority.take_recalled().is_empty());
}

#[test]
fn an_order_that_its_recall_has_overtaken_is_not_done() {
    let (mut bench, ana, ben) = (Bench::new(), caller(1, Role::Operator), caller(2, Role::Operator));
    let epoch = bench.granted(&ana);
    let [act, read, other] = [Wish::Act, Wish::Read, Wish::Act].map(|wish| bench.claim(wish, epoch));
    for late in [act, read] {
        assert_eq!(bench.end(&ana, Wish::Recall(late.id), 0).0, End::Done);
    }
    assert_eq!(bench.end(&ben, Wish::Recall(other.id), 0).0, End::Done, "and it is not his");
    // As late as it would be done otherwise, and again.
    bench.pass(5.0);
    for late in [act, read, act] {
        let verdict = bench.authority.on_order(&ana, &late, bench.now);
        let Verdict::Answer(answer) = verdict else { panic!("{verdict:?}") };
        assert_eq!((answer.end(), answer.why.contains("gave it up")), (End::Refused, true), "{}", answer.why);
    }
    assert_eq!(bench.authority.on_order(&ana, &other, bench.now), Verdict::Execute);
    assert!(bench.authority.take_recalled().is_empty());
}

#[test]
fn an_observer_reads_and_never_acts() {
    let (mut bench, eve) = (Bench::new(), caller(1, Role::Observer));
    for wish in [ASK, Wish::Act, Wish::Renew, Wish::Release, Wish::Keep(eve.key)] {
        let (end, answer) = bench.end(&eve, wish, 0);
        assert_eq!(end, End::Refused, "{wish:?}");
        assert!(answer.why.contains("observer"), "{}", answer.why);
    }
    assert_eq!(bench.order(&eve, Wish::Read, 0), Verdict::Execute);
    assert_eq!(bench.authority.lease(), None);
}

#[test]
fn control_ends_with_the_role_that_it_was_given_for() {
    let (mut bench, ana, ben) = (Bench::new(), caller(1, Role::Operator), caller(2, Role::Operator));
    let epoch = bench.granted(&ana);
    assert_eq!(bench.end(&ben, ASK, 0).0, End::Asked);
    assert_eq!(bench.order(&ana, Wish::Act, epoch), Verdict::Execute);
    let under_way = bench.ids;
    // Nothing changes for those who may still act; whoever is chief now is not displaced by another.
    bench.authority.on_roles(|key| Some(if *key == ana.key { Role::Chief } else { Role::Operator }));
    assert_eq!(bench.authority.lease(), Some((ana.key, epoch)));
    assert_eq!(bench.end(&caller(9, Role::Chief), ASK, 0).0, End::Held);
    // Who asks and may not any more is forgotten; who has control loses it, and what was under way is given up.
    bench.authority.on_roles(|key| (*key == ana.key).then_some(Role::Operator));
    assert_eq!(bench.authority.held().asking, "");
    bench.authority.on_roles(|_| Some(Role::Observer));
    assert_eq!(bench.authority.lease(), None);
    assert_eq!(bench.authority.take_fenced(), [under_way]);
    assert_eq!(bench.end(&ana, Wish::Act, epoch).0, End::Held, "fenced");
}
