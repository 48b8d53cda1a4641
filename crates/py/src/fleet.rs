//! Aircraft of a fleet and their ground stations, for Python.

use std::collections::BTreeMap;
use std::path::PathBuf;

use pyo3::prelude::*;
use vencejo_fleet::authority::Role;
use vencejo_fleet::carrier::{Aircraft, AircraftConfig, Ground, GroundConfig};
use vencejo_fleet::signature::PublicKey;
use vencejo_fleet::{FleetError, operator};

use crate::station::PyStation;
use crate::{errors, runtime};

/// Adds this module's classes.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<PyAircraft>()?;
    module.add_class::<PyGround>()
}

fn raise(error: FleetError) -> PyErr {
    let class = match error {
        FleetError::Network { .. } => "LinkError",
        FleetError::File { .. } | FleetError::NoRandom(_) => "VencejoError",
        _ => "InvalidRequest",
    };
    errors::raise(class, error)
}

/// Whether a router is reached, what the network said when it was not, who has control, states told a second.
type Status = (bool, Option<String>, Option<String>, f64);

/// An aircraft of a fleet, on board.
#[pyclass(frozen, name = "FleetAircraft", module = "vencejo._native")]
pub struct PyAircraft(Aircraft);

#[pymethods]
impl PyAircraft {
    #[new]
    #[pyo3(signature = (station, *, org, name, dial, trust, uplink_bit_s))]
    fn new(
        station: &PyStation,
        org: &str,
        name: &str,
        dial: &str,
        trust: Vec<(String, bool)>,
        uplink_bit_s: Option<f64>,
    ) -> PyResult<Self> {
        let trusted = |(key, is_chief): (String, bool)| {
            let role = if is_chief { Role::Chief } else { Role::Operator };
            Ok((key.parse::<PublicKey>()?, role))
        };
        let config = || -> Result<AircraftConfig, FleetError> {
            Ok(AircraftConfig {
                org: org.parse()?,
                name: name.parse()?,
                dial: dial.parse()?,
                trust: trust.into_iter().map(trusted).collect::<Result<BTreeMap<_, _>, FleetError>>()?,
                uplink_bit_s,
            })
        };
        let config = config().map_err(raise)?;
        Aircraft::start(station.station(), config, runtime::handle()).map(Self).map_err(raise)
    }

    fn status(&self) -> Status {
        let status = self.0.status();
        (status.is_connected, status.problem, status.holder, status.rate_hz)
    }

    fn close(&self, py: Python<'_>) -> PyResult<()> {
        runtime::wait(py, None, self.0.close()).map(drop)
    }
}

/// Name, system id here, whether it is reachable, age of what it said, who has control, who asks for it.
type Far = (String, Option<u8>, bool, f64, Option<String>, Option<String>);

/// A ground station of a fleet.
#[pyclass(frozen, name = "FleetGround", module = "vencejo._native")]
pub struct PyGround(Ground);

#[pymethods]
impl PyGround {
    #[new]
    #[pyo3(signature = (station, *, org, listen, dial, key_file))]
    fn new(
        py: Python<'_>,
        station: &PyStation,
        org: &str,
        listen: Option<&str>,
        dial: Option<&str>,
        key_file: PathBuf,
    ) -> PyResult<Self> {
        let config = || -> Result<GroundConfig, FleetError> {
            Ok(GroundConfig {
                org: org.parse()?,
                listen: listen.map(str::parse).transpose()?,
                dial: dial.map(str::parse).transpose()?,
                signer: operator::key_of_file(&key_file)?,
            })
        };
        let config = py.detach(config).map_err(raise)?;
        let started = runtime::wait(py, None, Ground::start(station.station(), config, runtime::handle()))?;
        let ground = started.ok_or_else(|| errors::raise("ClosedError", "the fleet was not joined"))?;
        ground.map(Self).map_err(raise)
    }

    /// Where the network is joined.
    #[getter]
    fn endpoint(&self) -> String {
        self.0.endpoint().to_string()
    }

    /// Its public key.
    #[getter]
    fn key(&self) -> String {
        self.0.key().to_string()
    }

    fn aircraft(&self) -> Vec<Far> {
        let far = |far: vencejo_fleet::carrier::Far| {
            (far.name, far.system.map(|system| system.0), far.is_present, far.age.as_secs_f64(), far.holder, far.asking)
        };
        self.0.aircraft().into_iter().map(far).collect()
    }

    fn close(&self, py: Python<'_>) -> PyResult<()> {
        runtime::wait(py, None, self.0.close()).map(drop)
    }
}
