//! Seeded lies: ground stations of all roles order, one of them is struck off the list, stations on board start again,
//! and what carries all of it between them repeats, reorders, holds back, cuts short, changes, mixes, sends elsewhere
//! and makes orders of its own, and tells the ground stations what it likes. Whatever it does: nothing is done that no
//! trusted operator signed for this aircraft, this boot and this epoch, seconds ago; nothing is done twice; and nobody
//! has control who does not want it.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::sync::LazyLock;
use std::time::Duration;

use prost::Message as _;
use rand::rngs::SmallRng;
use rand::{Rng, SeedableRng};

use super::tests::{Aboard, signed};
use super::*;
use crate::authority::{FRESH, LEASE};
use crate::deed::{Deed, Nothing};
use crate::payload::{Ask, VERSION};
use crate::signature::Signer;
use crate::stamp::Stamper;
use crate::state_source::millis;

/// Runs in the usual run and for each seed that `make soak` asks for.
const USUAL: u64 = 500;
const EACH: u64 = 100;
/// Aircraft of the fleet, of which two are there.
const AIRCRAFT: [&str; 2] = ["plane7", "plane8"];
/// An observer, two operators of whom the second is struck off, a chief; and who has a key that nobody trusts.
static SIGNERS: LazyLock<[Signer; 5]> = LazyLock::new(|| [1, 2, 3, 4, 5].map(|seed| Signer::from_seed(&[seed; 32])));
const ROLES: [Role; 4] = [Role::Observer, Role::Operator, Role::Operator, Role::Chief];
const STRUCK_OFF: usize = 2;
const LIAR: usize = 4;

fn key(of: usize) -> PublicKey {
    SIGNERS[of].public()
}

/// What was signed, by whom and when: nothing else may have an effect.
struct Fact {
    by: PublicKey,
    at: MonoTime,
}

/// A station on board.
struct Plane {
    trust: BTreeMap<PublicKey, Role>,
    authority: Authority,
    aboard: Aboard,
    under_way: Vec<Claim>,
    /// In which boots what was done: nothing twice.
    done: BTreeSet<u128>,
    /// When each key signed its newest order for this boot.
    signs: BTreeMap<PublicKey, MonoTime>,
}

/// What a ground station was told of a plane.
#[derive(Clone, Copy, Default)]
struct Seen {
    boot: u64,
    based_on: StateStamp,
    epoch: u64,
}

struct World {
    rng: SmallRng,
    now: MonoTime,
    planes: [Plane; 2],
    /// By station and plane.
    seen: [[Seen; 2]; 4],
    /// True pictures that were told once, for whoever wants to tell them again.
    pictures: Vec<Seen>,
    facts: HashMap<Vec<u8>, Fact>,
    /// What it was given to carry: for which plane, and the bytes.
    carried: Vec<(usize, Vec<u8>)>,
    tried: Tried,
}

#[derive(Default, Clone, Copy)]
struct Tried {
    acts: u64,
    grants: u64,
    refused: u64,
    repeated: u64,
    late: u64,
}

impl World {
    fn new(seed: u64) -> Self {
        let mut rng = SmallRng::seed_from_u64(seed);
        let now = MonoTime::from_millis(100_000);
        let mut plane = || Plane {
            trust: (0..4).map(|of| (key(of), ROLES[of])).collect(),
            authority: Authority::new(rng.random(), now, Stamper::new(&rng.random())),
            aboard: Aboard::default(),
            under_way: Vec::new(),
            done: BTreeSet::new(),
            signs: BTreeMap::new(),
        };
        Self {
            planes: [plane(), plane()],
            rng,
            now,
            seen: Default::default(),
            pictures: Vec::new(),
            facts: HashMap::new(),
            carried: Vec::new(),
            tried: Tried::default(),
        }
    }

    fn run(&mut self) {
        for _ in 0..24 {
            let ms = if self.rng.random_bool(0.05) { 2_000..12_000 } else { 20..900 };
            self.now += Duration::from_millis(self.rng.random_range(ms));
            self.happen();
            for station in 0..4 {
                let at = self.rng.random_range(0..2);
                self.show(station, at);
            }
            for _ in 0..self.rng.random_range(0..3) {
                self.order();
            }
            if !self.carried.is_empty() {
                self.lie();
            }
        }
    }

    /// What happens on board: a restart, an order's end, a station struck off the list.
    fn happen(&mut self) {
        let now = self.now;
        let at = self.rng.random_range(0..2);
        let plane = &mut self.planes[at];
        match self.rng.random_range(0..40) {
            0 => {
                plane.authority = Authority::new(self.rng.random(), now, Stamper::new(&self.rng.random()));
                plane.under_way.clear();
                plane.signs.clear();
            }
            1 => {
                plane.trust.remove(&key(STRUCK_OFF));
                plane.authority.on_roles(|key| plane.trust.get(key).copied());
            }
            2..12 => {
                for claim in plane.under_way.drain(..) {
                    plane.authority.on_ended(claim.id, answer(&claim, End::Done, ""), now);
                }
            }
            _ => plane.authority.on_time(now),
        }
    }

