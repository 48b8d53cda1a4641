//! Seeded schedules: two stations far away that send plans, over a network that loses, repeats, reorders, holds back
//! and cuts, to a station on board that writes them item by item and starts again in between. Whatever comes of it: a
//! plan is told as read only where it is whole, "done" is told only of the list that was sent, each is written at most
//! once, and nobody replaces what he has not seen.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use rand::rngs::SmallRng;
use rand::{Rng, SeedableRng};
use vencejo_proto::MonoTime;

use super::*;
use crate::authority::{Authority, Caller, Claim, Role, Verdict, Wish, answer};
use crate::content::{Digest, PART_BYTES, Part, Shelf, Tray};
use crate::delivery::{OrderDelivery, Outcome, RoundTrip, Step};
use crate::payload::{Answer, Ask, End};
use crate::signature::PublicKey;
use crate::stamp::{Stamper, StateStamp};

/// Schedules in the usual run and for each seed that `make soak` asks for.
const USUAL: u64 = 200;
const EACH: u64 = 25;
const STATIONS: usize = 2;
const MISSION: PlanKind = PlanKind::Mission;
/// A list is so many blocks, each written at once, so that a station that stops in between leaves a mixture.
const BLOCKS: usize = 3;

/// Bytes that no other list has, in two parts.
fn list_of(number: u64) -> Vec<u8> {
    let mut rng = SmallRng::seed_from_u64(number);
    (0..PART_BYTES + 60).map(|_| rng.random()).collect()
}

fn hash_of(bytes: &[u8]) -> u64 {
    u64::from_be_bytes(Digest::of(bytes).0[..8].try_into().expect("eight bytes"))
}

#[derive(Debug, Clone)]
enum Sent {
    Part(usize, Part),
    /// What it wants, the list's name, and what its sender had seen.
    Put(usize, Claim, Digest, PlanTold),
    Answer(usize, Answer),
    State(usize, u64, StateStamp, u32, Vec<PlanTold>),
}

/// What a station far away is at.
enum Doing {
    Nothing,
    Asking(OrderDelivery, Claim, MonoTime),
    /// The parts are on their way, then the order.
    Putting {
        delivery: OrderDelivery,
        claim: Claim,
        list: Vec<u8>,
        seen: PlanTold,
        due: MonoTime,
    },
}

struct Ground {
    caller: Caller,
    seen: Option<(u64, StateStamp)>,
    heard: PlansHeard,
    epoch: u64,
    doing: Doing,
    is_cut: bool,
}

/// What is being written on board.
struct Writing {
    id: u128,
    of: usize,
    list: Vec<u8>,
    blocks: usize,
}

struct World {
    rng: SmallRng,
    now: MonoTime,
    authority: Authority,
    plans: Plans,
    shelf: Shelf,
    tray: Tray,
    state: PlanState,
    writing: Option<Writing>,
    /// What the vehicle holds.
    vehicle: Vec<u8>,
    /// Whether what it holds may be a mixture: that outlives a restart.
    is_doubted: bool,
    read_at: MonoTime,
    grounds: Vec<Ground>,
    on_the_way: Vec<(MonoTime, Sent)>,
    whole: BTreeSet<u64>,
    executed: BTreeSet<u128>,
    verified: BTreeMap<u128, u64>,
    done: u64,
    refused: u64,
    restarts: u64,
    next: u64,
}

impl World {
    fn new(seed: u64) -> Self {
        let mut rng = SmallRng::seed_from_u64(seed);
        let ground = |number: usize| Ground {
            caller: Caller {
                key: PublicKey([number as u8 + 1; 32]),
                run: 0,
                name: format!("station {number}"),
                role: if number == 0 { Role::Chief } else { Role::Operator },
            },
            seen: None,
            heard: PlansHeard::default(),
            epoch: 0,
            doing: Doing::Nothing,
            is_cut: false,
        };
        let vehicle = list_of(0);
        Self {
            authority: Authority::new(rng.random(), MonoTime::ZERO, Stamper::new(&[7; 32])),
            rng,
            now: MonoTime::from_millis(1_000),
            plans: Plans::default(),
            shelf: Shelf::default(),
            tray: Tray::default(),
            state: PlanState::Unknown(Unknown::NeverRead),
            writing: None,
            whole: [hash_of(&vehicle)].into(),
            vehicle,
            is_doubted: false,
            read_at: MonoTime::from_millis(2_000),
            grounds: (0..STATIONS).map(ground).collect(),
            on_the_way: Vec::new(),
            executed: BTreeSet::new(),
            verified: BTreeMap::new(),
            done: 0,
            refused: 0,
            restarts: 0,
            next: 1,
        }
    }

