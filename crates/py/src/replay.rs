//! Replays of recordings for Python.

use std::path::PathBuf;
use std::time::Duration;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use vencejo_station::{Replay, ReplayOptions, SPEEDS, Station};
use vencejo_vehicle::VehicleId;

use crate::station::PyStation;
use crate::{errors, runtime};

/// Adds this module's class.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<PyReplay>()
}

fn place(position_s: f64) -> PyResult<Duration> {
    Duration::try_from_secs_f64(position_s)
        .map_err(|_| errors::raise("InvalidRequest", "a position in a recording is at least 0 s"))
}

fn speed_in(speed: f64) -> PyResult<f64> {
    let (slowest, fastest) = SPEEDS.into_inner();
    if (slowest..=fastest).contains(&speed) {
        return Ok(speed);
    }
    Err(errors::raise(
        "InvalidRequest",
        format!("the speed of a replay is {slowest} to {fastest} times the recorded pace"),
    ))
}

/// A recording that is replayed in a station.
#[pyclass(frozen, name = "Replay", module = "vencejo._native")]
pub struct PyReplay {
    replay: Replay,
    station: Station,
}

#[pymethods]
impl PyReplay {
    #[new]
    #[pyo3(signature = (station, path, *, speed, start_s, repeat))]
    fn new(
        py: Python<'_>,
        station: &PyStation,
        path: PathBuf,
        speed: f64,
        start_s: f64,
        repeat: bool,
    ) -> PyResult<Self> {
        let options = ReplayOptions { speed: speed_in(speed)?, start: place(start_s)?, repeat, stands_in: true };
        let station = station.station();
        let opened = runtime::wait(py, None, station.open_replay(&path, options))?;
        let opened = opened.ok_or_else(|| errors::raise("ClosedError", "interrupted"))?;
        let replay = opened.map_err(|error| errors::from_station(&error))?;
        Ok(Self { replay, station })
    }

    #[getter]
    fn id(&self) -> u32 {
        self.replay.id()
    }

    #[getter]
    fn name(&self) -> &str {
        self.replay.name()
    }

    #[getter]
    fn path(&self) -> PathBuf {
        self.replay.path().to_owned()
    }

    /// The fields of `vencejo.replay.ReplayStatus`.
    fn status<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (status, info) = (self.replay.status(), self.replay.info());
        let unix_s = |unix_us: u64| unix_us as f64 / 1e6;
        let dict = PyDict::new(py);
        dict.set_item("system_ids", self.replay.vehicles().map(VehicleId::number).collect::<Vec<_>>())?;
        dict.set_item("start_unix_s", info.start_unix_us.map(unix_s))?;
        dict.set_item("unix_s", status.unix_us.map(unix_s))?;
        dict.set_item("position_s", status.position.as_secs_f64())?;
        dict.set_item("duration_s", info.duration.as_secs_f64())?;
        dict.set_item("speed", status.speed)?;
        dict.set_item("is_paused", status.is_paused)?;
        dict.set_item("is_over", status.is_over)?;
        dict.set_item("seeks", status.seeks)?;
        dict.set_item("fault", status.fault)?;
        Ok(dict)
    }

    fn pause(&self) {
        self.replay.pause();
    }

    fn play(&self) {
        self.replay.play();
    }

    fn set_speed(&self, speed: f64) -> PyResult<()> {
        self.replay.set_speed(speed_in(speed)?);
        Ok(())
    }

    fn seek(&self, position_s: f64) -> PyResult<()> {
        self.replay.seek(place(position_s)?);
        Ok(())
    }

    fn close(&self, py: Python<'_>) -> PyResult<()> {
        runtime::wait(py, None, self.station.close_replay(self.replay.id())).map(drop)
    }
}
