//! Parameters: their names, typed values, both ways of putting a value into a float, and ArduPilot's packed file.
//!
//! Encodings: <https://mavlink.io/en/services/parameter.html>, "Parameter Encoding". Packed file `@PARAM/param.pck`
//! (ArduPilot): three u16 (magic 0x671b, or 0x671c with default values; parameters in the file; parameters in all),
//! then for each parameter a byte with type (low four bits: 1 i8, 2 i16, 3 i32, 4 f32) and flags (bit 0: a default
//! value follows; in a file with default values, one without this flag has its default value), a byte with the number of name bytes shared with the previous name (low) and of further ones less
//! one (high), those bytes, and the value. Zero bytes between parameters are padding.

use std::fmt;

use crate::dialect::MavParamType;

/// Most bytes of a parameter's name.
pub const PARAM_NAME_LEN: usize = 16;

/// Why a parameter's name or value is invalid.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ParamError {
    /// Not a parameter's name.
    #[error("{name:?} is not a parameter name: a name has 1 to 16 printable ASCII characters without spaces")]
    BadName {
        /// What was given.
        name: String,
    },
    /// The value is not a finite number.
    #[error("{value} cannot be a parameter's value; give a finite number")]
    NotFinite {
        /// What was given.
        value: f64,
    },
    /// The parameter is a whole number.
    #[error("{value} has a fraction, but the parameter is a whole number ({param_type}); give a whole number")]
    NotWhole {
        /// What was given.
        value: f64,
        /// The parameter's type.
        param_type: ParamType,
    },
    /// The type cannot hold the value.
    #[error("{value} does not fit into the parameter's type {param_type} ({min} to {max})")]
    OutOfRange {
        /// What was given.
        value: f64,
        /// The parameter's type.
        param_type: ParamType,
        /// Smallest value that fits.
        min: f64,
        /// Largest value that fits.
        max: f64,
    },
    /// How the vehicle encodes a whole number is unknown.
    #[error(
        "parameter {name} is a whole number, and whether this autopilot takes those as numbers or as bytes is not known: its \
         AUTOPILOT_VERSION does not say, and its value fits both; read all of its parameters, then try again"
    )]
    UnknownEncoding {
        /// The parameter's name.
        name: ParamName,
    },
    /// A packed parameter file that cannot be read.
    #[error("packed parameter file, byte {at}: {problem}")]
    BadFile {
        /// Where.
        at: usize,
        /// What is wrong.
        problem: &'static str,
    },
}

/// A parameter's name: 1 to 16 printable ASCII characters.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ParamName {
    bytes: [u8; PARAM_NAME_LEN],
    len: u8,
}

impl ParamName {
    /// Checks a name.
    ///
    /// # Errors
    /// [`ParamError::BadName`] when it is empty, too long, or has other characters.
    pub fn new(name: &str) -> Result<Self, ParamError> {
        Self::from_bytes(name.as_bytes()).ok_or_else(|| ParamError::BadName { name: name.chars().take(40).collect() })
    }

    /// Reads a name from a message's field, which ends at its first zero byte; `None` when it is not a valid name.
    pub fn from_field(field: &[u8; PARAM_NAME_LEN]) -> Option<Self> {
        let end = field.iter().position(|byte| *byte == 0).unwrap_or(PARAM_NAME_LEN);
        Self::from_bytes(&field[..end])
    }

    fn from_bytes(name: &[u8]) -> Option<Self> {
        let fits = (1..=PARAM_NAME_LEN).contains(&name.len()) && name.iter().all(u8::is_ascii_graphic);
        fits.then(|| {
            let mut bytes = [0u8; PARAM_NAME_LEN];
            bytes[..name.len()].copy_from_slice(name);
            Self { bytes, len: name.len() as u8 }
        })
    }

    /// The name.
    pub fn as_str(&self) -> &str {
        std::str::from_utf8(&self.bytes[..usize::from(self.len)]).expect("invariant: a parameter name is ASCII")
    }

