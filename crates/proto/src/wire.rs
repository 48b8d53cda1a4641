//! Messages kept with raw numbers instead of the dialect's enums.
//!
//! A newer autopilot may use a command, a result or a vehicle type that this dialect does not name yet. The generated
//! decoder refuses such a message whole; for these few, on which flight depends, the number is kept as it is
//! (`docs/adr/0003`). Field order is that of mavlink.io's definitions: by size, then as written, extensions last.

use crate::ids::Address;

/// Reads little-endian fields in order; what MAVLink 2 cut off the end reads as zero.
struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn take<const N: usize>(&mut self) -> [u8; N] {
        let mut field = [0u8; N];
        let have = self.0.len().min(N);
        field[..have].copy_from_slice(&self.0[..have]);
        self.0 = &self.0[have..];
        field
    }

    fn u8(&mut self) -> u8 {
        u8::from_le_bytes(self.take())
    }

    fn u16(&mut self) -> u16 {
        u16::from_le_bytes(self.take())
    }

    fn u32(&mut self) -> u32 {
        u32::from_le_bytes(self.take())
    }

    fn i32(&mut self) -> i32 {
        i32::from_le_bytes(self.take())
    }

    fn f32(&mut self) -> f32 {
        f32::from_le_bytes(self.take())
    }

    fn f32s<const N: usize>(&mut self) -> [f32; N] {
        std::array::from_fn(|_| self.f32())
    }

    fn address(&mut self) -> Address {
        Address::new(self.u8(), self.u8())
    }
}

/// Writes little-endian fields in order into a payload.
pub(crate) struct Writer<'a> {
    payload: &'a mut [u8; 255],
    len: usize,
}

impl<'a> Writer<'a> {
    pub(crate) fn new(payload: &'a mut [u8; 255]) -> Self {
        Self { payload, len: 0 }
    }

    pub(crate) fn len(&self) -> usize {
        self.len
    }

    fn put(&mut self, bytes: &[u8]) -> &mut Self {
        self.payload[self.len..self.len + bytes.len()].copy_from_slice(bytes);
        self.len += bytes.len();
        self
    }

    fn u8(&mut self, value: u8) -> &mut Self {
        self.put(&[value])
    }

    fn u16(&mut self, value: u16) -> &mut Self {
        self.put(&value.to_le_bytes())
    }

    fn u32(&mut self, value: u32) -> &mut Self {
        self.put(&value.to_le_bytes())
    }

    fn i32(&mut self, value: i32) -> &mut Self {
        self.put(&value.to_le_bytes())
    }

    fn f32(&mut self, value: f32) -> &mut Self {
        self.put(&value.to_le_bytes())
    }

    fn f32s(&mut self, values: &[f32]) -> &mut Self {
        for value in values {
            self.f32(*value);
        }
        self
    }

    fn address(&mut self, address: Address) -> &mut Self {
        self.u8(address.system.0).u8(address.component.0)
    }
}

/// A message of this module: its id, and its payload both ways.
pub(crate) trait Wire: Sized {
    const ID: u32;
    const NAME: &'static str;
    /// Length without extension fields: what MAVLink 1 sends.
    const BASE_LEN: usize;
    fn read(payload: &[u8]) -> Self;
    fn write(&self, payload: &mut Writer<'_>);
}

/// HEARTBEAT (0): type, mode and state of the sender.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Heartbeat {
    /// The mode's number, in the autopilot's own counting.
    pub custom_mode: u32,
    /// `MAV_TYPE`: 1 is a fixed-wing plane, 6 a ground station.
    pub mav_type: u8,
    /// `MAV_AUTOPILOT`: 3 is ArduPilot, 12 is PX4, 8 is "not an autopilot".
    pub autopilot: u8,
    /// `MAV_MODE_FLAG` bits; 0x80 is "armed".
    pub base_mode: u8,
    /// `MAV_STATE`.
    pub system_status: u8,
    /// The protocol's minor version, 3.
    pub mavlink_version: u8,
}

