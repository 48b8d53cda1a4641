//! Where a network is joined: addresses of this machine only, as long as nothing is encrypted.

use std::fmt;
use std::net::{SocketAddr, TcpListener};
use std::str::FromStr;

use crate::error::FleetError;

/// An address such as `tcp/127.0.0.1:7447`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Endpoint(SocketAddr);

impl FromStr for Endpoint {
    type Err = FleetError;

    fn from_str(text: &str) -> Result<Self, FleetError> {
        let bad = || FleetError::Address(text.chars().filter(|c| !c.is_control()).take(80).collect());
        let address: SocketAddr = text.strip_prefix("tcp/").ok_or_else(bad)?.parse().map_err(|_| bad())?;
        if !address.ip().is_loopback() {
            return Err(FleetError::NotLoopback(text.to_owned()));
        }
        Ok(Self(address))
    }
}

impl fmt::Display for Endpoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "tcp/{}", self.0)
    }
}

impl Endpoint {
    /// The same with a free port, where its port is 0: the network does not tell which one it took.
    pub(super) fn with_port(self) -> Result<Self, FleetError> {
        if self.0.port() != 0 {
            return Ok(self);
        }
        let free = TcpListener::bind(self.0).and_then(|listener| listener.local_addr());
        let free =
            free.map_err(|error| FleetError::Network { address: self.to_string(), problem: error.to_string() })?;
        Ok(Self(free))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_this_machine_is_reached_in_the_clear() {
        for good in ["tcp/127.0.0.1:7447", "tcp/127.9.9.9:1", "tcp/[::1]:7447"] {
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
        ] {
            assert!(matches!(bad.parse::<Endpoint>(), Err(FleetError::Address(_))), "{bad}");
        }
        let free = "tcp/127.0.0.1:0".parse::<Endpoint>().and_then(Endpoint::with_port);
        assert!(free.is_ok_and(|endpoint| endpoint.0.port() != 0));
    }
}
