//! What can go wrong between the stations of a fleet.

use thiserror::Error;

use crate::key::BadName;
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
    #[error("'{0}' is no address here: one is like tcp/127.0.0.1:7447")]
    Address(String),
    /// An address that others could reach: what goes over it is not encrypted.
    #[error(
        "{0} is not of this machine, and nothing here is encrypted yet: use tcp/127.0.0.1:PORT, through a tunnel (SSH, WireGuard) to another machine"
    )]
    NotLoopback(String),
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