    /// What a station is shown of a plane: the truth, nothing, what was true once, or what is not.
    fn show(&mut self, station: usize, at: usize) {
        let kind = self.rng.random_range(0..12);
        if (6..10).contains(&kind) {
            return;
        }
        let plane = &self.planes[at];
        let holds = plane.authority.lease().filter(|(holder, _)| *holder == key(station));
        let truth = Seen {
            boot: plane.authority.boot(),
            based_on: plane.authority.stamp(self.now),
            epoch: holds.map_or(0, |(_, epoch)| epoch),
        };
        let told = match kind {
            0..6 => truth,
            10 => self.pictures.get(self.rng.random_range(0..=self.pictures.len())).copied().unwrap_or(truth),
            // A moment to come: what is ordered now could be brought then.
            _ => {
                let at = self.now + Duration::from_millis(self.rng.random_range(0..20_000));
                let mark = if self.rng.random_bool(0.5) { truth.based_on.mark } else { self.rng.random() };
                Seen { based_on: StateStamp { at, mark }, ..truth }
            }
        };
        if self.pictures.len() < 20 {
            self.pictures.push(truth);
        }
        self.seen[station][at] = told;
    }

    /// A station orders, by what it was shown.
    fn order(&mut self) {
        let (mut station, at) = (self.rng.random_range(0..4), self.rng.random_range(0..2));
        // Mostly whoever has control.
        if let Some(holder) = (0..4).find(|station| self.seen[*station][at].epoch > 0 && self.rng.random_bool(0.8)) {
            station = holder;
        }
        let Seen { boot, based_on, epoch } = self.seen[station][at];
        let want = match self.rng.random_range(0..16) {
            0..6 if epoch == 0 => Want::Ask(Ask::default()),
            0..2 => Want::Renew(Nothing {}),
            2 => Want::Release(Nothing {}),
            3 => Want::Keep(key(self.rng.random_range(0..5)).0.to_vec()),
            4 => Want::Recall(self.rng.random::<u128>().to_be_bytes().to_vec()),
            5 => Want::Act(Act { deed: Some(Deed::ParamRead("WP_RADIUS".into())), ..Act::default() }),
            _ => Want::Act(Act { deed: Some(Deed::Takeoff(self.rng.random_range(10.0..100.0))), ..Act::default() }),
        };
        let order = Order {
            version: VERSION,
            // It may be an operator of another fleet as well.
            org: if self.rng.random_bool(0.05) { "other".into() } else { "acme".into() },
            aircraft: AIRCRAFT[at].into(),
            boot,
            epoch,
            id: self.rng.random::<u128>().to_be_bytes().to_vec(),
            based_on_ms: millis(based_on.at.as_duration()),
            operator: format!("station {station}"),
            mark: based_on.mark,
            run: 0,
            want: Some(want),
        };
        self.carried.push((at, signed(&SIGNERS[station], &order)));
        self.facts.insert(order.encode_to_vec(), Fact { by: key(station), at: self.now });
        if boot == self.planes[at].authority.boot() && order.org == "acme" {
            self.planes[at].signs.insert(key(station), self.now);
        }
    }

    /// What was carried arrives, in some form or other, or something else in its place.
    fn lie(&mut self) {
        let any = |rng: &mut SmallRng, of: &[(usize, Vec<u8>)]| of[rng.random_range(0..of.len())].clone();
        for _ in 0..self.rng.random_range(1..4) {
            let newest = self.carried.last().cloned().expect("something");
            let (at, bytes) = any(&mut self.rng, &self.carried);
            let read = |bytes: &[u8]| Signed::read(bytes).expect("as it was sent");
            let (to, bytes) = match self.rng.random_range(0..20) {
                0..8 => newest,
                // Again, late, in another order.
                8..12 => (at, bytes),
                // To another aircraft.
                12 => (1 - at, bytes),
                // Cut short.
                13 => (at, bytes[..self.rng.random_range(0..bytes.len())].to_vec()),
                14 => {
                    let mut bytes = bytes;
                    for _ in 0..self.rng.random_range(1..4) {
                        let bit = self.rng.random_range(0..bytes.len() * 8);
                        bytes[bit / 8] ^= 1 << (bit % 8);
                    }
                    (at, bytes)
                }
                // The signature of one to the order of another, or what says whose it is.
                15 => {
                    let (_, other) = any(&mut self.rng, &self.carried);
                    let (one, other) = (read(&bytes), read(&other));
                    let spliced = if self.rng.random_bool(0.5) {
                        Signed { order: one.order, ..other }
                    } else {
                        Signed { key: other.key, ..one }
                    };
                    (at, spliced.encode_to_vec())
                }
                // One after the other: fields of the second count.
                16 => {
                    let (_, other) = any(&mut self.rng, &self.carried);
                    let (mut one, other) = (read(&bytes), read(&other));
                    one.order.extend(other.order);
                    (at, one.encode_to_vec())
                }
                // Written anew, with what would be worth having.
                17 | 18 => {
                    let mut one = read(&bytes);
                    let mut order = Order::read(&one.order).expect("as it was sent");
                    match self.rng.random_range(0..5) {
                        0 => order.id = self.rng.random::<u128>().to_be_bytes().to_vec(),
                        1 => order.based_on_ms += self.rng.random_range(1..10_000),
                        2 => order.epoch += 1,
                        3 => order.boot = self.planes[at].authority.boot(),
                        _ => {
                            order.want = Some(Want::Act(Act { deed: Some(Deed::Disarm(true)), ..Act::default() }));
                        }
                    }
                    one.order = order.encode_to_vec();
                    (at, one.encode_to_vec())
                }
                // Its own, in its own name or in that of another.
                _ => {
                    let order = Order::read(&read(&bytes).order).expect("as it was sent");
                    let mut own = Signed::read(&signed(&SIGNERS[LIAR], &order)).expect("made");
                    if self.rng.random_bool(0.5) {
                        own.key = key(self.rng.random_range(0..4)).0.to_vec();
                    }
                    (at, own.encode_to_vec())
                }
            };
            self.arrive(to, &bytes);
        }
    }

