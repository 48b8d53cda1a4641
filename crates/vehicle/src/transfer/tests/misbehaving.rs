//! Vehicles that misbehave at one step of a transfer, as ground stations are tested with elsewhere: silent, with the
//! wrong item, with an error, too early, to somebody else. For each it is said how the transfer has to end.

use std::time::Duration;

use vencejo_flight::plan::PlanKind;
use vencejo_proto::dialect::{
    MISSION_COUNT_DATA, MISSION_REQUEST_INT_DATA, MavMessage, MavMissionType, MavParamType, PARAM_VALUE_DATA,
};
use vencejo_proto::{Address, Message, MissionAck, MissionItemInt, MonoTime};

use super::{LIMIT, by_ftp, by_items, has};
use crate::transfer::testing::{Endpoint, Faults, MockPlane, PLANE, RIVAL, Running, STATION, World, run};
use crate::transfer::{
    Param, ParamList, ParamName, ParamValue, PlanDownload, PlanUpload, Transfer, TransferConfig, TransferError,
};

/// What is done to a message that the vehicle says: nothing, something else, or it is not said. The number counts those
/// changed so far.
type Twist = fn(&mut Message, usize) -> Said;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Said {
    AsItIs,
    Changed,
    Not,
}

/// A plane whose words are twisted.
struct Twisted {
    plane: MockPlane,
    twist: Twist,
    count: usize,
    /// Asks with MISSION_REQUEST_INT, as PX4 does.
    asks_for_integers: bool,
}

impl Endpoint for Twisted {
    fn receive(&mut self, from: Address, message: &Message, now: MonoTime) {
        self.plane.receive(from, message, now);
    }

    fn tick(&mut self, now: MonoTime) {
        self.plane.tick(now);
    }

    fn wakes_at(&self) -> Option<MonoTime> {
        self.plane.wakes_at()
    }

    fn next_output(&mut self) -> Option<Message> {
        loop {
            let mut message = self.plane.next_output()?;
            if let (true, Message::Dialect(MavMessage::MISSION_REQUEST(asked))) = (self.asks_for_integers, &message) {
                message = request(asked.seq, Address::new(asked.target_system, asked.target_component));
            }
            match (self.twist)(&mut message, self.count) {
                Said::AsItIs => return Some(message),
                Said::Changed => {
                    self.count += 1;
                    return Some(message);
                }
                Said::Not => self.count += 1,
            }
        }
    }
}

/// The item that a message of the vehicle asks for.
fn asked(message: &Message) -> Option<u16> {
    match message {
        Message::Dialect(MavMessage::MISSION_REQUEST(asked)) => Some(asked.seq),
        Message::Dialect(MavMessage::MISSION_REQUEST_INT(asked)) => Some(asked.seq),
        _ => None,
    }
}

/// What PX4 asks for an item with.
fn request(seq: u16, of: Address) -> Message {
    Message::Dialect(MavMessage::MISSION_REQUEST_INT(MISSION_REQUEST_INT_DATA {
        seq,
        target_system: of.system.0,
        target_component: of.component.0,
        mission_type: MavMissionType::MAV_MISSION_TYPE_MISSION,
    }))
}

fn is_count(message: &Message) -> bool {
    matches!(message, Message::Dialect(MavMessage::MISSION_COUNT(_)))
}

fn is_item(message: &Message, seq: u16) -> bool {
    matches!(message, Message::MissionItemInt(item) if item.seq == seq)
}

fn is_good_end(message: &Message) -> bool {
    matches!(message, Message::MissionAck(ack) if ack.result == 0)
}

fn answer(result: u8) -> Message {
    Message::MissionAck(MissionAck { target: STATION, result, mission_type: 0, opaque_id: 0 })
}

fn drop_if(is_it: bool) -> Said {
    if is_it { Said::Not } else { Said::AsItIs }
}

fn replace_if(is_it: bool, message: &mut Message, with: Message) -> Said {
    if is_it {
        *message = with;
        return Said::Changed;
    }
    Said::AsItIs
}

/// An item, or the request for one, under a number that there is not.
fn misnumber_if(is_it: bool, message: &mut Message) -> Said {
    match message {
        Message::MissionItemInt(item) if is_it => item.seq = 999,
        Message::Dialect(MavMessage::MISSION_REQUEST(asked)) if is_it => asked.seq = 999,
        Message::Dialect(MavMessage::MISSION_REQUEST_INT(asked)) if is_it => asked.seq = 999,
        _ => return Said::AsItIs,
    }
    Said::Changed
}

