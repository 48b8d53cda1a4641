//! An imitation of ArduPlane 3.x on an APM 2, as read in its `GCS_Mavlink.pde`, `GCS_Common.cpp` and `AP_Mission.cpp`
//! (2014): MAVLink 1, mission items in 32-bit floats, and nothing that is younger.

use std::collections::VecDeque;
use std::time::Duration;

use vencejo_proto::dialect::{
    ATTITUDE_DATA, AUTOPILOT_VERSION_DATA, GLOBAL_POSITION_INT_DATA, MISSION_COUNT_DATA, MISSION_CURRENT_DATA,
    MISSION_REQUEST_DATA, MavDataStream, MavMessage, MavParamType, MavProtocolCapability, PARAM_VALUE_DATA,
};
use vencejo_proto::param::ParamName;
use vencejo_proto::{Address, CommandAck, Heartbeat, Message, MissionAck, MissionItemFloat, MonoTime, StatusText};

use super::{Endpoint, PLANE, TICK};

/// It asks again for an item after this.
const ASK_AGAIN: Duration = Duration::from_millis(1_000);
/// It stops waiting for items after this, and says nothing.
const GIVE_UP: Duration = Duration::from_millis(6_000);
/// Parameters that it sends each tenth of a second while it lists them.
const PARAMS_AT_ONCE: usize = 5;
/// The mode GUIDED.
const GUIDED: u32 = 15;

/// A command of its mission as it stores it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Stored {
    id: u16,
    params: [f32; 4],
    has_position: bool,
    pub lat_e7: i32,
    pub lng_e7: i32,
    pub alt_cm: i32,
    pub is_relative: bool,
}

impl Stored {
    /// What it keeps of an item; `None` when it refuses it. Arithmetic in 32-bit floats, as on the vehicle.
    fn of(item: &MissionItemFloat) -> Option<Self> {
        let [p1, p2, p3, p4] = item.params;
        let sense = if p3 < 0.0 { -1.0 } else { 1.0 };
        let (has_position, params) = match item.command {
            16 => (true, [0.0, f32::from(p2 as u16), 0.0, 0.0]),
            17 => (true, [0.0, 0.0, sense, 0.0]),
            18 => (true, [f32::from(p1 as u8), 0.0, sense * f32::from(p3.abs() as u8), 0.0]),
            19 => (true, [f32::from(p1 as u16), 0.0, sense, 0.0]),
            20 | 21 => (true, [0.0; 4]),
            22 => (true, [f32::from(p1 as u16), 0.0, 0.0, 0.0]),
            177 => (false, [f32::from(p1 as u16), f32::from(p2 as i16), 0.0, 0.0]),
            178 => (false, [p1, p2, p3, 0.0]),
            115 => (false, [p1, p2, p3, p4]),
            _ => return None,
        };
        if has_position && !matches!(item.frame, 0 | 2 | 3) {
            return None;
        }
        let place = |degrees: f32| if has_position { (1.0e7_f32 * degrees) as i32 } else { 0 };
        Some(Self {
            id: item.command,
            params,
            has_position,
            lat_e7: place(item.x),
            lng_e7: place(item.y),
            alt_cm: if has_position { (item.z * 100.0_f32) as i32 } else { 0 },
            is_relative: has_position && item.frame == 3,
        })
    }

    fn item(&self, seq: u16, target: Address) -> MissionItemFloat {
        MissionItemFloat {
            target,
            seq,
            frame: if self.is_relative { 3 } else { 0 },
            command: self.id,
            current: 0,
            autocontinue: 1,
            params: self.params,
            x: if self.has_position { self.lat_e7 as f32 / 1.0e7_f32 } else { 0.0 },
            y: if self.has_position { self.lng_e7 as f32 / 1.0e7_f32 } else { 0.0 },
            z: if self.has_position { self.alt_cm as f32 / 100.0_f32 } else { 0.0 },
            mission_type: 0,
        }
    }
}

struct Receiving {
    from: Address,
    next: u16,
    count: u16,
    received: MonoTime,
    asked: MonoTime,
}

