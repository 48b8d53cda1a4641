//! Parsed link addresses and the errors of link strings.

use std::fmt;
use std::path::PathBuf;

/// UDP port of a ground station when the link string has none.
pub const DEFAULT_UDP_PORT: u16 = 14550;
/// TCP port of a simulator when the link string has none.
pub const DEFAULT_TCP_PORT: u16 = 5760;
/// Baud rate of a USB device (`ttyACM*`), where the figure does not change the speed.
pub const DEFAULT_USB_BAUD: u32 = 115_200;
/// Baud rate of anything else, the usual rate of telemetry radios.
pub const DEFAULT_BAUD: u32 = 57_600;

/// A host (name, IPv4 or IPv6 address) and a port.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct HostPort {
    /// Name or address, an IPv6 address without its brackets.
    pub host: String,
    /// Port; 0 lets the system choose one, for listening links only.
    pub port: u16,
}

impl HostPort {
    /// `host` and `port` as they are.
    pub fn new(host: impl Into<String>, port: u16) -> Self {
        Self { host: host.into(), port }
    }

    /// Whether it is `lan`: this machine and the private networks that it is in.
    pub(crate) fn is_lan(&self) -> bool {
        self.host.eq_ignore_ascii_case("lan")
    }

    /// Whether the host is a loopback name or address.
    pub(super) fn is_loopback(&self) -> bool {
        self.host == "localhost" || self.host.parse::<std::net::IpAddr>().is_ok_and(|address| address.is_loopback())
    }
}

impl fmt::Display for HostPort {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.host.contains(':') {
            write!(f, "[{}]:{}", self.host, self.port)
        } else {
            write!(f, "{}:{}", self.host, self.port)
        }
    }
}

/// Where a link goes. [`Display`](fmt::Display) writes the canonical link string, which parses back to the same value.
#[derive(Debug, Clone, PartialEq)]
pub enum LinkAddress {
    /// Listens on UDP, and answers everyone who has spoken MAVLink to it lately.
    UdpIn {
        /// Where to listen.
        bind: HostPort,
    },
    /// Sends UDP to one address and receives from it alone; with `bind`, listens there too.
    UdpOut {
        /// Where to send.
        remote: HostPort,
        /// Our own end, when it matters (MAVROS: `udp://bind:port@host:port`). Peers that send to it are answered.
        bind: Option<HostPort>,
    },
    /// Sends UDP to a broadcast address until a peer answers, then to that peer.
    UdpBroadcast {
        /// The broadcast address and port.
        remote: HostPort,
    },
    /// Connects to a TCP server.
    TcpClient {
        /// The server.
        remote: HostPort,
    },
    /// Listens for TCP clients.
    TcpServer {
        /// Where to listen.
        bind: HostPort,
    },
    /// Opens a serial port exclusively.
    Serial {
        /// Device: `/dev/ttyACM0`, `COM3`.
        path: String,
        /// Bits per second.
        baud: u32,
    },
    /// Replays a recording.
    Tlog {
        /// The file.
        path: PathBuf,
        /// Times the recorded pace, 0.01 to 10,000; 1 by default.
        speed: f64,
        /// Starts again at the end instead of ending.
        repeat: bool,
    },
}

/// Why a text is not a link string. Each message says what was wrong and shows the right form.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum AddressError {
    /// The text is empty.
    #[error(
        "the link string is empty; write for example `udpin:0.0.0.0:14550`, `tcp:127.0.0.1:5760` or `/dev/ttyACM0,115200`"
    )]
    Empty,
    /// The word before the colon is not a kind of link.
    #[error("`{scheme}` in `{text}` is not a kind of link{}; kinds are udpin, udpout, udpbcast, tcp, tcpin, serial and tlog, as in `udpin:0.0.0.0:14550`",
        .suggestion.as_ref().map_or(String::new(), |s| format!(", did you mean `{s}`?")))]
    UnknownScheme {
        /// The whole text.
        text: String,
        /// What stood before the colon.
        scheme: String,
        /// The nearest link string that makes sense.
        suggestion: Option<String>,
    },
    /// A kind of link that other programs have and this one does not.
    #[error("`{scheme}` links are not supported; {instead}")]
    Unsupported {
        /// The kind.
        scheme: String,
        /// What to do instead.
        instead: &'static str,
    },
    /// A host is needed there.
    #[error("`{text}` names no host; write `{example}`")]
    MissingHost {
        /// The whole text.
        text: String,
        /// A valid link string of that kind.
        example: &'static str,
    },
    /// Not a host name or address.
    #[error("`{host}` in `{text}` is not a host name or address; write `{example}`{}", if .host.contains(':') { " (an IPv6 address goes in brackets: `[::1]:14550`)" } else { "" })]
    BadHost {
        /// The whole text.
        text: String,
        /// The part that was wrong.
        host: String,
        /// A valid link string of that kind.
        example: &'static str,
    },
    /// Not a port number.
    #[error("`{port}` in `{text}` is not a port from {lowest} to 65535; write `{example}`")]
    BadPort {
        /// The whole text.
        text: String,
        /// The part that was wrong.
        port: String,
        /// 0 for listening links, otherwise 1.
        lowest: u16,
        /// A valid link string of that kind.
        example: &'static str,
    },
    /// No device or file name.
    #[error("`{text}` names no {what}; write `{example}`")]
    MissingPath {
        /// The whole text.
        text: String,
        /// "device" or "file".
        what: &'static str,
        /// A valid link string of that kind.
        example: &'static str,
    },
    /// Not a baud rate.
    #[error("`{baud}` in `{text}` is not a baud rate from 300 to 12000000; write `/dev/ttyUSB0,57600`")]
    BadBaud {
        /// The whole text.
        text: String,
        /// The part that was wrong.
        baud: String,
    },
    /// Not an option of that kind of link.
    #[error("`{option}` in `{text}` is not an option of this link; {hint}")]
    BadOption {
        /// The whole text.
        text: String,
        /// The part that was wrong.
        option: String,
        /// What would be right.
        hint: &'static str,
    },
}