fn change_count(message: &mut Message, change: fn(&mut MISSION_COUNT_DATA)) -> Said {
    let Message::Dialect(MavMessage::MISSION_COUNT(count)) = message else { return Said::AsItIs };
    change(count);
    Said::Changed
}

fn change_end(message: &mut Message, change: fn(&mut MissionAck)) -> Said {
    let Message::MissionAck(ack) = message else { return Said::AsItIs };
    change(ack);
    Said::Changed
}

/// How a transfer has to end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum End {
    /// Well, and truly so.
    Well,
    /// With an error.
    Error,
    /// With the vehicle's own refusal.
    Refused,
}

/// `MAV_MISSION_ERROR`, `MAV_MISSION_NO_SPACE`.
const ERROR: u8 = 1;
const NO_SPACE: u8 = 4;

const READS: [(&str, Twist, End); 14] = [
    ("the list is not answered", |m, _| drop_if(is_count(m)), End::Error),
    ("the list is not answered the first time", |m, n| drop_if(n == 0 && is_count(m)), End::Well),
    ("item 0 never comes", |m, _| drop_if(is_item(m, 0)), End::Error),
    ("item 0 does not come the first time", |m, n| drop_if(n == 0 && is_item(m, 0)), End::Well),
    ("item 1 never comes", |m, _| drop_if(is_item(m, 1)), End::Error),
    ("item 1 does not come the first time", |m, n| drop_if(n == 0 && is_item(m, 1)), End::Well),
    ("item 0 comes under a number that there is not", |m, _| misnumber_if(is_item(m, 0), m), End::Error),
    ("item 1 comes under a number that there is not", |m, _| misnumber_if(is_item(m, 1), m), End::Error),
    ("an error in place of item 0", |m, _| replace_if(is_item(m, 0), m, answer(ERROR)), End::Error),
    ("an error in place of item 1", |m, _| replace_if(is_item(m, 1), m, answer(ERROR)), End::Error),
    ("an error in place of the list", |m, _| replace_if(is_count(m), m, answer(ERROR)), End::Refused),
    ("none", |m, _| change_count(m, |count| count.count = 0), End::Well),
    ("sixty-five thousand", |m, _| change_count(m, |count| count.count = 65_535), End::Error),
    (
        "the list of the fence",
        |m, _| change_count(m, |count| count.mission_type = MavMissionType::MAV_MISSION_TYPE_FENCE),
        End::Error,
    ),
];

const WRITES: [(&str, Twist, End); 16] = [
    ("the count is not answered", |m, _| drop_if(asked(m).is_some()), End::Error),
    ("the count is not answered the first time", |m, n| drop_if(n == 0 && asked(m) == Some(0)), End::Well),
    ("item 1 is never asked for", |m, _| drop_if(asked(m) == Some(1)), End::Error),
    ("item 1 is not asked for the first time", |m, n| drop_if(n == 0 && asked(m) == Some(1)), End::Well),
    ("an item that there is not in place of item 0", |m, _| misnumber_if(asked(m) == Some(0), m), End::Error),
    ("an item that there is not in place of item 1", |m, _| misnumber_if(asked(m) == Some(1), m), End::Error),
    (
        "an error in place of the request for item 0",
        |m, _| replace_if(asked(m) == Some(0), m, answer(ERROR)),
        End::Refused,
    ),
    (
        "an error in place of the request for item 1",
        |m, _| replace_if(asked(m) == Some(1), m, answer(ERROR)),
        End::Refused,
    ),
    (
        "no room in place of the request for item 1",
        |m, _| replace_if(asked(m) == Some(1), m, answer(NO_SPACE)),
        End::Refused,
    ),
    // It has all of it, as reading back shows.
    ("the end is not told", |m, _| drop_if(is_good_end(m)), End::Well),
    ("no room in place of the end", |m, _| replace_if(is_good_end(m), m, answer(NO_SPACE)), End::Refused),
    ("the end is told after item 0", |m, _| replace_if(asked(m).is_some_and(|seq| seq > 0), m, answer(0)), End::Error),
    ("the end is told in place of the first request", |m, _| replace_if(asked(m).is_some(), m, answer(0)), End::Error),
    ("the end is told to another station", |m, _| change_end(m, |ack| ack.target = RIVAL), End::Well),
    ("the end is told of the fence", |m, _| change_end(m, |ack| ack.mission_type = 1), End::Well),
    (
        "requests are for another station",
        |m, _| asked(m).map_or(Said::AsItIs, |seq| replace_if(true, m, request(seq, RIVAL))),
        End::Error,
    ),
];

