//! Where an aircraft was, as Foxglove's map shows it: its well-known message `foxglove.LocationFix`.

use vencejo_proto::Message;
use vencejo_proto::dialect::MavMessage;

use crate::payload::State;

/// GLOBAL_POSITION_INT.
const POSITION_ID: u32 = 33;

/// `google.protobuf.Timestamp`.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct Timestamp {
    /// Seconds since 1970.
    #[prost(int64, tag = "1")]
    pub seconds: i64,
    /// Nanoseconds, 0 to 999,999,999.
    #[prost(int32, tag = "2")]
    pub nanos: i32,
}

/// A position; of Foxglove's message the fields that there are.
#[derive(Clone, PartialEq, prost::Message)]
pub struct LocationFix {
    /// WGS-84.
    #[prost(double, tag = "1")]
    pub latitude: f64,
    /// WGS-84.
    #[prost(double, tag = "2")]
    pub longitude: f64,
    /// Above mean sea level, m.
    #[prost(double, tag = "3")]
    pub altitude: f64,
    /// When, UTC.
    #[prost(message, optional, tag = "6")]
    pub timestamp: Option<Timestamp>,
    /// Name of the aircraft.
    #[prost(string, tag = "7")]
    pub frame_id: String,
}

impl LocationFix {
    /// The position that a state tells, where it does; `unix_ns` is when the state was made.
    pub fn of(state: &State, unix_ns: u64, aircraft: &str) -> Option<Self> {
        let said = state.said().find(|said| said.message_id == POSITION_ID)?;
        let Some(Message::Dialect(MavMessage::GLOBAL_POSITION_INT(position))) = said.message() else { return None };
        if (position.lat, position.lon) == (0, 0) {
            // Before the first fix.
            return None;
        }
        let at = unix_ns.saturating_sub(u64::from(said.age_ms) * 1_000_000);
        let timestamp = Timestamp {
            seconds: i64::try_from(at / 1_000_000_000).unwrap_or(i64::MAX),
            nanos: i32::try_from(at % 1_000_000_000).unwrap_or(0),
        };
        Some(Self {
            latitude: f64::from(position.lat) / 1e7,
            longitude: f64::from(position.lon) / 1e7,
            altitude: f64::from(position.alt) / 1e3,
            timestamp: Some(timestamp),
            frame_id: aircraft.to_owned(),
        })
    }
}