impl Heartbeat {
    /// `MAV_MODE_FLAG_SAFETY_ARMED`.
    pub const ARMED: u8 = 0x80;
    /// `MAV_MODE_FLAG_CUSTOM_MODE_ENABLED`.
    pub const CUSTOM_MODE: u8 = 0x01;

    /// Whether the sender says that it is armed.
    pub fn is_armed(&self) -> bool {
        self.base_mode & Self::ARMED != 0
    }
}

impl Default for Heartbeat {
    /// The heartbeat of a ground station: `MAV_TYPE_GCS`, `MAV_AUTOPILOT_INVALID`, `MAV_STATE_ACTIVE`.
    fn default() -> Self {
        Self { custom_mode: 0, mav_type: 6, autopilot: 8, base_mode: 0, system_status: 4, mavlink_version: 3 }
    }
}

impl Wire for Heartbeat {
    const ID: u32 = 0;
    const NAME: &'static str = "HEARTBEAT";
    const BASE_LEN: usize = 9;

    fn read(payload: &[u8]) -> Self {
        let mut r = Reader(payload);
        Self {
            custom_mode: r.u32(),
            mav_type: r.u8(),
            autopilot: r.u8(),
            base_mode: r.u8(),
            system_status: r.u8(),
            mavlink_version: r.u8(),
        }
    }

    fn write(&self, w: &mut Writer<'_>) {
        w.u32(self.custom_mode)
            .u8(self.mav_type)
            .u8(self.autopilot)
            .u8(self.base_mode)
            .u8(self.system_status)
            .u8(self.mavlink_version);
    }
}

/// COMMAND_LONG (76): a command with seven float parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CommandLong {
    /// The addressee.
    pub target: Address,
    /// `MAV_CMD`.
    pub command: u16,
    /// 0 for the first transmission, one more for each repetition.
    pub confirmation: u8,
    /// Parameters 1 to 7, with the meaning that the command gives them.
    pub params: [f32; 7],
}

impl Wire for CommandLong {
    const ID: u32 = 76;
    const NAME: &'static str = "COMMAND_LONG";
    const BASE_LEN: usize = 33;

    fn read(payload: &[u8]) -> Self {
        let mut r = Reader(payload);
        let params = r.f32s();
        let command = r.u16();
        Self { params, command, target: r.address(), confirmation: r.u8() }
    }

    fn write(&self, w: &mut Writer<'_>) {
        w.f32s(&self.params).u16(self.command).address(self.target).u8(self.confirmation);
    }
}

/// COMMAND_INT (75): a command with a position as scaled integers and an explicit frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CommandInt {
    /// The addressee.
    pub target: Address,
    /// `MAV_FRAME` of x, y and z.
    pub frame: u8,
    /// `MAV_CMD`.
    pub command: u16,
    /// Not used.
    pub current: u8,
    /// Not used.
    pub autocontinue: u8,
    /// Parameters 1 to 4.
    pub params: [f32; 4],
    /// Parameter 5: latitude in degE7 in a global frame.
    pub x: i32,
    /// Parameter 6: longitude in degE7 in a global frame.
    pub y: i32,
    /// Parameter 7: altitude in metres, by the frame.
    pub z: f32,
}

impl Wire for CommandInt {
    const ID: u32 = 75;
    const NAME: &'static str = "COMMAND_INT";
    const BASE_LEN: usize = 35;

    fn read(payload: &[u8]) -> Self {
        let mut r = Reader(payload);
        let (params, x, y, z, command) = (r.f32s(), r.i32(), r.i32(), r.f32(), r.u16());
        let target = r.address();
        Self { params, x, y, z, command, target, frame: r.u8(), current: r.u8(), autocontinue: r.u8() }
    }

    fn write(&self, w: &mut Writer<'_>) {
        w.f32s(&self.params)
            .i32(self.x)
            .i32(self.y)
            .f32(self.z)
            .u16(self.command)
            .address(self.target)
            .u8(self.frame)
            .u8(self.current)
            .u8(self.autocontinue);
    }
}

