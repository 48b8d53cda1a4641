//! Plans in 32-bit floats: to and from ArduPlane 3.x, known to be old or found out to be.

use std::time::Duration;

use vencejo_flight::plan::{MissionItem, PlanKind};
use vencejo_proto::{MavVersion, MissionItemInt, MissionSeq, MonoTime};

use super::{LIMIT, by_items, has, mission};
use crate::transfer::testing::{Faults, MockPlane, OldPlane, PLANE, Running, STATION, World, run};
use crate::transfer::{
    ItemForm, NoPlanKinds, PlanClear, PlanDownload, PlanRoute, PlanUpload, Transfer, TransferConfig, TransferError,
};

fn old() -> TransferConfig {
    TransferConfig::old_ardupilot(PLANE, STATION)
}

/// The same vehicle, of which nothing is known yet but that it is an ArduPilot.
fn unknown() -> TransferConfig {
    TransferConfig { item_form: ItemForm::Unknown, ..old() }
}

/// Waypoints all over the globe.
fn waypoints(count: u16) -> Vec<MissionItemInt> {
    let item = |seq: u16| {
        let (lat, lon) = (f64::from(seq) * 1.337_133_7 - 60.0, 179.0 - f64::from(seq) * 3.571_428_5);
        MissionItem::waypoint(lat, lon, f64::from(seq) + 0.25)
    };
    (0..count).map(|seq| item(seq).to_wire(MissionSeq(seq), PLANE, PlanKind::Mission, false)).collect()
}

fn world<T: Transfer>(transfer: T, plane: OldPlane, faults: Faults, seed: u64) -> World<Running<T>, OldPlane> {
    let mut world = World::new(Running::new(transfer), plane, faults, seed);
    world.version = MavVersion::V1;
    world
}

#[test]
fn an_old_vehicle_has_what_was_sent_but_for_rounding() {
    let items = waypoints(90);
    let upload = PlanUpload::new(&old(), PlanKind::Mission, items.clone(), MonoTime::ZERO);
    let mut world = world(upload, OldPlane::new(), Faults::default(), 1);
    let (result, took) = run(&mut world, LIMIT);
    let plan = result.expect("uploaded");
    assert_eq!((plan.route, plan.items.len(), world.plane.mission.len()), (PlanRoute::FloatItems, 90, 90));
    let error_m = plan.position_error_m.expect("rounded");
    assert!((0.5..3.6).contains(&error_m), "{error_m}");
    println!("90 items to ArduPlane 3.x in {took:?}, at most {error_m:.2} m off");
    assert!(took < Duration::from_secs(10), "{took:?}");
}

#[test]
fn more_than_rounding_is_another_plan() {
    let items = waypoints(9);
    let upload = PlanUpload::new(&old(), PlanKind::Mission, items.clone(), MonoTime::ZERO);
    let mut world = world(upload, OldPlane::new(), Faults::default(), 1);
    // It has all, and then one of them is not what it was: item 5, at 53° south, by 4.4 m.
    assert!(world.run(MonoTime::from_millis(60_000), |_, plane| plane.mission.len() == 9));
    world.plane.mission[5].lat_e7 += 400;
    let (result, _) = run(&mut world, LIMIT);
    let Err(TransferError::NotAsSent { differences, .. }) = result else { panic!("{result:?}") };
    assert_eq!(differences.iter().map(|difference| difference.seq).collect::<Vec<_>>(), [5]);
}

