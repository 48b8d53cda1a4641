//! Links, and what went over them.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// State of a link.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum LinkState {
    /// On its way up.
    Connecting,
    /// Open; nobody needs to have spoken yet.
    Up,
    /// Closed.
    Down,
    /// A recording that was played to its end.
    Ended,
}

/// Why a link is not up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum LinkFault {
    /// Another program listens at that place.
    AddressInUse,
    /// To listen there, the server's machine would have to have that address.
    NotOurAddress,
    /// The system does not let the server.
    NoPermission,
    /// There is no such serial port.
    NoSerialPort,
    /// Another program uses the serial port.
    SerialPortInUse,
    /// The serial port does not have that baud rate.
    NoBaudRate,
    /// Nothing has that name.
    NoHost,
    /// That machine is there, and nothing listens at the port.
    Refused,
    /// No answer came in time.
    NoAnswer,
    /// The other end closed the connection.
    ClosedByPeer,
    /// Another one, which the detail alone tells.
    Other,
}

/// A link and what went over it.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct LinkInfo {
    /// Its id.
    pub id: u32,
    /// Its name.
    pub name: String,
    /// Its link string.
    pub address: String,
    /// Address and port of its own socket while it is up.
    #[schema(required = true)]
    pub local_address: Option<String>,
    /// Its state.
    pub state: LinkState,
    /// Why it is not up, where something went wrong.
    #[schema(required = true)]
    pub fault: Option<LinkFault>,
    /// The same in words.
    #[schema(required = true)]
    pub detail: Option<String>,
    /// Whether frames between it and the other links are passed on.
    pub forward: bool,
    /// Frames that came in.
    pub frames_received: u64,
    /// Frames that went out.
    pub frames_sent: u64,
    /// Bytes that came in.
    pub bytes_received: u64,
    /// Bytes that went out.
    pub bytes_sent: u64,
    /// Frames with a wrong checksum.
    pub bad_crc: u64,
    /// Bytes that belonged to no frame.
    pub garbage_bytes: u64,
    /// Frames that went nowhere because their signature was missing, wrong or not new.
    pub frames_refused: u64,
    /// Whether frames that should be signed and are not are believed there.
    pub accepts_unsigned: bool,
    /// Frames missing by the senders' counters.
    pub frames_lost: u64,
    /// Share of all frames that were lost.
    #[schema(required = true)]
    pub loss_pct: Option<f64>,
    /// Round trip of the newest TIMESYNC exchange.
    #[schema(required = true)]
    pub round_trip_ms: Option<f64>,
    /// Time since the newest frame.
    #[schema(required = true)]
    pub age_s: Option<f64>,
    /// Frames per second lately.
    pub frames_per_s: f64,
    /// Where on this link another station is heard that uses our own MAVLink address.
    #[schema(required = true)]
    pub namesake: Option<String>,
    /// Share of the frames that were lost lately.
    #[schema(required = true)]
    pub recent_loss_pct: Option<f64>,
}

/// A link to open.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct NewLink {
    /// Link string, such as `udpin:0.0.0.0:14550`.
    #[schema(max_length = 256)]
    pub address: String,
    /// Whether to pass frames on between it and the other links, for another ground station.
    #[serde(default)]
    pub forward: bool,
    /// Name to show; the link string when absent.
    #[serde(default)]
    pub name: Option<String>,
    /// Whether a vehicle that has to sign is believed there without; by its address when absent: USB and this machine are.
    pub accept_unsigned: Option<bool>,
}