/// COMMAND_ACK (77): the result of a command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CommandAck {
    /// `MAV_CMD` of the command.
    pub command: u16,
    /// `MAV_RESULT`.
    pub result: u8,
    /// Progress in per cent while the result is "in progress"; 255 is "unknown". Zero in MAVLink 1.
    pub progress: u8,
    /// Additional result, by the command.
    pub result_param2: i32,
    /// The sender of the command; 0/0 where the autopilot does not give it.
    pub target: Address,
}

impl Wire for CommandAck {
    const ID: u32 = 77;
    const NAME: &'static str = "COMMAND_ACK";
    const BASE_LEN: usize = 3;

    fn read(payload: &[u8]) -> Self {
        let mut r = Reader(payload);
        Self { command: r.u16(), result: r.u8(), progress: r.u8(), result_param2: r.i32(), target: r.address() }
    }

    fn write(&self, w: &mut Writer<'_>) {
        w.u16(self.command).u8(self.result).u8(self.progress).i32(self.result_param2).address(self.target);
    }
}

/// MISSION_ITEM_INT (73): one item of a mission, fence or rally list.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MissionItemInt {
    /// The addressee.
    pub target: Address,
    /// Position in the list.
    pub seq: u16,
    /// `MAV_FRAME` of x, y and z.
    pub frame: u8,
    /// `MAV_CMD`.
    pub command: u16,
    /// 1 when it is the item in execution; ArduPilot uses 2 and 3 for guided targets.
    pub current: u8,
    /// Whether to go on to the next item by itself.
    pub autocontinue: u8,
    /// Parameters 1 to 4.
    pub params: [f32; 4],
    /// Parameter 5: latitude in degE7 when the command has a position.
    pub x: i32,
    /// Parameter 6: longitude in degE7 when the command has a position.
    pub y: i32,
    /// Parameter 7: altitude in metres, by the frame, when the command has a position.
    pub z: f32,
    /// `MAV_MISSION_TYPE`: 0 mission, 1 fence, 2 rally.
    pub mission_type: u8,
}

impl Wire for MissionItemInt {
    const ID: u32 = 73;
    const NAME: &'static str = "MISSION_ITEM_INT";
    const BASE_LEN: usize = 37;

    fn read(payload: &[u8]) -> Self {
        let mut r = Reader(payload);
        let (params, x, y, z, seq, command) = (r.f32s(), r.i32(), r.i32(), r.f32(), r.u16(), r.u16());
        let target = r.address();
        let (frame, current, autocontinue, mission_type) = (r.u8(), r.u8(), r.u8(), r.u8());
        Self { target, seq, frame, command, current, autocontinue, params, x, y, z, mission_type }
    }

    fn write(&self, w: &mut Writer<'_>) {
        w.f32s(&self.params)
            .i32(self.x)
            .i32(self.y)
            .f32(self.z)
            .u16(self.seq)
            .u16(self.command)
            .address(self.target)
            .u8(self.frame)
            .u8(self.current)
            .u8(self.autocontinue)
            .u8(self.mission_type);
    }
}

impl MissionItemInt {
    /// Length of an item packed without cutting zeros, as in a MAVFTP plan file.
    pub const PACKED_LEN: usize = 38;

    /// Reads an item from a payload; missing bytes at the end read as zero.
    pub fn from_payload(payload: &[u8]) -> Self {
        Self::read(payload)
    }

    /// The whole payload, no zeros cut.
    pub fn to_packed(&self) -> [u8; Self::PACKED_LEN] {
        let mut payload = [0u8; 255];
        self.write(&mut Writer::new(&mut payload));
        let mut packed = [0u8; Self::PACKED_LEN];
        packed.copy_from_slice(&payload[..Self::PACKED_LEN]);
        packed
    }
}

