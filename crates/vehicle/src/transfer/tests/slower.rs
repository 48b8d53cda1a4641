//! Slow links: those whose delay doubles while a transfer runs, where no answer comes within the wait that was measured,
//! and those that lose, where few tries fit into the time in which a transfer is given up.

use std::time::Duration;

use vencejo_flight::plan::PlanKind;
use vencejo_proto::MonoTime;
use vencejo_proto::param::{Param, ParamName, ParamValue};

use super::{LIMIT, by_ftp, by_items, has, mission, ms};
use crate::transfer::testing::{Faults, MockPlane, PLANE, Running, STATION, World, run, seeds};
use crate::transfer::{
    ParamList, ParamRead, ParamSet, PlanDownload, PlanRoute, PlanUpload, Transfer, TransferConfig, VerifiedPlan,
};

/// Places in each transfer at which the delay doubles.
const PLACES: usize = 8;

/// Runs transfers over links whose round trip of 0.4 to 2 s doubles in the course. All succeed, hardly later than on
/// the slower link from the start, and send at most everything twice.
fn check<T: Transfer>(
    what: &str,
    mut begin: impl FnMut(Duration, u32) -> (T, MockPlane),
    is_right: impl Fn(&T::Value, &MockPlane) -> bool,
) {
    for round_trip in [400, 800, 1200, 1600, 2000].map(ms) {
        let mut go = |known, faults, seed| {
            let (transfer, plane) = begin(known, seed);
            let mut world = World::new(Running::new(transfer), plane, faults, u64::from(seed));
            let (result, took) = run(&mut world, LIMIT);
            let value = result.unwrap_or_else(|error| panic!("{what}, {round_trip:?}, seed {seed}: {error}"));
            assert!(is_right(&value, &world.plane), "{what}, {round_trip:?}, seed {seed}");
            (took, world.station_frames - world.plane.overflows)
        };
        let near = Faults { jitter: ms(10), ..Faults::round_trip(round_trip) };
        let (_, frames) = go(round_trip, near.clone(), 0);
        let (slow, _) = go(2 * round_trip, Faults { delay: round_trip, ..near.clone() }, 0);
        let (mut longest, mut most) = (slow, frames);
        for place in 0..PLACES {
            let faults = Faults { slower_after: Some((frames * place / PLACES, round_trip)), ..near.clone() };
            let (took, sent) = go(round_trip, faults, place as u32);
            (longest, most) = (longest.max(took), most.max(sent));
        }
        assert!(longest <= slow.mul_f64(1.1), "{what}, {round_trip:?}: {longest:?}, on the slower link {slow:?}");
        assert!(most <= 2 * frames + 2, "{what}, {round_trip:?}: {most} frames, else {frames}");
        println!("{what}, {round_trip:?}: {longest:?} (slow: {slow:?}), {most} frames (usual: {frames})");
    }
}

fn holding(plan: u16) -> MockPlane {
    let mut plane = MockPlane::new();
    plane.store(PlanKind::Mission, &mission(plan));
    plane
}

fn with_params() -> MockPlane {
    let mut plane = MockPlane::new();
    let param = |index: u16| Param::new(name(index), ParamValue::F32(f32::from(index)));
    plane.params = (0..500).map(param).collect();
    plane
}

fn name(index: u16) -> ParamName {
    ParamName::new(&format!("PARAM_{index}")).expect("a name")
}

#[test]
fn plans_go_on_where_the_delay_doubles() {
    let items = mission(100);
    let upload =
        |config| (PlanUpload::new(&config, PlanKind::Mission, items.clone(), MonoTime::ZERO), MockPlane::new());
    check(
        "upload by file",
        |known, seed| upload(by_ftp(known, seed)),
        |plan: &VerifiedPlan, plane| plan.route == PlanRoute::Ftp && has(&plane.plans[0], &items),
    );
    let few = mission(20);
    check(
        "upload by items",
        |known, _| {
            (PlanUpload::new(&by_items(known), PlanKind::Mission, few.clone(), MonoTime::ZERO), MockPlane::new())
        },
        |_, plane| has(&plane.plans[0], &few),
    );
    let download = |config| (PlanDownload::new(&config, PlanKind::Mission, MonoTime::ZERO), holding(100));
    check(
        "download by file",
        |known, seed| download(by_ftp(known, seed)),
        |plan, _| plan.route == PlanRoute::Ftp && has(&plan.items, &items),
    );
    check("download by items", |known, _| download(by_items(known)), |plan, _| has(&plan.items, &items));
    // One at a time, as a PX4 is asked.
    check(
        "download from another",
        |known, _| {
            let config = TransferConfig { round_trip: Some(known), ..TransferConfig::new(PLANE, STATION) };
            (PlanDownload::new(&config, PlanKind::Mission, MonoTime::ZERO), holding(20))
        },
        |plan, _| has(&plan.items, &few),
    );
}