    fn send(&mut self, sent: Sent) {
        let (Sent::Part(station, _) | Sent::Put(station, ..) | Sent::Answer(station, _) | Sent::State(station, ..)) =
            &sent;
        if self.grounds[*station].is_cut || self.rng.random_bool(0.1) {
            return;
        }
        for _ in 0..if self.rng.random_bool(0.15) { 2 } else { 1 } {
            let held_back = self.rng.random_bool(0.1);
            let ms = if held_back { self.rng.random_range(0..20_000) } else { self.rng.random_range(5..400) };
            self.on_the_way.push((self.now + Duration::from_millis(ms), sent.clone()));
        }
    }

    fn run(&mut self) {
        for tick in 0_u32..400 {
            self.now += Duration::from_millis(200);
            self.authority.on_time(self.now);
            self.happen();
            self.write();
            self.publish();
            if tick.is_multiple_of(3) {
                for station in 0..STATIONS {
                    let plans = if self.rng.random_bool(0.5) { self.plans.told().to_vec() } else { Vec::new() };
                    let boot = self.authority.boot();
                    let picture = self.authority.stamp(self.now);
                    self.send(Sent::State(station, boot, picture, self.plans.version(), plans));
                }
            }
            let (due, rest) = std::mem::take(&mut self.on_the_way).into_iter().partition(|(at, _)| *at <= self.now);
            self.on_the_way = rest;
            for (_, sent) in due as Vec<(MonoTime, Sent)> {
                self.arrive(sent);
            }
            for station in 0..STATIONS {
                self.work(station);
            }
        }
    }

    fn happen(&mut self) {
        match self.rng.random_range(0..300) {
            0..6 => {
                let station = self.rng.random_range(0..STATIONS);
                self.grounds[station].is_cut ^= true;
            }
            6 => {
                // The station on board starts again: what it wrote stays half written, and that is remembered.
                self.restarts += 1;
                self.is_doubted |= self.writing.take().is_some();
                (self.authority, self.plans) =
                    (Authority::new(self.rng.random(), self.now, Stamper::new(&[7; 32])), Plans::default());
                (self.shelf, self.tray) = (Shelf::default(), Tray::default());
                let why = if self.is_doubted { Unknown::TransferFailed } else { Unknown::NeverRead };
                (self.state, self.read_at) = (PlanState::Unknown(why), self.now + Duration::from_secs(2));
            }
            7 if self.writing.is_none() => {
                // Somebody beside the aircraft writes another one.
                self.vehicle = list_of(1_000_000 + self.next);
                self.next += 1;
                self.whole.insert(hash_of(&self.vehicle));
                self.is_doubted = false;
                self.state = PlanState::Unknown(Unknown::ChangedElsewhere);
                self.read_at = self.now + Duration::from_secs(1);
            }
            _ => {}
        }
    }

