//! Links and their traffic counters.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// State of a link.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum LinkState {
    /// Being opened.
    Connecting,
    /// Open; data may not have arrived yet.
    Up,
    /// Closed.
    Down,
    /// A recording that has been played to its end.
    Ended,
}

/// Why a link is not up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum LinkFault {
    /// Another program already listens on that address.
    AddressInUse,
    /// The server's machine does not have that address, so it cannot listen there.
    NotOurAddress,
    /// The operating system denies access to the port.
    NoPermission,
    /// The operating system denies access to the serial port: on Linux, the user is not in its group, mostly `dialout`.
    NoSerialPermission,
    /// There is no such serial port.
    NoSerialPort,
    /// Another program uses the serial port.
    SerialPortInUse,
    /// The serial port does not support that baud rate.
    NoBaudRate,
    /// The host name cannot be resolved.
    NoHost,
    /// The host is reachable, but nothing listens on the port.
    Refused,
    /// The host did not answer in time.
    NoAnswer,
    /// The other end closed the connection.
    ClosedByPeer,
    /// Another fault, described by `detail` only.
    Other,
}

/// A link and its traffic counters.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct LinkInfo {
    /// Id of the link.
    pub id: u32,
    /// Name of the link.
    pub name: String,
    /// Its link string.
    pub address: String,
    /// Address and port of its own socket; null while it is not up.
    #[schema(required = true)]
    pub local_address: Option<String>,
    /// State of the link.
    pub state: LinkState,
    /// Why it is not up; null when there is no fault.
    #[schema(required = true)]
    pub fault: Option<LinkFault>,
    /// The fault in English.
    #[schema(required = true)]
    pub detail: Option<String>,
    /// Whether frames are forwarded between this link and the others.
    pub forward: bool,
    /// Frames received.
    pub frames_received: u64,
    /// Frames sent.
    pub frames_sent: u64,
    /// Bytes received.
    pub bytes_received: u64,
    /// Bytes sent.
    pub bytes_sent: u64,
    /// Frames with a wrong checksum.
    pub bad_crc: u64,
    /// Bytes outside of any frame.
    pub garbage_bytes: u64,
    /// Frames discarded because their signature was missing, wrong or not newer than the last.
    pub frames_refused: u64,
    /// Whether unsigned frames of vehicles that must sign are accepted on this link.
    pub accepts_unsigned: bool,
    /// Frames missing according to the senders' sequence numbers.
    pub frames_lost: u64,
    /// Share of all frames that were lost, percent.
    #[schema(required = true)]
    pub loss_pct: Option<f64>,
    /// Round-trip time of the newest TIMESYNC exchange.
    #[schema(required = true)]
    pub round_trip_ms: Option<f64>,
    /// Time since the newest frame.
    #[schema(required = true)]
    pub age_s: Option<f64>,
    /// Recent rate of received frames.
    pub frames_per_s: f64,
    /// Where on this link another station with our own MAVLink address is heard; null when there is none.
    #[schema(required = true)]
    pub namesake: Option<String>,
    /// Share of recent frames that were lost, percent.
    #[schema(required = true)]
    pub recent_loss_pct: Option<f64>,
}

/// A serial port of the server's machine.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct SerialPort {
    /// Its device: `/dev/ttyUSB0`, `COM3`.
    pub device: String,
    /// A name that stays when the number of the device changes, in `/dev/serial/by-id`; null when there is none.
    #[schema(required = true)]
    pub lasting_path: Option<String>,
    /// Manufacturer and product, as a USB device says; null for another.
    #[schema(required = true)]
    pub description: Option<String>,
    /// Usual rate of such a port, baud: 115200 for an autopilot's own USB, 57600 for an adapter, behind which is mostly
    /// a radio, 921600 for a port of the machine's own.
    pub usual_baud: u32,
    /// Id of the link that is on it; null when there is none.
    #[schema(required = true)]
    pub link: Option<u32>,
    /// Whether a program has locked it, the server included. Only Linux tells, and not every program locks.
    pub is_in_use: bool,
    /// Whether the server may open it: on Linux, its user must be in the port's group, mostly `dialout`.
    pub is_allowed: bool,
}

/// The network of a fleet, over which remote vehicles are heard.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct FleetNetwork {
    /// Name of the fleet.
    pub name: String,
    /// Why its vehicles are not heard here, in English; null while all is well.
    #[schema(required = true)]
    pub problem: Option<String>,
}

/// A link to open.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct NewLink {
    /// Link string, such as `udpin:0.0.0.0:14550`.
    #[schema(max_length = 256)]
    pub address: String,
    /// Whether frames are forwarded between this link and the others, for another ground station.
    #[serde(default)]
    pub forward: bool,
    /// Display name; the link string when absent.
    #[serde(default)]
    pub name: Option<String>,
    /// Whether unsigned frames of a vehicle that must sign are accepted. When absent, the address decides: yes for USB
    /// and loopback.
    pub accept_unsigned: Option<bool>,
}
