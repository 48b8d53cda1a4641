//! Figures of faults that concern a whole vehicle: when a loss, a way back and a restart are noticed, what a dead
//! uplink costs, and what becomes of two people who want the same at once.

use super::*;
use crate::telemetry::Freshness;
use crate::transfer::TransferError;
use crate::transfer::testing::seeds;

fn is_told(world: &Pair, event: &VehicleEvent) -> bool {
    world.station.events.contains(event)
}

// fault 12: stale 3.5 s, lost 5 s after the last word, back within 1.5 s, at 5 phases of the heartbeat
#[test]
fn stale_lost_and_back_are_told_in_time() {
    for phase_ms in [0, 130, 410, 770, 990] {
        let mut world = connected();
        wait(&mut world, phase_ms);
        let now = world.now;
        let back = now + Duration::from_secs(12);
        world.faults.blackouts = vec![(now, back)];
        wait(&mut world, 1);
        let heard = world.station.vehicle.heard_at();
        let freshness = |world: &Pair| {
            let attitude = world.station.vehicle.telemetry().attitude.expect("it streams");
            attitude.freshness(world.now)
        };
        world.run(heard + Duration::from_millis(3_400), |_, _| false);
        assert_eq!(freshness(&world), Freshness::Fresh);
        world.run(heard + Duration::from_millis(3_501), |_, _| false);
        assert_eq!(freshness(&world), Freshness::Stale, "3.5 s after its last word");
        assert!(!is_told(&world, &VehicleEvent::Lost));
        assert!(world.run(back, |station, _| station.events.contains(&VehicleEvent::Lost)));
        let after = world.now.since(heard);
        assert!((Duration::from_secs(5)..=Duration::from_millis(5_010)).contains(&after), "lost after {after:?}");
        assert_eq!(freshness(&world), Freshness::Lost);
        assert!(
            world.run(back + Duration::from_secs(5), |station, _| station.events.contains(&VehicleEvent::Regained))
        );
        let after = world.now.since(back);
        assert!(after <= Duration::from_millis(1_500), "back after {after:?}");
    }
}

/// How long after `from` it is told that the vehicle is not reached.
fn told_after(world: &mut Pair, from: MonoTime) -> Duration {
    let is_told = |station: &mut Station, _: &mut Plane| station.events.contains(&VehicleEvent::Unreached);
    assert!(world.run(from + Duration::from_secs(20), is_told), "never told");
    assert_eq!(world.station.vehicle.is_reached(world.now), Some(false));
    world.now.since(from)
}

// fault 11: arm, mode, RTL and a jump at 9 phases of the questions: told ≤ 5 s that the vehicle is not reached, failed
// ≤ 5.3 s; nothing is called refused
#[test]
fn an_uplink_that_is_dead_is_told_within_five_seconds() {
    // What is heard is heard on; nothing that is sent arrives.
    let acts = [ARM, mode("AUTO"), Request::ReturnToLaunch, Request::SetCurrentItem { item: 1 }];
    let mut latest = Duration::ZERO;
    for request in acts {
        for phase in 0..9 {
            let mut world = connected();
            wait(&mut world, phase * 250);
            world.faults.is_deaf = true;
            let now = world.now;
            let id = start(&mut world, request.clone());
            latest = latest.max(told_after(&mut world, now));
            let error = end(&mut world, id, 60).expect_err("it cannot succeed");
            assert!(!matches!(error, VehicleError::CommandRefused { .. }), "{request:?}: {error}");
            assert!(world.station.vehicle.is_heard(world.now));
            let took = world.now.since(now);
            // Five tries of a second each, and the time on the way; in other phases the fifth waits for a heartbeat.
            let most = Duration::from_millis(if phase == 0 { 5_050 } else { 5_300 });
            assert!(took <= most, "{request:?}, phase {phase}: {took:?}");
        }
    }
    println!("dead uplink: told after {latest:?} at most");
    assert!(latest <= Duration::from_secs(5), "{latest:?}");
}

