//! Ground stations at work: two sites with a router at each, linked, over TLS; and one that comes late.

use std::path::PathBuf;

use tokio::time::timeout;
use vencejo_proto::{Address, CommandAck, Heartbeat, Message, StatusText};
use vencejo_station::{FarWish, Pending, RequestResult, StationConfig, StationError, VehicleHandle};
use vencejo_vehicle::Request;

use super::super::aircraft::tests::{Plane, beside_plane, on_board, until};
use super::super::aircraft::{Aircraft, AircraftConfig};
use super::super::membership::{Membership, join};
use super::super::organisation::Organisation;
use super::super::tests::{Scratch, endpoint, name, plane};
use super::super::unix_now;
use super::*;
use crate::authority::Role;
use crate::papers::roll::Newcomer;

const WAIT: Duration = Duration::from_secs(20);

/// A ground station, and the station that it is of.
async fn ground(listen: Option<Endpoint>, key: u8, standing: Standing) -> (Station, Ground) {
    dialling(listen, Vec::new(), key, standing).await
}

async fn dialling(listen: Option<Endpoint>, dial: Vec<Endpoint>, key: u8, standing: Standing) -> (Station, Ground) {
    let door = Some("127.0.0.1:0".into());
    started(GroundConfig { signer: Signer::from_seed(&[key; 32]), standing, door, ..clear(listen, dial) }).await
}

async fn joined(organisation: &Organisation, newcomer: &Newcomer, file: PathBuf, key: Option<u8>) -> Membership {
    let token = organisation.enrol(newcomer, 60, unix_now()).expect("a token").text();
    let key = key.map(|key| Signer::from_seed(&[key; 32]).public());
    join(&token, &file, key).await.expect("joined").0
}

/// An aircraft that dials these routers, and the station that is on board.
async fn flying(scratch: &Scratch, organisation: &Organisation, who: &str, dial: Vec<Endpoint>) -> (Station, Aircraft) {
    let file = scratch.board(who);
    let member = joined(organisation, &plane(who), file.clone(), None).await;
    let station = on_board().await;
    let config = AircraftConfig {
        org: name("acme"),
        name: name(who),
        dial,
        member: Some((member, file)),
        trust: BTreeMap::new(),
        uplink_bit_s: None,
        history: None,
    };
    let aircraft = Aircraft::start(station.clone(), config, &Handle::current()).expect("an aircraft");
    (station, aircraft)
}

fn clear(listen: Option<Endpoint>, dial: Vec<Endpoint>) -> GroundConfig {
    GroundConfig {
        org: name("acme"),
        listen,
        dial,
        signer: Signer::from_seed(&[1; 32]),
        overrules: false,
        standing: Standing::Alone,
        door: None,
        history: None,
    }
}

/// A ground station in the clear, and the station that it is of.
async fn in_the_clear(listen: Option<Endpoint>, dial: Vec<Endpoint>) -> (Station, Ground) {
    started(clear(listen, dial)).await
}

async fn started(config: GroundConfig) -> (Station, Ground) {
    let station = Station::start(StationConfig::default(), Handle::current()).expect("a station");
    let ground = Ground::start(station.clone(), config, &Handle::current()).await.expect("a ground station");
    (station, ground)
}

/// An aircraft in the clear, for the station on board.
fn plane7(board: &Station, at: &Endpoint) -> Aircraft {
    let config = AircraftConfig {
        org: name("acme"),
        name: name("plane7"),
        dial: vec![at.clone()],
        member: None,
        trust: BTreeMap::from([(Signer::from_seed(&[1; 32]).public(), Role::Operator)]),
        uplink_bit_s: None,
        history: None,
    };
    Aircraft::start(board.clone(), config, &Handle::current()).expect("an aircraft")
}

fn shows(ground: &Ground, who: &str) -> bool {
    ground.aircraft().iter().any(|far| far.name == who && far.is_present && far.id.is_some())
}

