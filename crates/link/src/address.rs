//! Owns link strings: one parser for every spelling that the MAVLink family uses, and the canonical spelling of each.
//!
//! | family | accepted |
//! |---|---|
//! | pymavlink, MAVProxy, DroneKit | `udp:` `udpin:` `udpout:` `udpbcast:` `tcp:` `tcpin:` + `host:port`; `/dev/ttyACM0[,57600]`, `com14`; bare `127.0.0.1:14550`; a file that ends in `.tlog` |
//! | MAVSDK | `udpin://` `udpout://` `tcpin://` `tcpout://` `serial:///dev/ttyUSB0:57600`; old `udp://:14540` |
//! | MAVROS | `udp://[bind]:14555@[host]:14550`, `tcp://`, `tcp-l://`, `serial:///dev/x:57600?ids=s,c` |
//! | mavlink-server | `udpserver://` `udpclient://` `tcpserver://` `tcpclient://` `tlogreader://` |
//!
//! What may be left out: the port (UDP 14550, TCP 5760), the host of a listening UDP link (`0.0.0.0`, so that aircraft
//! reach it; `lan` there hears this machine and private networks and nobody else), the host of a TCP server (`127.0.0.1`: a server is open to the network only when told so) and the baud
//! rate (115200 for a USB device such as `ttyACM0`, otherwise 57600, the rate of telemetry radios).

use std::fmt;
use std::net::Ipv6Addr;
use std::path::PathBuf;
use std::str::FromStr;

use vencejo_proto::Address;

/// UDP port of a ground station when the link string has none.
pub const DEFAULT_UDP_PORT: u16 = 14550;
/// TCP port of a simulator when the link string has none.
pub const DEFAULT_TCP_PORT: u16 = 5760;
/// Baud rate of a USB device (`ttyACM*`), where the figure does not change the speed.
pub const DEFAULT_USB_BAUD: u32 = 115_200;
/// Baud rate of anything else, the usual rate of telemetry radios.
pub const DEFAULT_BAUD: u32 = 57_600;

const BAUD_RANGE: std::ops::RangeInclusive<u32> = 300..=12_000_000;
const SPEED_RANGE: std::ops::RangeInclusive<f64> = 0.01..=10_000.0;

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

    /// Whether it stands for this machine and the private networks that it is in: `lan`.
    pub(crate) fn is_lan(&self) -> bool {
        self.host.eq_ignore_ascii_case("lan")
    }

    /// Whether the host is this machine, as far as its name tells.
    fn is_loopback(&self) -> bool {
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
    /// Sends UDP to one place and hears only that place; or, with `bind`, listens there too.
    UdpOut {
        /// Where to send.
        remote: HostPort,
        /// Our own end, when it matters (MAVROS: `udp://bind:port@host:port`). Whoever speaks to it is answered.
        bind: Option<HostPort>,
    },
    /// Sends UDP to a broadcast address until somebody answers, then to that peer.
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
    /// Opens a serial port for itself alone.
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
    /// Nothing there.
    #[error(
        "the link string is empty; write for example `udpin:0.0.0.0:14550`, `tcp:127.0.0.1:5760` or `/dev/ttyACM0,115200`"
    )]
    Empty,
    /// The word before the colon is no kind of link.
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
    /// A kind of link that others have and we do not.
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
        /// A right one of that kind.
        example: &'static str,
    },
    /// Not a host name or address.
    #[error("`{host}` in `{text}` is not a host name or address; write `{example}`{}", if .host.contains(':') { " (an IPv6 address goes in brackets: `[::1]:14550`)" } else { "" })]
    BadHost {
        /// The whole text.
        text: String,
        /// The part that was wrong.
        host: String,
        /// A right one of that kind.
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
        /// A right one of that kind.
        example: &'static str,
    },
    /// No device or file name.
    #[error("`{text}` names no {what}; write `{example}`")]
    MissingPath {
        /// The whole text.
        text: String,
        /// "device" or "file".
        what: &'static str,
        /// A right one of that kind.
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

/// The kinds of link, each with all its spellings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    UdpIn,
    UdpOut,
    UdpBroadcast,
    TcpClient,
    TcpServer,
    Serial,
    Tlog,
}