/// One of each kind.
fn transfers() -> [Request; 6] {
    [
        upload(),
        Request::DownloadPlan { kind: PlanKind::Mission },
        Request::ClearPlan { kind: PlanKind::Mission },
        Request::ParamList,
        Request::ParamRead { name: "TKOFF_ALT".into() },
        Request::ParamSet { name: "TKOFF_ALT".into(), value: 60.0 },
    ]
}

// fault 11: 6 transfers by 2 routes, begun before and after it is known: each ends as not reached ≤ 5 s after it began
#[test]
fn a_transfer_over_a_dead_uplink_ends_within_five_seconds() {
    let mut slowest = Duration::ZERO;
    for request in transfers() {
        for has_ftp in [true, false] {
            for before_ms in [0, 700, 1_900, 8_000, 20_000] {
                let mut world = connected();
                world.plane.services.has_ftp = has_ftp;
                wait(&mut world, 5_000);
                let on_board = world.plane.services.plans.clone();
                world.faults.is_deaf = true;
                wait(&mut world, before_ms);
                let now = world.now;
                let error = ask(&mut world, request.clone()).expect_err("it cannot succeed");
                let took = world.now.since(now);
                let is_told = matches!(error, VehicleError::Transfer(TransferError::Unreached { .. }));
                assert!(is_told, "{request:?} after {before_ms} ms: {error}");
                slowest = slowest.max(took);
                assert_eq!(world.station.vehicle.is_reached(world.now), Some(false));
                assert!(world.station.vehicle.plan_state(PlanKind::Mission).hash().is_none());
                assert!(world.plane.services.plans == on_board, "the plan on board was touched");
                // It works again as soon as the vehicle answers.
                world.faults.is_deaf = false;
                let now = world.now;
                let is_back = |station: &mut Station, _: &mut Plane| station.events.contains(&VehicleEvent::Reached);
                assert!(world.run(now + Duration::from_secs(1), is_back), "within a second");
                assert_eq!(world.station.vehicle.is_reached(world.now), Some(true));
                ask(&mut world, request.clone()).expect("it is reached");
            }
        }
    }
    println!("dead uplink: a transfer ends after {slowest:?} at most");
    assert!(slowest <= Duration::from_secs(5), "{slowest:?}");
}

// fault 11: an uplink that dies while nobody asks anything, in the middle of an upload, or was never there: told ≤ 5 s
#[test]
fn a_dead_uplink_is_told_when_nobody_asks_anything_too() {
    for phase in 0..9 {
        let mut world = connected();
        wait(&mut world, phase * 250);
        world.faults.is_deaf = true;
        let now = world.now;
        // The next question goes out within 2 s.
        let took = told_after(&mut world, now);
        assert!(took <= Duration::from_secs(5), "{took:?}");
    }
    let mut world = connected();
    wait(&mut world, 5_000);
    world.faults = Faults { delay: Duration::from_millis(100), ..world.faults };
    let id = start(&mut world, upload());
    // The first question of the upload has arrived, its answer has not.
    wait(&mut world, 150);
    world.faults.is_deaf = true;
    let now = world.now;
    let took = told_after(&mut world, now);
    assert!(took <= Duration::from_secs(5), "{took:?}");
    assert!(!world.station.results.contains_key(&id), "it goes on: the vehicle may hold half of it");
    world.faults.is_deaf = false;
    end(&mut world, id, 60).expect("survived");
    let faults = Faults { is_deaf: true, ..Faults::default() };
    let mut world = World::new(Station::new(), Plane::new(), faults, 1);
    let took = told_after(&mut world, MonoTime::ZERO);
    assert!(took <= Duration::from_secs(5), "{took:?}");
}