/// ArduPlane 3.x. It hears nothing that its firmware has no message for.
pub(crate) struct OldPlane {
    inbox: Vec<(Address, Message)>,
    out: VecDeque<Message>,
    next_tick: MonoTime,
    next_heartbeat: MonoTime,
    next_stream: MonoTime,
    receiving: Option<Receiving>,
    /// Its mission; item 0 is its own home, whatever is sent.
    pub mission: Vec<Stored>,
    pub params: Vec<(ParamName, f32)>,
    listing: Option<usize>,
    pub is_armed: bool,
    pub mode: u32,
    pub current: u16,
    /// Where it was told to go, and how high.
    pub guided: Option<Stored>,
    pub height: Option<Stored>,
    /// Streams that were asked for.
    pub streams: Vec<MavDataStream>,
    /// Everything that came, known to it or not.
    pub heard: Vec<Message>,
    /// Messages of this id that it does not get, and how many.
    pub deaf_to: (u32, usize),
    /// MISSION_ACKs that get lost.
    pub mute: usize,
    /// The last of the 3.x tell AUTOPILOT_VERSION when asked by the command of their time.
    pub has_version: bool,
}

impl OldPlane {
    pub(crate) fn new() -> Self {
        let name = |name: &str| ParamName::new(name).expect("a name");
        Self {
            inbox: Vec::new(),
            out: VecDeque::new(),
            next_tick: MonoTime::ZERO,
            next_heartbeat: MonoTime::from_millis(3),
            next_stream: MonoTime::from_millis(5),
            receiving: None,
            mission: vec![Stored::of(&home()).expect("home")],
            params: (0..37)
                .map(|n| (name(&format!("P{n}_TEST")), n as f32))
                .chain([(name("WP_LOITER_RAD"), 60.0), (name("TRIM_ARSPD_CM"), 1200.0)])
                .collect(),
            listing: None,
            is_armed: false,
            mode: 5,
            current: 0,
            guided: None,
            height: None,
            streams: Vec::new(),
            heard: Vec::new(),
            deaf_to: (0, 0),
            mute: 0,
            has_version: false,
        }
    }

    pub(crate) fn count_heard(&self, id: u32) -> usize {
        self.heard.iter().filter(|message| message.id() == id).count()
    }

    fn dialect(&mut self, message: MavMessage) {
        self.out.push_back(Message::Dialect(message));
    }

    fn ack(&mut self, to: Address, result: u8) {
        if self.mute > 0 {
            self.mute -= 1;
            return;
        }
        self.out.push_back(Message::MissionAck(MissionAck { target: to, result, mission_type: 0, opaque_id: 0 }));
    }

    #[allow(deprecated, reason = "it has no other")]
    fn ask(&mut self, now: MonoTime) {
        let Some(receiving) = &mut self.receiving else { return };
        receiving.asked = now;
        let (seq, to) = (receiving.next, receiving.from);
        self.dialect(MavMessage::MISSION_REQUEST(MISSION_REQUEST_DATA {
            seq,
            target_system: to.system.0,
            target_component: to.component.0,
            ..Default::default()
        }));
    }

    fn on_item(&mut self, from: Address, item: &MissionItemFloat, now: MonoTime) {
        let Some(stored) = Stored::of(item) else { return self.ack(from, 5) };
        match item.current {
            2 => {
                self.guided = Some(stored);
                self.mode = GUIDED;
                return self.ack(from, 0);
            }
            3 => {
                self.height = Some(stored);
                return self.ack(from, 0);
            }
            _ => {}
        }
        let Some(receiving) = &mut self.receiving else { return self.ack(from, 1) };
        if item.seq != receiving.next {
            return self.ack(from, 13);
        }
        let is_next = usize::from(item.seq) == self.mission.len();
        match self.mission.get_mut(usize::from(item.seq)) {
            // Home is its own.
            Some(_) if item.seq == 0 => {}
            Some(slot) => *slot = stored,
            None if item.seq == 0 => self.mission.push(Stored::of(&home()).expect("home")),
            None if is_next => self.mission.push(stored),
            None => return self.ack(from, 1),
        }
        receiving.received = now;
        receiving.next += 1;
        if receiving.next >= receiving.count {
            self.receiving = None;
            self.ack(from, 0);
        } else {
            self.ask(now);
        }
    }