const SCHEMES: &[(&str, Kind)] = &[
    ("udpin", Kind::UdpIn),
    ("udp", Kind::UdpIn),
    ("udpserver", Kind::UdpIn),
    ("udps", Kind::UdpIn),
    ("udpout", Kind::UdpOut),
    ("udpclient", Kind::UdpOut),
    ("udpc", Kind::UdpOut),
    ("udpbcast", Kind::UdpBroadcast),
    ("tcp", Kind::TcpClient),
    ("tcpout", Kind::TcpClient),
    ("tcpclient", Kind::TcpClient),
    ("tcpc", Kind::TcpClient),
    ("tcpin", Kind::TcpServer),
    ("tcp-l", Kind::TcpServer),
    ("tcpserver", Kind::TcpServer),
    ("tcps", Kind::TcpServer),
    ("serial", Kind::Serial),
    ("tlog", Kind::Tlog),
    ("tlogreader", Kind::Tlog),
];

const UNSUPPORTED: &[(&str, &str)] = &[
    ("mcast", "listen for a single sender instead: `udpin:0.0.0.0:14550`"),
    ("ws", "use `tcp:host:5760`"),
    ("wsserver", "use `tcpin:127.0.0.1:5760`"),
    ("zenoh", "use `udpin:0.0.0.0:14550`"),
    ("serial-hwfc", "use `serial:/dev/ttyUSB0:57600` (hardware flow control is not used)"),
    ("serial_flowcontrol", "use `serial:/dev/ttyUSB0:57600` (hardware flow control is not used)"),
    ("udp-b", "use `udpbcast:192.168.1.255:14550`"),
    ("udp-pb", "use `udpbcast:192.168.1.255:14550`"),
];

impl Kind {
    const fn example(self) -> &'static str {
        match self {
            Self::UdpIn => "udpin:0.0.0.0:14550",
            Self::UdpOut => "udpout:127.0.0.1:14550",
            Self::UdpBroadcast => "udpbcast:192.168.1.255:14550",
            Self::TcpClient => "tcp:127.0.0.1:5760",
            Self::TcpServer => "tcpin:127.0.0.1:5760",
            Self::Serial => "serial:/dev/ttyACM0:115200",
            Self::Tlog => "tlog:flight.tlog?speed=2",
        }
    }

    const fn default_port(self) -> u16 {
        match self {
            Self::TcpClient | Self::TcpServer => DEFAULT_TCP_PORT,
            _ => DEFAULT_UDP_PORT,
        }
    }

    const fn default_host(self) -> Option<&'static str> {
        match self {
            Self::UdpIn => Some("0.0.0.0"),
            Self::TcpServer => Some("127.0.0.1"),
            _ => None,
        }
    }

    const fn lowest_port(self) -> u16 {
        match self {
            Self::UdpIn | Self::TcpServer => 0,
            _ => 1,
        }
    }
}

impl LinkAddress {
    /// Reads a link string, and with it the system and component id that MAVROS' `?ids=s,c` asks us to take.
    ///
    /// # Errors
    /// [`AddressError`] says what is wrong and shows the right form.
    pub fn parse_with_ids(text: &str) -> Result<(Self, Option<Address>), AddressError> {
        Parser { text: text.trim() }.parse()
    }

    /// Whether somebody else may reach this link from another machine without our asking: a listening link that is not
    /// on the loopback interface.
    pub fn listens_beyond_loopback(&self) -> bool {
        let (Self::UdpIn { bind } | Self::TcpServer { bind } | Self::UdpOut { bind: Some(bind), .. }) = self else {
            return false;
        };
        !bind.is_loopback()
    }