#[test]
fn parameters_go_on_where_the_delay_doubles() {
    let is_whole = |read: &Vec<Param>, plane: &MockPlane| *read == plane.params;
    let list = |config| (ParamList::new(&config, MonoTime::ZERO), with_params());
    check("parameters by file", |known, seed| list(by_ftp(known, seed)), is_whole);
    check("parameters one by one", |known, _| list(by_items(known)), is_whole);
    let read = |known, _| (ParamRead::new(&by_items(known), name(7), MonoTime::ZERO), with_params());
    check("a parameter", read, |param, _| param.value == ParamValue::F32(7.0));
    let set = |known, _| (ParamSet::new(&by_items(known), name(7), 1.5, MonoTime::ZERO), with_params());
    check("a parameter set", set, |_, plane| plane.params[7].value == ParamValue::F32(1.5));
}

/// Runs a transfer over links that lose 20 % each way, and returns where fewer than 95 % succeed. What succeeds is right.
fn check_losing<T: Transfer>(
    what: &str,
    begin: impl Fn(Duration, u32) -> (T, MockPlane),
    is_right: impl Fn(&T::Value, &MockPlane) -> bool,
) -> Vec<String> {
    let mut poor = Vec::new();
    for round_trip in [50, 800, 1_600].map(ms) {
        let seeds = seeds(100);
        let mut took: Vec<_> = (0..seeds as u32)
            .filter_map(|seed| {
                let (transfer, plane) = begin(round_trip, seed);
                let faults = Faults { loss: 0.2, jitter: round_trip / 20, ..Faults::round_trip(round_trip) };
                let mut world = World::new(Running::new(transfer), plane, faults, u64::from(seed));
                let (result, took) = run(&mut world, LIMIT);
                match result {
                    Ok(value) => assert!(is_right(&value, &world.plane), "{what}, {round_trip:?}, seed {seed}"),
                    Err(error) => {
                        println!("{what}, {round_trip:?}, seed {seed}: {error}, {took:?}");
                        return None;
                    }
                }
                Some(took)
            })
            .collect();
        took.sort();
        let share = took.len() as f64 / seeds as f64;
        println!("{what}, {round_trip:?}: {share}, {:?}, at most {:?}", took[took.len() / 2], took[took.len() - 1]);
        if share < 0.95 {
            poor.push(format!("{what}, {round_trip:?}: {share}"));
        }
    }
    poor
}

#[test]
fn slow_links_that_lose_are_served() {
    let items = mission(30);
    let upload =
        |config| (PlanUpload::new(&config, PlanKind::Mission, items.clone(), MonoTime::ZERO), MockPlane::new());
    let download = |config| (PlanDownload::new(&config, PlanKind::Mission, MonoTime::ZERO), holding(30));
    let read = |known, _| (ParamRead::new(&by_items(known), name(7), MonoTime::ZERO), with_params());
    let set = |known, _| (ParamSet::new(&by_items(known), name(7), 1.5, MonoTime::ZERO), with_params());
    let list = |config| (ParamList::new(&config, MonoTime::ZERO), with_params());
    let is_whole = |read: &Vec<Param>, plane: &MockPlane| *read == plane.params;
    let poor = [
        check_losing("a parameter", read, |param, _| param.value == ParamValue::F32(7.0)),
        check_losing("a parameter set", set, |_, plane| plane.params[7].value == ParamValue::F32(1.5)),
        check_losing("parameters by file", |known, seed| list(by_ftp(known, seed)), is_whole),
        check_losing("parameters one by one", |known, _| list(by_items(known)), is_whole),
        check_losing(
            "download by file",
            |known, seed| download(by_ftp(known, seed)),
            |plan, _| has(&plan.items, &items),
        ),
        check_losing("download by items", |known, _| download(by_items(known)), |plan, _| has(&plan.items, &items)),
        check_losing(
            "upload by file",
            |known, seed| upload(by_ftp(known, seed)),
            |_, plane| has(&plane.plans[0], &items),
        ),
        check_losing("upload by items", |known, _| upload(by_items(known)), |_, plane| has(&plane.plans[0], &items)),
    ];
    assert!(poor.concat().is_empty(), "{poor:#?}");
}
