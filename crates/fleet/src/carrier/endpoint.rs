//! Addresses of routers: TLS or QUIC anywhere, unencrypted on this machine only.

use std::fmt;
use std::net::{IpAddr, SocketAddr, TcpListener, UdpSocket};
use std::str::FromStr;

use crate::error::FleetError;

/// The transport of an address.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Transport {
    /// Unencrypted TCP.
    Tcp,
    /// TLS 1.3 over TCP.
    Tls,
    /// QUIC, over UDP.
    Quic,
}

impl Transport {
    /// Its scheme in an address.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Tcp => "tcp",
            Self::Tls => "tls",
            Self::Quic => "quic",
        }
    }
}

/// An address such as `tls/ground.local:7447`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Endpoint {
    transport: Transport,
    host: String,
    port: u16,
}

/// Whether it can be a host name: without characters that the network's settings interpret.
fn is_name(host: &str) -> bool {
    let is_good = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'-' || byte == b'.';
    !host.is_empty() && host.len() <= 253 && host.bytes().all(is_good) && !host.starts_with(['-', '.'])
}

/// Splits `HOST:PORT`: a name, an IPv4 address, or an IPv6 address in brackets.
pub(super) fn split(text: &str) -> Option<(&str, u16)> {
    let (host, port) = text.rsplit_once(':')?;
    let is_digits = port.bytes().all(|byte| byte.is_ascii_digit());
    let is_host = match host.strip_prefix('[').and_then(|host| host.strip_suffix(']')) {
        Some(v6) => v6.parse::<std::net::Ipv6Addr>().is_ok(),
        None => is_name(host),
    };
    (is_digits && is_host).then_some((host, port.parse().ok()?))
}

/// The host of `HOST:PORT`, an IPv6 address without brackets.
pub(super) fn host_of(address: &str) -> Option<&str> {
    split(address).map(|(host, _)| host.trim_matches(['[', ']']))
}

/// A host as written before a port: an IPv6 address in brackets.
pub(super) fn bracketed(host: &str) -> String {
    if host.contains(':') { format!("[{host}]") } else { host.to_owned() }
}

impl FromStr for Endpoint {
    type Err = FleetError;

    fn from_str(text: &str) -> Result<Self, FleetError> {
        let bad = || FleetError::Address(shown(text));
        let endpoint = Self::anywhere(text).ok_or_else(bad)?;
        if endpoint.transport == Transport::Tcp {
            let ip: IpAddr = endpoint.host().parse().map_err(|_| bad())?;
            if !ip.is_loopback() {
                return Err(FleetError::NotLoopback(text.to_owned()));
            }
        }
        Ok(endpoint)
    }
}

/// An invalid address, shortened for display.
fn shown(text: &str) -> String {
    vencejo_proto::plain(text, 80)
}

impl fmt::Display for Endpoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.transport.as_str(), self.authority())
    }
}

impl Endpoint {
    /// Parses an address, encrypted or not, of any machine.
    fn anywhere(text: &str) -> Option<Self> {
        let (scheme, rest) = text.split_once('/')?;
        let transport =
            [Transport::Tcp, Transport::Tls, Transport::Quic].into_iter().find(|known| known.as_str() == scheme)?;
        let (host, port) = split(rest)?;
        Some(Self { transport, host: host.to_owned(), port })
    }

    /// The address of a router of ROS 2; the caller decides whether it may be unencrypted.
    pub(super) fn of_ros(text: &str) -> Result<Self, FleetError> {
        let endpoint = Self::anywhere(text).filter(|endpoint| endpoint.port != 0 && !endpoint.is_any());
        endpoint.ok_or_else(|| FleetError::RosRouter(shown(text)))
    }

    /// Whether it is a loopback address.
    pub fn is_here(&self) -> bool {
        let host = self.host();
        host == "localhost" || host.parse::<IpAddr>().is_ok_and(|ip| ip.is_loopback())
    }

    /// The transport of an address.
    pub fn transport(&self) -> Transport {
        self.transport
    }

    /// `HOST:PORT`.
    pub fn authority(&self) -> String {
        format!("{}:{}", self.host, self.port)
    }

