//! Any message of the dialect by the names of its fields: for callers that inspect or send raw messages.
//!
//! Numbers are those of the wire, enums and bit masks included, so that a value without a name in this dialect is kept
//! as it is (`docs/adr/0003`). Requests to vehicles do not use this.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use thiserror::Error;

use crate::frame::DecodeError;
use crate::info::message_id_of;
use crate::layouts::LAYOUTS;

/// The longest payload.
const MAX_PAYLOAD: usize = 255;

/// A field's value as the wire has it.
#[derive(Debug, Clone, PartialEq)]
pub enum FieldValue {
    /// An unsigned number.
    Unsigned(u64),
    /// A signed number.
    Signed(i64),
    /// A floating-point number; may be NaN, which many messages use for "not known".
    Float(f64),
    /// Text, up to its first zero.
    Text(String),
    /// Several numbers.
    List(Vec<FieldValue>),
}

/// Why a message cannot be made of fields.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum FieldError {
    /// There is no such message.
    #[error("there is no message '{name}' in the dialect; names are like 'COMMAND_LONG'")]
    UnknownMessage {
        /// What was asked for.
        name: String,
    },
    /// The message has no such field.
    #[error("{message} has no field '{field}'; it has {known}")]
    UnknownField {
        /// The message.
        message: String,
        /// What was asked for.
        field: String,
        /// Those that it has.
        known: String,
    },
    /// A value that the field cannot hold.
    #[error("{message}.{field} takes {expected}")]
    BadValue {
        /// The message.
        message: String,
        /// The field.
        field: String,
        /// What it takes.
        expected: String,
    },
    /// Values that are valid each, but not together.
    #[error(transparent)]
    NoMessage(#[from] DecodeError),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Unsigned,
    Signed,
    Float,
    Text,
}

/// One field: `count` values of `size` bytes each; a list where `is_list`.
#[derive(Debug, Clone, Copy)]
struct Field {
    name: &'static str,
    kind: Kind,
    size: usize,
    count: usize,
    is_list: bool,
}

impl Field {
    fn parse(text: &'static str) -> Option<Self> {
        let (name, rest) = text.split_once(':')?;
        let (kind, count) = rest.split_once('*').map_or((rest, None), |(kind, count)| (kind, Some(count)));
        let size = |bits: &str| bits.parse::<usize>().ok().map(|bits| bits / 8);
        let (kind, size) = match kind.split_at_checked(1)? {
            ("u", bits) => (Kind::Unsigned, size(bits)?),
            ("i", bits) => (Kind::Signed, size(bits)?),
            ("f", bits) => (Kind::Float, size(bits)?),
            _ => (Kind::Text, 1),
        };
        let is_list = count.is_some() && kind != Kind::Text;
        Some(Self { name, kind, size, count: count.map_or(Some(1), |count| count.parse().ok())?, is_list })
    }

    fn read(self, bytes: &[u8]) -> FieldValue {
        if self.kind == Kind::Text {
            let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
            return FieldValue::Text(String::from_utf8_lossy(&bytes[..end]).into_owned());
        }
        let mut values = bytes.chunks(self.size).map(|value| self.read_one(value));
        if self.is_list {
            return FieldValue::List(values.collect());
        }
        values.next().unwrap_or(FieldValue::Unsigned(0))
    }

    fn read_one(self, bytes: &[u8]) -> FieldValue {
        let mut wide = [0_u8; 8];
        wide[..bytes.len()].copy_from_slice(bytes);
        let number = u64::from_le_bytes(wide);
        let unused = 64 - 8 * bytes.len() as u32;
        match (self.kind, self.size) {
            (Kind::Float, 4) => FieldValue::Float(f32::from_bits(number as u32).into()),
            (Kind::Float, _) => FieldValue::Float(f64::from_bits(number)),
            // Shifted up and down again to extend the sign.
            (Kind::Signed, _) => FieldValue::Signed((number << unused) as i64 >> unused),
            _ => FieldValue::Unsigned(number),
        }
    }

    fn write(self, value: &FieldValue, bytes: &mut [u8]) -> Option<()> {
        match value {
            FieldValue::Text(text) if self.kind == Kind::Text => {
                bytes.get_mut(..text.len())?.copy_from_slice(text.as_bytes());
            }
            // The text may not be UTF-8.
            FieldValue::List(values) if self.kind == Kind::Text && values.len() <= self.count => {
                for (value, byte) in values.iter().zip(bytes) {
                    let FieldValue::Unsigned(value) = value else { return None };
                    *byte = u8::try_from(*value).ok()?;
                }
            }
            FieldValue::List(values) if self.is_list && values.len() <= self.count => {
                for (value, place) in values.iter().zip(bytes.chunks_mut(self.size)) {
                    self.write_one(value, place)?;
                }
            }
            value if !self.is_list && self.kind != Kind::Text => self.write_one(value, bytes)?,
            _ => return None,
        }
        Some(())
    }

