//! Transfers over links that lose, double, reorder, delay and go dark, and with others who meddle.
//!
//! Everywhere: a success is true (the plane has the plan, also after all late frames have come), and a failure is told
//! in time.

use std::collections::BTreeSet;
use std::time::Duration;

use rand::rngs::SmallRng;
use rand::{Rng, SeedableRng};
use vencejo_flight::plan::PlanKind;
use vencejo_proto::dialect::{
    MISSION_COUNT_DATA, MISSION_REQUEST_INT_DATA, MavMessage, MavMissionType, MavParamType, PARAM_VALUE_DATA,
};
use vencejo_proto::ftp::{FtpOpcode, FtpPayload};
use vencejo_proto::param::{Param, ParamName, ParamValue};
use vencejo_proto::{Address, Message, MissionAck, MissionItemInt, MonoTime};

use super::{LIMIT, by_ftp, by_items, has, mission, ms};
use crate::transfer::testing::{Endpoint, Faults, MockPlane, PLANE, RIVAL, Running, STATION, World, run, seeds};
use crate::transfer::{
    DownloadedPlan, FtpGet, ParamList, ParamRead, ParamSet, PlanClear, PlanDownload, PlanUpload, Transfer,
    TransferConfig, TransferError, VerifiedPlan,
};

/// Seeds for each rate of loss, in the suite.
const SEEDS: u64 = 200;
/// How often an upload may begin anew until it is there.
const RESTARTS: usize = 3;
/// A link that is gone is told by then (tests/faults, row 3).
const GONE: Duration = Duration::from_secs(15);

type UploadWorld = World<Running<PlanUpload>, MockPlane>;
type Uploaded = Result<VerifiedPlan, TransferError>;

fn uploading(config: &TransferConfig, items: &[MissionItemInt], faults: Faults, seed: u64) -> UploadWorld {
    let upload = PlanUpload::new(config, PlanKind::Mission, items.to_vec(), MonoTime::ZERO);
    // Every other one has several MAVFTP sessions.
    let mut plane = if seed.is_multiple_of(2) { MockPlane::new() } else { MockPlane::with_several_sessions() };
    // What was there before: other items, and more of them.
    plane.plans[0].extend(mission(70).into_iter().skip(1).map(|item| MissionItemInt { z: 11.0, ..item }));
    World::new(Running::new(upload), plane, faults, seed)
}

/// Runs an upload to its end and beyond; a success must be one, and stay one.
fn check(world: &mut UploadWorld, items: &[MissionItemInt]) -> (Uploaded, Duration) {
    let (result, took) = run(world, LIMIT);
    if let Ok(plan) = &result {
        assert!(has(&world.plane.plans[0], items), "false success");
        assert!(has(&plan.items, items));
        let until = world.now + Duration::from_secs(20);
        world.run(until, |_, _| false);
        assert!(has(&world.plane.plans[0], items), "the plan changed after its success");
    }
    (result, took)
}

fn bad_link(loss: f64) -> Faults {
    Faults { loss, duplicates: 0.1, reorder: 0.1, jitter: ms(3), ..Faults::default() }
}

/// How often an upload began anew: a count after items had gone out, or another creation of the file. (One that is
/// asked for again by its number was lost or overtaken.)
fn restarts(log: &[(MonoTime, Message)]) -> usize {
    let (mut counts, mut is_under_way, mut creations) = (0, false, BTreeSet::new());
    for (_, message) in log {
        match FtpPayload::from_message(message) {
            Some((_, request)) if request.opcode == FtpOpcode::CREATE_FILE => {
                creations.insert((request.session, request.sequence));
            }
            _ if matches!(message, Message::Dialect(MavMessage::MISSION_COUNT(_))) => {
                counts += usize::from(is_under_way);
                is_under_way = false;
            }
            _ => is_under_way |= matches!(message, Message::MissionItemInt(_)),
        }
    }
    counts + creations.len().saturating_sub(1)
}

/// Share of uploads that succeed and do not begin anew too often, and the longest that one took.
fn share(loss: f64, items: u16, config: impl Fn(u32) -> TransferConfig) -> (f64, Duration) {
    let items = mission(items);
    let (mut good, mut longest, mut most_restarts) = (0, Duration::ZERO, 0);
    let seeds = seeds(SEEDS);
    for seed in 0..seeds {
        let mut world = uploading(&config(seed as u32), &items, bad_link(loss), seed);
        world.log = Some(Vec::new());
        let (result, took) = check(&mut world, &items);
        let restarts = restarts(&world.log.expect("logged"));
        if let Err(error) = &result {
            println!("{loss}, seed {seed}: {error} after {took:?}");
        }
        good += usize::from(result.is_ok() && restarts <= RESTARTS);
        longest = longest.max(took);
        most_restarts = most_restarts.max(restarts);
    }
    println!("{loss}: begun anew {most_restarts} times at most");
    (good as f64 / seeds as f64, longest)
}

/// What of all uploads has to succeed where so many frames are lost.
fn bar(loss: f64) -> f64 {
    if loss > 0.2 { 0.99 } else { 0.999 }
}

// fault 1 (200 seeds each): by file: ≥ 99.9 % (≥ 99 % at 30 %) of 50 items at 0, 5, 10, 20 and 30 % lost, begun anew at
// most 3 times, 0 false successes
#[test]
fn uploads_by_file_succeed_on_any_bad_link() {
    for loss in [0.0, 0.05, 0.1, 0.2, 0.3] {
        let (good, longest) = share(loss, 50, |seed| by_ftp(ms(0), seed));
        println!("by file, {loss}: {good} good, at most {longest:?}");
        assert!(good >= bar(loss), "{loss}: {good}");
    }
}