/// Waypoints that every autopilot keeps as they are sent.
fn plain(count: u16) -> Vec<MissionItemInt> {
    let item = |seq: u16| MissionItemInt {
        target: PLANE,
        seq,
        frame: if seq == 0 { 0 } else { 3 },
        command: 16,
        current: 0,
        autocontinue: 1,
        params: [0.0; 4],
        x: 403_332_000 + i32::from(seq) * 1000,
        y: -37_978_000,
        z: 50.0 + f32::from(seq),
        mission_type: 0,
    };
    (0..count).map(item).collect()
}

fn check<T>(what: &str, end: End, result: &Result<T, TransferError>, took: Duration) {
    let is_right = match end {
        End::Well => result.is_ok(),
        End::Error => result.is_err(),
        End::Refused => matches!(result, Err(TransferError::Refused { .. })),
    };
    assert!(is_right, "{what}: {:?}", result.as_ref().err());
    assert!(took <= Duration::from_secs(60), "{what}: {took:?}");
}

/// A PX4 in which another upload was abandoned: it refuses MISSION_COUNT until nothing has come for 5 s, a count that it
/// refuses included.
struct InAbandonedUpload {
    plane: Twisted,
    until: MonoTime,
    refusals: Vec<Message>,
}

impl InAbandonedUpload {
    const TIMEOUT: Duration = Duration::from_secs(5);

    fn new(twist: Twist) -> Self {
        let mut plane = MockPlane::new();
        (plane.strict_order, plane.keeps_home) = (true, false);
        let plane = Twisted { plane, twist, count: 0, asks_for_integers: true };
        Self { plane, until: MonoTime::ZERO + Self::TIMEOUT, refusals: Vec::new() }
    }
}

impl Endpoint for InAbandonedUpload {
    fn receive(&mut self, from: Address, message: &Message, now: MonoTime) {
        if is_count(message) && now < self.until {
            self.until = now + Self::TIMEOUT;
            self.refusals.push(answer(ERROR));
        } else {
            self.plane.receive(from, message, now);
        }
    }

    fn tick(&mut self, now: MonoTime) {
        self.plane.tick(now);
    }

    fn wakes_at(&self) -> Option<MonoTime> {
        self.plane.wakes_at()
    }

    fn next_output(&mut self) -> Option<Message> {
        self.refusals.pop().or_else(|| self.plane.next_output())
    }
}

/// A PX4 to which item by item is sent over a link with this round trip.
fn px4(round_trip: Duration) -> TransferConfig {
    TransferConfig { round_trip: Some(round_trip), item_window: 1, ..TransferConfig::new(PLANE, STATION) }
}

// v1.17.0, `MavlinkMissionManager::handle_mission_count`.
#[test]
fn a_px4_in_an_abandoned_upload_is_left_alone_until_it_ends() {
    let items = plain(6);
    for round_trip in [Duration::ZERO, Duration::from_millis(600)] {
        let upload = PlanUpload::new(&px4(round_trip), PlanKind::Mission, items.clone(), MonoTime::ZERO);
        let plane = InAbandonedUpload::new(|_, _| Said::AsItIs);
        let mut world = World::new(Running::new(upload), plane, Faults::round_trip(round_trip), 1);
        let (result, took) = run(&mut world, LIMIT);
        assert!(result.is_ok() && has(&world.plane.plane.plane.plans[0], &items), "{:?}", result.err());
        assert!(took <= Duration::from_secs(15), "{took:?}");
    }
    // What ends without success frees it for the next.
    let upload = PlanUpload::new(&px4(Duration::ZERO), PlanKind::Mission, items, MonoTime::ZERO);
    let plane = InAbandonedUpload::new(|message, _| drop_if(asked(message) == Some(1)));
    let mut world = World::new(Running::new(upload), plane, Faults::default(), 1);
    world.log = Some(Vec::new());
    let (result, _) = run(&mut world, LIMIT);
    assert!(matches!(result, Err(TransferError::NoProgress { .. })), "{:?}", result.err());
    let last = world.log.as_ref().and_then(|log| log.last()).map(|(_, message)| message);
    assert!(matches!(last, Some(Message::MissionAck(MissionAck { result: 15, .. }))), "{last:?}");
}

