//! Seeded schedules: stations far away, one beside the aircraft, and a network that loses, repeats, reorders and holds
//! back what it carries, cuts some of them off, and a station on board that starts again. Whatever comes of it: nobody
//! acts who is not the one who was given control last, nothing is done twice, and nothing on an old picture.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use rand::rngs::SmallRng;
use rand::{Rng, SeedableRng};

use super::*;
use crate::delivery::{OrderDelivery, Outcome, RoundTrip, Step};

/// Schedules in the usual run and for each seed that `make soak` asks for.
const USUAL: u64 = 4_000;
const EACH: u64 = 100;
const STATIONS: usize = 3;
/// Orders that a station has on their way at most.
const AT_ONCE: usize = 3;

fn schedules() -> u64 {
    let seeds = std::env::var("VENCEJO_TEST_SEEDS").ok().and_then(|text| text.parse::<u64>().ok());
    seeds.map_or(USUAL, |seeds| seeds * EACH)
}

/// A program that has control: its key and run.
type Program = (PublicKey, u32);

fn program(caller: &Caller) -> Program {
    (caller.key, caller.run)
}

/// What is on its way.
#[derive(Debug, Clone)]
enum Sent {
    Order(usize, Claim),
    Answer(usize, Box<Answer>),
    /// Boot, moment on board, who asks for control.
    State(usize, u64, StateStamp, Option<PublicKey>),
}

/// A station far away, as far as it has to do with this.
struct Ground {
    caller: Caller,
    /// The newest picture: boot, moment on board, who asks.
    seen: Option<(u64, StateStamp, Option<PublicKey>)>,
    /// When each boot was heard last.
    heard: BTreeMap<u64, MonoTime>,
    epoch: u64,
    /// What it has on its way, and until when it waits: several things at once, as its operators want.
    deliveries: Vec<(OrderDelivery, Claim, MonoTime)>,
    is_cut: bool,
}

/// What happened, told apart from the authority's own account.
#[derive(Default)]
struct Truth {
    /// Whom the lease was given last, in which boot and epoch; `None` after a local operator took control or a restart.
    given: Option<(u64, u64, Program)>,
    epochs: BTreeMap<(u64, u64), Program>,
    executed: BTreeSet<u128>,
    /// Acts that were given up on board before they came; and how often one came then.
    recalled: BTreeSet<u128>,
    averted: u64,
    executions: u64,
    answered: HashMap<u128, End>,
    unknown: u64,
    /// Answers of a program to an order for the one before, and those of which it was sure that nothing was done.
    restarted: u64,
    overtaken: u64,
    /// How often control went from one who was not heard any more to one who asked.
    passed_on: u64,
    /// How often control that was given up went back to whom it was borrowed from.
    given_back: u64,
}

struct World {
    rng: SmallRng,
    now: MonoTime,
    authority: Authority,
    grounds: Vec<Ground>,
    on_the_way: Vec<(MonoTime, Sent)>,
    /// Acts under way on board and when they end.
    under_way: Vec<(MonoTime, u128, usize)>,
    local: bool,
    truth: Truth,
    ids: u128,
}

impl World {
    fn new(seed: u64) -> Self {
        let mut rng = SmallRng::seed_from_u64(seed);
        let chief = rng.random_bool(0.5);
        let ground = |number: usize| Ground {
            caller: Caller {
                // The last two are programs of one ground station.
                key: PublicKey([number.min(STATIONS - 2) as u8 + 1; 32]),
                run: number as u32,
                name: format!("station {number}"),
                role: if number == 0 && chief { Role::Chief } else { Role::Operator },
            },
            seen: None,
            heard: BTreeMap::new(),
            epoch: 0,
            deliveries: Vec::new(),
            is_cut: false,
        };
        Self {
            authority: Authority::new(rng.random(), MonoTime::from_millis(1_000), Stamper::new(&[7; 32])),
            grounds: (0..STATIONS).map(ground).collect(),
            rng,
            now: MonoTime::from_millis(1_000),
            on_the_way: Vec::new(),
            under_way: Vec::new(),
            local: false,
            truth: Truth::default(),
            ids: 0,
        }
    }

