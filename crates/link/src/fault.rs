//! Why a link is not up.

use std::fmt;

/// The kind of fault, from which a front end derives what to do about it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FaultKind {
    /// Another program listens at that address.
    AddressInUse,
    /// This machine does not have the address to listen on.
    NotOurAddress,
    /// Permission denied: a port below 1024.
    NoPermission,
    /// Permission denied: a serial port of a group that the user is not in.
    NoSerialPermission,
    /// There is no such serial port.
    NoSerialPort,
    /// Another program uses the serial port.
    SerialPortInUse,
    /// The serial port does not have that baud rate.
    NoBaudRate,
    /// The host name has no address.
    NoHost,
    /// The machine answers, and nothing listens at the port.
    Refused,
    /// No answer came in time.
    NoAnswer,
    /// The other end closed the connection.
    ClosedByPeer,
    /// Another one; see the detail.
    Other,
}

/// Why a link is not up.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LinkFault {
    /// Its kind.
    pub kind: FaultKind,
    /// What went wrong and where, with the system's error and a hint for the usual reasons; a sentence without a full
    /// stop.
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