    /// Executes a command; its `MAV_RESULT`.
    fn execute(&mut self, command: u16, p1: f32) -> u8 {
        match command {
            17 => self.mode = 12,
            20 => self.mode = 11,
            300 => self.mode = 10,
            400 => self.is_armed = p1 == 1.0,
            // MAV_MODE, not its own numbers.
            176 => match p1 as u16 {
                64 | 192 => self.mode = 0,
                92 | 220 => self.mode = 10,
                80 | 208 => self.mode = 5,
                _ => return 3,
            },
            189 => return 4,
            520 if self.has_version => self.dialect(MavMessage::AUTOPILOT_VERSION(AUTOPILOT_VERSION_DATA {
                capabilities: MavProtocolCapability::MAV_PROTOCOL_CAPABILITY_MISSION_FLOAT
                    | MavProtocolCapability::MAV_PROTOCOL_CAPABILITY_PARAM_FLOAT,
                flight_sw_version: 0x0304_00ff,
                ..Default::default()
            })),
            _ => return 3,
        }
        0
    }

    fn say_param(&mut self, index: usize, as_index: u16) {
        let (name, value) = self.params[index];
        let param_count = self.params.len() as u16;
        self.dialect(MavMessage::PARAM_VALUE(PARAM_VALUE_DATA {
            param_value: value,
            param_count,
            param_index: as_index,
            param_id: name.to_field().into(),
            param_type: MavParamType::MAV_PARAM_TYPE_REAL32,
        }));
    }

    fn find(&self, field: &[u8; 16]) -> Option<usize> {
        let name = ParamName::from_field(field)?;
        self.params.iter().position(|(known, _)| *known == name)
    }

    #[allow(deprecated, reason = "it has no other")]
    fn handle(&mut self, from: Address, message: &Message, now: MonoTime) {
        match message {
            Message::CommandLong(long) => {
                self.out.push_back(Message::StatusText(StatusText {
                    severity: 1,
                    text: "command received: ".into(),
                    id: 0,
                    chunk_seq: 0,
                }));
                let result = self.execute(long.command, long.params[0]);
                let target = Address::new(0, 0);
                let ack = CommandAck { command: long.command, result, progress: 0, result_param2: 0, target };
                self.out.push_back(Message::CommandAck(ack));
            }
            Message::MissionItemFloat(item) => self.on_item(from, item, now),
            Message::Dialect(message) => match message {
                MavMessage::SET_MODE(mode) => {
                    self.mode = mode.custom_mode;
                    let ack = CommandAck {
                        command: 11,
                        result: 0,
                        progress: 0,
                        result_param2: 0,
                        target: Address::new(0, 0),
                    };
                    self.out.push_back(Message::CommandAck(ack));
                }
                MavMessage::REQUEST_DATA_STREAM(request) => self.streams.push(request.req_stream_id),
                MavMessage::MISSION_COUNT(count) => {
                    self.mission.truncate(usize::from(count.count));
                    self.receiving = Some(Receiving { from, next: 0, count: count.count, received: now, asked: now });
                    self.ask(now);
                }
                MavMessage::MISSION_REQUEST_LIST(_) => {
                    self.receiving = None;
                    let count = self.mission.len() as u16;
                    self.dialect(MavMessage::MISSION_COUNT(MISSION_COUNT_DATA {
                        count,
                        target_system: from.system.0,
                        target_component: from.component.0,
                        ..Default::default()
                    }));
                }
                MavMessage::MISSION_REQUEST(request) => match self.mission.get(usize::from(request.seq)) {
                    Some(stored) => self.out.push_back(Message::MissionItemFloat(stored.item(request.seq, from))),
                    None => self.ack(from, 1),
                },
                MavMessage::MISSION_CLEAR_ALL(_) => {
                    self.mission.clear();
                    self.ack(from, 0);
                }
                MavMessage::MISSION_SET_CURRENT(set) if usize::from(set.seq) < self.mission.len() => {
                    self.current = set.seq;
                    self.say_current();
                }
                MavMessage::PARAM_REQUEST_LIST(_) => self.listing = Some(0),
                MavMessage::PARAM_REQUEST_READ(request) => {
                    let by_index = usize::try_from(request.param_index).ok().filter(|index| *index < self.params.len());
                    if let Some(index) = by_index.or_else(|| self.find(&request.param_id)) {
                        self.say_param(index, request.param_index as u16);
                    }
                }
                MavMessage::PARAM_SET(set) => {
                    if let Some(index) = self.find(&set.param_id) {
                        self.params[index].1 = set.param_value;
                        self.say_param(index, u16::MAX);
                    }
                }
                _ => {}
            },
            // MISSION_ITEM_INT, COMMAND_INT, …: messages that its firmware has not.
            _ => {}
        }
    }