    fn send(&mut self, sent: Sent) {
        let station = match &sent {
            Sent::Order(station, _) | Sent::Answer(station, _) | Sent::State(station, ..) => *station,
        };
        if self.grounds[station].is_cut && self.rng.random_bool(0.9) || self.rng.random_bool(0.1) {
            return;
        }
        for _ in 0..if self.rng.random_bool(0.15) { 2 } else { 1 } {
            // Mostly a normal round trip, sometimes held back for longer than a lease.
            let ms = if self.rng.random_bool(0.1) {
                self.rng.random_range(0..20_000)
            } else {
                self.rng.random_range(5..400)
            };
            self.on_the_way.push((self.now + Duration::from_millis(ms), sent.clone()));
        }
    }

    fn run(&mut self) {
        for tick in 0_u32..300 {
            self.now += Duration::from_millis(200);
            let had = self.authority.lease();
            self.authority.on_time(self.now);
            self.truth.passed_on +=
                u64::from(had.is_some() && self.authority.lease().is_some_and(|has| had != Some(has)));
            self.look_who_has_it();
            if tick.is_multiple_of(5) {
                for station in 0..STATIONS {
                    let held = self.authority.held();
                    let key = |key: &[u8]| key.try_into().ok().map(PublicKey);
                    let boot = self.authority.boot();
                    let picture = self.authority.stamp(self.now);
                    self.send(Sent::State(station, boot, picture, key(&held.asking_key)));
                }
            }
            self.happen();
            let (due, rest) = std::mem::take(&mut self.on_the_way).into_iter().partition(|(at, _)| *at <= self.now);
            self.on_the_way = rest;
            for (_, sent) in due as Vec<(MonoTime, Sent)> {
                self.arrive(sent);
            }
            self.end_acts();
            for station in 0..STATIONS {
                self.work(station);
            }
        }
    }

    /// Something of what happens to those who fly.
    fn happen(&mut self) {
        match self.rng.random_range(0..400) {
            0..8 => {
                let station = self.rng.random_range(0..STATIONS);
                self.grounds[station].is_cut ^= true;
            }
            8 => {
                // The program on board starts again: with what it knew go the acts that it was at.
                self.authority = Authority::new(self.rng.random(), self.now, Stamper::new(&[7; 32]));
                self.under_way.clear();
                self.truth.given = None;
                if self.local {
                    self.authority.set_local(Some("field".into()));
                }
            }
            9..12 => {
                self.local ^= true;
                self.authority.set_local(self.local.then(|| "field".into()));
                if self.local {
                    self.truth.given = None;
                    self.cancel_given_up();
                    assert!(self.under_way.is_empty(), "the operator beside the aircraft has it for himself");
                }
            }
            _ => {}
        }
    }

    fn cancel_given_up(&mut self) {
        let given_up = [self.authority.take_fenced(), self.authority.take_recalled()].concat();
        let now = self.now;
        for (_, id, station) in self.under_way.extract_if(.., |(_, id, _)| given_up.contains(id)).collect::<Vec<_>>() {
            let answer = Answer { end: End::Unknown.into(), id: id.to_be_bytes().into(), ..Answer::default() };
            self.authority.on_ended(id, answer.clone(), now);
            self.send(Sent::Answer(station, Box::new(answer)));
        }
    }

    fn end_acts(&mut self) {
        let now = self.now;
        for (_, id, station) in self.under_way.extract_if(.., |(at, ..)| *at <= now).collect::<Vec<_>>() {
            let answer = Answer { end: End::Done.into(), id: id.to_be_bytes().into(), ..Answer::default() };
            self.authority.on_ended(id, answer.clone(), now);
            self.send(Sent::Answer(station, Box::new(answer)));
        }
    }

