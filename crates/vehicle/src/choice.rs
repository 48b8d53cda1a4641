//! Choices in the values of requests: a mode, a message and its rate, the reference of an altitude.

use std::str::FromStr;

#[cfg(feature = "describe")]
use serde::de::{Deserialize, Deserializer};
use vencejo_proto::{FieldError, message_id_of};

use crate::error::VehicleError;
#[cfg(feature = "describe")]
use crate::several::Kinds;

/// Slowest rate of any message, Hz: its interval fits a whole number of 32 bits of microseconds, as which ArduPilot
/// takes it.
pub const SLOWEST_HZ: f64 = 0.0005;
/// Fastest rate of any message, Hz.
pub const MAX_RATE_HZ: f64 = 50.0;

/// A flight mode as a caller names it.
#[derive(Debug, Clone, PartialEq, Eq)]
#[cfg_attr(feature = "describe", derive(serde::Serialize, utoipa::ToSchema), serde(untagged))]
pub enum ModeChoice {
    /// By the number of HEARTBEAT's `custom_mode`.
    Custom(u32),
    /// By name: `"AUTO"`, `"fbwa"`, `"Avoid ADSB"`, `"mode 42"`.
    Name(String),
}

#[cfg(feature = "describe")]
impl<'de> Deserialize<'de> for ModeChoice {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = |name: &str| Some(Self::Name(name.to_owned()));
        Kinds { expected: "the name of a mode or its number", number: Self::Custom, text, list: None }
            .read(deserializer)
    }
}

/// The reference of an altitude in a request.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "describe",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case")
)]
pub enum AltFrame {
    /// Above mean sea level (`MAV_FRAME_GLOBAL`).
    Amsl,
    /// Above home (`MAV_FRAME_GLOBAL_RELATIVE_ALT`).
    #[cfg_attr(feature = "describe", serde(rename = "home"))]
    RelHome,
    /// Above the terrain below (`MAV_FRAME_GLOBAL_TERRAIN_ALT`).
    Terrain,
}

impl AltFrame {
    /// The number on the wire (`MAV_FRAME`).
    pub const fn mav_frame(self) -> u8 {
        match self {
            Self::Amsl => 0,
            Self::RelHome => 3,
            Self::Terrain => 10,
        }
    }
}

/// Which speed DO_CHANGE_SPEED sets.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "describe",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case")
)]
pub enum SpeedKind {
    /// Through the air.
    Airspeed,
    /// Over ground.
    Groundspeed,
}

/// The sense of a circle. Serialised as whether it is clockwise.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "describe", derive(serde::Serialize, serde::Deserialize), serde(from = "bool", into = "bool"))]
pub enum Turn {
    /// Clockwise seen from above.
    #[default]
    Clockwise,
    /// Counter-clockwise seen from above.
    CounterClockwise,
}

/// A MAVLink message. Read from its name in the dialect, such as `"ATTITUDE"`, or its number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "describe", derive(serde::Serialize, serde::Deserialize), serde(try_from = "MessageChoice"))]
pub struct MessageId(pub u32);

impl FromStr for MessageId {
    type Err = FieldError;

    fn from_str(text: &str) -> Result<Self, FieldError> {
        let is_number = text.bytes().all(|byte| byte.is_ascii_digit());
        let number = is_number.then(|| text.parse().ok()).flatten();
        let id = number.or_else(|| message_id_of(&text.to_ascii_uppercase()));
        id.map(Self).ok_or_else(|| FieldError::UnknownMessage { name: text.chars().take(60).collect() })
    }
}

/// A MAVLink message: its name in the dialect, or its number.
#[cfg(feature = "describe")]
#[derive(utoipa::ToSchema)]
#[serde(untagged)]
pub enum MessageChoice {
    /// Its number.
    Number(u32),
    /// Its name, such as `"ATTITUDE"`.
    Name(String),
}