    fn write_one(self, value: &FieldValue, bytes: &mut [u8]) -> Option<()> {
        let bits = 8 * self.size as u32;
        let wide = match (self.kind, value) {
            (Kind::Float, value) => {
                let value = match value {
                    FieldValue::Float(value) => *value,
                    FieldValue::Unsigned(value) => *value as f64,
                    FieldValue::Signed(value) => *value as f64,
                    _ => return None,
                };
                if self.size == 4 {
                    let narrow = value as f32;
                    // Only infinity may be infinite.
                    (narrow.is_infinite() == value.is_infinite()).then_some(u64::from(narrow.to_bits()))?
                } else {
                    value.to_bits()
                }
            }
            (Kind::Unsigned, FieldValue::Unsigned(value)) => (bits == 64 || *value >> bits == 0).then_some(*value)?,
            (Kind::Unsigned, FieldValue::Signed(value)) => {
                let value = u64::try_from(*value).ok()?;
                (bits == 64 || value >> bits == 0).then_some(value)?
            }
            (Kind::Signed, value) => {
                let value = match value {
                    FieldValue::Signed(value) => *value,
                    FieldValue::Unsigned(value) => i64::try_from(*value).ok()?,
                    _ => return None,
                };
                let unused = 64 - bits;
                ((value << unused) >> unused == value).then_some(value as u64)?
            }
            _ => return None,
        };
        bytes.copy_from_slice(&wide.to_le_bytes()[..self.size]);
        Some(())
    }

    fn expected(self) -> String {
        let bits = 8 * self.size;
        let one = match self.kind {
            Kind::Unsigned => format!("a whole number of {bits} bits, not negative"),
            Kind::Signed => format!("a whole number of {bits} bits"),
            Kind::Float => "a number".to_owned(),
            Kind::Text => return format!("text of at most {} bytes", self.count),
        };
        if self.is_list { format!("a list of at most {}, each {one}", self.count) } else { one }
    }
}

fn layout(id: u32) -> Option<&'static [Field]> {
    static TABLE: OnceLock<BTreeMap<u32, Vec<Field>>> = OnceLock::new();
    let table = TABLE.get_or_init(|| {
        LAYOUTS.iter().map(|(id, fields)| (*id, fields.split(' ').filter_map(Field::parse).collect())).collect()
    });
    table.get(&id).map(Vec::as_slice)
}

/// The fields of a payload; bytes missing at its end read as zero. `None` for a message that the dialect does not have.
pub fn decode_fields(id: u32, payload: &[u8]) -> Option<Vec<(&'static str, FieldValue)>> {
    let mut whole = [0_u8; MAX_PAYLOAD];
    let len = payload.len().min(MAX_PAYLOAD);
    whole[..len].copy_from_slice(&payload[..len]);
    let mut at = 0;
    layout(id).map(|fields| {
        let read = |field: &Field| {
            let bytes = &whole[at..at + field.size * field.count];
            at += bytes.len();
            (field.name, field.read(bytes))
        };
        fields.iter().map(read).collect()
    })
}

/// Whether a message has a field of this name.
pub(crate) fn has_field(id: u32, name: &str) -> bool {
    layout(id).is_some_and(|fields| fields.iter().any(|field| field.name == name))
}