// It answers each copy of an item, or of a request, that comes when it has given up waiting.
#[test]
fn refusals_of_what_came_late_are_not_taken_for_a_busy_vehicle() {
    let (items, second) = (plain(20), Duration::from_secs(1));
    let late = |at_ms: u64| MonoTime::from_millis(at_ms);
    let upload = PlanUpload::new(&px4(second), PlanKind::Mission, items.clone(), MonoTime::ZERO);
    let mut plane = MockPlane::new();
    (plane.strict_order, plane.keeps_home) = (true, false);
    let mut world = World::new(Running::new(upload), plane, Faults::round_trip(second), 1);
    (0..3).for_each(|copy| world.inject(late(12_000 + 100 * copy), true, PLANE, &answer(ERROR)));
    let (result, _) = run(&mut world, LIMIT);
    assert!(result.is_ok() && has(&world.plane.plans[0], &items), "{:?}", result.err());

    let mut plane = MockPlane::new();
    plane.store(PlanKind::Mission, &items);
    let download = PlanDownload::new(&px4(second), PlanKind::Mission, MonoTime::ZERO);
    let mut world = World::new(Running::new(download), plane, Faults::round_trip(second), 1);
    (0..3).for_each(|copy| world.inject(late(12_000 + 100 * copy), true, PLANE, &answer(ERROR)));
    assert!(has(&run(&mut world, LIMIT).0.expect("read").items, &items));
}

// A PX4 ends a transfer in which nothing comes for 5 s, answers what comes late with an error, and until then whatever
// else is begun (v1.17.0, `MavlinkMissionManager`).
#[test]
fn a_px4_that_was_busy_or_gave_up_is_asked_again() {
    let items = plain(6);
    let config = TransferConfig { item_window: 1, ..TransferConfig::new(PLANE, STATION) };
    let cases: [Twist; 2] = [
        |m, n| replace_if(n == 0 && asked(m) == Some(3), m, answer(ERROR)),
        |m, n| replace_if(n < 3 && asked(m) == Some(0), m, answer(ERROR)),
    ];
    for twist in cases {
        let mut plane = MockPlane::new();
        (plane.strict_order, plane.keeps_home) = (true, false);
        let upload = PlanUpload::new(&config, PlanKind::Mission, items.clone(), MonoTime::ZERO);
        let twisted = Twisted { plane, twist, count: 0, asks_for_integers: true };
        let mut world = World::new(Running::new(upload), twisted, Faults::default(), 1);
        let (result, _) = run(&mut world, LIMIT);
        assert!(result.is_ok() && has(&world.plane.plane.plans[0], &items), "{:?}", result.err());
        assert!(world.plane.count > 0);
    }
    let mut plane = MockPlane::new();
    plane.store(PlanKind::Mission, &items);
    let twist: Twist = |m, n| replace_if(n < 3 && is_count(m), m, answer(ERROR));
    let download = PlanDownload::new(&config, PlanKind::Mission, MonoTime::ZERO);
    let twisted = Twisted { plane, twist, count: 0, asks_for_integers: true };
    let mut world = World::new(Running::new(download), twisted, Faults::default(), 1);
    let (result, _) = run(&mut world, LIMIT);
    assert!(has(&result.expect("read").items, &items));
}

/// A PX4 that gives up a transfer before its third item, and answers nothing more until a list is asked for anew.
struct Forgetful {
    plane: MockPlane,
    lists: u32,
}

impl Endpoint for Forgetful {
    fn receive(&mut self, from: Address, message: &Message, now: MonoTime) {
        self.lists += u32::from(matches!(message, Message::Dialect(MavMessage::MISSION_REQUEST_LIST(_))));
        if self.lists > 1 || asked(message).is_none_or(|seq| seq < 2) {
            self.plane.receive(from, message, now);
        }
    }

    fn tick(&mut self, now: MonoTime) {
        self.plane.tick(now);
    }

    fn wakes_at(&self) -> Option<MonoTime> {
        self.plane.wakes_at()
    }

    fn next_output(&mut self) -> Option<Message> {
        self.plane.next_output()
    }
}

#[test]
fn a_px4_that_has_forgotten_a_reading_is_asked_anew() {
    let items = plain(6);
    let mut plane = MockPlane::new();
    plane.store(PlanKind::Mission, &items);
    let download = PlanDownload::new(&TransferConfig::new(PLANE, STATION), PlanKind::Mission, MonoTime::ZERO);
    let mut world = World::new(Running::new(download), Forgetful { plane, lists: 0 }, Faults::default(), 1);
    let (result, _) = run(&mut world, LIMIT);
    assert!(has(&result.expect("read").items, &items));
    assert_eq!(world.plane.lists, 2);
}

