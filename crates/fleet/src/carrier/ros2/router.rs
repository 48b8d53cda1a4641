//! Where a router of ROS 2 is, and how it is reached.

use std::fmt;
use std::net::IpAddr;
use std::str::FromStr;
use std::time::Duration;

use tokio::net::TcpStream;
use zenoh::Session;

use crate::carrier::endpoint::Endpoint;
use crate::carrier::network::{self, Part};
use crate::error::FleetError;
use crate::ros2::name::BadRosName;

/// How long a router is waited for.
const CONNECT: Duration = Duration::from_secs(3);
/// The largest `ROS_DOMAIN_ID`.
const MAX_DOMAIN: u32 = 232;

/// Where a router of ROS 2 is: in the clear, as those are.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RosRouter(Endpoint);

impl FromStr for RosRouter {
    type Err = FleetError;

    fn from_str(text: &str) -> Result<Self, FleetError> {
        Endpoint::in_the_clear(text)?.dialled().map(Self)
    }
}

impl RosRouter {
    /// Whether it is on this machine.
    pub(super) fn is_here(&self) -> bool {
        let host = self.0.host();
        host == "localhost" || host.parse::<IpAddr>().is_ok_and(|ip| ip.is_loopback())
    }
}

impl fmt::Display for RosRouter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// Refuses a domain that cannot be.
pub(super) fn check_domain(domain: u32) -> Result<(), FleetError> {
    if domain > MAX_DOMAIN { Err(BadRosName::Domain(domain).into()) } else { Ok(()) }
}

/// Joins the network of a router; in plain words why not.
pub(super) async fn open(router: &RosRouter) -> Result<Session, FleetError> {
    let failed = |problem: String| FleetError::Network { address: router.0.to_string(), problem };
    let tried = tokio::time::timeout(CONNECT, TcpStream::connect(router.0.authority())).await;
    match tried {
        Err(_) => return Err(failed("nobody answers there".into())),
        Ok(Err(error)) => {
            let why = "start one there, such as `ros2 run rmw_zenoh_cpp rmw_zenohd`, or name another with --ros2";
            return Err(failed(format!("no router is there ({error}): {why}")));
        }
        Ok(Ok(_)) => {}
    }
    let opened = network::open(Part::Client(std::slice::from_ref(&router.0), CONNECT), None).await;
    opened.map_err(|error| failed(format!("something answers there that is no router of Zenoh 1 ({error})")))
}
