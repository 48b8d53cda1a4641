//! Telemetry snapshots for Python: each group as a dictionary whose keys are the fields of `vencejo.telemetry`'s
//! classes.

use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use vencejo_proto::MonoTime;
use vencejo_vehicle::telemetry::Telemetry;

use crate::serial::ToPython;

/// A snapshot of a vehicle's telemetry.
#[pyclass(frozen, module = "vencejo._native")]
pub struct TelemetrySnapshot {
    telemetry: Telemetry,
    taken_at: MonoTime,
}

impl TelemetrySnapshot {
    /// The state at `taken_at`.
    pub fn new(telemetry: Telemetry, taken_at: MonoTime) -> Self {
        Self { telemetry, taken_at }
    }
}

/// Seconds as Python has them.
pub fn seconds(moment: MonoTime) -> f64 {
    moment.as_duration().as_secs_f64()
}

#[pymethods]
impl TelemetrySnapshot {
    /// When it was taken, seconds on a monotonic clock.
    #[getter]
    fn time_s(&self) -> f64 {
        seconds(self.taken_at)
    }

    /// Messages so far.
    #[getter]
    fn messages(&self) -> u64 {
        self.telemetry.messages
    }

    /// Values so far that could not be and were not used.
    #[getter]
    fn invalid_values(&self) -> u64 {
        self.telemetry.invalid_values
    }

    /// One group by name, `None` when it was not heard yet; "batteries" and "imus" are tuples.
    fn group<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let group = self.telemetry.serialize_group(name, self.taken_at, ToPython::new(py));
        Ok(group.ok_or_else(|| PyKeyError::new_err(name.to_owned()))??)
    }
}