    /// The name as a message's field, filled with zeros.
    pub fn to_field(self) -> [u8; PARAM_NAME_LEN] {
        self.bytes
    }
}

impl fmt::Display for ParamName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.as_str())
    }
}

impl fmt::Debug for ParamName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.as_str().fmt(f)
    }
}

/// Type of a parameter, of those that fit into a PARAM_VALUE.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[allow(missing_docs, reason = "the names are Rust's own")]
pub enum ParamType {
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    F32,
}

impl ParamType {
    /// The type of `MAV_PARAM_TYPE`; `None` for the 64-bit types, which fit into no PARAM_VALUE.
    pub fn from_mav(param_type: MavParamType) -> Option<Self> {
        Some(match param_type {
            MavParamType::MAV_PARAM_TYPE_UINT8 => Self::U8,
            MavParamType::MAV_PARAM_TYPE_INT8 => Self::I8,
            MavParamType::MAV_PARAM_TYPE_UINT16 => Self::U16,
            MavParamType::MAV_PARAM_TYPE_INT16 => Self::I16,
            MavParamType::MAV_PARAM_TYPE_UINT32 => Self::U32,
            MavParamType::MAV_PARAM_TYPE_INT32 => Self::I32,
            MavParamType::MAV_PARAM_TYPE_REAL32 => Self::F32,
            _ => return None,
        })
    }

    /// As `MAV_PARAM_TYPE`.
    pub fn to_mav(self) -> MavParamType {
        match self {
            Self::U8 => MavParamType::MAV_PARAM_TYPE_UINT8,
            Self::I8 => MavParamType::MAV_PARAM_TYPE_INT8,
            Self::U16 => MavParamType::MAV_PARAM_TYPE_UINT16,
            Self::I16 => MavParamType::MAV_PARAM_TYPE_INT16,
            Self::U32 => MavParamType::MAV_PARAM_TYPE_UINT32,
            Self::I32 => MavParamType::MAV_PARAM_TYPE_INT32,
            Self::F32 => MavParamType::MAV_PARAM_TYPE_REAL32,
        }
    }

    /// Smallest and largest value.
    pub fn range(self) -> (f64, f64) {
        match self {
            Self::U8 => (0.0, f64::from(u8::MAX)),
            Self::I8 => (f64::from(i8::MIN), f64::from(i8::MAX)),
            Self::U16 => (0.0, f64::from(u16::MAX)),
            Self::I16 => (f64::from(i16::MIN), f64::from(i16::MAX)),
            Self::U32 => (0.0, f64::from(u32::MAX)),
            Self::I32 => (f64::from(i32::MIN), f64::from(i32::MAX)),
            Self::F32 => (f64::from(f32::MIN), f64::from(f32::MAX)),
        }
    }
}

impl fmt::Display for ParamType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::U8 => "u8",
            Self::I8 => "i8",
            Self::U16 => "u16",
            Self::I16 => "i16",
            Self::U32 => "u32",
            Self::I32 => "i32",
            Self::F32 => "f32",
        })
    }
}

/// How a vehicle puts an integer parameter into the float of PARAM_VALUE and PARAM_SET.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ParamEncoding {
    /// As a number, `5` becomes `5.0` (ArduPilot; `MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_C_CAST`).
    CCast,
    /// As its bytes (PX4; `MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_BYTEWISE`).
    Bytewise,
}

/// Which encodings the values of a vehicle have shown.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ShownEncodings {
    c_cast: bool,
    bytewise: bool,
}