/// Id and payload of a message made of its fields; those not given are zero.
///
/// # Errors
/// [`FieldError`] for a message or field that does not exist, or a value that does not fit.
pub fn encode_fields(name: &str, values: &BTreeMap<String, FieldValue>) -> Result<(u32, Vec<u8>), FieldError> {
    let unknown = || FieldError::UnknownMessage { name: name.chars().take(60).collect() };
    let id = message_id_of(name).ok_or_else(unknown)?;
    let fields = layout(id).ok_or_else(unknown)?;
    if let Some(field) = values.keys().find(|key| !fields.iter().any(|field| field.name == key.as_str())) {
        let known: Vec<_> = fields.iter().map(|field| field.name).collect();
        let field = field.chars().take(60).collect();
        return Err(FieldError::UnknownField { message: name.to_owned(), field, known: known.join(", ") });
    }
    let mut payload = vec![0; fields.iter().map(|field| field.size * field.count).sum()];
    let mut rest = payload.as_mut_slice();
    for field in fields {
        let (bytes, after) = rest.split_at_mut(field.size * field.count);
        rest = after;
        if let Some(value) = values.get(field.name) {
            field.write(value, bytes).ok_or_else(|| FieldError::BadValue {
                message: name.to_owned(),
                field: field.name.to_owned(),
                expected: field.expected(),
            })?;
        }
    }
    Ok((id, payload))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::info::message_name;
    use crate::{CommandLong, MavVersion, Message};

    fn given(values: &[(&str, FieldValue)]) -> BTreeMap<String, FieldValue> {
        values.iter().map(|(name, value)| ((*name).to_owned(), value.clone())).collect()
    }

    #[test]
    fn every_message_of_the_decoder_has_a_layout_that_fits_a_frame() {
        let mut compared = 0;
        for (id, text) in LAYOUTS {
            let fields = layout(*id).expect("there");
            assert_eq!(fields.len(), text.split(' ').count(), "{text}");
            let len: usize = fields.iter().map(|field| field.size * field.count).sum();
            assert!((1..=MAX_PAYLOAD).contains(&len), "{id}: {len}");
            if message_name(*id).is_some() {
                compared += 1;
            }
        }
        assert!(compared > 250, "{compared}");
    }

    #[test]
    fn fields_are_those_of_the_definition() {
        // HEARTBEAT of a fixed-wing ArduPlane in AUTO, armed (mavlink.io, ids 0 and 11).
        let payload = [10, 0, 0, 0, 1, 3, 209, 4, 3];
        let fields: BTreeMap<_, _> = decode_fields(0, &payload).expect("known").into_iter().collect();
        assert_eq!(fields["custom_mode"], FieldValue::Unsigned(10));
        assert_eq!((&fields["type"], &fields["autopilot"]), (&FieldValue::Unsigned(1), &FieldValue::Unsigned(3)));
        assert_eq!(fields["base_mode"], FieldValue::Unsigned(209));
        assert_eq!(decode_fields(u32::MAX, &[]), None);
    }

    #[test]
    fn a_message_made_of_fields_is_the_one_that_the_codec_reads() {
        let values = given(&[
            ("target_system", FieldValue::Unsigned(1)),
            ("command", FieldValue::Unsigned(400)),
            ("param1", FieldValue::Unsigned(1)),
            ("param7", FieldValue::Float(-2.5)),
        ]);
        let (id, payload) = encode_fields("COMMAND_LONG", &values).expect("fits");
        let Ok(Message::CommandLong(CommandLong { target, command, params, .. })) =
            Message::from_payload(MavVersion::V2, id, &payload)
        else {
            panic!("a COMMAND_LONG");
        };
        assert_eq!((target.system.0, command, params[0], params[6]), (1, 400, 1.0, -2.5));
        let back: BTreeMap<_, _> = decode_fields(id, &payload).expect("known").into_iter().collect();
        assert_eq!(back["param7"], FieldValue::Float(-2.5));
    }

    #[test]
    fn texts_lists_and_signs_survive() {
        let values = given(&[("severity", FieldValue::Unsigned(6)), ("text", FieldValue::Text("hola".into()))]);
        let (id, payload) = encode_fields("STATUSTEXT", &values).expect("fits");
        let back: BTreeMap<_, _> = decode_fields(id, &payload).expect("known").into_iter().collect();
        assert_eq!(back["text"], FieldValue::Text("hola".into()));
        let cells = FieldValue::List(vec![FieldValue::Unsigned(4100), FieldValue::Unsigned(4090)]);
        let values = given(&[("voltages", cells), ("current_battery", FieldValue::Signed(-1))]);
        let (id, payload) = encode_fields("BATTERY_STATUS", &values).expect("fits");
        let back: BTreeMap<_, _> = decode_fields(id, &payload).expect("known").into_iter().collect();
        assert_eq!(back["current_battery"], FieldValue::Signed(-1));
        let FieldValue::List(cells) = &back["voltages"] else { panic!("a list") };
        assert_eq!((cells.len(), &cells[1]), (10, &FieldValue::Unsigned(4090)));
    }

    #[test]
    fn what_does_not_fit_says_what_would() {
        for (name, field, value, word) in [
            ("NO_SUCH", "x", FieldValue::Unsigned(1), "no message"),
            ("HEARTBEAT", "colour", FieldValue::Unsigned(1), "custom_mode"),
            ("HEARTBEAT", "type", FieldValue::Unsigned(256), "8 bits"),
            ("HEARTBEAT", "type", FieldValue::Signed(-1), "not negative"),
            ("HEARTBEAT", "type", FieldValue::Float(1.0), "whole"),
            ("HEARTBEAT", "type", FieldValue::Text("plane".into()), "whole"),
            ("ATTITUDE", "roll", FieldValue::Float(1e300), "a number"),
            ("STATUSTEXT", "text", FieldValue::Text("x".repeat(51)), "50 bytes"),
            ("BATTERY_STATUS", "voltages", FieldValue::List(vec![FieldValue::Unsigned(1); 11]), "at most 10"),
        ] {
            let error = encode_fields(name, &given(&[(field, value)])).expect_err("does not fit").to_string();
            assert!(error.contains(word), "{error}");
        }
    }
}