// fault 5 (200 seeds each): uploads with 10 % of frames up to 60 ms late, doubled and lost too: exact fault 1 (200
// seeds each): item by item: ≥ 99.9 % (≥ 99 % at 30 %) of 50 items at 0, 5, 10, 20 and 30 % lost, begun anew at most 3
// times, 0 false successes
#[test]
fn uploads_by_items_succeed_on_any_bad_link() {
    for loss in [0.0, 0.05, 0.1, 0.2, 0.3] {
        let (good, longest) = share(loss, 50, |_| by_items(ms(0)));
        println!("by items, {loss}: {good} good, at most {longest:?}");
        assert!(good >= bar(loss), "{loss}: {good}");
    }
}

// fault 1 (200 seeds each): 64 items ahead: ≥ 99.9 % (≥ 99 % at 30 %) of 50 items at 0, 5, 10, 20 and 30 % lost, begun
// anew at most 3 times, 0 false successes
#[test]
fn items_sent_ahead_succeed_on_any_bad_link() {
    for loss in [0.0, 0.05, 0.1, 0.2, 0.3] {
        let ahead = |_| TransferConfig { item_window: 64, ..by_items(ms(0)) };
        let (good, longest) = share(loss, 50, ahead);
        println!("ahead, {loss}: {good} good, at most {longest:?}");
        assert!(good >= bar(loss), "{loss}: {good}");
    }
}

// fault 4 (200 seeds): a vehicle that ends the upload at an item out of order: ≥ 99 % succeed
#[test]
fn a_vehicle_that_gives_up_at_an_item_out_of_order_gets_the_list_again() {
    let items = mission(12);
    let mut good = 0;
    let seeds = seeds(SEEDS);
    for seed in 0..seeds {
        let link = Faults { duplicates: 0.02, reorder: 0.02, ..bad_link(0.05) };
        let mut world = uploading(&by_items(ms(0)), &items, link, seed);
        world.plane.strict_order = true;
        good += usize::from(check(&mut world, &items).0.is_ok());
    }
    assert!(good as f64 >= 0.99 * seeds as f64, "{good}");
}

// fault 4 (50 seeds each): 10 % of frames three times, three routes: exact; items out of order were refused and
// survived
#[test]
fn frames_that_come_three_times_change_nothing() {
    let items = mission(50);
    let seeds = seeds(50);
    for config in [by_ftp(ms(0), 4), by_items(ms(0)), TransferConfig { item_window: 64, ..by_items(ms(0)) }] {
        let mut doubled = 0;
        for seed in 0..seeds {
            let link = Faults { duplicates: 0.1, copies: 3, jitter: ms(3), ..Faults::default() };
            let mut world = uploading(&config, &items, link, seed);
            let (result, _) = check(&mut world, &items);
            assert!(result.is_ok(), "seed {seed}: {result:?}");
            // What ArduPilot says to an item that it has already.
            doubled += world.plane.out_of_order;
        }
        println!("three times: {doubled} items came out of order");
        assert!(config.has_ftp || doubled as u64 >= seeds, "{doubled}");
    }
}

#[test]
fn every_kind_of_plan_is_sent_read_and_cleared() {
    for kind in PlanKind::ALL {
        for config in [by_ftp(ms(0), 5), by_items(ms(0))] {
            let items = match kind {
                PlanKind::Mission => mission(9),
                _ => listed(kind, 5),
            };
            let plane = MockPlane::new();
            let upload = PlanUpload::new(&config, kind, items.clone(), MonoTime::ZERO);
            let mut world = World::new(Running::new(upload), plane, bad_link(0.1), 7);
            let plan = run(&mut world, LIMIT).0.expect("sent");
            assert_eq!((plan.kind, plan.items.len()), (kind, items.len()));

            let clear = PlanClear::new(&config, kind, MonoTime::ZERO);
            let mut world = World::new(Running::new(clear), world.plane, bad_link(0.1), 8);
            run(&mut world, LIMIT).0.expect("cleared");
            assert!(world.plane.plans[kind as usize].is_empty());

            let download = PlanDownload::new(&config, kind, MonoTime::ZERO);
            let mut world = World::new(Running::new(download), world.plane, bad_link(0.1), 9);
            assert_eq!(run(&mut world, LIMIT).0.expect("read").items, []);
        }
    }
}

/// A fence polygon or rally points.
fn listed(kind: PlanKind, count: u16) -> Vec<MissionItemInt> {
    let command = if kind == PlanKind::Fence { 5001 } else { 5100 };
    let count_param = if kind == PlanKind::Fence { f32::from(count) } else { 0.0 };
    (0..count)
        .map(|seq| MissionItemInt {
            target: PLANE,
            seq,
            frame: if kind == PlanKind::Fence { 0 } else { 3 },
            command,
            current: 0,
            autocontinue: 1,
            params: [count_param, 0.0, 0.0, 0.0],
            x: 403_300_000 + i32::from(seq % 3) * 10_000,
            y: -37_900_000 + i32::from(seq) * 10_000,
            z: if kind == PlanKind::Fence { 0.0 } else { 60.0 },
            mission_type: kind.mission_type(),
        })
        .collect()
}