impl ShownEncodings {
    /// Takes the float of a PARAM_VALUE into account.
    ///
    /// A float below 2^-126 holds the bytes of a whole number up to 8,388,607; a NaN holds those of a negative one,
    /// unless it is the NaN of arithmetic. A whole number other than 0 is sent as a number: as bytes it would exceed 8
    /// and 16 bits, and 10^9 in 32 bits. Zero fits both encodings, and any other float shows nothing.
    pub fn note(&mut self, raw: f32, param_type: ParamType) {
        if param_type == ParamType::F32 || raw == 0.0 {
            return;
        }
        let is_made = raw.to_bits() & 0x7fff_ffff == f32::NAN.to_bits();
        self.bytewise |= raw.is_subnormal() || raw.is_nan() && raw.is_sign_negative() && !is_made;
        self.c_cast |= ParamValue::from_wire(raw, param_type, ParamEncoding::CCast).is_some();
    }

    /// The only encoding shown so far; `None` for none or both.
    pub fn only(self) -> Option<ParamEncoding> {
        match self {
            Self { c_cast: true, bytewise: false } => Some(ParamEncoding::CCast),
            Self { c_cast: false, bytewise: true } => Some(ParamEncoding::Bytewise),
            _ => None,
        }
    }
}

/// A parameter's value with its type.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(missing_docs, reason = "the names are Rust's own")]
pub enum ParamValue {
    U8(u8),
    I8(i8),
    U16(u16),
    I16(i16),
    U32(u32),
    I32(i32),
    F32(f32),
}

impl ParamValue {
    /// A checked value of a type.
    ///
    /// # Errors
    /// [`ParamError::NotFinite`], [`ParamError::NotWhole`] or [`ParamError::OutOfRange`].
    pub fn new(param_type: ParamType, value: f64) -> Result<Self, ParamError> {
        if !value.is_finite() {
            return Err(ParamError::NotFinite { value });
        }
        let (min, max) = param_type.range();
        if !(min..=max).contains(&value) {
            return Err(ParamError::OutOfRange { value, param_type, min, max });
        }
        if param_type != ParamType::F32 && value.fract() != 0.0 {
            return Err(ParamError::NotWhole { value, param_type });
        }
        Ok(match param_type {
            ParamType::U8 => Self::U8(value as u8),
            ParamType::I8 => Self::I8(value as i8),
            ParamType::U16 => Self::U16(value as u16),
            ParamType::I16 => Self::I16(value as i16),
            ParamType::U32 => Self::U32(value as u32),
            ParamType::I32 => Self::I32(value as i32),
            ParamType::F32 => Self::F32(value as f32),
        })
    }

    /// Reads the float of a PARAM_VALUE.
    ///
    /// A float that is NaN or infinite, and an integer that its type cannot hold, are `None`. A C-cast integer above
    /// 2^24 has lost its last bits on the wire; at the very top of the type the float rounds past it and is clamped
    /// back.
    pub fn from_wire(raw: f32, param_type: ParamType, encoding: ParamEncoding) -> Option<Self> {
        if param_type == ParamType::F32 {
            return raw.is_finite().then_some(Self::F32(raw));
        }
        if encoding == ParamEncoding::Bytewise {
            let b = raw.to_bits().to_le_bytes();
            return Some(match param_type {
                ParamType::U8 => Self::U8(b[0]),
                ParamType::I8 => Self::I8(b[0] as i8),
                ParamType::U16 => Self::U16(u16::from_le_bytes([b[0], b[1]])),
                ParamType::I16 => Self::I16(i16::from_le_bytes([b[0], b[1]])),
                ParamType::U32 => Self::U32(u32::from_le_bytes(b)),
                ParamType::I32 | ParamType::F32 => Self::I32(i32::from_le_bytes(b)),
            });
        }
        let (min, max) = param_type.range();
        let value = f64::from(raw);
        let rounded_up = f64::from(max as f32);
        let value = if value > max && value <= rounded_up { max } else { value };
        (value >= min).then_some(())?;
        Self::new(param_type, value).ok()
    }

    /// The float for PARAM_SET.
    pub fn to_wire(self, encoding: ParamEncoding) -> f32 {
        if encoding == ParamEncoding::CCast {
            return self.as_f64() as f32;
        }
        let bits = match self {
            Self::U8(value) => u32::from(value),
            Self::I8(value) => u32::from(value as u8),
            Self::U16(value) => u32::from(value),
            Self::I16(value) => u32::from(value as u16),
            Self::U32(value) => value,
            Self::I32(value) => value as u32,
            Self::F32(value) => return value,
        };
        f32::from_bits(bits)
    }

