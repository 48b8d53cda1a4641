//! Converts numbers of the wire to values with units: unknown and impossible ones become `None`.

use std::ops::RangeInclusive;

/// Counts the impossible values of one message.
#[derive(Debug, Default)]
pub(super) struct Check {
    pub(super) invalid: u32,
}

impl Check {
    /// A float in `range`; NaN and infinities are in no range.
    pub(super) fn float(&mut self, value: f32, range: RangeInclusive<f64>) -> Option<f64> {
        self.value(f64::from(value), range)
    }

    /// An integer that counts parts, `parts` to the unit, unless it is the number that stands for "unknown".
    pub(super) fn scaled<T>(&mut self, raw: T, unknown: T, parts: f64, range: RangeInclusive<f64>) -> Option<f64>
    where
        T: PartialEq + Into<f64>,
    {
        if raw == unknown {
            return None;
        }
        self.value(raw.into() / parts, range)
    }

    fn value(&mut self, value: f64, range: RangeInclusive<f64>) -> Option<f64> {
        if range.contains(&value) {
            Some(value)
        } else {
            self.invalid += 1;
            None
        }
    }

    /// Latitude and longitude in 10⁻⁷ degrees. 0/0 is how vehicles say that they have none.
    pub(super) fn lat_lon(&mut self, lat: i32, lon: i32) -> Option<(f64, f64)> {
        if (lat, lon) == (0, 0) || lat == i32::MAX || lon == i32::MAX {
            return None;
        }
        let lat_deg = self.value(f64::from(lat) / 1e7, -90.0..=90.0);
        let lon_deg = self.value(f64::from(lon) / 1e7, -180.0..=180.0);
        lat_deg.zip(lon_deg)
    }

    /// A height in millimetres.
    pub(super) fn height_mm(&mut self, raw: i32) -> Option<f64> {
        self.scaled(raw, i32::MAX, 1e3, HEIGHT_M)
    }

    /// A direction in hundredths of a degree, 0 to 360 (exclusive).
    pub(super) fn direction_cdeg(&mut self, raw: u16) -> Option<f64> {
        self.scaled(raw, u16::MAX, 1e2, 0.0..=360.0).map(|degrees| if degrees == 360.0 { 0.0 } else { degrees })
    }

    /// Three raw integers, `parts` to the unit; the lowest number stands for a failed conversion.
    pub(super) fn vector(&mut self, raw: [i16; 3], parts: f64) -> Option<[f64; 3]> {
        if raw.contains(&i16::MIN) {
            self.invalid += 1;
            return None;
        }
        Some(raw.map(|value| f64::from(value) / parts))
    }
}

/// Heights that something in the air can have, from the Dead Sea to near space.
pub(super) const HEIGHT_M: RangeInclusive<f64> = -1_000.0..=100_000.0;
/// Speeds of anything that we fly; the wire's 16-bit fields end at 327 m/s (signed) and 655 m/s.
pub(super) const SPEED_M_S: RangeInclusive<f64> = 0.0..=700.0;
/// Components of a velocity.
pub(super) const VELOCITY_M_S: RangeInclusive<f64> = -327.67..=327.67;
/// Temperatures that electronics survive.
pub(super) const TEMPERATURE_C: RangeInclusive<f64> = -100.0..=300.0;
/// Percentages.
pub(super) const PERCENT: RangeInclusive<f64> = 0.0..=100.0;