// fault 11 (40 seeds): 19 minutes each at 20 and 30 % lost each way and at a round trip of 1 s without and with 20 %
// lost, with uploads: no false alarm
#[test]
fn a_bad_or_slow_link_is_not_taken_for_a_dead_one() {
    let slow = Faults::round_trip(Duration::from_secs(1));
    let links = [Faults::loss(0.2), Faults::loss(0.3), slow.clone(), Faults { loss: 0.2, ..slow }];
    let mut uploads = 0;
    for (link, faults) in links.into_iter().enumerate() {
        for seed in 0..seeds(10) {
            let mut world = World::new(Station::new(), Plane::new(), faults.clone(), seed);
            wait(&mut world, 10_000);
            for _ in 0..3 {
                let id = start(&mut world, upload());
                wait(&mut world, 35_000);
                uploads += usize::from(world.station.results.contains_key(&id));
                assert!(!is_told(&world, &VehicleEvent::Unreached), "link {link}, seed {seed}");
                assert_ne!(world.station.vehicle.is_reached(world.now), Some(false));
            }
        }
    }
    assert!(uploads >= 100, "{uploads}");
}

// fault 11: both directions dark for 1 to 30 s at 8 phases is not a dead uplink, before or after
#[test]
fn a_link_that_is_dark_both_ways_is_not_a_dead_uplink() {
    for dark_ms in [1_000, 1_400, 2_000, 3_000, 5_000, 10_000, 30_000] {
        for phase in 0..8 {
            let mut world = connected();
            wait(&mut world, phase * 270);
            let until = world.now + Duration::from_millis(dark_ms);
            world.faults.blackouts = vec![(world.now, until)];
            let id = start(&mut world, upload());
            wait(&mut world, dark_ms + 10_000);
            assert!(!is_told(&world, &VehicleEvent::Unreached), "{dark_ms} ms, phase {phase}");
            let result = end(&mut world, id, 60);
            if dark_ms <= 5_000 {
                result.expect("survived");
            }
            assert_eq!(world.station.vehicle.is_reached(world.now), Some(true));
        }
    }
}

// fault 15: 6 transfers by 2 routes, a restart at 15 steps each: seen ≤ 2 s after the first word, plan unknown, each
// transfer ends
#[test]
fn a_restart_at_any_step_of_any_transfer_is_seen_and_voids_the_plan() {
    let (mut latest, mut interrupted) = (Duration::ZERO, 0);
    for request in transfers() {
        for has_ftp in [true, false] {
            for step in 0..15 {
                let mut world = World::new(Station::new(), Plane::new(), Faults::default(), step);
                world.plane.services.has_ftp = has_ftp;
                wait(&mut world, 2_000);
                ask(&mut world, upload()).expect("uploaded");
                assert!(world.station.vehicle.plan_state(PlanKind::Mission).hash().is_some());
                // Of one that was up for a second alone nobody could tell.
                wait(&mut world, 30_000);
                let id = start(&mut world, request.clone());
                wait(&mut world, step * if has_ftp { 5 } else { 15 });
                interrupted += usize::from(!world.station.results.contains_key(&id));
                let now = world.now;
                world.plane.reboot(now);
                // The first that is heard of it afterwards.
                let speaks = world.plane.next_heartbeat;
                let is_seen = |station: &mut Station, _: &mut Plane| station.events.contains(&VehicleEvent::Rebooted);
                assert!(world.run(speaks + Duration::from_secs(10), is_seen), "{request:?}, step {step}");
                latest = latest.max(world.now.since(speaks));
                let state = world.station.vehicle.plan_state(PlanKind::Mission);
                assert!(state.hash().is_none(), "{request:?}, step {step}: {state}");
                wait(&mut world, 60_000);
                assert!(world.station.results.contains_key(&id), "{request:?}, step {step}: it ends");
            }
        }
    }
    println!("restarts: seen {latest:?} after the first word at the latest; {interrupted} transfers were under way");
    assert!(latest <= Duration::from_secs(2), "{latest:?}");
    assert!(interrupted >= 40, "{interrupted}");
}