// fault 5 (200 seeds each): downloads likewise: exact
// fault 2 (200 and 20 seeds each): 50 and 500 items at 5 to 30 % lost: all exact, within 30 s and 180 s
#[test]
fn downloads_are_exact_on_any_bad_link() {
    for (count, seeds) in [(50, seeds(SEEDS)), (500, seeds(SEEDS) / 10)] {
        let items = mission(count);
        for loss in [0.05, 0.1, 0.2, 0.3] {
            for seed in 0..seeds {
                for config in [by_ftp(ms(0), seed as u32), by_items(ms(0))] {
                    let mut plane = MockPlane::new();
                    plane.store(PlanKind::Mission, &items);
                    let download = PlanDownload::new(&config, PlanKind::Mission, MonoTime::ZERO);
                    let mut world = World::new(Running::new(download), plane, bad_link(loss), seed);
                    let (result, took) = run(&mut world, LIMIT);
                    let DownloadedPlan { items: read, .. } = result.unwrap_or_else(|error| panic!("{seed}: {error}"));
                    assert!(read.len() == items.len() && has(&read, &items));
                    // tests/faults, row 2: at 20 % 50 items within 30 s, 500 within 180 s.
                    assert!(took <= if count == 50 { ms(30_000) } else { ms(180_000) }, "{took:?}");
                }
            }
        }
    }
}

// fault 3: uploads by both routes dark at 25 steps: true, or told within 15 s
#[test]
fn a_link_that_goes_dark_is_survived_or_told_in_time() {
    let items = mission(40);
    for by_file in [true, false] {
        let mut outcomes = [0, 0];
        let config = |seed| if by_file { by_ftp(ms(0), seed) } else { by_items(ms(0)) };
        let whole = check(&mut uploading(&config(0), &items, Faults::default(), 0), &items).1;
        for seconds in [2, 5, 10, 30] {
            for step in 0..25 {
                let from = MonoTime::from_micros((whole.as_micros() as u64 / 25) * step);
                let until = from + Duration::from_secs(seconds);
                let faults = Faults { blackouts: vec![(from, until)], ..Faults::default() };
                let mut world = uploading(&config(step as u32), &items, faults, step);
                let (result, took) = check(&mut world, &items);
                match result {
                    Ok(_) => outcomes[0] += 1,
                    Err(_) => {
                        outcomes[1] += 1;
                        assert!(took <= from.as_duration() + GONE, "{seconds} s dark from {from}: told after {took:?}");
                    }
                }
                // As much as it takes the vehicle to give up (8 s) is not too long for us.
                assert!(seconds > 5 || world.plane.changes == 0 || has(&world.plane.plans[0], &items));
            }
        }
        println!("dark, by file {by_file}: {outcomes:?}");
        assert!(outcomes[0] >= 50, "{outcomes:?}");
    }
}

/// A transfer over a link that is dark for some seconds, from each of some steps of it on: it ends well, or says so in
/// time.
fn darkened<T: Transfer>(
    what: &str,
    mut begin: impl FnMut(u32) -> (T, MockPlane),
    is_right: impl Fn(&T::Value, &MockPlane) -> bool,
) {
    const STEPS: u32 = 12;
    let (transfer, plane) = begin(0);
    let mut world = World::new(Running::new(transfer), plane, Faults::default(), 0);
    let (whole, took) = run(&mut world, LIMIT);
    assert!(whole.is_ok_and(|value| is_right(&value, &world.plane)), "{what}");
    let (mut good, mut told) = (0, 0);
    for seconds in [2, 5, 10, 30] {
        for step in 0..STEPS {
            let from = MonoTime::ZERO + took.mul_f64(f64::from(step) / f64::from(STEPS));
            let blackouts = vec![(from, from + Duration::from_secs(seconds))];
            let (transfer, plane) = begin(step);
            let faults = Faults { blackouts, ..Faults::default() };
            let mut world = World::new(Running::new(transfer), plane, faults, u64::from(step));
            let (result, took) = run(&mut world, LIMIT);
            match result {
                Ok(value) => {
                    assert!(is_right(&value, &world.plane), "{what}: {seconds} s dark from {from}: wrong");
                    good += 1;
                }
                Err(error) => {
                    assert!(
                        took <= from.as_duration() + GONE,
                        "{what}: {seconds} s dark from {from}: {took:?}, {error}"
                    );
                    told += 1;
                }
            }
        }
    }
    println!("dark, {what}: {good} went on, {told} were told");
    assert!(good >= 12, "{what}: {good} went on");
}

/// A file of so many bytes, no two parts of which are alike.
fn content(len: usize) -> Vec<u8> {
    let mut rng = SmallRng::seed_from_u64(20);
    (0..len).map(|_| rng.random()).collect()
}

const FILE: &str = "@SYS/a.bin";

fn with_file(len: usize) -> MockPlane {
    let mut plane = MockPlane::new();
    plane.files = vec![(FILE.as_bytes(), content(len))];
    plane
}

// fault 3: parameter lists, a parameter, downloads and a file dark at 12 steps: right, or told within 15 s
#[test]
fn parameters_files_and_downloads_survive_the_dark_or_tell_it_in_time() {
    for (name, config) in [("by file", by_ftp(ms(0), 3)), ("one by one", by_items(ms(0)))] {
        let with_params = || {
            let mut plane = MockPlane::new();
            plane.params = params();
            plane
        };
        let list = |_| (ParamList::new(&config, MonoTime::ZERO), with_params());
        darkened(&format!("parameters {name}"), list, |read, _| *read == params());
        let set = |_| (ParamSet::new(&config, name_of("P3_33"), 7.0, MonoTime::ZERO), with_params());
        darkened(&format!("a parameter {name}"), set, |_, plane| plane.params[33].value == ParamValue::I8(7));
        let items = mission(50);
        let download = |_| {
            let mut plane = MockPlane::new();
            plane.store(PlanKind::Mission, &items);
            (PlanDownload::new(&config, PlanKind::Mission, MonoTime::ZERO), plane)
        };
        darkened(&format!("download {name}"), download, |read, _| has(&read.items, &items));
    }
    let get = |_| {
        let get = FtpGet::new(&by_ftp(ms(0), 3), FILE, 1 << 20, MonoTime::ZERO).expect("a path");
        (get, with_file(100_000))
    };
    darkened("a file", get, |read, _| *read == content(100_000));
}

