//! The battery of a rehearsed plane, and its charge after a flight.

use super::airframe::Airframe;
use crate::guidance::bound;
use crate::words::words;

/// Default reserve, as a part of the capacity: four fifths are used, as is usual of lithium polymer.
const RESERVE: f64 = 0.2;
/// Part of the charge that must have been used before the capacity can be inferred from it.
const TELLS_CAPACITY: f64 = 0.1;

/// A battery, as far as it is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Battery {
    /// Charge of a full one, mAh (`BATT_CAPACITY`); `None`: not known.
    pub capacity_mah: Option<f64>,
    /// Its voltage while the engine runs, V; `None`: that of the airframe's profile ([`Airframe::voltage_v`]).
    pub voltage_v: Option<f64>,
    /// Part of its capacity that it holds at the start, 0 to 1; default 1.
    pub charge: f64,
    /// Part of its capacity that should be left at the landing, 0 to 1: the higher of `BATT_LOW_MAH` and
    /// `BATT_CRT_MAH`; default 0.2.
    pub reserve: f64,
}

impl Default for Battery {
    fn default() -> Self {
        Self { capacity_mah: None, voltage_v: None, charge: 1.0, reserve: RESERVE }
    }
}

/// A user's values for a battery, in place of those of parameters and battery monitor; `None`: as those.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "describe", derive(serde::Deserialize, utoipa::ToSchema), serde(default, deny_unknown_fields))]
pub struct BatterySettings {
    /// Charge of a full one, mAh, 1 to 1,000,000.
    pub capacity_mah: Option<f64>,
    /// Its voltage while the engine runs, V, 1 to 1,000.
    pub voltage_v: Option<f64>,
    /// Charge at the start, % of its capacity, 0 to 100.
    pub charge_pct: Option<f64>,
    /// What should be left at the landing, % of its capacity, 0 to 100.
    pub reserve_pct: Option<f64>,
    /// Power that is drawn from it in level flight at cruise, W, 0.1 to 1,000,000 ([`Airframe::power_cruise_w`]).
    pub power_cruise_w: Option<f64>,
}

impl BatterySettings {
    /// The first value out of range: the field, its value and its range.
    pub fn fault(&self) -> Option<(&'static str, f64, (f64, f64))> {
        let fields = [
            ("capacity_mah", self.capacity_mah, (1.0, 1e6)),
            ("voltage_v", self.voltage_v, (1.0, 1_000.0)),
            ("charge_pct", self.charge_pct, (0.0, 100.0)),
            ("reserve_pct", self.reserve_pct, (0.0, 100.0)),
            ("power_cruise_w", self.power_cruise_w, (0.1, 1e6)),
        ];
        // NaN is in no range.
        let outside = |(name, value, range): (&'static str, Option<f64>, (f64, f64))| {
            value.filter(|value| !(range.0..=range.1).contains(value)).map(|value| (name, value, range))
        };
        fields.into_iter().find_map(outside)
    }
}

words! {
    /// Why the remaining charge is unknown.
    BatteryLack {
        /// The plane's power is not known: it was not learned from a flight.
        Power = "power",
        /// The battery's capacity is not known.
        Capacity = "capacity",
        /// Its voltage is not known, which turns charge into energy.
        Voltage = "voltage",
    }
}

/// Charge of a battery after a flight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BatteryLeft {
    /// Energy of a full one, Wh.
    pub capacity_wh: f64,
    /// Energy left at the end, Wh; below 0: as much more than it holds is wanted.
    pub left_wh: f64,
    /// Part of its capacity that should be left, 0 to 1.
    pub reserve: f64,
    /// When it is empty, s since the start; `None`: it is not.
    pub empty_s: Option<f64>,
    /// Index of the item that is flown then; `None` in a return and where it is not empty.
    pub empty_index: Option<usize>,
}

impl BatteryLeft {
    /// Part of its capacity that is left at the end; below 0 as [`Self::left_wh`].
    pub fn left(&self) -> f64 {
        self.left_wh / self.capacity_wh
    }

    /// Whether less is left than should be.
    pub fn is_below_reserve(&self) -> bool {
        self.left() < self.reserve
    }
}

impl Battery {
    /// From an ArduPlane's parameters; one whose monitor is off (`BATT_MONITOR` 0) is not known.
    pub fn from_ardupilot(get: impl Fn(&str) -> Option<f64>) -> Self {
        let known = |name: &str| get(name).filter(|value| value.is_finite() && *value > 0.0);
        let is_watched = get("BATT_MONITOR").is_none_or(|monitor| monitor != 0.0);
        let Some(capacity_mah) = known("BATT_CAPACITY").filter(|_| is_watched) else { return Self::default() };
        let marks = [known("BATT_LOW_MAH"), known("BATT_CRT_MAH")].into_iter().flatten();
        let reserve = marks.map(|mark_mah| bound(mark_mah / capacity_mah, 0.0, 1.0)).reduce(f64::max);
        Self { capacity_mah: Some(capacity_mah), reserve: reserve.unwrap_or(RESERVE), ..Self::default() }
    }

    /// With the vehicle's telemetry: its present voltage, the charge used, mAh, and the part that is left.
    ///
    /// An unknown capacity is inferred from the charge used, once that is a tenth.
    #[must_use]
    pub fn as_told(self, voltage_v: Option<f64>, consumed_mah: Option<f64>, left: Option<f64>) -> Self {
        let left = left.filter(|left| (0.0..=1.0).contains(left));
        let given = consumed_mah.zip(left).filter(|(_, left)| 1.0 - left >= TELLS_CAPACITY);
        let told_mah = given.map(|(consumed_mah, left)| consumed_mah / (1.0 - left)).filter(|mah| *mah > 0.0);
        Self {
            capacity_mah: self.capacity_mah.or(told_mah),
            voltage_v: self.voltage_v.or(voltage_v.filter(|voltage_v| *voltage_v > 0.0)),
            charge: left.unwrap_or(self.charge),
            ..self
        }
    }

    /// With a user's values.
    #[must_use]
    pub fn with(self, said: &BatterySettings) -> Self {
        Self {
            capacity_mah: said.capacity_mah.or(self.capacity_mah),
            voltage_v: said.voltage_v.or(self.voltage_v),
            charge: said.charge_pct.map_or(self.charge, |charge_pct| charge_pct / 100.0),
            reserve: said.reserve_pct.map_or(self.reserve, |reserve_pct| reserve_pct / 100.0),
        }
    }

    /// Energy of a full one, Wh, as `mAh · V / 1000`.
    ///
    /// # Errors
    /// The value that is unknown.
    pub(super) fn capacity_wh(&self, airframe: &Airframe) -> Result<f64, BatteryLack> {
        airframe.power_cruise_w.ok_or(BatteryLack::Power)?;
        let capacity_mah = self.capacity_mah.ok_or(BatteryLack::Capacity)?;
        let voltage_v = self.voltage_v.or(airframe.voltage_v).ok_or(BatteryLack::Voltage)?;
        Ok(capacity_mah * voltage_v / 1_000.0)
    }
}