    /// The value's type.
    pub fn param_type(self) -> ParamType {
        match self {
            Self::U8(_) => ParamType::U8,
            Self::I8(_) => ParamType::I8,
            Self::U16(_) => ParamType::U16,
            Self::I16(_) => ParamType::I16,
            Self::U32(_) => ParamType::U32,
            Self::I32(_) => ParamType::I32,
            Self::F32(_) => ParamType::F32,
        }
    }

    /// The value as a number, exact.
    pub fn as_f64(self) -> f64 {
        match self {
            Self::U8(value) => f64::from(value),
            Self::I8(value) => f64::from(value),
            Self::U16(value) => f64::from(value),
            Self::I16(value) => f64::from(value),
            Self::U32(value) => f64::from(value),
            Self::I32(value) => f64::from(value),
            Self::F32(value) => f64::from(value),
        }
    }
}

impl fmt::Display for ParamValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::F32(value) => value.fmt(f),
            other => other.as_f64().fmt(f),
        }
    }
}

/// One parameter of a vehicle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Param {
    /// Its name.
    pub name: ParamName,
    /// Its value.
    pub value: ParamValue,
    /// Its default value on this vehicle, of the same type. `None`: not reported; PARAM_VALUE has no field for it.
    pub default: Option<ParamValue>,
}

impl Param {
    /// A parameter without a default value.
    pub fn new(name: ParamName, value: ParamValue) -> Self {
        Self { name, value, default: None }
    }
}

const PACKED_MAGIC: u16 = 0x671b;
const PACKED_MAGIC_WITH_DEFAULTS: u16 = 0x671c;
const PACKED_HEADER_LEN: usize = 6;

/// Reads ArduPilot's packed parameter file.
///
/// # Errors
/// [`ParamError::BadFile`] when it is truncated, its count does not match, or a name or type is invalid. A float that
/// is not finite is refused too.
pub fn decode_packed_params(file: &[u8]) -> Result<Vec<Param>, ParamError> {
    let bad = |at, problem| Err(ParamError::BadFile { at, problem });
    let Some(header) = file.get(..PACKED_HEADER_LEN) else { return bad(file.len(), "the header is cut") };
    let magic = u16::from_le_bytes([header[0], header[1]]);
    if magic != PACKED_MAGIC && magic != PACKED_MAGIC_WITH_DEFAULTS {
        return bad(0, "the file does not start with 0x671b or 0x671c");
    }
    let has_defaults = magic == PACKED_MAGIC_WITH_DEFAULTS;
    let count = usize::from(u16::from_le_bytes([header[2], header[3]]));
    // A parameter takes at least four bytes, so a hostile count reserves no more than the file's size.
    let mut params = Vec::with_capacity(count.min(file.len() / 4));
    let mut name = [0u8; PARAM_NAME_LEN];
    let mut name_len = 0;
    let mut at = PACKED_HEADER_LEN;
    while params.len() < count {
        while file.get(at) == Some(&0) {
            at += 1;
        }
        let (Some(kind), Some(lengths)) = (file.get(at), file.get(at + 1)) else {
            return bad(at, "the file ends before its last parameter");
        };
        let start = at;
        let (common, further) = (usize::from(lengths & 0x0f), usize::from(lengths >> 4) + 1);
        if common > name_len || common + further > PARAM_NAME_LEN {
            return bad(start, "a name is longer than 16 characters or shares more than there was");
        }
        at += 2;
        let Some(tail) = file.get(at..at + further) else { return bad(start, "the file ends within a name") };
        name_len = common + further;
        name[common..name_len].copy_from_slice(tail);
        at += further;
        let value_len = match kind & 0x0f {
            1 => 1,
            2 => 2,
            3 | 4 => 4,
            _ => return bad(start, "a parameter has an unknown type"),
        };
        let mut value = || {
            let bytes = file.get(at..at + value_len);
            at += value_len;
            Some(match (kind & 0x0f, bytes?) {
                (1, &[b]) => ParamValue::I8(b as i8),
                (2, &[b0, b1]) => ParamValue::I16(i16::from_le_bytes([b0, b1])),
                (3, &[b0, b1, b2, b3]) => ParamValue::I32(i32::from_le_bytes([b0, b1, b2, b3])),
                (_, &[b0, b1, b2, b3]) => ParamValue::F32(f32::from_le_bytes([b0, b1, b2, b3])),
                _ => return None,
            })
        };
        let Some(current) = value() else { return bad(start, "the file ends within a value") };
        if !current.as_f64().is_finite() {
            return bad(start, "a value is not a finite number");
        }
        let default = match (kind & 0x10 != 0, has_defaults) {
            (true, _) => match value() {
                Some(default) => Some(default).filter(|default| default.as_f64().is_finite()),
                None => return bad(start, "the file ends within a default value"),
            },
            (false, true) => Some(current),
            (false, false) => None,
        };
        let Some(name) = ParamName::from_bytes(&name[..name_len]) else {
            return bad(start, "a name has characters that are not printable ASCII");
        };
        params.push(Param { name, value: current, default });
    }
    if file.get(at..).is_none_or(|rest| rest.iter().any(|byte| *byte != 0)) {
        return bad(at, "there are bytes behind the last parameter");
    }
    Ok(params)
}