    /// Writes on, and reads back what is at rest.
    fn write(&mut self) {
        if let Some(writing) = &mut self.writing {
            let (block, length) = (writing.list.len().div_ceil(BLOCKS), writing.list.len());
            if writing.blocks < BLOCKS {
                let from = writing.blocks * block;
                let to = length.min(from + block);
                self.vehicle[from..to].copy_from_slice(&writing.list[from..to]);
                writing.blocks += 1;
                return;
            }
            let (id, of) = (writing.id, writing.of);
            assert_eq!(self.vehicle, writing.list, "read back");
            self.writing = None;
            self.is_doubted = false;
            self.state = PlanState::Verified { count: 1, hash: hash_of(&self.vehicle) };
            self.verified.insert(id, hash_of(&self.vehicle));
            self.publish();
            let answer = Answer { id: id.to_be_bytes().into(), end: End::Done.into(), ..Answer::default() };
            self.authority.on_ended(id, answer.clone(), self.now);
            self.send(Sent::Answer(of, answer));
        } else if matches!(self.state, PlanState::Unknown(_)) && self.now >= self.read_at {
            let hash = hash_of(&self.vehicle);
            let is_whole = !self.is_doubted || self.whole.contains(&hash);
            self.is_doubted &= !is_whole;
            self.state =
                if is_whole { PlanState::Verified { count: 1, hash } } else { PlanState::Differs { count: 1, hash } };
        }
    }

    fn publish(&mut self) {
        if let PlanState::Verified { hash, .. } = self.state {
            assert!(self.whole.contains(&hash) && hash == hash_of(&self.vehicle), "told as read, and is a mixture");
        }
        let list = self.vehicle.clone();
        self.plans.on_state(MISSION, self.state, || Some(Content::of(list)));
    }

    fn arrive(&mut self, sent: Sent) {
        match sent {
            Sent::Part(station, part) => {
                let key = self.grounds[station].caller.key;
                if let Ok(Some(list)) = self.tray.on_part(key, &part) {
                    self.shelf.put(&list);
                }
            }
            Sent::Put(station, claim, name, seen) => self.on_put(station, &claim, &name, &seen),
            Sent::Answer(station, answer) => self.on_answer(station, answer),
            Sent::State(station, boot, at, version, plans) => {
                let ground = &mut self.grounds[station];
                if ground.seen.is_none_or(|(known, seen)| known != boot || seen.at < at.at) {
                    ground.seen = Some((boot, at));
                    ground.heard.on_state(boot, version, &plans);
                }
            }
        }
    }

    fn on_put(&mut self, station: usize, claim: &Claim, name: &Digest, seen: &PlanTold) {
        let list = self.shelf.get(name);
        if claim.wish == Wish::Act && list.is_none() {
            self.send(Sent::Answer(station, answer(claim, End::ListMissing, "")));
            return;
        }
        let caller = self.grounds[station].caller.clone();
        match self.authority.on_order(&caller, claim, self.now) {
            Verdict::UnderWay => {}
            Verdict::Answer(answer) => self.send(Sent::Answer(station, *answer)),
            Verdict::Execute => {
                let refused = match self.plans.admit(MISSION, seen.revision) {
                    Err(_) => Some("another plan"),
                    Ok(()) if self.writing.is_some() => Some("busy"),
                    Ok(()) => None,
                };
                if let Some(why) = refused {
                    let answer = answer(claim, End::Refused, why);
                    self.authority.on_ended(claim.id, answer.clone(), self.now);
                    return self.send(Sent::Answer(station, answer));
                }
                let is_read = |told: &PlanTold| told.knowledge == Knowledge::Verified as i32;
                let now = &self.plans.told()[0];
                assert!(!is_read(seen) || !is_read(now) || seen.hash == now.hash, "replaced what nobody had seen");
                assert!(self.executed.insert(claim.id), "written twice");
                let list = list.expect("it is there").to_vec();
                self.whole.insert(hash_of(&list));
                self.state = PlanState::Unknown(Unknown::Transferring);
                self.writing = Some(Writing { id: claim.id, of: station, list, blocks: 0 });
                self.publish();
            }
        }
        self.authority.take_fenced();
    }

