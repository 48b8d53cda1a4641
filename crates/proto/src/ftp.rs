//! The payload of FILE_TRANSFER_PROTOCOL (110): a 12-byte header and up to 239 bytes of data.
//!
//! Layout, opcodes and error codes: <https://mavlink.io/en/services/ftp.html>, "Payload Format". Opcodes and errors
//! keep their raw number, because a vehicle may use one that is not listed here.

use std::fmt;

use crate::dialect::{FILE_TRANSFER_PROTOCOL_DATA, MavMessage};
use crate::frame::Target;
use crate::ids::{Address, ComponentId, SystemId};
use crate::message::Message;

/// Bytes of header in front of the data.
const HEADER_LEN: usize = 12;

/// Most data bytes that one message carries.
pub const FTP_MAX_DATA: usize = 239;

/// What a MAVFTP message asks or answers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct FtpOpcode(pub u8);

impl FtpOpcode {
    /// End a session and close its file. ArduPilot applies an uploaded plan here.
    pub const TERMINATE_SESSION: Self = Self(1);
    /// End all sessions; ArduPilot ends only the one that the message names.
    pub const RESET_SESSIONS: Self = Self(2);
    /// Open a file to read; the answer's data is its size as u32.
    pub const OPEN_FILE_RO: Self = Self(4);
    /// Read `size` bytes at `offset`.
    pub const READ_FILE: Self = Self(5);
    /// Create a file, or empty it, and open it to write.
    pub const CREATE_FILE: Self = Self(6);
    /// Write the data at `offset`.
    pub const WRITE_FILE: Self = Self(7);
    /// Open an existing file to write.
    pub const OPEN_FILE_WO: Self = Self(11);
    /// Compute the CRC-32 of a file.
    pub const CALC_FILE_CRC32: Self = Self(14);
    /// Read from `offset` to the end, many answers to one request.
    pub const BURST_READ_FILE: Self = Self(15);
    /// Done.
    pub const ACK: Self = Self(128);
    /// Not done; the data's first byte is an [`FtpError`].
    pub const NAK: Self = Self(129);

    /// The opcode's name in the specification.
    pub const fn name(self) -> &'static str {
        match self.0 {
            0 => "None",
            1 => "TerminateSession",
            2 => "ResetSessions",
            3 => "ListDirectory",
            4 => "OpenFileRO",
            5 => "ReadFile",
            6 => "CreateFile",
            7 => "WriteFile",
            8 => "RemoveFile",
            9 => "CreateDirectory",
            10 => "RemoveDirectory",
            11 => "OpenFileWO",
            12 => "TruncateFile",
            13 => "Rename",
            14 => "CalcFileCRC32",
            15 => "BurstReadFile",
            128 => "ACK",
            129 => "NAK",
            _ => "unknown opcode",
        }
    }
}

impl fmt::Display for FtpOpcode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Why a MAVFTP request was refused: the error code, and errno when the code is [`FtpError::FAIL_ERRNO`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct FtpError {
    /// The error code of the specification.
    pub code: u8,
    /// The vehicle's file system error (errno), when the answer carries one.
    pub errno: Option<u8>,
}

impl FtpError {
    /// Unknown failure. ArduPilot: a file is already open in this session.
    pub const FAIL: u8 = 1;
    /// Failure with an errno.
    pub const FAIL_ERRNO: u8 = 2;
    /// The size field is invalid.
    pub const INVALID_DATA_SIZE: u8 = 3;
    /// The session is not open. ArduPilot: another session has a file open.
    pub const INVALID_SESSION: u8 = 4;
    /// All sessions are taken.
    pub const NO_SESSIONS_AVAILABLE: u8 = 5;
    /// Offset behind the end of the file.
    pub const END_OF_FILE: u8 = 6;
    /// The opcode is not known to the vehicle.
    pub const UNKNOWN_COMMAND: u8 = 7;
    /// The file exists already.
    pub const FILE_EXISTS: u8 = 8;
    /// The file may not be written.
    pub const FILE_PROTECTED: u8 = 9;
    /// No such file. ArduPilot also: no file is open.
    pub const FILE_NOT_FOUND: u8 = 10;

    /// An error without errno.
    pub const fn new(code: u8) -> Self {
        Self { code, errno: None }
    }

    /// The error's name in the specification.
    pub const fn name(self) -> &'static str {
        match self.code {
            0 => "None",
            1 => "Fail",
            2 => "FailErrno",
            3 => "InvalidDataSize",
            4 => "InvalidSession",
            5 => "NoSessionsAvailable",
            6 => "EndOfFile",
            7 => "UnknownCommand",
            8 => "FileExists",
            9 => "FileProtected",
            10 => "FileNotFound",
            _ => "unknown error",
        }
    }
}