/// Writes ArduPilot's packed parameter file, padded so that no value crosses a multiple of `read_size` bytes; with the
/// default values that are known, if all are. Unsigned types, which the file does not know, are written as the next
/// larger signed one.
pub fn encode_packed_params(params: &[Param], read_size: usize) -> Vec<u8> {
    let count = params.len().min(usize::from(u16::MAX));
    let mut file = Vec::with_capacity(PACKED_HEADER_LEN + 12 * count);
    let has_defaults = !params.is_empty() && params.iter().all(|param| param.default.is_some());
    let magic = if has_defaults { PACKED_MAGIC_WITH_DEFAULTS } else { PACKED_MAGIC };
    for field in [magic, count as u16, count as u16] {
        file.extend_from_slice(&field.to_le_bytes());
    }
    let mut last: &[u8] = &[];
    for param in &params[..count] {
        let name = param.name.as_str().as_bytes();
        let common = last.iter().zip(name).take_while(|(a, b)| a == b).count().min(name.len() - 1).min(15);
        let (kind, value) = packed_value(param.value);
        let default = param.default.filter(|default| has_defaults && *default != param.value);
        let default = default.map(|default| packed_value(default).1).unwrap_or_default();
        let flags = if default.is_empty() { 0 } else { 0x10 };
        let further = &name[common..];
        let end = file.len() + 2 + further.len() + value.len() + default.len();
        let over = end % read_size.max(1);
        if (1..value.len()).contains(&over) {
            file.resize(file.len() + value.len() - over, 0);
        }
        file.extend_from_slice(&[kind | flags, common as u8 | ((further.len() as u8 - 1) << 4)]);
        file.extend_from_slice(further);
        file.extend_from_slice(&value);
        file.extend_from_slice(&default);
        last = name;
    }
    file
}