// fault 20 (1 seed): 1 MiB at 20 % lost each way: equal; more than was allowed is refused
/// A megabyte over a link that loses one frame in five each way.
#[test]
fn a_file_of_a_megabyte_arrives_whole() {
    for seed in 0..seeds(1) {
        let get = FtpGet::new(&by_ftp(ms(0), seed as u32), FILE, 1 << 21, MonoTime::ZERO).expect("a path");
        let mut world = World::new(Running::new(get), with_file(1 << 20), Faults::loss(0.2), seed);
        let (read, took) = run(&mut world, LIMIT);
        println!("1 MiB, a fifth lost: {took:?}");
        assert!(read.expect("read") == content(1 << 20), "seed {seed}");
    }
    // More than was allowed is refused, whatever its size is said to be.
    let get = FtpGet::new(&by_ftp(ms(0), 1), FILE, 1000, MonoTime::ZERO).expect("a path");
    let mut world = World::new(Running::new(get), with_file(5000), Faults::default(), 1);
    assert!(matches!(run(&mut world, LIMIT).0, Err(TransferError::TooMany { limit: 1000, .. })));
}

// fault 9 (20 seeds each): round trips of 0.5 ± 0.1 s and 1 s, both routes: success, ≤ 1.2 times the frames
/// What is on its way for long is not sent again and again.
#[test]
fn a_slow_link_is_waited_for_and_not_flooded() {
    // What was said twice was said in vain; a request of MAVFTP has another number then.
    let said = |message: &Message| match FtpPayload::from_message(message) {
        Some((_, it)) => format!("{:?} {} {} {:?}", it.opcode, it.session, it.offset, it.data),
        None => format!("{message:?}"),
    };
    let items = mission(50);
    type Config = fn(Duration, u32) -> TransferConfig;
    let routes: [(&str, Config); 2] = [("by file", by_ftp), ("by items", |round_trip, _| by_items(round_trip))];
    for (name, config) in routes {
        for (delay, jitter) in [(ms(500), ms(200)), (ms(1000), ms(0))] {
            let mut most = 0.0_f64;
            for seed in 0..seeds(20) {
                let faults = Faults { delay: delay / 2, jitter: jitter / 2, ..Faults::default() };
                // The round trip as it is known by then from TIMESYNC.
                let mut world = uploading(&config(delay + jitter / 2, seed as u32), &items, faults, seed);
                world.log = Some(Vec::new());
                let (result, _) = run(&mut world, LIMIT);
                assert!(result.is_ok() && has(&world.plane.plans[0], &items), "{name}, {delay:?}: {result:?}");
                let log = world.log.expect("logged");
                let needed: BTreeSet<_> = log.iter().map(|(_, message)| said(message)).collect();
                // What its queue had no room for has to be said again.
                most = most.max(log.len() as f64 / (needed.len() + world.plane.overflows) as f64);
            }
            println!("{name}, {delay:?}: {most:.2} times the frames at most");
            assert!(most <= 1.2, "{name}, {delay:?}: {most}");
        }
    }
}

#[test]
fn a_link_cut_at_any_frame_is_never_a_success() {
    let items = mission(20);
    for by_file in [true, false] {
        let config = |seed| if by_file { by_ftp(ms(0), seed) } else { by_items(ms(0)) };
        let mut whole = uploading(&config(0), &items, Faults::default(), 0);
        assert!(run(&mut whole, LIMIT).0.is_ok());
        let frames = whole.station_frames;
        let mut failed = 0;
        for cut in 0..frames {
            let faults = Faults { cut_after: Some(cut), ..Faults::default() };
            let mut world = uploading(&config(cut as u32), &items, faults, cut as u64);
            let (result, took) = check(&mut world, &items);
            assert!(took <= GONE + ms(1500), "cut after {cut} of {frames}: told after {took:?}");
            match result {
                Ok(_) => assert!(cut + 2 >= frames, "a good-bye only"),
                Err(TransferError::Timeout { .. } | TransferError::Unverified { .. }) => failed += 1,
                Err(error) => panic!("cut after {cut}: {error}"),
            }
        }
        assert!(failed + 2 >= frames, "{failed} of {frames}");
    }
}

#[test]
fn a_file_left_half_never_becomes_the_plan() {
    // Whatever got through, the session is closed by the next that comes: the old plan must stand, or the whole new
    // one.
    let items = mission(40);
    for cut in 0..12 {
        let faults = Faults { cut_after: Some(cut), loss: 0.2, ..Faults::default() };
        let mut world = uploading(&by_ftp(ms(0), cut as u32), &items, faults, cut as u64);
        let before = world.plane.plans[0].clone();
        assert!(run(&mut world, LIMIT).0.is_err());
        let download = PlanDownload::new(&by_ftp(ms(0), 99), PlanKind::Mission, MonoTime::ZERO);
        let mut next = World::new(Running::new(download), world.plane, Faults::default(), 1);
        next.now = world.now;
        run(&mut next, LIMIT).0.expect("read");
        assert!(next.plane.plans[0] == before || has(&next.plane.plans[0], &items), "cut after {cut}");
    }
}