#[cfg(feature = "describe")]
impl<'de> Deserialize<'de> for MessageChoice {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = |name: &str| Some(Self::Name(name.to_owned()));
        let expected = "the name of a message or its number";
        Kinds { expected, number: Self::Number, text, list: None }.read(deserializer)
    }
}

#[cfg(feature = "describe")]
impl TryFrom<MessageChoice> for MessageId {
    type Error = FieldError;

    fn try_from(choice: MessageChoice) -> Result<Self, FieldError> {
        match choice {
            MessageChoice::Number(number) => Ok(Self(number)),
            MessageChoice::Name(name) => name.parse(),
        }
    }
}

/// The rate at which a vehicle is to send a message. Read from a number, where 0 is the vehicle's own rate, or a word.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(
    feature = "describe",
    derive(serde::Serialize, serde::Deserialize),
    serde(from = "RateChoice", into = "RateChoice")
)]
pub enum MessageRate {
    /// Messages per second, [`SLOWEST_HZ`] to [`MAX_RATE_HZ`].
    Hz(f64),
    /// The vehicle's own rate, set by its parameters.
    Default,
    /// Not at all.
    Stop,
}

impl MessageRate {
    /// The same rate, checked.
    ///
    /// # Errors
    /// [`VehicleError::InvalidValue`] for a rate outside [`SLOWEST_HZ`] to [`MAX_RATE_HZ`].
    pub fn checked(self) -> Result<Self, VehicleError> {
        match self {
            Self::Hz(rate_hz) if !(SLOWEST_HZ..=MAX_RATE_HZ).contains(&rate_hz) => Err(VehicleError::InvalidValue {
                field: "rate_hz",
                value: rate_hz.to_string(),
                expected: "0.0005 (one in 2,000 s) to 50 messages per second, \"default\" or \"stop\"",
            }),
            rate => Ok(rate),
        }
    }

    /// The interval of MAV_CMD_SET_MESSAGE_INTERVAL, µs: 0 is the vehicle's own, −1 stops.
    pub fn interval_us(self) -> f32 {
        match self {
            Self::Hz(rate_hz) => (1e6 / rate_hz).round() as f32,
            Self::Default => 0.0,
            Self::Stop => -1.0,
        }
    }
}

/// A rate: messages per second, 0.0005 to 50, of which 0 stands for the vehicle's own rate; or a word.
#[cfg(feature = "describe")]
#[derive(Clone, serde::Serialize, utoipa::ToSchema)]
#[serde(untagged)]
pub enum RateChoice {
    /// Messages per second.
    Number(f64),
    /// A word.
    Word(RateWord),
}

#[cfg(feature = "describe")]
impl<'de> Deserialize<'de> for RateChoice {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = |word: &str| match word {
            "default" => Some(Self::Word(RateWord::Default)),
            "stop" => Some(Self::Word(RateWord::Stop)),
            _ => None,
        };
        let expected = "a number (messages per second), \"default\" or \"stop\"";
        Kinds { expected, number: Self::Number, text, list: None }.read(deserializer)
    }
}

/// A rate given as a word.
#[cfg(feature = "describe")]
#[derive(Clone, Copy, serde::Serialize, utoipa::ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum RateWord {
    /// The vehicle's own.
    Default,
    /// None.
    Stop,
}

#[cfg(feature = "describe")]
impl From<RateChoice> for MessageRate {
    fn from(choice: RateChoice) -> Self {
        match choice {
            RateChoice::Word(RateWord::Default) | RateChoice::Number(0.0) => Self::Default,
            RateChoice::Word(RateWord::Stop) => Self::Stop,
            RateChoice::Number(rate_hz) => Self::Hz(rate_hz),
        }
    }
}

#[cfg(feature = "describe")]
impl From<MessageRate> for RateChoice {
    fn from(rate: MessageRate) -> Self {
        match rate {
            MessageRate::Hz(rate_hz) => Self::Number(rate_hz),
            MessageRate::Default => Self::Word(RateWord::Default),
            MessageRate::Stop => Self::Word(RateWord::Stop),
        }
    }
}