/// What the station on board of an aircraft says to what is asked of it here.
async fn answer_of(station: &Station, ground: &Ground, who: &str) -> StationError {
    let id = ground.aircraft().into_iter().find(|far| far.name == who).and_then(|far| far.id).expect("it is there");
    let vehicle = station.vehicle(id).expect("a vehicle");
    let asked = vehicle.request(Request::ParamRead { name: "a b".into() });
    let ended = timeout(WAIT, asked.wait()).await.expect("it ends").expect("it was not given up");
    ended.expect_err("no such name")
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn aircraft_and_stations_at_either_of_two_routers_are_one_fleet_and_one_router_is_enough() {
    let scratch = Scratch::new();
    let organisation = scratch.organisation("acme");
    let (valley, below) = ground(Some(endpoint("tls/127.0.0.1:0")), 1, Standing::Authority(organisation.clone())).await;
    let at_hill = endpoint("tls/127.0.0.1:0").with_port().expect("a port");
    let hill = Newcomer::Station(name("hill"), Role::Operator, vec![at_hill.to_string()]);
    let place = scratch.board("hill");
    let member = joined(&organisation, &hill, place.clone(), Some(2)).await;
    assert_eq!(member.serves(), Ok(vec![at_hill.clone()]));
    assert_eq!(member.routers(), Ok(vec![below.endpoint().clone(), at_hill.clone()]), "all are told of both");
    let (hill, above) = ground(Some(at_hill.clone()), 2, Standing::Member(place.clone())).await;

    let both = vec![below.endpoint().clone(), at_hill.clone()];
    let (seven, plane7) = flying(&scratch, &organisation, "plane7", both).await;
    let (eight, plane8) = flying(&scratch, &organisation, "plane8", vec![at_hill.clone()]).await;
    for (plane, ground, what) in [
        ("plane7", &below, "plane7 is seen at its router"),
        ("plane8", &above, "plane8 is seen at its router"),
        ("plane7", &above, "plane7 is seen at the other router"),
        ("plane8", &below, "plane8 is seen at the other router"),
    ] {
        until(what, || shows(ground, plane)).await;
    }
    for (station, ground, who) in [(&valley, &below, "plane8"), (&hill, &above, "plane7")] {
        let said = answer_of(station, ground, who).await.to_string();
        assert!(said.contains("not a parameter name"), "{said}");
    }
    // Another program at the hill uses the router there.
    let (beside, program) = dialling(None, vec![at_hill], 2, Standing::Member(place)).await;
    until("both are seen there", || shows(&program, "plane7") && shows(&program, "plane8")).await;
    program.close().await;
    beside.close().await;
    // Who is put out is out at both.
    let revoked = organisation.change(|roll| roll.revoke("plane8", unix_now()));
    revoked.expect("revoked");
    for ground in [&below, &above] {
        until("it is out", || !shows(ground, "plane8") && shows(ground, "plane7")).await;
    }

    below.close().await;
    until("it is at the other", || {
        let there = above.aircraft().into_iter().find(|far| far.name == "plane7").expect("it is known");
        there.is_present && there.age < Duration::from_secs(2) && plane7.status().is_connected
    })
    .await;
    let said = answer_of(&hill, &above, "plane7").await.to_string();
    assert!(said.contains("not a parameter name"), "{said}");
    for (station, aircraft) in [(&seven, &plane7), (&eight, &plane8)] {
        aircraft.close().await;
        station.close().await;
    }
    above.close().await;
    for station in [valley, hill] {
        station.close().await;
    }
}

/// Who has control of the first aircraft, as a station sees it: the holder, who asks, and which of the two is here.
fn control(station: &Station) -> (String, String, bool, bool) {
    let held = station.vehicles().first().and_then(VehicleHandle::held_far).unwrap_or_default();
    let name = |name: Option<String>| name.unwrap_or_default();
    (name(held.holder), name(held.requested_by), held.is_ours, held.is_request_ours)
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn control_goes_from_one_ground_station_to_another_that_asks_for_it() {
    let scratch = Scratch::new();
    let organisation = scratch.organisation("acme");
    let (here, ground_here) =
        ground(Some(endpoint("tls/127.0.0.1:0")), 1, Standing::Authority(organisation.clone())).await;
    let tower = Newcomer::Station(name("tower"), Role::Operator, Vec::new());
    let place = scratch.board("tower");
    joined(&organisation, &tower, place.clone(), Some(2)).await;
    let (there, ground_there) = ground(None, 2, Standing::Member(place)).await;
    let (board, aircraft) = flying(&scratch, &organisation, "plane7", Vec::new()).await;
    until("it is seen at both", || shows(&ground_here, "plane7") && shows(&ground_there, "plane7")).await;

    let (ana, luis) = (Arc::new(here.enlist("Ana")), Arc::new(there.enlist("Luis")));
    ana.attach(here.now());
    luis.attach(there.now());
    let (ours, theirs) = (here.vehicles().remove(0).acting_as(ana), there.vehicles().remove(0).acting_as(luis));
    let wish = async |vehicle: &VehicleHandle, wish| {
        let ended = timeout(WAIT, vehicle.control(wish).wait()).await.expect("it ends").expect("it was not given up");
        ended.expect("it was heard");
    };
    let keep = || FarWish::Keep { requested_by: None };
    let said =
        |holder: &str, asking: &str, is_ours, is_asking| (holder.to_owned(), asking.to_owned(), is_ours, is_asking);

    wish(&ours, FarWish::Request).await;
    assert_eq!(control(&here), said("ground · Ana", "", true, false));
    // An act does not ask.
    until("the other sees it", || control(&there).0 == "ground · Ana").await;
    let refused = timeout(WAIT, theirs.request(Request::LoiterHere).wait()).await.expect("it ends").expect("an end");
    let held = StationError::Control { holder: "ground · Ana".into(), vehicle: Some("plane7".into()) };
    assert_eq!(refused, Err(held));
    wish(&theirs, FarWish::Request).await;
    assert_eq!(control(&there), said("ground · Ana", "tower · Luis", false, true));
    until("the holder is told", || control(&here) == said("ground · Ana", "tower · Luis", true, false)).await;
    wish(&ours, keep()).await;
    until("it is declined", || control(&there) == said("ground · Ana", "", false, false)).await;
    until("and not kept up", || !ground_there.fleet.aircraft().values().any(|far| far.known().is_claimed())).await;
    wish(&theirs, FarWish::Request).await;
    wish(&ours, FarWish::Release).await;
    until("the other has it", || control(&there) == said("tower · Luis", "", true, false)).await;

    // A program that has it gives it at once to whoever asks.
    wish(&theirs, FarWish::Release).await;
    here.operator().take_over("Ana", here.now()).expect("by name");
    wish(&here.vehicles().remove(0), FarWish::Request).await;
    assert_eq!(control(&here), said("ground · program", "", true, false));
    wish(&theirs, FarWish::Request).await;
    until("the other has it", || control(&there) == said("tower · Luis", "", true, false)).await;

    // A ground station that is closed takes its request back, and gets nothing.
    wish(&theirs, FarWish::Release).await;
    here.operator().release(here.now());
    wish(&ours, FarWish::Request).await;
    wish(&theirs, FarWish::Request).await;
    until("it asks", || control(&here) == said("ground · Ana", "tower · Luis", true, false)).await;
    ground_there.close().await;
    until("it asks no more", || control(&here) == said("ground · Ana", "", true, false)).await;
    wish(&ours, FarWish::Release).await;
    assert_eq!(control(&here), said("", "", false, false));
    aircraft.close().await;
    ground_here.close().await;
    for station in [here, there, board] {
        station.close().await;
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn whoever_comes_late_hears_all_that_was_said() {
    let (board, plane) = beside_plane().await;
    let (early, router) = in_the_clear(Some(endpoint("tcp/127.0.0.1:0")), Vec::new()).await;
    let at = router.endpoint().clone();
    let aircraft = plane7(&board, &at);
    until("it is seen", || shows(&router, "plane7")).await;
    let said: Vec<_> = (0..150).map(|number| format!("text {number}")).collect();
    for text in &said {
        plane.say(&Message::StatusText(StatusText { severity: 4, text: text.clone(), id: 0, chunk_seq: 0 })).await;
    }
    let hears_all = |station: &Station| {
        station.vehicles().first().is_some_and(|vehicle| vehicle.texts().iter().map(|text| &text.text).eq(&said))
    };
    until("all is heard while it is said", || hears_all(&early)).await;
    let (late, newcomer) = in_the_clear(None, vec![at]).await;
    until("all is heard later", || hears_all(&late)).await;
    for ground in [newcomer, router] {
        ground.close().await;
    }
    aircraft.close().await;
    for station in [early, late, board] {
        station.close().await;
    }
}

const HEARTBEAT: u32 = 0;
const COMMAND_LONG: u32 = 76;

/// Orders a return, again when what was known of the aircraft was too old on a busy machine, until its autopilot hears.
async fn told_to_return(vehicle: &VehicleHandle, flying: &Plane) -> Pending<RequestResult> {
    let heard = async {
        loop {
            let asked = vehicle.request(Request::ReturnToLaunch);
            tokio::select! {
                () = flying.hears(COMMAND_LONG) => return asked,
                ended = asked.wait() => println!("not sent: {ended:?}"),
            }
        }
    };
    timeout(WAIT, heard).await.expect("it hears")
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn of_two_computers_that_speak_as_one_aircraft_the_first_stays_under_control() {
    let (station, ground) = in_the_clear(Some(endpoint("tcp/127.0.0.1:0")), Vec::new()).await;
    let ((one, flying), (other, bench)) = (beside_plane().await, beside_plane().await);
    let first = plane7(&one, ground.endpoint());
    until("it is seen", || shows(&ground, "plane7")).await;
    let vehicle = station.vehicles().into_iter().next().expect("it is there");
    assert_eq!(vehicle.rival(), None);
    let asked = told_to_return(&vehicle, &flying).await;
    flying.hears(HEARTBEAT).await;
    let second = plane7(&other, ground.endpoint());
    until("both are noticed", || vehicle.rival().is_some()).await;
    assert_eq!(vehicle.rival().as_deref(), Some("the fleet acme"));
    // The autopilot answered nothing.
    assert!(timeout(WAIT, asked.wait()).await.expect("it ends").expect("it was not given up").is_err());
    flying.has_heard(&[]);
    let _asked = told_to_return(&vehicle, &flying).await;
    flying.hears(HEARTBEAT).await;
    assert_eq!((first.status().holder.is_some(), second.status().holder), (true, None));
    assert!(!bench.has_heard(&[COMMAND_LONG, HEARTBEAT]), "it is not the one that is shown");
    for (station, aircraft) in [(&one, &first), (&other, &second)] {
        aircraft.close().await;
        station.close().await;
    }
    ground.close().await;
    station.close().await;
}

/// Such as a script beside `vencejo serve`.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn programs_with_one_key_have_control_each_for_itself() {
    let (station, ground) = in_the_clear(Some(endpoint("tcp/127.0.0.1:0")), Vec::new()).await;
    let (board, _flying) = beside_plane().await;
    let aircraft = plane7(&board, ground.endpoint());
    let beside = |overrules| {
        let config = clear(None, vec![ground.endpoint().clone()]);
        started(GroundConfig { overrules, ..config })
    };
    let (other, script) = beside(false).await;
    until("it is seen", || shows(&ground, "plane7") && shows(&script, "plane7")).await;
    let wish = async |station: &Station, wish| {
        let asked = station.vehicles().remove(0).control(wish);
        timeout(WAIT, asked.wait()).await.expect("it ends").expect("it was not given up").map(|_| ())
    };
    let ana = Arc::new(station.enlist("Ana"));
    ana.attach(station.now());
    let ours = station.vehicles().remove(0).acting_as(ana);
    timeout(WAIT, ours.control(FarWish::Request).wait()).await.expect("it ends").expect("an end").expect("it is free");

    let act = async |station: &Station| {
        let act = station.vehicles().remove(0).request(Request::LoiterHere);
        timeout(WAIT, act.wait()).await.expect("it ends").expect("it was not given up")
    };
    let held = StationError::Control { holder: "Ana".into(), vehicle: Some("plane7".into()) };
    assert_eq!(act(&other).await, Err(held.clone()), "nothing was sent");
    wish(&other, FarWish::Request).await.expect("it asks");
    assert_eq!((control(&other).2, control(&other).3), (false, true));
    until("she is asked", || !control(&station).1.is_empty() && !control(&station).3).await;
    wish(&other, FarWish::Release).await.expect("it asks no more");
    assert!(control(&station).2 || !control(&station).0.is_empty());
    script.close().await;
    other.close().await;
    until("its end gives up nothing", || control(&station).2).await;

    // One that was told to take it takes it, and gives it back when it ends.
    let (other, script) = beside(true).await;
    until("it is seen", || shows(&script, "plane7")).await;
    // Not for a client that does not see whose it is.
    let node = Arc::new(other.enlist("ROS 2").asking());
    let act_of_node = other.vehicles().remove(0).acting_as(node.clone()).request(Request::LoiterHere);
    let ended = timeout(WAIT, act_of_node.wait()).await.expect("it ends").expect("it was not given up");
    assert_eq!(ended, Err(held.clone()));
    node.release(other.now());
    wish(&other, FarWish::Request).await.expect("it takes it");
    let has_lost_it = || control(&station).0 == "program" && !control(&station).2;
    until("she has lost it", has_lost_it).await;
    // Nor back from her, when she has stopped it, by its next act.
    timeout(WAIT, ours.control(FarWish::Request).wait()).await.expect("it ends").expect("an end").expect("she asks");
    until("she has it", || control(&station).2 && !control(&other).2).await;
    assert_eq!(act(&other).await, Err(held));
    wish(&other, FarWish::Request).await.expect("it takes it");
    until("she has lost it again", has_lost_it).await;
    script.close().await;
    other.close().await;
    until("it is back", || control(&station).2).await;

    aircraft.close().await;
    for station in [station, board] {
        station.close().await;
    }
    ground.close().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_effect_of_an_act_is_shown_when_it_has_ended() {
    let (station, ground) = in_the_clear(Some(endpoint("tcp/127.0.0.1:0")), Vec::new()).await;
    let (board, flying) = beside_plane().await;
    let aircraft = plane7(&board, ground.endpoint());
    until("it is seen", || shows(&ground, "plane7")).await;
    let vehicle = station.vehicles().into_iter().next().expect("it is there");
    let mode = || vehicle.telemetry().0.mode().and_then(|mode| mode.name());
    for (number, name) in [(11, "RTL"), (12, "LOITER"), (11, "RTL"), (12, "LOITER")] {
        let request = if name == "RTL" { Request::ReturnToLaunch } else { Request::LoiterHere };
        let asked = vehicle.request(request);
        flying.hears(COMMAND_LONG).await;
        let heartbeat =
            Heartbeat { mav_type: 1, autopilot: 3, base_mode: 1, custom_mode: number, ..Heartbeat::default() };
        flying
            .say(&Message::CommandAck(CommandAck {
                command: 176,
                result: 0,
                progress: 0,
                result_param2: 0,
                target: Address::new(0, 0),
            }))
            .await;
        flying.say(&Message::Heartbeat(heartbeat)).await;
        timeout(WAIT, asked.wait()).await.expect("it ends").expect("it was not given up").expect("it is done");
        assert_eq!(mode(), Some(name));
    }
    aircraft.close().await;
    board.close().await;
    ground.close().await;
    station.close().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_silent_autopilot_is_told_apart_from_a_silent_computer() {
    let (station, ground) = in_the_clear(Some(endpoint("tcp/127.0.0.1:0")), Vec::new()).await;
    let (board, flying) = beside_plane().await;
    let aircraft = plane7(&board, ground.endpoint());
    until("it is seen", || shows(&ground, "plane7")).await;
    let vehicle = station.vehicles().into_iter().next().expect("it is there");
    let far = || ground.aircraft().into_iter().next().and_then(|far| far.silence);
    assert_eq!((far(), vehicle.silence(), aircraft.status().silence), (None, None, None));
    // The autopilot says nothing more.
    let asked = vehicle.request(Request::ReturnToLaunch);
    until("it is silent", || far().is_some()).await;
    for silence in [far(), vehicle.silence(), aircraft.status().silence] {
        let silence = silence.expect("it is silent");
        assert!(silence.lasts >= LOST_AFTER && silence.links.ends_with("(open)"), "{silence:?}");
    }
    let ended = timeout(WAIT, asked.wait()).await.expect("it ends").expect("it was not given up");
    let error = ended.expect_err("nobody answers").to_string();
    assert!(error.starts_with("plane7 did not answer") && !error.contains("vehicle 1/1"), "{error}");
    let asked = vehicle.request(Request::LoiterHere);
    let ended = timeout(WAIT, asked.wait()).await.expect("it ends").expect("it was not given up");
    let error = ended.expect_err("nobody answers").to_string();
    assert!(error.contains("its autopilot has been silent on board for"), "{error}");
    flying.say(&Message::Heartbeat(Heartbeat { mav_type: 1, autopilot: 3, ..Heartbeat::default() })).await;
    until("it is heard", || (far(), vehicle.silence(), aircraft.status().silence) == (None, None, None)).await;
    aircraft.close().await;
    board.close().await;
    ground.close().await;
    station.close().await;
}

/// The computer may be the same one, started again, or another one with a copy of its card.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_was_ordered_before_another_computer_took_its_place_is_not_carried_to_that() {
    let (station, ground) = in_the_clear(Some(endpoint("tcp/127.0.0.1:0")), Vec::new()).await;
    let ((one, _flying), (other, bench)) = (beside_plane().await, beside_plane().await);
    let first = plane7(&one, ground.endpoint());
    until("it is seen", || shows(&ground, "plane7")).await;
    let vehicle = station.vehicles().into_iter().next().expect("it is there");
    let far = ground.fleet.aircraft().values().next().cloned().expect("it is there");
    let boot = || far.known().boot();
    let ordered_for = boot();
    // It waits for its turn to ask for control.
    let turn = far.asking.lock().await;
    let asked = vehicle.request(Request::ReturnToLaunch);
    first.close().await;
    let second = plane7(&other, ground.endpoint());
    until("the second is followed", || boot() != ordered_for).await;
    drop(turn);
    let ended = timeout(WAIT, asked.wait()).await.expect("it ends").expect("it was not given up");
    let refused = ended.expect_err("it was for another").to_string();
    assert!(refused.contains("started again"), "{refused}");
    assert!(!bench.has_heard(&[COMMAND_LONG, HEARTBEAT]));
    let _asked = vehicle.request(Request::ReturnToLaunch);
    bench.hears(COMMAND_LONG).await;
    for (station, aircraft) in [(&one, &first), (&other, &second)] {
        aircraft.close().await;
        station.close().await;
    }
    ground.close().await;
    station.close().await;
}