// fault 16: 30 misbehaviours of ArduPilot's and PX4's kind at each step of reading and writing: each ends as it has to,
// no success that is none
#[test]
fn each_misbehaviour_ends_as_it_has_to() {
    let items = plain(6);
    let px4 = TransferConfig { item_window: 1, ..TransferConfig::new(PLANE, STATION) };
    let mut seen = 0;
    for (name, config, asks_for_integers) in [("ArduPilot", by_items(Duration::ZERO), false), ("PX4", px4, true)] {
        for (what, twist, end) in READS {
            let mut plane = MockPlane::new();
            plane.store(PlanKind::Mission, &items);
            let download = PlanDownload::new(&config, PlanKind::Mission, MonoTime::ZERO);
            let twisted = Twisted { plane, twist, count: 0, asks_for_integers };
            let mut world = World::new(Running::new(download), twisted, Faults::default(), 1);
            let (result, took) = run(&mut world, LIMIT);
            check(&format!("{name}, reading, {what}"), end, &result, took);
            assert!(world.plane.count > 0, "{what}: it happened");
            if let Ok(plan) = result {
                assert!(plan.items.is_empty() || has(&plan.items, &items), "{name}, reading, {what}");
                assert_eq!(plan.items.is_empty(), what == "none", "{name}, reading, {what}");
            }
            seen += 1;
        }
        for (what, twist, end) in WRITES {
            let mut plane = MockPlane::new();
            (plane.strict_order, plane.keeps_home) = (asks_for_integers, !asks_for_integers);
            plane.store(PlanKind::Mission, &plain(9));
            let upload = PlanUpload::new(&config, PlanKind::Mission, items.clone(), MonoTime::ZERO);
            let twisted = Twisted { plane, twist, count: 0, asks_for_integers };
            let mut world = World::new(Running::new(upload), twisted, Faults::default(), 1);
            let (result, took) = run(&mut world, LIMIT);
            check(&format!("{name}, writing, {what}"), end, &result, took);
            assert!(world.plane.count > 0, "{what}: it happened");
            if result.is_ok() {
                assert!(has(&world.plane.plane.plans[0], &items), "{name}, writing, {what}: false success");
            }
            seen += 1;
        }
    }
    assert_eq!(seen, 60);
}

#[test]
fn default_values_are_read_with_the_parameters_unless_the_vehicle_refuses() {
    let param = |name: &str, value, default| {
        let name = ParamName::new(name).expect("a name");
        Param { default, ..Param::new(name, ParamValue::I16(value)) }
    };
    let known = |value| Some(ParamValue::I16(value));
    let read = |params: Vec<Param>, refuses_defaults| {
        let mut plane = MockPlane::new();
        (plane.params, plane.refuses_defaults) = (params, refuses_defaults);
        let list = ParamList::new(&by_ftp(Duration::ZERO, 1), MonoTime::ZERO);
        run(&mut World::new(Running::new(list), plane, Faults::default(), 1), LIMIT).0
    };
    let told = vec![param("ALT_OFFSET", 7, known(0)), param("FENCE_ALT_MAX", 100, known(100))];
    assert_eq!(read(told.clone(), false), Ok(told));
    let untold = vec![param("ALT_OFFSET", 7, None), param("FENCE_ALT_MAX", 100, None)];
    for refuses in [false, true] {
        assert_eq!(read(untold.clone(), refuses), Ok(untold.clone()), "without a query, or one that is ignored");
    }
}

/// Its block of the file may have been read before.
#[test]
fn a_parameter_that_is_set_while_the_file_is_read_has_its_new_value() {
    let name = ParamName::new("FENCE_ENABLE").expect("a name");
    let of = |value| Param { default: Some(ParamValue::I8(0)), ..Param::new(name, ParamValue::I8(value)) };
    let mut plane = MockPlane::new();
    plane.params = vec![of(0)];
    let mut list = ParamList::new(&by_ftp(Duration::ZERO, 1), MonoTime::ZERO);
    let told = PARAM_VALUE_DATA {
        param_value: 1.0,
        param_index: u16::MAX,
        param_id: name.to_field().into(),
        param_type: MavParamType::MAV_PARAM_TYPE_INT8,
        ..PARAM_VALUE_DATA::default()
    };
    list.on_message(PLANE, &Message::Dialect(MavMessage::PARAM_VALUE(told)), MonoTime::ZERO);
    let mut world = World::new(Running::new(list), plane, Faults::default(), 1);
    assert_eq!(run(&mut world, LIMIT).0, Ok(vec![of(1)]));
}