#[test]
fn a_cancelled_upload_leaves_the_old_plan_or_nothing_mixed_by_file() {
    let items = mission(40);
    for step in 0..20 {
        let mut world = uploading(&by_ftp(ms(0), step), &items, Faults::default(), 3);
        let before = world.plane.plans[0].clone();
        world.run(MonoTime::from_millis(u64::from(step) * 5), |_, _| false);
        let sending = world.plane.changes == 0;
        let now = world.now;
        world.station.cancel(now);
        assert!(matches!(world.station.result, Some(Err(TransferError::Cancelled)) | Some(Ok(_))));
        world.run(now + Duration::from_secs(60), |_, _| false);
        let after = &world.plane.plans[0];
        assert!(*after == before || has(after, &items), "cancelled at {now}: mixed");
        assert!(sending || has(after, &items));
    }
}

#[test]
fn cancelling_item_by_item_tells_the_vehicle() {
    let items = mission(40);
    let mut world = uploading(&by_items(ms(0)), &items, Faults::default(), 3);
    world.log = Some(Vec::new());
    world.run(MonoTime::from_millis(300), |_, _| false);
    let now = world.now;
    world.station.cancel(now);
    world.run(now + ms(100), |_, _| false);
    assert!(matches!(world.station.result, Some(Err(TransferError::Cancelled))));
    let log = world.log.expect("logged");
    let (_, last) = log.last().expect("something was sent");
    assert!(matches!(last, Message::MissionAck(MissionAck { result: 15, mission_type: 0, .. })), "{last:?}");
}

#[test]
fn a_reboot_on_the_way_is_survived_or_told() {
    let items = mission(60);
    for by_file in [true, false] {
        let mut good = 0;
        for step in 0..40u32 {
            let config = if by_file { by_ftp(ms(0), step) } else { by_items(ms(0)) };
            let mut world = uploading(&config, &items, Faults::default(), 5);
            let at = MonoTime::from_millis(u64::from(step) * if by_file { 4 } else { 60 });
            if !world.run(at, |station, _| station.result.is_some()) {
                world.plane.reboot();
            } else {
                continue;
            }
            good += usize::from(check(&mut world, &items).0.is_ok());
        }
        println!("reboots, by file {by_file}: {good} good");
        assert!(good >= 15, "{good}");
    }
}

/// Frames of another station's transfers, and nonsense, that must not change ours.
fn meddle<S: Endpoint, P: Endpoint>(world: &mut World<S, P>, until: Duration) {
    let count = |count, target: Address, mission_type| {
        Message::Dialect(MavMessage::MISSION_COUNT(MISSION_COUNT_DATA {
            count,
            target_system: target.system.0,
            target_component: target.component.0,
            mission_type,
            ..Default::default()
        }))
    };
    let request = |seq, target: Address, mission_type| {
        Message::Dialect(MavMessage::MISSION_REQUEST_INT(MISSION_REQUEST_INT_DATA {
            seq,
            target_system: target.system.0,
            target_component: target.component.0,
            mission_type,
        }))
    };
    let ack =
        |result, target, mission_type| Message::MissionAck(MissionAck { target, result, mission_type, opaque_id: 0 });
    let stray = |seq, target, mission_type| {
        Message::MissionItemInt(MissionItemInt { target, seq, mission_type, z: -999.0, ..mission(1)[0] })
    };
    let mission_kind = MavMissionType::MAV_MISSION_TYPE_MISSION;
    let fence_kind = MavMissionType::MAV_MISSION_TYPE_FENCE;
    let mut at = MonoTime::ZERO;
    let mut seq = 0;
    while at.as_duration() < until {
        seq = (seq + 7) % 40;
        // From the plane, to the rival.
        world.inject(at, true, PLANE, &request(seq, RIVAL, mission_kind));
        world.inject(at, true, PLANE, &ack(0, RIVAL, 0));
        world.inject(at, true, PLANE, &ack(3, RIVAL, 0));
        world.inject(at, true, PLANE, &count(3, RIVAL, mission_kind));
        world.inject(at, true, PLANE, &stray(seq, RIVAL, 0));
        // From the plane, to us, of another kind of plan.
        world.inject(at, true, PLANE, &ack(1, STATION, 1));
        world.inject(at, true, PLANE, &request(seq, STATION, fence_kind));
        world.inject(at, true, PLANE, &count(2, STATION, fence_kind));
        world.inject(at, true, PLANE, &stray(seq, STATION, 2));
        // From somebody else, to us.
        world.inject(at, true, RIVAL, &ack(0, STATION, 0));
        world.inject(at, true, Address::new(1, 42), &ack(4, STATION, 0));
        world.inject(at, true, Address::new(7, 1), &request(seq, STATION, mission_kind));
        world.inject(at, true, RIVAL, &stray(seq, STATION, 0));
        let write = FtpPayload::request(FtpOpcode::NAK, 3, seq, 0, &[10]);
        world.inject(at, true, RIVAL, &write.to_message(STATION));
        world.inject(at, true, PLANE, &write.to_message(RIVAL));
        at += ms(9);
    }
}

