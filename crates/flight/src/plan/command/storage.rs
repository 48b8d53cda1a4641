//! How ArduPlane stores the parameters of mission commands: what is sent is not always what reads back.
//!
//! Source: the packing rules of ArduPilot's mission library (`AP_Mission::mavlink_int_to_mission_cmd` and back).

/// In what form ArduPlane keeps a field, hence what it reads back.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Storage {
    /// Not kept: reads back as 0.
    Dropped,
    /// Kept as it is (32-bit float).
    Float,
    /// Kept as a half-precision float.
    Half,
    /// Cut to a whole number of 8 bits, 0 to 255.
    U8,
    /// Cut to a whole number of 8 bits, −128 to 127.
    I8,
    /// Cut to a whole number of 16 bits, 0 to 65,535.
    U16,
    /// Cut to a whole number of 16 bits, −32,768 to 32,767.
    I16,
    /// As [`Storage::U16`], then at most 255 (half of a 16-bit field).
    U16Max255,
    /// Hundredths in 16 bits, 0 to 655.35.
    CentiU16,
    /// Magnitude as [`Storage::U16`], sign kept (negative: counter-clockwise).
    SignedU16,
    /// More than 0 reads back as 1, anything else as 0.
    Positive,
    /// Lowest bit of the whole number.
    Bit0,
    /// Negative reads back as −1, anything else as 1.
    LoiterSign,
    /// As [`Storage::LoiterSign`]; unset (NaN) reads back as 1.
    YawSign,
    /// Whole turns 0 to 255; a part of one turn in steps of 1/256.
    Turns,
    /// Metres up to 255, above that tens of metres up to 2,550; sign kept.
    TurnsRadius,
    /// A whole number on the wire, lowest 8 bits kept.
    LowU8,
    /// A whole number on the wire, lowest 16 bits kept as a signed number.
    LowI16,
    /// Reads back as 2 whatever was sent.
    Two,
    /// Whole degrees within ±180, else 0.
    RollDegrees,
    /// Whole degrees within ±90, else 0.
    PitchDegrees,
    /// Whole degrees from −180 to 360, else 0.
    YawDegrees,
    /// Metres; whole when within a millimetre above a whole number.
    FenceRadius,
    /// degE7 on the wire, kept exactly.
    DegE7,
    /// Whole centimetres, cut towards 0.
    Centimetres,
}

impl Storage {
    /// Whether a value can be converted as it is stored: anything but a float passes through a 32-bit whole number.
    ///
    /// Other conversions are undefined behaviour (ISO C++, 7.10): ArduPilot's simulator crashes, a board stores any
    /// value.
    pub fn converts(self, sent: f32) -> bool {
        let factor = match self {
            Self::Dropped | Self::Float | Self::Half => return true,
            Self::CentiU16 | Self::Centimetres => 100.0,
            _ => 1.0,
        };
        (sent * factor).abs() < 2_147_483_648.0
    }

    /// The value that is read back after this one was sent (as the 32-bit float of the wire).
    ///
    /// Values beyond the range of the storage saturate here; on a vehicle they are undefined, so the checks refuse
    /// them.
    pub fn keep(self, sent: f32) -> f32 {
        let whole_within = |low: f32, high: f32| {
            if (low..=high).contains(&sent) { sent.trunc() } else { 0.0 }
        };
        match self {
            Self::Dropped => 0.0,
            Self::Float | Self::DegE7 => sent,
            Self::Half => half_precision(sent),
            Self::U8 => f32::from(sent as u8),
            Self::I8 => f32::from(sent as i8),
            Self::U16 => f32::from(sent as u16),
            Self::I16 => f32::from(sent as i16),
            Self::U16Max255 => f32::from((sent as u16).min(255)),
            Self::CentiU16 => f32::from((sent * 100.0) as u16) * 0.01,
            Self::SignedU16 => with_sign(f32::from(sent.abs() as u16), sent),
            Self::Positive => f32::from(u8::from(sent > 0.0)),
            Self::Bit0 => ((sent as u32) & 1) as f32,
            Self::LoiterSign => {
                if sent < 0.0 {
                    -1.0
                } else {
                    1.0
                }
            }
            Self::YawSign => {
                if sent <= -f32::EPSILON {
                    -1.0
                } else {
                    1.0
                }
            }
            Self::Turns => {
                if sent > 0.0 && sent < 1.0 {
                    f32::from((sent * 256.0) as u8) / 256.0
                } else {
                    f32::from(sent.min(255.0) as u8)
                }
            }
            Self::TurnsRadius => {
                let radius_m = sent.abs();
                let kept_m = if radius_m <= 255.0 {
                    f32::from(radius_m as u8)
                } else {
                    f32::from((radius_m * 0.1).min(255.0) as u8) * 10.0
                };
                with_sign(kept_m, sent)
            }
            Self::LowU8 => f32::from(sent as i32 as u8),
            Self::LowI16 => f32::from(sent as i32 as i16),
            Self::Two => 2.0,
            Self::RollDegrees => whole_within(-180.0, 180.0),
            Self::PitchDegrees => whole_within(-90.0, 90.0),
            Self::YawDegrees => whole_within(-180.0, 360.0),
            Self::FenceRadius => {
                if sent - sent.trunc() < 0.001 {
                    sent.trunc()
                } else {
                    sent
                }
            }
            Self::Centimetres => ((sent * 100.0) as i32) as f32 / 100.0,
        }
    }
}

fn with_sign(magnitude: f32, sign: f32) -> f32 {
    if sign < 0.0 { -magnitude } else { magnitude }
}

/// Nearest value that an IEEE 754 half-precision float can hold, as ArduPilot rounds: the lowest twelve
/// bits of the fraction are cut, then half up.
fn half_precision(value: f32) -> f32 {
    const MAX: f32 = 65_504.0;
    if value.is_nan() {
        return value;
    }
    let magnitude = f32::from_bits(value.abs().to_bits() & 0xFFFF_F000);
    // Step of a half float: 2^-10 of the power of two below the value, 2^-24 for subnormals.
    let exponent = (magnitude.to_bits() >> 23) as i32 - 127;
    let step = 2.0_f32.powi(exponent.max(-14) - 10);
    with_sign(((magnitude / step + 0.5).floor() * step).min(MAX), value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loiter_turns_keep_a_byte_of_turns_and_a_byte_of_radius() {
        let turns = |v| Storage::Turns.keep(v);
        assert_eq!(
            [turns(0.0), turns(0.5), turns(0.999), turns(1.0), turns(2.75), turns(300.0)],
            [0.0, 0.5, 255.0 / 256.0, 1.0, 2.0, 255.0]
        );
        let radius = |v| Storage::TurnsRadius.keep(v);
        assert_eq!([radius(80.9), radius(-80.9), radius(255.0), radius(256.0)], [80.0, -80.0, 255.0, 250.0]);
        assert_eq!([radius(-1234.0), radius(9999.0)], [-1230.0, 2550.0]);
    }

    #[test]
    fn half_floats_round_as_the_vehicle_does() {
        // Bit patterns of IEEE 754 binary16: 3.75 and 4.5 are exact, 0.1 becomes 0x2E66.
        for exact in [0.0, 1.0, -2.0, 3.75, 4.5, 0.25, 65_504.0] {
            assert_eq!(half_precision(exact), exact);
        }
        assert_eq!(half_precision(0.1), 0.099_975_586);
        assert_eq!(half_precision(1000.7), 1000.5);
        assert_eq!(half_precision(1e9), 65_504.0);
    }
}