#[test]
fn a_vehicle_that_does_not_understand_integers_is_found_out() {
    let items = waypoints(8);
    let upload = PlanUpload::new(&unknown(), PlanKind::Mission, items.clone(), MonoTime::ZERO);
    let mut sending = world(upload, OldPlane::new(), Faults::default(), 1);
    let (result, took) = run(&mut sending, LIMIT);
    let plan = result.expect("uploaded");
    assert_eq!((plan.route, sending.plane.mission.len()), (PlanRoute::FloatItems, 8));
    assert!(took < Duration::from_secs(4), "{took:?}");

    let download = PlanDownload::new(&unknown(), PlanKind::Mission, MonoTime::ZERO);
    let mut reading = world(download, sending.plane, Faults::default(), 1);
    let (result, _) = run(&mut reading, LIMIT);
    let read = result.expect("downloaded");
    assert_eq!((read.route, read.items), (PlanRoute::FloatItems, plan.items));

    let clear = PlanClear::new(&unknown(), PlanKind::Mission, MonoTime::ZERO);
    let mut clearing = world(clear, reading.plane, Faults::default(), 1);
    assert_eq!(run(&mut clearing, LIMIT).0, Ok(()));
    assert!(clearing.plane.mission.is_empty());
}

#[test]
fn a_vehicle_of_today_keeps_its_integers() {
    // ArduPlane of today asks with MISSION_REQUEST too.
    let config = TransferConfig { item_form: ItemForm::Unknown, ..by_items(Duration::ZERO) };
    let items = mission(20);
    for seed in 0..40 {
        let faults = if seed == 0 { Faults::default() } else { Faults::loss(0.05) };
        let upload = PlanUpload::new(&config, PlanKind::Mission, items.clone(), MonoTime::ZERO);
        let mut world = World::new(Running::new(upload), MockPlane::new(), faults, seed);
        let plan = run(&mut world, LIMIT).0.expect("uploaded");
        assert_eq!((plan.route, plan.position_error_m), (PlanRoute::Items, None));
        assert!(has(&world.plane.plans[0], &items));
    }
}

#[test]
fn a_bad_link_to_an_old_vehicle_never_ends_in_a_false_success() {
    let items = waypoints(30);
    for config in [old(), unknown()] {
        let mut done = 0;
        for seed in 0..60 {
            let faults = Faults { duplicates: 0.1, reorder: 0.1, ..Faults::loss(0.1) };
            let upload = PlanUpload::new(&config, PlanKind::Mission, items.clone(), MonoTime::ZERO);
            let mut world = world(upload, OldPlane::new(), faults, seed);
            let (result, _) = run(&mut world, LIMIT);
            let Ok(plan) = result else { continue };
            done += 1;
            assert_eq!((plan.items.len(), world.plane.mission.len()), (30, 30));
            for (stored, sent) in world.plane.mission.iter().zip(&items).skip(1) {
                assert!((stored.lat_e7 - sent.x).abs() < 120 && (stored.lng_e7 - sent.y).abs() < 330, "{stored:?}");
            }
        }
        println!("{done} of 60 uploads of 30 items with 10 % loss each way");
        assert!(done >= 55, "{done} of 60");
    }
}

#[test]
fn what_cannot_be_told_apart_from_the_mission_is_not_sent() {
    for (reason, says) in [(NoPlanKinds::OldFirmware, "FENCE_TOTAL"), (NoPlanKinds::Mavlink1, "MAVLink 1")] {
        let config = TransferConfig { no_plan_kinds: Some(reason), ..old() };
        let kind = PlanKind::Fence;
        let mut clear = PlanClear::new(&config, kind, MonoTime::ZERO);
        let mut download = PlanDownload::new(&config, kind, MonoTime::ZERO);
        let error = TransferError::OnlyMission { kind, reason };
        assert_eq!((clear.poll_output(), clear.deadline()), (None, None));
        assert_eq!(clear.result(), Some(Err(error.clone())));
        assert_eq!(download.poll_output(), None);
        assert_eq!(download.result(), Some(Err(error.clone())));
        assert!(error.to_string().contains(says));
        clear.cancel(MonoTime::ZERO);
        assert_eq!((clear.poll_output(), clear.result()), (None, None), "over is over");
        // The mission goes.
        assert!(PlanClear::new(&config, PlanKind::Mission, MonoTime::ZERO).poll_output().is_some());
    }
}
