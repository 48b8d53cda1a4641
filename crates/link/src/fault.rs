//! Why a link is not up.

use std::fmt;

/// What kind of fault it is: what to do about it follows from that, in whatever language.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FaultKind {
    /// Another program listens at that place.
    AddressInUse,
    /// To listen there, this machine would have to have that address.
    NotOurAddress,
    /// The system does not let us: a serial port of another group, a port below 1024.
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

/// Why a link is not up.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LinkFault {
    /// Its kind.
    pub kind: FaultKind,
    /// What went wrong where, in the system's words too, and what to do about the usual reasons; a sentence without a full stop.
    pub detail: String,
}

impl LinkFault {
    pub(crate) fn new(kind: FaultKind, detail: impl Into<String>) -> Self {
        Self { kind, detail: detail.into() }
    }
}

impl fmt::Display for LinkFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.detail)
    }
}

impl From<std::io::Error> for LinkFault {
    fn from(error: std::io::Error) -> Self {
        use std::io::ErrorKind;
        let kind = match error.kind() {
            ErrorKind::ConnectionRefused => FaultKind::Refused,
            ErrorKind::ConnectionReset | ErrorKind::ConnectionAborted | ErrorKind::BrokenPipe => {
                FaultKind::ClosedByPeer
            }
            ErrorKind::TimedOut => FaultKind::NoAnswer,
            _ => FaultKind::Other,
        };
        Self::new(kind, error.to_string())
    }
}
