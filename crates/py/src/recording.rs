//! Summaries and telemetry of recordings.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use vencejo_flight::rehearsal::IsWanted;
use vencejo_station::{RecordedTelemetry, summarize_recording as summarize};
use vencejo_vehicle::VehicleId;

use crate::errors;
use crate::runtime::{self, WhileWanted};
use crate::telemetry::TelemetrySnapshot;

/// Adds the functions of this module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<PyRecordedTelemetry>()?;
    module.add_function(wrap_pyfunction!(summarize_recording, module)?)
}

/// A file whose reading Ctrl-C ends.
struct Signalled(File);

impl Read for Signalled {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        runtime::attached(|py| py.check_signals()).map_err(io::Error::other)?;
        self.0.read(buffer)
    }
}

/// The telemetry of a vehicle of a `.tlog` file, sampled.
#[pyclass(frozen, name = "RecordedTelemetry", module = "vencejo._native")]
pub struct PyRecordedTelemetry {
    path: PathBuf,
    samples: Mutex<RecordedTelemetry<Signalled>>,
}

impl PyRecordedTelemetry {
    fn unreadable(path: &Path, error: io::Error) -> PyErr {
        let message = format!("{}: {error}", path.display());
        match error.downcast::<PyErr>() {
            Ok(interrupt) => interrupt,
            Err(_) => errors::raise("FileFormatError", message),
        }
    }
}

#[pymethods]
impl PyRecordedTelemetry {
    #[new]
    #[pyo3(signature = (path, *, system_id, period_s))]
    fn new(path: PathBuf, system_id: Option<u16>, period_s: f64) -> PyResult<Self> {
        let file = File::open(&path).map_err(|error| Self::unreadable(&path, error))?;
        let period = Duration::try_from_secs_f64(period_s).map_err(|error| errors::raise("InvalidRequest", error))?;
        let samples = RecordedTelemetry::new(Signalled(file), system_id.map(VehicleId::new), period);
        Ok(Self { path, samples: Mutex::new(samples) })
    }

    fn __iter__(slf: PyRef<'_, Self>) -> PyRef<'_, Self> {
        slf
    }

    fn __next__(&self, py: Python<'_>) -> PyResult<Option<TelemetrySnapshot>> {
        let next = || self.samples.lock().unwrap_or_else(PoisonError::into_inner).next().transpose();
        let sample = runtime::detached(py, next).map_err(|error| Self::unreadable(&self.path, error))?;
        Ok(sample.map(|(at, telemetry)| TelemetrySnapshot::new(telemetry, at)))
    }
}

/// The contents of a `.tlog` file, as the fields of `vencejo.recording.RecordingSummary`.
#[pyfunction]
fn summarize_recording(py: Python<'_>, path: PathBuf) -> PyResult<Bound<'_, PyDict>> {
    let name = path.clone();
    let read =
        move |is_wanted: IsWanted<'_>| File::open(&name).and_then(|file| summarize(WhileWanted(file, is_wanted)));
    let summary = runtime::interruptible(py, read)?
        .map_err(|error| errors::raise("FileFormatError", format!("{}: {error}", path.display())))?;
    let fields = PyDict::new(py);
    fields.set_item("frames", summary.frames)?;
    fields.set_item("skipped_bytes", summary.skipped_bytes)?;
    fields.set_item("start_unix_s", summary.start_unix_us.map(|start_us| start_us as f64 / 1e6))?;
    fields.set_item("duration_s", summary.duration.as_secs_f64())?;
    fields.set_item("messages", summary.messages)?;
    let senders = summary.senders.into_iter();
    let senders: Vec<_> =
        senders.map(|(address, sender)| (address.system.0, address.component.0, sender.frames, sender.kind)).collect();
    fields.set_item("senders", senders)?;
    let events = summary.events.into_iter();
    let events: Vec<_> = events.map(|event| (event.at.as_secs_f64(), event.system.0, event.kind, event.text)).collect();
    fields.set_item("events", events)?;
    fields.set_item("events_left_out", summary.events_left_out)?;
    Ok(fields)
}