// fault 32 (20 seeds each): answers to others in between: exact
#[test]
fn what_concerns_others_changes_nothing() {
    let items = mission(30);
    for config in [by_ftp(ms(0), 11), by_items(ms(0))] {
        for seed in 0..20 {
            let mut world = uploading(&config, &items, Faults::loss(0.05), seed);
            meddle(&mut world, ms(3000));
            let (result, _) = check(&mut world, &items);
            assert!(result.is_ok(), "{result:?}");

            let mut plane = MockPlane::new();
            plane.store(PlanKind::Mission, &items);
            let download = PlanDownload::new(&config, PlanKind::Mission, MonoTime::ZERO);
            let mut world = World::new(Running::new(download), plane, Faults::loss(0.05), seed);
            meddle(&mut world, ms(3000));
            assert!(has(&run(&mut world, LIMIT).0.expect("read").items, &items));
        }
    }
}

#[test]
fn a_rival_that_uploads_is_waited_for_or_named() {
    let items = mission(10);
    let begin = Message::Dialect(MavMessage::MISSION_COUNT(MISSION_COUNT_DATA {
        count: 5,
        target_system: 1,
        target_component: 1,
        mission_type: MavMissionType::MAV_MISSION_TYPE_MISSION,
        ..Default::default()
    }));
    // The rival begins and falls silent: the vehicle gives up on it after 8 s, then it is our turn.
    let mut world = uploading(&by_items(ms(0)), &items, Faults { delay: ms(30), ..Faults::default() }, 1);
    world.inject(MonoTime::ZERO, false, RIVAL, &begin);
    let (result, took) = check(&mut world, &items);
    assert!(result.is_ok() && took >= Duration::from_secs(8), "{result:?} {took:?}");
    // The rival begins again and again.
    let mut world = uploading(&by_items(ms(0)), &items, Faults { delay: ms(30), ..Faults::default() }, 1);
    for second in 0..30 {
        world.inject(MonoTime::from_millis(second * 1000), false, RIVAL, &begin);
    }
    let (result, took) = run(&mut world, LIMIT);
    assert!(matches!(result, Err(TransferError::Refused { item: None, .. })), "{result:?}");
    assert!(took <= GONE, "{took:?}");
}

#[test]
fn a_rival_that_holds_the_file_session_is_waited_for_or_gone_round() {
    /// A seed whose plane has one MAVFTP session for all; where there are several, a rival does not matter.
    const ONE_SESSION: u64 = 2;
    let items = mission(10);
    let open = FtpPayload::request(FtpOpcode::OPEN_FILE_RO, 0, 1, 0, b"@PARAM/param.pck");
    let read = |sequence| FtpPayload::read_request(FtpOpcode::READ_FILE, 0, sequence, 0, 80).to_message(PLANE);
    // It opens a file and falls silent: ArduPilot lets others in after 3 s.
    let mut world = uploading(&by_ftp(ms(0), 40), &items, Faults { delay: ms(30), ..Faults::default() }, ONE_SESSION);
    world.inject(MonoTime::ZERO, false, RIVAL, &open.to_message(PLANE));
    let (result, took) = check(&mut world, &items);
    let route = result.expect("sent").route;
    println!("after a silent rival: {route:?} in {took:?}");
    // It keeps reading: the items go by the other protocol.
    let mut world = uploading(&by_ftp(ms(0), 40), &items, Faults { delay: ms(30), ..Faults::default() }, ONE_SESSION);
    world.inject(MonoTime::ZERO, false, RIVAL, &open.to_message(PLANE));
    for step in 0..200 {
        world.inject(MonoTime::from_millis(step * 100), false, RIVAL, &read(2 + step as u16));
    }
    let (result, took) = check(&mut world, &items);
    assert_eq!(result.expect("sent").route, crate::transfer::PlanRoute::Items);
    assert!(took <= GONE, "{took:?}");
}

#[test]
fn a_vehicle_whose_files_are_switched_off_is_served_item_by_item() {
    let items = mission(10);
    let mut world = uploading(&by_ftp(ms(0), 1), &items, Faults::default(), 1);
    world.plane.has_ftp = false;
    let (result, took) = check(&mut world, &items);
    assert_eq!(result.expect("sent").route, crate::transfer::PlanRoute::Items);
    assert!(took <= Duration::from_secs(5), "{took:?}");
}

#[test]
fn an_item_that_the_vehicle_refuses_is_named_whatever_the_route() {
    let mut items = mission(20);
    items[13].command = 4;
    for config in [by_ftp(ms(0), 1), by_items(ms(0))] {
        let mut world = uploading(&config, &items, Faults::default(), 1);
        let (result, _) = run(&mut world, LIMIT);
        let Err(TransferError::Refused { result, item, .. }) = result else { panic!("{result:?}") };
        assert_eq!((result.0, item), (3, Some(13)));
    }
}

#[test]
fn a_plan_that_may_not_be_sent_is_refused_before_anything_is() {
    type Change<'a> = &'a dyn Fn(&mut Vec<MissionItemInt>);
    let with = |change: Change<'_>| {
        let mut items = mission(5);
        change(&mut items);
        PlanUpload::new(&by_items(ms(0)), PlanKind::Mission, items, MonoTime::ZERO)
    };
    let bad: [Change<'_>; 5] = [
        &|items| items[2].z = f32::INFINITY,
        &|items| items[2].x = 910_000_000,
        &|items| items[2].params[0] = f32::NEG_INFINITY,
        &|items| items[2].seq = 3,
        &|items| items[2].mission_type = 1,
    ];
    for change in bad {
        let mut upload = with(change);
        assert!(matches!(upload.result(), Some(Err(TransferError::Item(_) | TransferError::BadList { .. }))));
        assert_eq!((upload.poll_output(), upload.deadline()), (None, None));
    }
}

/// A vehicle that says the same thing all the time.
struct Parrot {
    says: Vec<Message>,
    next: usize,
    at: MonoTime,
    every: Duration,
}