impl fmt::Display for FtpError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.errno {
            Some(errno) => write!(f, "{} (code {}, errno {errno})", self.name(), self.code),
            None => write!(f, "{} (code {})", self.name(), self.code),
        }
    }
}

/// Why a MAVFTP payload could not be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("MAVFTP payload says {size} bytes of data, but {FTP_MAX_DATA} fit; the message is dropped")]
pub struct FtpPayloadError {
    /// The size field.
    pub size: u8,
}

/// One MAVFTP request or answer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FtpPayload {
    /// Number of the message; an answer carries the request's number plus one, wrapping.
    pub sequence: u16,
    /// The session that the message belongs to.
    pub session: u8,
    /// The request, or ACK / NAK.
    pub opcode: FtpOpcode,
    /// Bytes of data; in a read request, bytes wanted.
    pub size: u8,
    /// In an answer, the opcode that it answers.
    pub req_opcode: FtpOpcode,
    /// In an answer to a burst read, whether this is the last one of the burst.
    pub burst_complete: bool,
    /// Place in the file, bytes.
    pub offset: u32,
    /// The data, at most [`FTP_MAX_DATA`] bytes.
    pub data: Vec<u8>,
}

impl FtpPayload {
    /// A request that carries `data` (a path, or bytes to write), cut at [`FTP_MAX_DATA`].
    pub fn request(opcode: FtpOpcode, session: u8, sequence: u16, offset: u32, data: &[u8]) -> Self {
        let data = data[..data.len().min(FTP_MAX_DATA)].to_vec();
        Self {
            sequence,
            session,
            opcode,
            size: data.len() as u8,
            req_opcode: FtpOpcode(0),
            burst_complete: false,
            offset,
            data,
        }
    }

    /// A request for `size` bytes at `offset`.
    pub fn read_request(opcode: FtpOpcode, session: u8, sequence: u16, offset: u32, size: u8) -> Self {
        Self { size, ..Self::request(opcode, session, sequence, offset, &[]) }
    }

    /// Reads the payload of a message.
    ///
    /// # Errors
    /// [`FtpPayloadError`] when the size field is larger than what fits.
    pub fn decode(payload: &[u8; 251]) -> Result<Self, FtpPayloadError> {
        let size = payload[4];
        let Some(data) = payload[HEADER_LEN..].get(..usize::from(size)) else {
            return Err(FtpPayloadError { size });
        };
        Ok(Self {
            sequence: u16::from_le_bytes([payload[0], payload[1]]),
            session: payload[2],
            opcode: FtpOpcode(payload[3]),
            size,
            req_opcode: FtpOpcode(payload[5]),
            burst_complete: payload[6] != 0,
            offset: u32::from_le_bytes([payload[8], payload[9], payload[10], payload[11]]),
            data: data.to_vec(),
        })
    }