    /// Whether nobody but this machine and what is plugged into it can be at the other end: loopback, and an autopilot's own
    /// USB. A serial adapter is not, for most often a radio hangs on it.
    pub fn is_private(&self) -> bool {
        match self {
            Self::UdpIn { bind } | Self::TcpServer { bind } => bind.is_loopback(),
            Self::UdpOut { remote, bind } => remote.is_loopback() && bind.as_ref().is_none_or(HostPort::is_loopback),
            Self::TcpClient { remote } => remote.is_loopback(),
            Self::Serial { path, .. } => {
                // What `/dev/serial/by-id/…` stands for.
                let device = std::fs::canonicalize(path).unwrap_or_else(|_| path.into());
                let name = device.file_name().and_then(|name| name.to_str()).unwrap_or_default();
                ["ttyACM", "cu.usbmodem", "tty.usbmodem"].iter().any(|usb| name.starts_with(usb))
            }
            Self::UdpBroadcast { .. } => false,
            Self::Tlog { .. } => true,
        }
    }
}

impl FromStr for LinkAddress {
    type Err = AddressError;

    fn from_str(text: &str) -> Result<Self, AddressError> {
        Self::parse_with_ids(text).map(|(address, _)| address)
    }
}

impl fmt::Display for LinkAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UdpIn { bind } => write!(f, "udpin:{bind}"),
            Self::UdpOut { remote, bind: None } => write!(f, "udpout:{remote}"),
            Self::UdpOut { remote, bind: Some(bind) } => write!(f, "udp://{bind}@{remote}"),
            Self::UdpBroadcast { remote } => write!(f, "udpbcast:{remote}"),
            Self::TcpClient { remote } => write!(f, "tcp:{remote}"),
            Self::TcpServer { bind } => write!(f, "tcpin:{bind}"),
            Self::Serial { path, baud } => write!(f, "serial:{path}:{baud}"),
            Self::Tlog { path, speed, repeat } => {
                write!(f, "tlog:{}", path.display())?;
                match (*speed == 1.0, repeat) {
                    (true, false) => Ok(()),
                    (false, false) => write!(f, "?speed={speed}"),
                    (true, true) => f.write_str("?loop=true"),
                    (false, true) => write!(f, "?speed={speed}&loop=true"),
                }
            }
        }
    }
}

/// What may stand behind the `?`.
#[derive(Default)]
struct Query {
    ids: Option<Address>,
    speed: Option<f64>,
    repeat: Option<bool>,
    baud: Option<u32>,
}

struct Parser<'a> {
    text: &'a str,
}