    fn arrive(&mut self, sent: Sent) {
        match sent {
            Sent::Order(station, claim) => {
                let caller = self.grounds[station].caller.clone();
                let (asked, had) = (self.authority.held(), self.authority.lease());
                match self.authority.on_order(&caller, &claim, self.now) {
                    Verdict::Execute => self.execute(station, &caller, &claim),
                    Verdict::UnderWay => {}
                    Verdict::Answer(answer) => {
                        self.hear_of(&caller, &claim, &answer);
                        self.send(Sent::Answer(station, answer));
                    }
                }
                let has = self.authority.lease();
                if let Some(holder) = self.authority.holder().filter(|_| claim.wish == Wish::Release && has != had)
                    && asked.asking.is_empty()
                {
                    let boot = self.authority.boot();
                    let mut earlier = self.truth.epochs.range((boot, 0)..(boot, claim.epoch));
                    let (borrowed, lent) = (program(&caller), program(holder));
                    assert!(borrowed != lent && earlier.any(|(_, had)| *had == lent), "to one who never had it");
                    self.truth.given_back += 1;
                }
                if let Some(holder) = self.authority.holder().filter(|_| has != had && !asked.asking.is_empty()) {
                    let has_asked = (holder.key.0.as_slice(), holder.run) == (&asked.asking_key, asked.asking_run);
                    let has_overruled = matches!(claim.wish, Wish::Ask(Ask { overrules: true, .. }));
                    assert!(has_asked || has_overruled && *holder == caller, "past the one who asked for it");
                }
                self.look_who_has_it();
                self.cancel_given_up();
            }
            Sent::Answer(station, answer) => {
                let ground = &mut self.grounds[station];
                let id = answer.id.as_slice().try_into().map_or(0, u128::from_be_bytes);
                let Some(place) = ground.deliveries.iter().position(|(_, claim, _)| claim.id == id) else { return };
                let (mut delivery, claim, _) = ground.deliveries.swap_remove(place);
                self.truth.restarted += u64::from(answer.boot_age_ms > 0);
                let heard_at = ground.heard.get(&claim.boot).copied().unwrap_or_default();
                let outcome = match delivery.on_answer(*answer, heard_at, self.now) {
                    Step::Send { after, wait } => {
                        ground.deliveries.push((delivery, claim, self.now + after + wait));
                        return self.send(Sent::Order(station, claim));
                    }
                    Step::End(outcome) => outcome,
                };
                if let Outcome::Answered(answer) = outcome {
                    match answer.end() {
                        End::Granted => ground.epoch = answer.epoch,
                        End::Held | End::Asked => ground.epoch = 0,
                        End::Done if claim.wish == Wish::Act => {
                            assert!(self.truth.executed.contains(&id), "told as done, and was not");
                        }
                        End::Stale if answer.boot_age_ms > 0 => {
                            self.truth.overtaken += 1;
                            assert!(
                                !self.truth.executed.contains(&id),
                                "told as not done by the program before, and was"
                            );
                        }
                        End::Refused | End::Stale if claim.wish == Wish::Act => {
                            assert!(!self.truth.executed.contains(&id), "told as not done, and was");
                        }
                        _ => {}
                    }
                } else {
                    self.truth.unknown += 1;
                }
            }
            Sent::State(station, boot, at, asking) => {
                let ground = &mut self.grounds[station];
                ground.heard.insert(boot, self.now);
                if ground.seen.is_none_or(|(known, seen, _)| known != boot || seen.at < at.at) {
                    ground.seen = Some((boot, at, asking));
                }
            }
        }
    }

    /// Who has control now, was given it by an order or had asked for it: of whom, the state tells.
    fn look_who_has_it(&mut self) {
        let (Some(holder), Some((_, epoch))) = (self.authority.holder(), self.authority.lease()) else { return };
        let (boot, holder) = (self.authority.boot(), program(holder));
        let owner = *self.truth.epochs.entry((boot, epoch)).or_insert(holder);
        assert_eq!(owner, holder, "two holders in epoch {epoch}");
        let before = self.truth.given.replace((boot, epoch, holder));
        if let Some((_, before, _)) = before {
            assert!(epoch >= before, "epochs never go back");
        }
        assert!(!self.local, "beside an operator at the aircraft nobody has it");
    }

    fn hear_of(&mut self, caller: &Caller, claim: &Claim, answer: &Answer) {
        let end = answer.end();
        if let (Wish::Recall(id), End::Done) = (claim.wish, end)
            && !self.truth.executed.contains(&id)
        {
            self.truth.recalled.insert(id);
        }
        self.truth.averted += u64::from(answer.why.contains("gave it up"));
        // Of another boot nobody knows what became of it; and what was stale was forgotten.
        let is_known = claim.boot == self.authority.boot() && end != End::Stale;
        if claim.wish != Wish::Renew && is_known && !(end == End::Refused && answer.why.starts_with("this id")) {
            let first = *self.truth.answered.entry(claim.id).or_insert(end);
            assert_eq!(first, end, "one order, one answer ({})", caller.name);
        }
    }