/// MISSION_ITEM (39): one item of a mission with its position as 32-bit floats, for autopilots from before
/// MISSION_ITEM_INT. A float has 24 bits: degrees are off by up to 0.2 m at latitude 40°, 0.8 m at longitude 180°.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MissionItemFloat {
    /// The addressee.
    pub target: Address,
    /// Position in the list.
    pub seq: u16,
    /// `MAV_FRAME` of x, y and z.
    pub frame: u8,
    /// `MAV_CMD`.
    pub command: u16,
    /// 1 when it is the item in execution; for ArduPilot 2 is a guided target and 3 a guided change of height.
    pub current: u8,
    /// Whether to go on to the next item by itself.
    pub autocontinue: u8,
    /// Parameters 1 to 4.
    pub params: [f32; 4],
    /// Parameter 5: latitude in degrees when the command has a position.
    pub x: f32,
    /// Parameter 6: longitude in degrees when the command has a position.
    pub y: f32,
    /// Parameter 7: altitude in metres, by the frame, when the command has a position.
    pub z: f32,
    /// `MAV_MISSION_TYPE`: 0 mission, 1 fence, 2 rally. MAVLink 1 does not carry it.
    pub mission_type: u8,
}

impl Wire for MissionItemFloat {
    const ID: u32 = 39;
    const NAME: &'static str = "MISSION_ITEM";
    const BASE_LEN: usize = 37;

    fn read(payload: &[u8]) -> Self {
        let mut r = Reader(payload);
        let (params, x, y, z, seq, command) = (r.f32s(), r.f32(), r.f32(), r.f32(), r.u16(), r.u16());
        let target = r.address();
        let (frame, current, autocontinue, mission_type) = (r.u8(), r.u8(), r.u8(), r.u8());
        Self { target, seq, frame, command, current, autocontinue, params, x, y, z, mission_type }
    }

    fn write(&self, w: &mut Writer<'_>) {
        w.f32s(&self.params)
            .f32(self.x)
            .f32(self.y)
            .f32(self.z)
            .u16(self.seq)
            .u16(self.command)
            .address(self.target)
            .u8(self.frame)
            .u8(self.current)
            .u8(self.autocontinue)
            .u8(self.mission_type);
    }
}

/// MISSION_ACK (47): how a plan transfer ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MissionAck {
    /// The station of the transfer.
    pub target: Address,
    /// `MAV_MISSION_RESULT`.
    pub result: u8,
    /// `MAV_MISSION_TYPE`.
    pub mission_type: u8,
    /// The id that the autopilot gives to the plan it holds; 0 where it has none (ArduPilot).
    pub opaque_id: u32,
}

impl Wire for MissionAck {
    const ID: u32 = 47;
    const NAME: &'static str = "MISSION_ACK";
    const BASE_LEN: usize = 3;

    fn read(payload: &[u8]) -> Self {
        let mut r = Reader(payload);
        Self { target: r.address(), result: r.u8(), mission_type: r.u8(), opaque_id: r.u32() }
    }

    fn write(&self, w: &mut Writer<'_>) {
        w.address(self.target).u8(self.result).u8(self.mission_type).u32(self.opaque_id);
    }
}

/// STATUSTEXT (253): a text for people, at most 50 bytes a chunk.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StatusText {
    /// `MAV_SEVERITY`: 0 emergency to 7 debug.
    pub severity: u8,
    /// The text of this chunk, without trailing zeros; bytes that are not UTF-8 are replaced.
    pub text: String,
    /// Chunks with the same id belong together; 0 when the text is whole.
    pub id: u16,
    /// The chunk's place.
    pub chunk_seq: u8,
}

impl StatusText {
    /// Bytes of text in one chunk.
    pub const TEXT_LEN: usize = 50;
}

impl Wire for StatusText {
    const ID: u32 = 253;
    const NAME: &'static str = "STATUSTEXT";
    const BASE_LEN: usize = 51;

    fn read(payload: &[u8]) -> Self {
        let mut r = Reader(payload);
        let severity = r.u8();
        let text: [u8; Self::TEXT_LEN] = r.take();
        let end = text.iter().position(|byte| *byte == 0).unwrap_or(text.len());
        Self { severity, text: String::from_utf8_lossy(&text[..end]).into_owned(), id: r.u16(), chunk_seq: r.u8() }
    }

    fn write(&self, w: &mut Writer<'_>) {
        let mut text = [0u8; Self::TEXT_LEN];
        let have = self.text.len().min(Self::TEXT_LEN);
        text[..have].copy_from_slice(&self.text.as_bytes()[..have]);
        w.u8(self.severity).put(&text).u16(self.id).u8(self.chunk_seq);
    }
}