impl Endpoint for Parrot {
    fn receive(&mut self, _: Address, _: &Message, _: MonoTime) {}

    fn tick(&mut self, now: MonoTime) {
        self.at = now + self.every;
        self.next = 0;
    }

    fn wakes_at(&self) -> Option<MonoTime> {
        Some(self.at)
    }

    fn next_output(&mut self) -> Option<Message> {
        self.next += 1;
        self.says.get(self.next - 1).cloned()
    }
}

/// Runs a transfer against a parrot: it must end, in bounded time and memory.
fn against<T: Transfer>(transfer: T, says: Vec<Message>) -> Result<T::Value, TransferError> {
    let parrot = Parrot { says, next: 0, at: MonoTime::ZERO, every: ms(50) };
    let mut world = World::new(Running::new(transfer), parrot, Faults::default(), 1);
    run(&mut world, Duration::from_secs(200)).0
}

// fault 16: 21 scripts by 3 routes and 4 transfers: an error each
#[test]
fn absurd_vehicles_end_every_transfer_with_an_error() {
    let count = |count| {
        Message::Dialect(MavMessage::MISSION_COUNT(MISSION_COUNT_DATA {
            count,
            target_system: 255,
            target_component: 190,
            mission_type: MavMissionType::MAV_MISSION_TYPE_MISSION,
            ..Default::default()
        }))
    };
    let ack = |result| Message::MissionAck(MissionAck { target: STATION, result, mission_type: 0, opaque_id: 0 });
    let request = |seq| {
        Message::Dialect(MavMessage::MISSION_REQUEST_INT(MISSION_REQUEST_INT_DATA {
            seq,
            target_system: 255,
            target_component: 190,
            mission_type: MavMissionType::MAV_MISSION_TYPE_MISSION,
        }))
    };
    let item = |seq| Message::MissionItemInt(MissionItemInt { target: STATION, seq, ..mission(1)[0] });
    let nan = Message::MissionItemInt(MissionItemInt {
        target: STATION,
        params: [f32::NAN; 4],
        z: f32::NAN,
        ..mission(1)[0]
    });
    let ftp = |opcode, request, data: &[u8]| {
        let mut answer = FtpPayload::request(opcode, 2, 2040, 0, data);
        answer.req_opcode = request;
        answer.to_message(STATION)
    };
    let absurd: Vec<Vec<Message>> = vec![
        vec![],
        vec![count(65_535)],
        vec![count(10), count(11)],
        vec![count(3), item(0), item(0), item(9)],
        vec![count(10_000)],
        vec![ack(0)],
        vec![ack(13)],
        vec![ack(14)],
        vec![ack(15)],
        vec![ack(1)],
        vec![ack(255)],
        vec![request(0)],
        vec![request(65_535)],
        vec![request(1), request(0)],
        vec![request(0), ack(13)],
        vec![request(0), ack(0)],
        vec![count(1), nan],
        vec![
            ftp(FtpOpcode::ACK, FtpOpcode::OPEN_FILE_RO, &[]),
            ftp(FtpOpcode::ACK, FtpOpcode::BURST_READ_FILE, &[1; 239]),
        ],
        vec![ftp(FtpOpcode::ACK, FtpOpcode::CREATE_FILE, &[]), ftp(FtpOpcode::NAK, FtpOpcode::WRITE_FILE, &[1])],
        vec![ftp(FtpOpcode::NAK, FtpOpcode::CREATE_FILE, &[4]), ftp(FtpOpcode::NAK, FtpOpcode::OPEN_FILE_RO, &[4])],
        vec![ftp(FtpOpcode::NAK, FtpOpcode::CREATE_FILE, &[]), ftp(FtpOpcode::NAK, FtpOpcode::OPEN_FILE_RO, &[])],
    ];
    let is_unset = |message: &Message| matches!(message, Message::MissionItemInt(item) if item.z.is_nan());
    let mut ended = 0;
    for says in absurd {
        for config in [by_ftp(ms(0), 1), by_items(ms(0)), TransferConfig { item_window: 64, ..by_items(ms(0)) }] {
            for items in [mission(4), mission(2)] {
                let upload = PlanUpload::new(&config, PlanKind::Mission, items, MonoTime::ZERO);
                assert!(against(upload, says.clone()).is_err(), "{says:?}");
            }
            let download = against(PlanDownload::new(&config, PlanKind::Mission, MonoTime::ZERO), says.clone());
            // The one that holds together: a plan of one item, though its numbers are unset.
            assert!(download.is_err() || says.last().is_some_and(is_unset), "{says:?} {download:?}");
            let clear = against(PlanClear::new(&config, PlanKind::Mission, MonoTime::ZERO), says.clone());
            assert!(clear.is_err(), "{says:?}");
            assert!(against(ParamList::new(&config, MonoTime::ZERO), says.clone()).is_err(), "{says:?}");
            ended += 1;
        }
    }
    assert_eq!(ended, 63);
}

fn name_of(text: &str) -> ParamName {
    ParamName::new(text).expect("a name")
}

fn params() -> Vec<Param> {
    let value = |index: u32| match index % 3 {
        0 => ParamValue::I8(index as i8),
        1 => ParamValue::F32(index as f32 / 7.0),
        _ => ParamValue::I32(index as i32 * 1000),
    };
    (0..400).map(|index| Param::new(name_of(&format!("P{}_{index}", index / 10)), value(index))).collect()
}