// fault 31 (500 races): 500 races of two, either of whom begins, at once or one behind the other: one whole plan,
// whoever came second told; each parameter told as written, the last one on board
#[test]
fn of_two_who_send_at_once_one_has_a_whole_plan_on_board_and_the_other_is_told() {
    let route = |north_deg: f64, count: usize| -> Vec<MissionItem> {
        (0..count).map(|index| MissionItem::waypoint(40.33 + north_deg, -3.8 + index as f64 * 1e-3, 80.0)).collect()
    };
    let send = |items: &[MissionItem]| Request::UploadPlan {
        kind: PlanKind::Mission,
        items: items.to_vec(),
        home: None,
        despite_findings: false,
    };
    let set = |value| Request::ParamSet { name: "TKOFF_ALT".into(), value };
    let mut rng = SmallRng::seed_from_u64(31);
    // Ana and Ben: whose plan or value is on board in the end, and whether the other was told that somebody sends.
    let mut plans: BTreeMap<(&str, bool), u64> = BTreeMap::new();
    let mut values: BTreeMap<&str, u64> = BTreeMap::new();
    let mut world = connected();
    world.plane.services.has_ftp = false;
    let races = 5 * seeds(100);
    for race in 0..races {
        world.faults.loss = if race % 5 == 0 { 0.1 } else { 0.0 };
        let mut order = [("Ana", 0), ("Ben", 1)];
        if rng.random_bool(0.5) {
            order.reverse();
        }
        let between_ms = [0, rng.random_range(0..400), rng.random_range(0..6_000)][rng.random_range(0..3)];
        if race % 10 == 9 {
            // Two values of one parameter: both are written, and each is told the value that it wrote.
            let wanted = order.map(|(_, who)| [40.0, 900.0][who] + race as f64);
            let first = start(&mut world, set(wanted[0]));
            wait(&mut world, between_ms);
            let ids = [first, start(&mut world, set(wanted[1]))];
            for (id, wanted) in ids.into_iter().zip(wanted) {
                let told = end(&mut world, id, 120);
                let Ok(Reply::Parameter(param)) = &told else { panic!("race {race}: {told:?}") };
                assert_eq!(param.value.as_f64(), wanted, "race {race}");
            }
            let on_board = world.plane.services.params.iter().find(|param| param.name.as_str() == "TKOFF_ALT");
            assert_eq!(
                on_board.map(|param| param.value.as_f64()),
                Some(wanted[1]),
                "race {race}: the last that was told"
            );
            *values.entry(order[1].0).or_default() += 1;
            continue;
        }
        let routes = [route(0.001, 4 + (race % 9) as usize), route(0.05, 4 + (race % 7) as usize)];
        let [(first_name, first_route), (second_name, second_route)] = order.map(|(name, who)| (name, &routes[who]));
        let first = start(&mut world, send(first_route));
        wait(&mut world, between_ms);
        let second = start(&mut world, send(second_route));
        let results = [end(&mut world, first, 240), end(&mut world, second, 240)];
        let on_board: Vec<_> = world.plane.services.plans[0][1..].iter().map(|item| (item.x, item.y)).collect();
        let is_whole = |items: &[MissionItem]| {
            let wire = items.iter().map(|item| [4, 5].map(|at| (item.params[at].unwrap_or(0.0) * 1e7).round() as i32));
            wire.eq(on_board.iter().map(|(x, y)| [*x, *y]))
        };
        match &results {
            [Ok(_), Err(VehicleError::TransferBusy { running })] => {
                assert_eq!(*running, "plan upload");
                assert!(is_whole(first_route), "race {race}");
                *plans.entry((first_name, true)).or_default() += 1;
            }
            [Ok(_), Ok(_)] => {
                assert!(is_whole(second_route), "race {race}");
                *plans.entry((second_name, false)).or_default() += 1;
            }
            others => panic!("race {race}: {others:?}"),
        }
    }
    println!("races: {plans:?} plans, {values:?} values");
    // Each of them: before one who was told so, behind one who was done, and the last to write a value.
    assert!(plans.len() == 4 && plans.values().all(|count| *count >= races / 20), "{plans:?}");
    assert!(values.len() == 2 && values.values().all(|count| *count >= races / 50), "{values:?}");
}