    /// The host, an IPv6 address without brackets.
    pub fn host(&self) -> &str {
        self.host.trim_matches(['[', ']'])
    }

    /// Whether it is unspecified (all addresses of this machine), as only a listener's can be.
    pub fn is_any(&self) -> bool {
        self.host().parse::<IpAddr>().is_ok_and(|ip| ip.is_unspecified())
    }

    /// Refuses addresses that are for listeners only.
    pub(super) fn dialled(self) -> Result<Self, FleetError> {
        if self.is_any() {
            return Err(FleetError::Address(format!("{self} (to dial, give a host name or an address)")));
        }
        Ok(self)
    }

    /// The form that Zenoh dials. It takes the brackets of an IPv6 address for a part of the certificate's name;
    /// without them it finds the port at the last colon, and name and address are right.
    pub(super) fn for_zenoh(&self) -> String {
        match self.transport {
            Transport::Tcp => self.to_string(),
            Transport::Tls | Transport::Quic => format!("{}/{}:{}", self.transport.as_str(), self.host(), self.port),
        }
    }

    /// The same at another host.
    pub(super) fn at(&self, host: &str) -> Self {
        Self { host: bracketed(host), ..self.clone() }
    }

    /// The same over another transport.
    pub(super) fn by(&self, transport: Transport) -> Self {
        Self { transport, ..self.clone() }
    }

    /// The same with a free port if its port is 0: Zenoh does not report which one it took.
    pub(super) fn with_port(self) -> Result<Self, FleetError> {
        if self.port != 0 {
            return Ok(self);
        }
        let (address, at) = (self.authority(), |address: SocketAddr| address.port());
        let free = match self.transport {
            Transport::Quic => UdpSocket::bind(&address).and_then(|socket| socket.local_addr()).map(at),
            Transport::Tcp | Transport::Tls => {
                TcpListener::bind(&address).and_then(|listener| listener.local_addr()).map(at)
            }
        };
        let port =
            free.map_err(|error| FleetError::Network { address: self.to_string(), problem: error.to_string() })?;
        Ok(Self { port, ..self })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_this_machine_is_reached_in_the_clear() {
        for good in [
            "tcp/127.0.0.1:7447",
            "tcp/127.9.9.9:1",
            "tcp/[::1]:7447",
            "tls/0.0.0.0:7447",
            "quic/192.168.1.2:7447",
            "tls/ground.local:7447",
            "quic/[::]:7447",
        ] {
            assert_eq!(good.parse::<Endpoint>().map(|endpoint| endpoint.to_string()), Ok(good.to_owned()));
        }
        for open in ["tcp/0.0.0.0:7447", "tcp/192.168.1.2:7447", "tcp/[::]:7447"] {
            assert!(matches!(open.parse::<Endpoint>(), Err(FleetError::NotLoopback(_))), "{open}");
        }
        for bad in [
            "",
            "127.0.0.1:7447",
            "tcp/localhost:7447",
            "udp/127.0.0.1:7447",
            "tcp/127.0.0.1",
            "tcp/127.0.0.1:7447#x=y",
            "tls/ground:7447#enable_mtls=false",
            "tls/ground;x:7447",
            "tls/ground:+7447",
            "tls/[ground]:7447",
            "tls/:7447",
            "quic/a:70000",
        ] {
            assert!(matches!(bad.parse::<Endpoint>(), Err(FleetError::Address(_))), "{bad}");
        }
        for free in ["tcp/127.0.0.1:0", "tls/127.0.0.1:0", "quic/127.0.0.1:0"] {
            let free = free.parse::<Endpoint>().and_then(Endpoint::with_port);
            assert!(free.is_ok_and(|endpoint| endpoint.port != 0));
        }
        for unreachable in ["tls/0.0.0.0:7447", "quic/[::]:7447"] {
            assert!(unreachable.parse::<Endpoint>().and_then(Endpoint::dialled).is_err(), "{unreachable}");
        }
        let six = "quic/[2001:db8::1]:7447".parse::<Endpoint>().expect("an address");
        assert_eq!(six.for_zenoh(), "quic/2001:db8::1:7447");
        assert_eq!(six.at("2001:db8::2").to_string(), "quic/[2001:db8::2]:7447");
    }
}
