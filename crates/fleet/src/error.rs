//! What can go wrong between the stations of a fleet.

use thiserror::Error;

use crate::key::BadName;
use crate::ros2::name::BadRosName;
use crate::signature::BadKey;

/// Why a fleet cannot be joined.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum FleetError {
    /// Name of an organisation or an aircraft.
    #[error(transparent)]
    Name(#[from] BadName),
    /// An operator's key.
    #[error(transparent)]
    Key(#[from] BadKey),
    /// An invalid address.
    #[error(
        "'{0}' is not a valid address; expected for example tls/ground.local:7447, quic/192.168.1.2:7447 or tcp/127.0.0.1:7447"
    )]
    Address(String),
    /// The same of a router of ROS 2.
    #[error(
        "'{0}' is not the address of a ROS 2 router; expected for example tcp/127.0.0.1:7447 or tls/robot.local:7447, with a host name or an address"
    )]
    RosRouter(String),
    /// An unencrypted router of ROS 2 on another machine that was not explicitly allowed.
    #[error(
        "{0} is not of this machine, and nothing is encrypted there: use tls/ in place of tcp/, with --ros2-ca, or --ros2-plain to do without"
    )]
    RosPlain(String),
    /// Certificates that are missing or too many for a router of ROS 2.
    #[error("{address}: {problem}")]
    RosPapers {
        /// The router.
        address: String,
        /// What is wrong, and what to do.
        problem: &'static str,
    },
    /// A router of ROS 2 that refuses us, or whose certificate is not trusted.
    #[error("{address} cannot be used: {problem}")]
    RosUnreached {
        /// Where.
        address: String,
        /// A stable name.
        code: &'static str,
        /// What is wrong, and what to do.
        problem: String,
    },
    /// A name or a domain of ROS 2.
    #[error(transparent)]
    Ros(#[from] BadRosName),
    /// Acting services at a router that others can reach.
    #[error(
        "{0} is not of this machine, and whoever reaches that router could command the plane: act by a router on this machine, or only read"
    )]
    RosOperator(String),
    /// An invalid host name or address.
    #[error("'{0}' is not a host name or address; expected for example ground.example.org or 192.168.1.2")]
    Host(String),
    /// An address that others could reach: TCP alone is not encrypted.
    #[error("{0} is not of this machine, and nothing is encrypted there: use tls/ or quic/ in place of tcp/")]
    NotLoopback(String),
    /// TLS and QUIC require certificates.
    #[error("{0} needs certificates, and there are none here: {1}")]
    NoCertificates(String, String),
    /// A certificate, a key or a request for one.
    #[error("{what}: {problem}")]
    Certificate {
        /// Which.
        what: String,
        /// What is wrong.
        problem: String,
    },
    /// An invalid token.
    #[error("this is not a token of `vencejo fleet enrol`: {0}; copy it again as a whole")]
    Token(String),
    /// A token that is for another kind of station.
    #[error("this token is for {0}")]
    TokenFor(&'static str),
    /// An unknown role.
    #[error("'{0}' is not a role of a ground station: observer, operator or chief")]
    Role(String),
    /// The ground station refused to issue a certificate.
    #[error("the ground station says: {0}")]
    Refused(String),
    /// The network could not be opened.
    #[error("{address} cannot be used: {problem}")]
    Network {
        /// Where.
        address: String,
        /// What it said.
        problem: String,
    },
    /// A file of this program.
    #[error("{path}: {problem}")]
    File {
        /// Which.
        path: String,
        /// What is wrong.
        problem: String,
    },
    /// The station has no vehicle to represent.
    #[error("no random numbers are to be had: {0}")]
    NoRandom(String),
}
