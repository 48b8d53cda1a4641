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
    /// An address that cannot be read.
    #[error("'{0}' is no address here: one is like tls/ground.local:7447, quic/192.168.1.2:7447 or tcp/127.0.0.1:7447")]
    Address(String),
    /// The same of a router of ROS 2.
    #[error(
        "'{0}' is no router of ROS 2: one is like tcp/127.0.0.1:7447 or tls/robot.local:7447, with a host name or an address"
    )]
    RosRouter(String),
    /// A router of ROS 2 on another machine, in the clear without having been asked for.
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
    /// A router of ROS 2 that does not let us in, or that is not believed.
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
    /// Services that act, for whoever reaches a router elsewhere.
    #[error(
        "{0} is not of this machine, and whoever reaches that router could command the plane: act by a router on this machine, or only read"
    )]
    RosOperator(String),
    /// A name or address of a machine that cannot be read.
    #[error("'{0}' is no name or address of a machine: one is like ground.example.org or 192.168.1.2")]
    Host(String),
    /// An address that others could reach: what goes over TCP alone is not encrypted.
    #[error("{0} is not of this machine, and nothing is encrypted there: use tls/ or quic/ in place of tcp/")]
    NotLoopback(String),
    /// TLS and QUIC are for who has certificates.
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
    /// A text that is no token.
    #[error("this is no token of `vencejo fleet enrol`: {0}; copy it again as a whole")]
    Token(String),
    /// A token that is for another kind of station.
    #[error("this token is for {0}")]
    TokenFor(&'static str),
    /// A role that there is not.
    #[error("'{0}' is no role of a ground station: observer, operator or chief")]
    Role(String),
    /// The ground station does not give a certificate.
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
    /// A file of ours.
    #[error("{path}: {problem}")]
    File {
        /// Which.
        path: String,
        /// What is wrong.
        problem: String,
    },
    /// The station has no vehicle that it could speak for.
    #[error("no random numbers are to be had: {0}")]
    NoRandom(String),
}