    fn on_answer(&mut self, station: usize, answer: Answer) {
        let ground = &mut self.grounds[station];
        let id = answer.id.as_slice().try_into().map_or(0, u128::from_be_bytes);
        match std::mem::replace(&mut ground.doing, Doing::Nothing) {
            Doing::Asking(mut delivery, claim, _) if claim.id == id => {
                if let Step::End(Outcome::Answered(answer)) = delivery.on_answer(answer, MonoTime::ZERO, self.now) {
                    ground.epoch = if answer.end() == End::Granted { answer.epoch } else { 0 };
                }
            }
            Doing::Putting { mut delivery, claim, list, .. } if claim.id == id => {
                if let Step::End(Outcome::Answered(answer)) = delivery.on_answer(answer, MonoTime::ZERO, self.now) {
                    match answer.end() {
                        End::Done => {
                            assert_eq!(
                                self.verified.get(&id),
                                Some(&hash_of(&list)),
                                "told as done, and another was written"
                            );
                            self.done += 1;
                        }
                        End::Refused | End::Stale => {
                            assert!(!self.executed.contains(&id), "told as not done, and was");
                            self.refused += 1;
                        }
                        End::Held => ground.epoch = 0,
                        _ => {}
                    }
                }
            }
            doing => ground.doing = doing,
        }
    }

    fn work(&mut self, station: usize) {
        let now = self.now;
        match std::mem::replace(&mut self.grounds[station].doing, Doing::Nothing) {
            Doing::Asking(mut delivery, claim, due) if due <= now => {
                if let Step::Send { wait, .. } = delivery.on_silence(now) {
                    self.ask(station, delivery, claim, wait);
                }
            }
            Doing::Putting { mut delivery, claim, list, seen, due } if due <= now => {
                if let Step::Send { wait, .. } = delivery.on_silence(now) {
                    self.put(station, delivery, claim, list, seen, wait);
                }
            }
            Doing::Nothing => self.begin(station),
            doing => self.grounds[station].doing = doing,
        }
    }

    fn begin(&mut self, station: usize) {
        let ground = &self.grounds[station];
        let (Some((boot, based_on)), Some(seen)) = (ground.seen, ground.heard.told(MISSION).cloned()) else { return };
        let epoch = ground.epoch;
        let (id, wish) = (u128::from(self.next), if epoch == 0 { Wish::Ask(Ask::default()) } else { Wish::Act });
        if !self.rng.random_bool(0.15) {
            return;
        }
        self.next += 1;
        let claim = Claim { boot, epoch, id, based_on, wish };
        let mut delivery = OrderDelivery::new(Duration::from_secs(30), RoundTrip::default(), self.now);
        let Step::Send { wait, .. } = delivery.start() else { return };
        match wish {
            Wish::Ask(_) => self.ask(station, delivery, claim, wait),
            _ => self.put(station, delivery, claim, list_of(u64::try_from(id).expect("small")), seen, wait),
        }
    }

    fn ask(&mut self, station: usize, delivery: OrderDelivery, claim: Claim, wait: Duration) {
        self.grounds[station].doing = Doing::Asking(delivery, claim, self.now + wait);
        self.send(Sent::Put(station, claim, Digest([0; 32]), PlanTold::default()));
    }

    fn put(
        &mut self,
        station: usize,
        delivery: OrderDelivery,
        claim: Claim,
        list: Vec<u8>,
        seen: PlanTold,
        wait: Duration,
    ) {
        for part in Part::all_of(&list) {
            self.send(Sent::Part(station, part));
        }
        self.send(Sent::Put(station, claim, Digest::of(&list), seen.clone()));
        self.grounds[station].doing = Doing::Putting { delivery, claim, list, seen, due: self.now + wait };
    }
}

#[test]
fn schedules_of_plans_over_what_networks_do() {
    let seeds = std::env::var("VENCEJO_TEST_SEEDS").ok().and_then(|text| text.parse::<u64>().ok());
    let schedules = seeds.map_or(USUAL, |seeds| seeds * EACH);
    let (mut written, mut done, mut refused, mut restarts) = (0, 0, 0, 0);
    for seed in 0..schedules {
        let mut world = World::new(seed);
        world.run();
        written += world.executed.len() as u64;
        done += world.done;
        refused += world.refused;
        restarts += world.restarts;
    }
    println!(
        "{schedules} schedules: {written} plans written, {done} told as done, {refused} refused, {restarts} restarts"
    );
    assert!(written > schedules && done * 2 > written && refused > 0 && restarts > schedules / 2, "it was tried");
}
