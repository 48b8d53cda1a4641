//! The protocol of the door, for enrolment and renewal of certificates: one request and one answer, in Protocol
//! Buffers, length-prefixed.

use prost::Message;

use crate::error::FleetError;
use crate::payload::VERSION;

/// Most bytes of either.
pub const MAX_BYTES: usize = 16 * 1024;

/// The refusal of an otherwise acceptable caller with an invalid request: an aircraft without a request checks so
/// whether it is still enrolled.
pub const BAD_REQUEST: &str = "the request is not good";

/// A request for a certificate.
#[derive(Clone, PartialEq, Message)]
pub struct Asked {
    /// The protocol version.
    #[prost(uint32, tag = "1")]
    pub version: u32,
    /// The secret of its token; empty if it authenticates with its present certificate.
    #[prost(bytes = "vec", tag = "2")]
    pub secret: Vec<u8>,
    /// Its request (PKCS #10).
    #[prost(bytes = "vec", tag = "3")]
    pub request: Vec<u8>,
    /// A ground station that joins: the public key that it signs orders with.
    #[prost(bytes = "vec", tag = "4")]
    pub operator: Vec<u8>,
}

/// The answer.
#[derive(Clone, PartialEq, Message)]
pub struct Given {
    /// The protocol version.
    #[prost(uint32, tag = "1")]
    pub version: u32,
    /// Why it gets nothing; empty where it does.
    #[prost(string, tag = "2")]
    pub refused: String,
    /// The organisation.
    #[prost(string, tag = "3")]
    pub org: String,
    /// The common name of its certificate.
    #[prost(string, tag = "4")]
    pub name: String,
    /// Its certificate, as PEM.
    #[prost(string, tag = "5")]
    pub certificate: String,
    /// That of the organisation's authority.
    #[prost(string, tag = "6")]
    pub ca: String,
    /// The ground stations, routers and doors: a [`SignedStations`](super::stations::SignedStations).
    #[prost(bytes = "vec", tag = "7")]
    pub stations: Vec<u8>,
}

impl Given {
    /// Nothing, and why.
    pub fn refused(why: impl Into<String>) -> Self {
        Self { version: VERSION, refused: why.into(), ..Self::default() }
    }

    /// What the ground answered, looked through.
    ///
    /// # Errors
    /// [`FleetError::Refused`] with its words; or where it makes no sense.
    pub fn checked(self) -> Result<Self, FleetError> {
        if !self.refused.is_empty() {
            // What is shown of it has an end.
            return Err(FleetError::Refused(vencejo_proto::plain(&self.refused, 300)));
        }
        if self.version != VERSION {
            let why = "its answer cannot be read: use the same version of Vencejo on both sides";
            return Err(FleetError::Refused(why.into()));
        }
        Ok(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_answer_has_an_end_and_one_version() {
        let read = |given: Given| given.checked().map_err(|error| error.to_string());
        let good = Given { version: VERSION, name: "plane7".into(), ..Given::default() };
        assert_eq!(read(good.clone()), Ok(good.clone()));
        let long = read(Given::refused("no\u{7}".repeat(1_000))).expect_err("refused");
        assert!(long.len() < 400 && !long.contains('\u{7}'), "{long}");
        let bad = Given { version: 2, ..good };
        assert!(read(bad).is_err_and(|error| error.contains("the same version of Vencejo")));
    }
}