    /// It arrives on board: was what came of it allowed to?
    fn arrive(&mut self, at: usize, bytes: &[u8]) {
        let now = self.now;
        let plane = &mut self.planes[at];
        let names = BTreeMap::new();
        plane.authority.on_time(now);
        let to = Addressee { org: "acme", aircraft: AIRCRAFT[at], trust: &plane.trust, names: &names, has_list: true };
        let before = (plane.authority.held(), plane.authority.lease());
        let judged = judge(bytes, &to, &mut plane.authority, &mut plane.aboard, now);
        match &judged {
            Judged::OfStranger(_, answer) => {
                let is_of_other_boot = answer.end() == End::Unknown && answer.boot_age_ms > 0;
                assert!(answer.end() == End::Refused || is_of_other_boot, "{answer:?}");
                assert_eq!((plane.authority.held(), plane.authority.lease()), before, "a stranger changes nothing");
                self.tried.refused += 1;
            }
            Judged::OfList(_) => panic!("of no list"),
            Judged::UnderWay(id) => {
                assert!(plane.done.contains(id));
                self.tried.repeated += 1;
            }
            Judged::Ended((_, order), answer) => {
                assert_eq!(answer.id, order.id, "the answer is that order's");
                self.tried.late += u64::from(answer.end() == End::Stale);
            }
            Judged::Execute(to_do) => {
                let ToDo { sender: (by, order), claim, request, .. } = &**to_do;
                let fact = self.facts.get(&order.encode_to_vec()).expect("somebody signed just that");
                assert_eq!(fact.by, *by, "in its own name");
                assert_eq!((order.org.as_str(), order.aircraft.as_str()), ("acme", AIRCRAFT[at]), "for this aircraft");
                assert_eq!(order.boot, plane.authority.boot(), "for this boot");
                let role = plane.trust.get(by).expect("who is on the list");
                if request.is_act() {
                    assert_ne!(*role, Role::Observer, "an observer acts");
                    assert_eq!(plane.authority.lease(), Some((*by, order.epoch)), "in its epoch");
                    self.tried.acts += 1;
                }
                let Some(Want::Act(act)) = &order.want else { panic!("something to do") };
                assert_eq!(act::request_of(act).as_ref().map(|(ordered, _)| ordered), Ok(request), "as it was ordered");
                assert!(plane.done.insert(claim.id), "twice");
                assert!(now.since(fact.at) <= FRESH, "brought {:?} after it was ordered", now.since(fact.at));
                plane.under_way.push(*claim);
            }
        }
        let holder = plane.authority.lease();
        self.tried.grants += u64::from(holder.is_some() && holder != before.1);
        if let Some((holder, _)) = holder {
            assert!(plane.trust.get(&holder).is_some_and(|role| *role != Role::Observer), "who may not has control");
            let newest = plane.signs.get(&holder).expect("it has signed something for this boot");
            // What is brought late keeps it.
            assert!(now <= *newest + FRESH + LEASE, "control outlives the last sign of its holder");
        }
    }
}

#[test]
fn a_router_that_lies_gets_nothing_done_that_nobody_ordered() {
    let seeds = std::env::var("VENCEJO_TEST_SEEDS").ok().and_then(|text| text.parse::<u64>().ok());
    let runs = seeds.map_or(USUAL, |seeds| seeds * EACH);
    let mut all = Tried::default();
    for seed in 0..runs {
        let mut world = World::new(seed);
        world.run();
        let Tried { acts, grants, refused, repeated, late } = world.tried;
        all.acts += acts;
        all.grants += grants;
        all.refused += refused;
        all.repeated += repeated;
        all.late += late;
    }
    let Tried { acts, grants, refused, repeated, late } = all;
    println!("{runs} runs: {acts} acts, {grants} grants; {refused} of strangers, {repeated} again, {late} late");
    assert!(acts > runs && grants > runs, "it was tried: {acts}, {grants}");
    assert!(refused > 3 * runs && repeated > runs / 4 && late > runs / 4, "{refused}, {repeated}, {late}");
}