    /// Writes the payload of a message; data behind [`FTP_MAX_DATA`] bytes is cut.
    pub fn encode(&self) -> [u8; 251] {
        let mut payload = [0u8; 251];
        payload[..2].copy_from_slice(&self.sequence.to_le_bytes());
        payload[2] = self.session;
        payload[3] = self.opcode.0;
        payload[4] = self.size.min(FTP_MAX_DATA as u8);
        payload[5] = self.req_opcode.0;
        payload[6] = u8::from(self.burst_complete);
        payload[8..12].copy_from_slice(&self.offset.to_le_bytes());
        let len = self.data.len().min(FTP_MAX_DATA);
        payload[HEADER_LEN..HEADER_LEN + len].copy_from_slice(&self.data[..len]);
        payload
    }

    /// The message that carries this payload to `target`.
    pub fn to_message(&self, target: Address) -> Message {
        Message::Dialect(MavMessage::FILE_TRANSFER_PROTOCOL(FILE_TRANSFER_PROTOCOL_DATA {
            target_network: 0,
            target_system: target.system.0,
            target_component: target.component.0,
            payload: self.encode(),
        }))
    }

    /// The payload of a FILE_TRANSFER_PROTOCOL message and its target; `None` for any other message and for an invalid
    /// payload.
    pub fn from_message(message: &Message) -> Option<(Target, Self)> {
        let Message::Dialect(MavMessage::FILE_TRANSFER_PROTOCOL(message)) = message else { return None };
        let target = Target {
            system: Some(SystemId(message.target_system)),
            component: Some(ComponentId(message.target_component)),
        };
        Some((target, Self::decode(&message.payload).ok()?))
    }

    /// The error of a NAK; `None` for any other opcode.
    pub fn error(&self) -> Option<FtpError> {
        (self.opcode == FtpOpcode::NAK).then(|| {
            let code = self.data.first().copied().unwrap_or(FtpError::FAIL);
            let errno = self.data.get(1).copied().filter(|_| code == FtpError::FAIL_ERRNO);
            FtpError { code, errno }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn an_open_request_has_the_bytes_of_the_specification() {
        let payload = FtpPayload::request(FtpOpcode::OPEN_FILE_RO, 7, 0x1234, 0, b"@PARAM/param.pck").encode();
        assert_eq!(&payload[..12], &[0x34, 0x12, 7, 4, 16, 0, 0, 0, 0, 0, 0, 0]);
        assert_eq!(&payload[12..28], b"@PARAM/param.pck");
        assert!(payload[28..].iter().all(|byte| *byte == 0));
    }

    #[test]
    fn a_size_that_does_not_fit_is_refused() {
        let mut payload = [0u8; 251];
        payload[4] = 240;
        assert_eq!(FtpPayload::decode(&payload), Err(FtpPayloadError { size: 240 }));
        payload[4] = 239;
        assert_eq!(FtpPayload::decode(&payload).map(|p| p.data.len()), Ok(239));
    }

    #[test]
    fn a_nak_without_data_is_still_an_error() {
        let mut nak = FtpPayload::request(FtpOpcode::NAK, 0, 0, 0, &[]);
        assert_eq!(nak.error(), Some(FtpError::new(FtpError::FAIL)));
        nak.data = vec![2, 28];
        assert_eq!(nak.error().map(|e| e.to_string()), Some("FailErrno (code 2, errno 28)".to_owned()));
    }

    proptest! {
        // fault 53 (256 cases): any bytes as a MAVFTP message
        #[test]
        fn any_bytes_decode_or_are_refused(bytes in proptest::collection::vec(any::<u8>(), 251)) {
            let payload: [u8; 251] = bytes.try_into().expect("251 bytes");
            if let Ok(decoded) = FtpPayload::decode(&payload) {
                prop_assert!(decoded.data.len() <= FTP_MAX_DATA);
                let again = FtpPayload::decode(&decoded.encode()).expect("what was read can be written");
                prop_assert_eq!(again, decoded);
            } else {
                prop_assert!(payload[4] > 239);
            }
        }
    }
}
