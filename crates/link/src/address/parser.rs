//! Link strings, read: every spelling of the family, and for what is wrong the right form.

use std::net::Ipv6Addr;
use std::path::PathBuf;

use vencejo_proto::Address;

use super::forms::{
    AddressError, DEFAULT_BAUD, DEFAULT_TCP_PORT, DEFAULT_UDP_PORT, DEFAULT_USB_BAUD, HostPort, LinkAddress,
};

const BAUD_RANGE: std::ops::RangeInclusive<u32> = 300..=12_000_000;
const SPEED_RANGE: std::ops::RangeInclusive<f64> = 0.01..=10_000.0;

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

/// What may stand behind the `?`.
#[derive(Default)]
struct Query {
    ids: Option<Address>,
    speed: Option<f64>,
    repeat: Option<bool>,
    baud: Option<u32>,
}

pub(super) struct Parser<'a> {
    pub(super) text: &'a str,
}

impl Parser<'_> {
    pub(super) fn parse(&self) -> Result<(LinkAddress, Option<Address>), AddressError> {
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
        let address = self.host_port(kind, rest)?;
        Ok(match kind {
            Kind::UdpIn => LinkAddress::UdpIn { bind: address },
            Kind::UdpOut => LinkAddress::UdpOut { remote: address, bind: None },
            Kind::UdpBroadcast => LinkAddress::UdpBroadcast { remote: address },
            Kind::TcpServer => LinkAddress::TcpServer { bind: address },
            Kind::TcpClient | Kind::Serial | Kind::Tlog => LinkAddress::TcpClient { remote: address },
        })
    }

    fn host_port(&self, kind: Kind, address: &str) -> Result<HostPort, AddressError> {
        let bad_host = |host: &str| AddressError::BadHost {
            text: self.text.to_owned(),
            host: host.to_owned(),
            example: kind.example(),
        };
        let (host, port) = if let Some(bracketed) = address.strip_prefix('[') {
            let (host, after) = bracketed.split_once(']').ok_or_else(|| bad_host(address))?;
            // Strictly an IPv6 address, with an optional zone as in `fe80::1%eth0`.
            host.split('%').next().and_then(|ip| ip.parse::<Ipv6Addr>().ok()).ok_or_else(|| bad_host(host))?;
            match after.strip_prefix(':') {
                Some(port) => (host, Some(port)),
                None if after.is_empty() => (host, None),
                None => return Err(bad_host(address)),
            }
        } else {
            match address.split_once(':') {
                Some((_, port)) if port.contains(':') => return Err(bad_host(address)),
                Some((host, port)) => (host, Some(port)),
                // `udpin:14550`: a port alone.
                None if kind.default_host().is_some()
                    && !address.is_empty()
                    && address.bytes().all(|b| b.is_ascii_digit()) =>
                {
                    ("", Some(address))
                }
                None => (address, None),
            }
        };
        let host = match (host, kind.default_host()) {
            ("", Some(default)) => default,
            ("", None) => {
                return Err(AddressError::MissingHost { text: self.text.to_owned(), example: kind.example() });
            }
            (host, _) if address.starts_with('[') || is_host_name(host) => host,
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
        // A comma always separates the rate; a colon only before digits, for names under /dev/serial/by-path have
        // colons.
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

/// The baud rate of a serial port that is named without one.
pub(crate) fn default_baud(path: &str) -> u32 {
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