impl Parser<'_> {
    fn parse(&self) -> Result<(LinkAddress, Option<Address>), AddressError> {
        if self.text.is_empty() {
            return Err(AddressError::Empty);
        }
        let (body, query) = match self.text.split_once('?') {
            Some((body, query)) => (body, Some(query)),
            None => (self.text, None),
        };
        let (kind, rest) = self.kind(body)?;
        let query = self.query(kind, query.unwrap_or_default())?;
        let ids = query.ids;
        let address = match kind {
            Kind::Serial => self.serial(rest, &query)?,
            Kind::Tlog => self.tlog(rest, &query)?,
            _ => self.socket(kind, rest)?,
        };
        Ok((address, ids))
    }

    /// Splits the kind of link from the rest. Without a scheme: a device, a recording, or DroneKit's bare `host:port`.
    fn kind<'t>(&self, body: &'t str) -> Result<(Kind, &'t str), AddressError> {
        if is_device(body) {
            return Ok((Kind::Serial, body));
        }
        if let Some((scheme, rest)) = body.split_once(':') {
            let lower = scheme.to_ascii_lowercase();
            let rest = rest.strip_prefix("//").unwrap_or(rest);
            if let Some((_, kind)) = SCHEMES.iter().find(|(name, _)| *name == lower) {
                return Ok((*kind, rest));
            }
            if let Some((_, instead)) = UNSUPPORTED.iter().find(|(name, _)| *name == lower) {
                return Err(AddressError::Unsupported { scheme: lower, instead });
            }
            if has_recording_name(body) {
                return Ok((Kind::Tlog, body));
            }
            // A bare `host:port` starts with an address or a dotted name; a misspelt scheme does not.
            let looks_like_host =
                scheme.contains('.') || scheme == "localhost" || scheme.starts_with('[') || scheme.is_empty();
            if looks_like_host {
                return Ok((Kind::UdpIn, body));
            }
            return Err(self.unknown_scheme(scheme, rest));
        }
        if has_recording_name(body) {
            return Ok((Kind::Tlog, body));
        }
        Err(self.unknown_scheme(body, ""))
    }

    fn unknown_scheme(&self, scheme: &str, rest: &str) -> AddressError {
        let lower = scheme.to_ascii_lowercase();
        let suggestion = SCHEMES
            .iter()
            .map(|(name, kind)| (edit_distance(&lower, name), *name, *kind))
            .filter(|(distance, name, _)| *distance <= 2 && *distance < name.len())
            .min_by_key(|(distance, _, _)| *distance)
            .map(|(_, name, kind)| {
                let corrected = format!("{name}:{rest}");
                if !rest.is_empty() && corrected.parse::<LinkAddress>().is_ok() {
                    corrected
                } else {
                    kind.example().to_owned()
                }
            })
            .or_else(|| lower.starts_with("tty").then(|| format!("/dev/{}", self.text)));
        AddressError::UnknownScheme { text: self.text.to_owned(), scheme: scheme.to_owned(), suggestion }
    }

    fn query(&self, kind: Kind, query: &str) -> Result<Query, AddressError> {
        let mut parsed = Query::default();
        for option in query.split('&').filter(|option| !option.is_empty()) {
            let bad = |hint| AddressError::BadOption { text: self.text.to_owned(), option: option.to_owned(), hint };
            let (name, value) = option.split_once('=').unwrap_or((option, ""));
            match (name, kind) {
                ("ids", _) => {
                    let hint = "write `?ids=255,190`, a system id and a component id from 1 to 255";
                    let (system, component) = value.split_once(',').ok_or_else(|| bad(hint))?;
                    let id = |text: &str| text.parse::<u8>().ok().filter(|id| *id > 0).ok_or_else(|| bad(hint));
                    parsed.ids = Some(Address::new(id(system)?, id(component)?));
                }
                ("speed", Kind::Tlog) => {
                    let speed = value.parse().ok().filter(|speed| SPEED_RANGE.contains(speed));
                    parsed.speed =
                        Some(speed.ok_or_else(|| bad("write `?speed=2`, from 0.01 to 10000 times the recorded pace"))?);
                }
                ("loop", Kind::Tlog) => {
                    parsed.repeat = Some(match value {
                        "" | "true" | "1" | "yes" => true,
                        "false" | "0" | "no" => false,
                        _ => return Err(bad("write `?loop=true` or `?loop=false`")),
                    });
                }
                ("baud" | "baudrate", Kind::Serial) => parsed.baud = Some(self.baud(value)?),
                (_, Kind::Tlog) => return Err(bad("a recording takes `?speed=2` and `?loop=true`")),
                (_, Kind::Serial) => return Err(bad("a serial port takes `?baud=57600` and `?ids=255,190`")),
                _ => return Err(bad("a network link takes `?ids=255,190` only")),
            }
        }
        Ok(parsed)
    }

    fn socket(&self, kind: Kind, rest: &str) -> Result<LinkAddress, AddressError> {
        let rest = rest.strip_suffix('/').unwrap_or(rest);
        if let Some((bind, remote)) = rest.split_once('@') {
            if kind != Kind::UdpIn {
                return Err(AddressError::BadHost {
                    text: self.text.to_owned(),
                    host: rest.to_owned(),
                    example: kind.example(),
                });
            }
            let bind = self.host_port(Kind::UdpIn, bind)?;
            return Ok(match remote {
                "" => LinkAddress::UdpIn { bind },
                remote => LinkAddress::UdpOut { remote: self.host_port(Kind::UdpOut, remote)?, bind: Some(bind) },
            });
        }
        let place = self.host_port(kind, rest)?;
        Ok(match kind {
            Kind::UdpIn => LinkAddress::UdpIn { bind: place },
            Kind::UdpOut => LinkAddress::UdpOut { remote: place, bind: None },
            Kind::UdpBroadcast => LinkAddress::UdpBroadcast { remote: place },
            Kind::TcpServer => LinkAddress::TcpServer { bind: place },
            Kind::TcpClient | Kind::Serial | Kind::Tlog => LinkAddress::TcpClient { remote: place },
        })
    }

    fn host_port(&self, kind: Kind, place: &str) -> Result<HostPort, AddressError> {
        let bad_host = |host: &str| AddressError::BadHost {
            text: self.text.to_owned(),
            host: host.to_owned(),
            example: kind.example(),
        };
        let (host, port) = if let Some(bracketed) = place.strip_prefix('[') {
            let (host, after) = bracketed.split_once(']').ok_or_else(|| bad_host(place))?;
            // Strictly an IPv6 address, with an optional zone as in `fe80::1%eth0`.
            host.split('%').next().and_then(|ip| ip.parse::<Ipv6Addr>().ok()).ok_or_else(|| bad_host(host))?;
            match after.strip_prefix(':') {
                Some(port) => (host, Some(port)),
                None if after.is_empty() => (host, None),
                None => return Err(bad_host(place)),
            }
        } else {
            match place.split_once(':') {
                Some((_, port)) if port.contains(':') => return Err(bad_host(place)),
                Some((host, port)) => (host, Some(port)),
                // `udpin:14550`: a port alone.
                None if kind.default_host().is_some()
                    && !place.is_empty()
                    && place.bytes().all(|b| b.is_ascii_digit()) =>
                {
                    ("", Some(place))
                }
                None => (place, None),
            }
        };
        let host = match (host, kind.default_host()) {
            ("", Some(default)) => default,
            ("", None) => {
                return Err(AddressError::MissingHost { text: self.text.to_owned(), example: kind.example() });
            }
            (host, _) if place.starts_with('[') || is_host_name(host) => host,
            (host, _) => return Err(bad_host(host)),
        };
        let port = match port {
            None => kind.default_port(),
            Some(port) => port.parse().ok().filter(|number| *number >= kind.lowest_port()).ok_or_else(|| {
                AddressError::BadPort {
                    text: self.text.to_owned(),
                    port: port.to_owned(),
                    lowest: kind.lowest_port(),
                    example: kind.example(),
                }
            })?,
        };
        Ok(HostPort::new(host, port))
    }

    fn serial(&self, rest: &str, query: &Query) -> Result<LinkAddress, AddressError> {
        // A comma always separates the rate; a colon only before digits, for names under /dev/serial/by-path have colons.
        let (path, baud) = match rest.split_once(',') {
            Some((path, baud)) => (path, Some(baud)),
            None => match rest.rsplit_once(':') {
                Some((path, baud)) if !baud.is_empty() && baud.bytes().all(|b| b.is_ascii_digit()) => {
                    (path, Some(baud))
                }
                Some((path, baud)) if !path.contains("/by-") => (path, Some(baud)),
                _ => (rest, None),
            },
        };
        if path.is_empty() {
            return Err(AddressError::MissingPath {
                text: self.text.to_owned(),
                what: "device",
                example: Kind::Serial.example(),
            });
        }
        let baud = match (baud, query.baud) {
            (Some(baud), _) => self.baud(baud)?,
            (None, Some(baud)) => baud,
            (None, None) => default_baud(path),
        };
        Ok(LinkAddress::Serial { path: path.to_owned(), baud })
    }

    fn baud(&self, baud: &str) -> Result<u32, AddressError> {
        let number = baud.parse().ok().filter(|number| BAUD_RANGE.contains(number));
        number.ok_or_else(|| AddressError::BadBaud { text: self.text.to_owned(), baud: baud.to_owned() })
    }

    fn tlog(&self, rest: &str, query: &Query) -> Result<LinkAddress, AddressError> {
        if rest.is_empty() {
            return Err(AddressError::MissingPath {
                text: self.text.to_owned(),
                what: "file",
                example: Kind::Tlog.example(),
            });
        }
        Ok(LinkAddress::Tlog {
            path: PathBuf::from(rest),
            speed: query.speed.unwrap_or(1.0),
            repeat: query.repeat.unwrap_or(false),
        })
    }
}