    fn say_current(&mut self) {
        self.dialect(MavMessage::MISSION_CURRENT(MISSION_CURRENT_DATA { seq: self.current, ..Default::default() }));
    }
}

fn home() -> MissionItemFloat {
    MissionItemFloat {
        target: PLANE,
        seq: 0,
        frame: 0,
        command: 16,
        current: 0,
        autocontinue: 1,
        params: [0.0; 4],
        x: 40.3332,
        y: -3.7978,
        z: 600.09,
        mission_type: 0,
    }
}

impl Endpoint for OldPlane {
    fn receive(&mut self, from: Address, message: &Message, _now: MonoTime) {
        if self.deaf_to.0 == message.id() && self.deaf_to.1 > 0 {
            self.deaf_to.1 -= 1;
            return;
        }
        self.heard.push(message.clone());
        if message.target().includes(PLANE) {
            self.inbox.push((from, message.clone()));
        }
    }

    fn tick(&mut self, now: MonoTime) {
        self.next_tick = now + TICK;
        for (from, message) in std::mem::take(&mut self.inbox) {
            self.handle(from, &message, now);
        }
        if let Some(receiving) = &self.receiving {
            if now.since(receiving.received) > GIVE_UP {
                self.receiving = None;
            } else if now.since(receiving.asked) > ASK_AGAIN {
                self.ask(now);
            }
        }
        if now >= self.next_heartbeat {
            self.next_heartbeat = now + Duration::from_secs(1);
            let armed = if self.is_armed { Heartbeat::ARMED } else { 0 };
            self.out.push_back(Message::Heartbeat(Heartbeat {
                custom_mode: self.mode,
                mav_type: 1,
                autopilot: 3,
                base_mode: armed | Heartbeat::CUSTOM_MODE,
                system_status: 4,
                mavlink_version: 3,
            }));
        }
        if now >= self.next_stream {
            self.next_stream = now + Duration::from_millis(100);
            if let Some(next) = self.listing {
                let end = (next + PARAMS_AT_ONCE).min(self.params.len());
                (next..end).for_each(|index| self.say_param(index, index as u16));
                self.listing = (end < self.params.len()).then_some(end);
            }
            if !self.streams.is_empty() {
                let time_boot_ms = now.as_duration().as_millis() as u32;
                self.dialect(MavMessage::ATTITUDE(ATTITUDE_DATA { time_boot_ms, ..Default::default() }));
                self.dialect(MavMessage::GLOBAL_POSITION_INT(GLOBAL_POSITION_INT_DATA {
                    time_boot_ms,
                    lat: 403_332_000,
                    lon: -37_978_000,
                    alt: 600_090,
                    ..Default::default()
                }));
                self.say_current();
            }
        }
    }

    fn wakes_at(&self) -> Option<MonoTime> {
        Some(self.next_tick)
    }

    fn next_output(&mut self) -> Option<Message> {
        self.out.pop_front()
    }
}