    /// An act is done: was it allowed to be?
    fn execute(&mut self, station: usize, caller: &Caller, claim: &Claim) {
        assert_eq!(self.truth.given, Some((claim.boot, claim.epoch, program(caller))), "an act after its fence");
        assert!(!self.local, "an act beside the operator at the aircraft");
        assert!(self.truth.executed.insert(claim.id), "done twice");
        assert!(!self.truth.recalled.contains(&claim.id), "done after it was given up");
        assert!(self.now.since(claim.based_on.at) <= FRESH, "done on an old picture");
        self.truth.executions += 1;
        let takes = Duration::from_millis(self.rng.random_range(10..6_000));
        self.under_way.push((self.now + takes, claim.id, station));
    }

    /// What a station does when it has nothing on its way, or waits in vain.
    fn work(&mut self, station: usize) {
        let now = self.now;
        let waits = |(_, _, due): &mut (OrderDelivery, Claim, MonoTime)| *due <= now;
        for (mut delivery, claim, _) in self.grounds[station].deliveries.extract_if(.., waits).collect::<Vec<_>>() {
            if let Step::Send { wait, .. } = delivery.on_silence(now) {
                self.grounds[station].deliveries.push((delivery, claim, now + wait));
                self.send(Sent::Order(station, claim));
            }
        }
        if self.grounds[station].deliveries.len() >= AT_ONCE {
            return;
        }
        let Some((boot, based_on, asking)) = self.grounds[station].seen else { return };
        let epoch = self.grounds[station].epoch;
        let wish = match self.rng.random_range(0..10) {
            0 | 1 if epoch == 0 => Wish::Ask(Ask {
                only_if_free: self.rng.random_bool(0.5),
                overrules: self.rng.random_bool(0.2),
                borrows: self.rng.random_bool(0.5),
            }),
            6 if epoch == 0 => Wish::Release,
            0..4 if epoch > 0 => Wish::Act,
            4..6 if epoch > 0 => Wish::Renew,
            6 if epoch > 0 && self.rng.random_bool(0.2) => Wish::Release,
            7 if epoch > 0 => match asking {
                Some(key) if self.rng.random_bool(0.2) => Wish::Keep(key),
                Some(_) => Wish::Release,
                None => return,
            },
            8 if self.rng.random_bool(0.5) => {
                let deliveries = &mut self.grounds[station].deliveries;
                let Some(place) = deliveries.iter().position(|(_, claim, _)| claim.wish == Wish::Act) else { return };
                Wish::Recall(deliveries.swap_remove(place).1.id)
            }
            _ => return,
        };
        self.ids += 1;
        let claim = Claim { boot, epoch, id: self.ids, based_on, wish };
        let mut delivery = OrderDelivery::new(Duration::from_secs(10), RoundTrip::default(), now);
        let Step::Send { wait, .. } = delivery.start() else { return };
        self.grounds[station].deliveries.push((delivery, claim, now + wait));
        self.send(Sent::Order(station, claim));
    }
}

#[test]
fn schedules_of_what_networks_do() {
    let (mut executions, mut unknown, mut epochs, mut restarted, mut overtaken, mut averted) = (0, 0, 0, 0, 0, 0);
    let (mut passed_on, mut given_back) = (0, 0);
    for seed in 0..schedules() {
        let mut world = World::new(seed);
        world.run();
        executions += world.truth.executions;
        unknown += world.truth.unknown;
        epochs += world.truth.epochs.len();
        restarted += world.truth.restarted;
        overtaken += world.truth.overtaken;
        averted += world.truth.averted;
        passed_on += world.truth.passed_on;
        given_back += world.truth.given_back;
    }
    println!(
        "{} schedules: {executions} acts, {epochs} grants, {unknown} answers that told nothing, {restarted} of another \
        boot, which in {overtaken} cases was known not to have been done; {averted} came after they were given up",
        schedules()
    );
    assert!(restarted > schedules() / 10 && overtaken > schedules() / 100, "{restarted}, {overtaken}");
    assert!(averted > schedules() / 100 && passed_on > schedules() / 100, "{averted}, {passed_on}");
    assert!(given_back > schedules() / 100, "{given_back}");
    assert!(executions > 5 * schedules() && epochs as u64 > 2 * schedules(), "it was tried: {executions}, {epochs}");
}