fn is_device(body: &str) -> bool {
    let is_com = body.len() > 3
        && body.is_char_boundary(3)
        && body[..3].eq_ignore_ascii_case("com")
        && body[3..].starts_with(|c: char| c.is_ascii_digit());
    (body.starts_with('/') && !has_recording_name(body)) || body.starts_with(r"\\.\") || is_com
}

fn has_recording_name(body: &str) -> bool {
    body.len() > 5 && body.to_ascii_lowercase().ends_with(".tlog")
}

fn is_host_name(host: &str) -> bool {
    host.len() <= 253 && host.bytes().all(|b| b.is_ascii_alphanumeric() || matches!(b, b'.' | b'-' | b'_'))
}

fn default_baud(path: &str) -> u32 {
    let name = path.rsplit('/').next().unwrap_or(path);
    let is_usb = name.starts_with("ttyACM") || name.contains("usbmodem") || name.starts_with("usb-");
    if is_usb { DEFAULT_USB_BAUD } else { DEFAULT_BAUD }
}

/// Edits (insert, delete, replace, swap neighbours) that turn `a` into `b`: restricted Damerau-Levenshtein distance.
fn edit_distance(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().take(32).collect(), b.chars().collect());
    let mut rows = vec![vec![0; b.len() + 1]; a.len() + 1];
    for (i, row) in rows.iter_mut().enumerate() {
        row[0] = i;
    }
    for (j, first) in rows[0].iter_mut().enumerate() {
        *first = j;
    }
    for i in 1..=a.len() {
        for j in 1..=b.len() {
            let replace = rows[i - 1][j - 1] + usize::from(a[i - 1] != b[j - 1]);
            let mut best = replace.min(rows[i - 1][j] + 1).min(rows[i][j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                best = best.min(rows[i - 2][j - 2] + 1);
            }
            rows[i][j] = best;
        }
    }
    rows[a.len()][b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_spelling_of_the_family_is_read() {
        // given → canonical
        let cases = [
            ("udpin:0.0.0.0:14550", "udpin:0.0.0.0:14550"),
            ("udp:127.0.0.1:14551", "udpin:127.0.0.1:14551"),
            ("udp:", "udpin:0.0.0.0:14550"),
            ("udp::14540", "udpin:0.0.0.0:14540"),
            ("udpin:14540", "udpin:0.0.0.0:14540"),
            ("UDPIN:localhost:14550", "udpin:localhost:14550"),
            ("  udpin:0.0.0.0:14550\n", "udpin:0.0.0.0:14550"),
            ("udpout:192.168.1.20:14550", "udpout:192.168.1.20:14550"),
            ("udpout:gcs.example.org", "udpout:gcs.example.org:14550"),
            ("udpbcast:192.168.1.255:14550", "udpbcast:192.168.1.255:14550"),
            ("tcp:127.0.0.1:5760", "tcp:127.0.0.1:5760"),
            ("tcp:sitl", "tcp:sitl:5760"),
            ("tcpin:0.0.0.0:5770", "tcpin:0.0.0.0:5770"),
            ("tcpin:", "tcpin:127.0.0.1:5760"),
            ("127.0.0.1:14550", "udpin:127.0.0.1:14550"),
            ("localhost:14550", "udpin:localhost:14550"),
            (":14550", "udpin:0.0.0.0:14550"),
            ("/dev/ttyACM0", "serial:/dev/ttyACM0:115200"),
            ("/dev/ttyACM0,57600", "serial:/dev/ttyACM0:57600"),
            ("/dev/ttyUSB0:57600", "serial:/dev/ttyUSB0:57600"),
            ("/dev/ttyUSB0", "serial:/dev/ttyUSB0:57600"),
            (
                "/dev/serial/by-path/pci-0000:00:14.0-usb-0:2:1.0",
                "serial:/dev/serial/by-path/pci-0000:00:14.0-usb-0:2:1.0:57600",
            ),
            (
                "/dev/serial/by-id/usb-ArduPilot_CubeOrange_1-if00",
                "serial:/dev/serial/by-id/usb-ArduPilot_CubeOrange_1-if00:115200",
            ),
            ("com14", "serial:com14:57600"),
            ("COM3,115200", "serial:COM3:115200"),
            ("COM3:115200", "serial:COM3:115200"),
            // MAVSDK
            ("udpin://0.0.0.0:14540", "udpin:0.0.0.0:14540"),
            ("udpout://192.168.1.1:14550", "udpout:192.168.1.1:14550"),
            ("udp://:14540", "udpin:0.0.0.0:14540"),
            ("tcpin://0.0.0.0:5760", "tcpin:0.0.0.0:5760"),
            ("tcpout://10.0.0.1:5760", "tcp:10.0.0.1:5760"),
            ("serial:///dev/ttyUSB0:57600", "serial:/dev/ttyUSB0:57600"),
            ("serial:/dev/ttyS0:921600", "serial:/dev/ttyS0:921600"),
            ("serial:/dev/ttyS0?baud=9600", "serial:/dev/ttyS0:9600"),
            ("serial://COM3:57600", "serial:COM3:57600"),
            // MAVROS
            ("udp://127.0.0.1:14555@10.1.1.2:14550", "udp://127.0.0.1:14555@10.1.1.2:14550"),
            ("udp://:14540@", "udpin:0.0.0.0:14540"),
            ("udp://:14540@192.168.1.36:14557/?ids=255,240", "udp://0.0.0.0:14540@192.168.1.36:14557"),
            ("udp://@10.1.1.2", "udp://0.0.0.0:14550@10.1.1.2:14550"),
            ("tcp://127.0.0.1:5760", "tcp:127.0.0.1:5760"),
            ("tcp-l://:5760", "tcpin:127.0.0.1:5760"),
            ("serial:///dev/ttyUSB0:57600?ids=255,190", "serial:/dev/ttyUSB0:57600"),
            // mavlink-server
            ("udpserver://0.0.0.0:14550", "udpin:0.0.0.0:14550"),
            ("udpclient://127.0.0.1:14550", "udpout:127.0.0.1:14550"),
            ("tcpserver://0.0.0.0:5760", "tcpin:0.0.0.0:5760"),
            ("tcpclient://127.0.0.1:5760", "tcp:127.0.0.1:5760"),
            ("tlogreader:///tmp/a.tlog", "tlog:/tmp/a.tlog"),
            // recordings
            ("tlog:flight.tlog", "tlog:flight.tlog"),
            ("tlog:flight.tlog?speed=2", "tlog:flight.tlog?speed=2"),
            ("tlog:/a b/flight.bin?speed=0.5&loop", "tlog:/a b/flight.bin?speed=0.5&loop=true"),
            ("flights/one.tlog", "tlog:flights/one.tlog"),
            ("/tmp/one.tlog", "tlog:/tmp/one.tlog"),
            // IPv6
            ("udpin:[::]:14550", "udpin:[::]:14550"),
            ("[::1]:14550", "udpin:[::1]:14550"),
            ("tcp://[fe80::1%eth0]:5760", "tcp:[fe80::1%eth0]:5760"),
            ("udpout:[2001:db8::2]", "udpout:[2001:db8::2]:14550"),
            ("udp://[::1]:14540@[::1]:14557", "udp://[::1]:14540@[::1]:14557"),
        ];
        for (given, canonical) in cases {
            let address: LinkAddress = given.parse().unwrap_or_else(|error| panic!("{given}: {error}"));
            assert_eq!(address.to_string(), canonical, "{given}");
            assert_eq!(canonical.parse::<LinkAddress>().unwrap(), address, "{canonical} reads back as itself");
        }
    }

    #[test]
    fn ids_are_read() {
        let (_, ids) = LinkAddress::parse_with_ids("udp://:14540@10.0.0.2:14557/?ids=1,191").unwrap();
        assert_eq!(ids, Some(Address::new(1, 191)));
        assert_eq!(LinkAddress::parse_with_ids("udp:").unwrap().1, None);
    }

    #[test]
    fn errors_say_what_was_wrong_and_show_the_right_form() {
        // given, a part of the message
        let cases = [
            ("", "empty"),
            ("upd:127.0.0.1:14550", "did you mean `udp:127.0.0.1:14550`?"),
            ("updin:0.0.0.0:14550", "did you mean `udpin:0.0.0.0:14550`?"),
            ("tpc://127.0.0.1:5760", "did you mean `tcp:127.0.0.1:5760`?"),
            ("seral:/dev/ttyACM0", "did you mean `serial:/dev/ttyACM0`?"),
            ("udpserve://:14550", "did you mean `udpserver:"),
            ("ttyUSB0", "did you mean `/dev/ttyUSB0`?"),
            ("carrier-pigeon:home", "is not a kind of link; kinds are"),
            ("plane", "`plane` in `plane` is not a kind of link"),
            ("mcast:", "not supported"),
            ("udpout:", "names no host; write `udpout:127.0.0.1:14550`"),
            ("tcp:", "names no host; write `tcp:127.0.0.1:5760`"),
            ("tcp:host:0", "`0` in `tcp:host:0` is not a port from 1"),
            ("udpin:0.0.0.0:99999", "`99999` in `udpin:0.0.0.0:99999` is not a port from 0"),
            ("udpin:0.0.0.0:http", "not a port"),
            ("udpin:::1:14550", "IPv6 address goes in brackets"),
            ("udpin:[::1:14550", "not a host name or address"),
            ("tcp:ho st:5760", "`ho st`"),
            ("tcp:a:5760@b:5760", "not a host name or address"),
            ("/dev/ttyUSB0,fast", "`fast`"),
            ("/dev/ttyUSB0:57", "`57` in `/dev/ttyUSB0:57` is not a baud rate"),
            ("/dev/ttyUSB0:x", "not a baud rate"),
            ("serial:", "names no device"),
            ("tlog:", "names no file"),
            ("tlog:a.tlog?speed=0", "from 0.01"),
            ("tlog:a.tlog?speed=NaN", "from 0.01"),
            ("tlog:a.tlog?sped=2", "takes `?speed=2`"),
            ("udpin::14550?ids=0,1", "system id"),
            ("udpin::14550?speed=2", "takes `?ids=255,190` only"),
        ];
        for (given, expected) in cases {
            let message = given.parse::<LinkAddress>().expect_err(given).to_string();
            assert!(message.contains(expected), "{given}: {message}");
        }
    }

    #[test]
    fn only_open_links_count_as_reachable_from_outside() {
        for (text, open) in [
            ("udpin:0.0.0.0:14550", true),
            ("udpin:127.0.0.1:14550", false),
            ("tcpin:[::1]:5760", false),
            ("tcpin:[::]:5760", true),
            ("tcp:0.0.0.0:5760", false),
            ("udp://:14540@1.2.3.4:14557", true),
        ] {
            assert_eq!(text.parse::<LinkAddress>().unwrap().listens_beyond_loopback(), open, "{text}");
        }
    }
}