/// Type and bytes of a value in the packed file.
fn packed_value(value: ParamValue) -> (u8, Vec<u8>) {
    match value {
        ParamValue::I8(value) => (1, value.to_le_bytes().to_vec()),
        ParamValue::U8(value) => (2, i16::from(value).to_le_bytes().to_vec()),
        ParamValue::I16(value) => (2, value.to_le_bytes().to_vec()),
        ParamValue::U16(value) => (3, i32::from(value).to_le_bytes().to_vec()),
        ParamValue::I32(value) => (3, value.to_le_bytes().to_vec()),
        ParamValue::U32(value) => (4, (value as f32).to_le_bytes().to_vec()),
        ParamValue::F32(value) => (4, value.to_le_bytes().to_vec()),
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use proptest::prelude::*;

    /// Read from a real ArduPlane by MAVFTP, and the same parameters as text by PARAM_REQUEST_LIST.
    const PACKED: &[u8] = include_bytes!("../../../tests/fixtures/captures/param.pck");
    const TEXT: &str = include_str!("../../../tests/fixtures/captures/arduplane-params.parm");

    #[test]
    fn the_packed_file_of_a_real_arduplane_holds_what_its_parameter_list_says() {
        let packed = decode_packed_params(PACKED).expect("a packed file");
        assert_eq!(packed.len(), 1399);
        let by_name: BTreeMap<String, Param> = packed.iter().map(|p| (p.name.to_string(), *p)).collect();
        assert_eq!(by_name.len(), 1399);
        let mut differing = Vec::new();
        for line in TEXT.lines() {
            let fields: Vec<&str> = line.split_whitespace().collect();
            let [name, value, mav_type] = fields[..] else { panic!("three fields in {line:?}") };
            let param = by_name[name];
            assert_eq!((param.value.param_type().to_mav() as u8).to_string(), mav_type, "{name}");
            let (text, packed): (f64, f64) = (value.parse().expect("a number"), param.value.as_f64());
            if (text - packed).abs() > 1e-5 * text.abs().max(1.0) {
                differing.push(name);
            }
        }
        // The two were read minutes apart; between them RTL_AUTOLAND was set, and the others change by themselves.
        let moved = |name: &&str| {
            *name == "RTL_AUTOLAND"
                || name.starts_with("STAT_")
                || name.ends_with("GND_PRESS")
                || name.ends_with("TOTAL")
        };
        assert!(differing.iter().all(moved), "{differing:?}");
    }

    #[test]
    fn names_and_values_are_checked() {
        assert!(ParamName::new("WP_RADIUS").is_ok());
        for bad in ["", "SEVENTEEN_LETTERS", "A B", "ñ", "A\0B"] {
            assert!(matches!(ParamName::new(bad), Err(ParamError::BadName { .. })), "{bad:?}");
        }
        assert_eq!(ParamValue::new(ParamType::I8, -128.0), Ok(ParamValue::I8(-128)));
        assert!(matches!(ParamValue::new(ParamType::I8, 128.0), Err(ParamError::OutOfRange { .. })));
        assert!(matches!(ParamValue::new(ParamType::I16, 1.5), Err(ParamError::NotWhole { .. })));
        assert!(matches!(ParamValue::new(ParamType::F32, f64::NAN), Err(ParamError::NotFinite { .. })));
        assert!(matches!(ParamValue::new(ParamType::F32, 1e39), Err(ParamError::OutOfRange { .. })));
    }

    #[test]
    fn values_show_the_encoding_where_only_one_fits() {
        use ParamEncoding::{Bytewise, CCast};
        let shown = |values: &[(f32, ParamType)]| {
            let mut shown = ShownEncodings::default();
            values.iter().for_each(|(raw, param_type)| shown.note(*raw, *param_type));
            shown.only()
        };
        for value in [ParamValue::U8(7), ParamValue::I16(-300), ParamValue::U32(8_388_607), ParamValue::I32(-8_000_000)]
        {
            for encoding in [CCast, Bytewise] {
                assert_eq!(
                    shown(&[(value.to_wire(encoding), value.param_type())]),
                    Some(encoding),
                    "{value} {encoding:?}"
                );
            }
        }
        let bytes = f32::from_bits(5);
        for raw in [0.0, -0.0, f32::NAN, -f32::NAN, f32::INFINITY, 0.5, 1e12] {
            assert_eq!(shown(&[(raw, ParamType::I32)]), None, "{raw}");
        }
        assert_eq!(shown(&[(bytes, ParamType::F32), (5.0, ParamType::F32)]), None, "floats are themselves in each");
        assert_eq!(shown(&[(bytes, ParamType::I32), (5.0, ParamType::U8)]), None, "it cannot be both");
    }

    #[test]
    fn both_encodings_carry_integers() {
        assert_eq!(ParamValue::I32(5).to_wire(ParamEncoding::CCast), 5.0);
        assert_eq!(ParamValue::I32(5).to_wire(ParamEncoding::Bytewise).to_bits(), 5);
        let read = |raw, kind, encoding| ParamValue::from_wire(raw, kind, encoding);
        assert_eq!(read(-3.0, ParamType::I8, ParamEncoding::CCast), Some(ParamValue::I8(-3)));
        assert_eq!(read(f32::from_bits(0xfd), ParamType::I8, ParamEncoding::Bytewise), Some(ParamValue::I8(-3)));
        assert_eq!(read(2_147_483_648.0, ParamType::I32, ParamEncoding::CCast), Some(ParamValue::I32(i32::MAX)));
        for raw in [f32::NAN, f32::INFINITY] {
            assert_eq!(read(raw, ParamType::F32, ParamEncoding::CCast), None);
            assert_eq!(read(raw, ParamType::I16, ParamEncoding::CCast), None);
        }
        assert_eq!(read(300.0, ParamType::U8, ParamEncoding::CCast), None);
    }

    fn any_param() -> impl Strategy<Value = Param> {
        let value = prop_oneof![
            any::<i8>().prop_map(ParamValue::I8),
            any::<i16>().prop_map(ParamValue::I16),
            any::<i32>().prop_map(ParamValue::I32),
            (-1e9f32..1e9).prop_map(ParamValue::F32),
        ];
        ("[A-Z][A-Z0-9_]{0,15}", value)
            .prop_map(|(name, value)| Param::new(ParamName::new(&name).expect("a name"), value))
    }

    proptest! {
        #[test]
        fn packed_files_round_trip(params in proptest::collection::vec(any_param(), 0..80), size in 20usize..240) {
            prop_assert_eq!(decode_packed_params(&encode_packed_params(&params, size)), Ok(params));
        }

        #[test]
        fn default_values_round_trip(
            params in proptest::collection::vec((any_param(), any_param()), 0..80),
            size in 20usize..240,
        ) {
            let with_default = |(param, other): (Param, Param)| {
                let is_same_type = param.value.param_type() == other.value.param_type();
                Param { default: Some(if is_same_type { other.value } else { param.value }), ..param }
            };
            let params: Vec<Param> = params.into_iter().map(with_default).collect();
            prop_assert_eq!(decode_packed_params(&encode_packed_params(&params, size)), Ok(params));
        }

        // fault 53 (256 cases): any bytes as packed parameters
        #[test]
        fn any_bytes_decode_or_are_refused(mut bytes in proptest::collection::vec(any::<u8>(), 0..400), honest: bool) {
            if honest && bytes.len() > 2 {
                bytes[..2].copy_from_slice(&PACKED_MAGIC.to_le_bytes());
            }
            let _ = decode_packed_params(&bytes);
        }

        #[test]
        fn a_damaged_file_is_refused_or_reads_as_some_list(at in 0usize..15_675, to: u8) {
            let mut file = PACKED.to_vec();
            file[at] = to;
            if let Ok(params) = decode_packed_params(&file) {
                prop_assert!(params.len() <= usize::from(u16::MAX));
            }
        }

        #[test]
        fn any_value_survives_both_encodings(param in any_param()) {
            for encoding in [ParamEncoding::CCast, ParamEncoding::Bytewise] {
                let wire = param.value.to_wire(encoding);
                let exact = encoding == ParamEncoding::Bytewise || param.value.as_f64().abs() < 16_777_216.0;
                let back = ParamValue::from_wire(wire, param.value.param_type(), encoding);
                if exact { prop_assert_eq!(back, Some(param.value)); } else { prop_assert!(back.is_some()); }
            }
        }
    }
}