// fault 19 (40 seeds each): 400 parameters at up to 30 % lost: complete within 60 s
// fault 5 (40 seeds each): parameter lists by both routes likewise: exact
#[test]
fn parameter_lists_are_complete_on_any_bad_link() {
    for loss in [0.0, 0.05, 0.2, 0.3] {
        for seed in 0..seeds(40) {
            for config in [by_ftp(ms(0), seed as u32), by_items(ms(0))] {
                let mut plane = MockPlane::new();
                plane.params = params();
                let list = ParamList::new(&config, MonoTime::ZERO);
                let mut world = World::new(Running::new(list), plane, bad_link(loss), seed);
                let (result, took) = run(&mut world, LIMIT);
                assert_eq!(result.expect("read"), params());
                assert!(took <= Duration::from_secs(60), "{took:?}");
            }
        }
    }
}

#[test]
fn parameters_are_set_and_seen_to_be_on_any_bad_link() {
    for loss in [0.0, 0.1, 0.3] {
        for seed in 0..seeds(SEEDS) {
            let mut plane = MockPlane::new();
            plane.params = params();
            plane.read_only = vec![name_of("P5_51")];
            let set = |param: &str, value| ParamSet::new(&by_items(ms(0)), name_of(param), value, MonoTime::ZERO);

            let mut world = World::new(Running::new(set("P3_33", 7.0)), plane, bad_link(loss), seed);
            let (result, took) = run(&mut world, LIMIT);
            match result {
                Ok(param) => {
                    assert_eq!(param.value, ParamValue::I8(7));
                    assert_eq!(world.plane.params[33].value, ParamValue::I8(7), "false success");
                }
                Err(error) => assert!(loss > 0.2, "{loss} {seed}: {error}"),
            }
            assert!(took <= GONE);

            let mut world = World::new(Running::new(set("P5_51", 3.0)), world.plane, bad_link(loss), seed);
            let result = run(&mut world, LIMIT).0;
            assert!(result.is_err(), "{result:?}");
            assert!(loss > 0.0 || matches!(result, Err(TransferError::ParamNotKept { .. })), "{result:?}");

            let read = ParamRead::new(&by_items(ms(0)), name_of("NOT_A_PARAM"), MonoTime::ZERO);
            let mut world = World::new(Running::new(read), world.plane, bad_link(loss), seed);
            let result = run(&mut world, LIMIT).0;
            assert!(matches!(result, Err(TransferError::UnknownParam { .. })), "{result:?}");
        }
    }
}

#[test]
fn values_that_cannot_be_are_not_sent() {
    for (param, value) in [("P3_33", 128.0), ("P3_33", 1.5), ("P3_32", 3e9), ("P3_31", f64::NAN), ("P3_31", 1e39)] {
        let mut plane = MockPlane::new();
        plane.params = params();
        let set = ParamSet::new(&by_items(ms(0)), name_of(param), value, MonoTime::ZERO);
        let mut world = World::new(Running::new(set), plane, Faults::default(), 1);
        let result = run(&mut world, LIMIT).0;
        assert!(matches!(result, Err(TransferError::Param(_))), "{param} {value}: {result:?}");
        assert_eq!(world.plane.sets, 0);
    }
}

// fault 19: a million names, counts and types that change, values that are none: bounded, or an error
#[test]
fn hostile_parameter_streams_stay_bounded() {
    let value = |index: u32, count: u32, number: f32| {
        let id = format!("X{index}");
        Message::Dialect(MavMessage::PARAM_VALUE(PARAM_VALUE_DATA {
            param_value: number,
            param_count: count as u16,
            param_index: index as u16,
            param_id: id.as_str().into(),
            param_type: MavParamType::MAV_PARAM_TYPE_REAL32,
        }))
    };
    let config = by_items(ms(0));
    let feed = |messages: &mut dyn Iterator<Item = Message>| {
        let mut list = ParamList::new(&config, MonoTime::ZERO);
        let mut now = MonoTime::ZERO;
        for message in messages {
            now += Duration::from_micros(100);
            list.on_message(PLANE, &message, now);
            let mut puts = 0;
            while list.poll_output().is_some() {
                puts += 1;
            }
            assert!(puts <= 20, "{puts} at once");
            if let Some(result) = list.result() {
                return Some(result);
            }
        }
        None
    };
    // A million ids that nobody asked for.
    assert!(feed(&mut (0..1_000_000).map(|id| value(id, 65_535, 1.0))).is_some_and(|result| result.is_err()));
    assert!(feed(&mut (0..1_000_000).map(|_| value(65_535, 100, 1.0))).is_none());
    // A count that never stands still.
    let changing = feed(&mut (0..1000).map(|n| value(n % 10, 50 + n % 2, 1.0)));
    assert!(matches!(changing, Some(Err(TransferError::NoProgress { .. }))), "{changing:?}");
    // A type that turns over with each of its values: the list is whole, each value read as its type says.
    let flipping = feed(&mut (0..20).map(|n| {
        let mut message = value(n % 10, 10, 7.0);
        if let Message::Dialect(MavMessage::PARAM_VALUE(data)) = &mut message
            && n % 2 == 0
        {
            data.param_type = MavParamType::MAV_PARAM_TYPE_INT8;
        }
        message
    }));
    let flipping = flipping.expect("ended").expect("read");
    assert!(flipping.len() == 10 && flipping.iter().all(|param| param.value.as_f64() == 7.0), "{flipping:?}");
    // Values that are no numbers are left out, not fatal.
    let numbers = feed(&mut (0..10).map(|n| value(n, 10, if n == 3 { f32::NAN } else { 1.0 })));
    assert_eq!(numbers.expect("ended").expect("read").len(), 9);
}
