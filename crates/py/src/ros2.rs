//! Planes in ROS 2, for Python.

use std::path::PathBuf;

use pyo3::prelude::*;
use vencejo_fleet::FleetError;
use vencejo_fleet::carrier::{Gateway, GatewayConfig, RosPapers, RosRouter, examine};
use vencejo_fleet::ros2::message::{MESSAGES, SERVICES};

use crate::fleet::raise;
use crate::station::PyStation;
use crate::{errors, runtime};

/// Adds this module's classes.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<PyRouter>()?;
    module.add_class::<PyGateway>()?;
    module.add_function(wrap_pyfunction!(ros2_examine, module)?)?;
    module.add_function(wrap_pyfunction!(ros2_types, module)?)
}

/// A router of ROS 2, with the certificates by which it is known.
#[pyclass(frozen, name = "Ros2Router", module = "vencejo._native")]
pub struct PyRouter(RosRouter);

#[pymethods]
impl PyRouter {
    #[new]
    #[pyo3(signature = (address, *, ca, certificate, key, is_plain_meant))]
    fn new(
        address: &str,
        ca: Option<PathBuf>,
        certificate: Option<PathBuf>,
        key: Option<PathBuf>,
        is_plain_meant: bool,
    ) -> PyResult<Self> {
        RosRouter::new(address, &RosPapers { ca, certificate, key, is_plain_meant }).map(Self).map_err(raise)
    }
}

/// Whether the router is reached, why not, planes with what their topics begin with, messages sent.
type Status = (bool, Option<String>, Vec<(u16, String)>, u64);

/// The planes of a station, in ROS 2.
#[pyclass(frozen, name = "Ros2Gateway", module = "vencejo._native")]
pub struct PyGateway(Gateway);

#[pymethods]
impl PyGateway {
    #[new]
    #[pyo3(signature = (station, *, router, domain, names, namespace, is_operator))]
    fn new(
        station: &PyStation,
        router: &PyRouter,
        domain: u32,
        names: &str,
        namespace: &str,
        is_operator: bool,
    ) -> PyResult<Self> {
        let config = || -> Result<GatewayConfig, FleetError> {
            let (names, namespace) = (names.parse()?, namespace.parse()?);
            Ok(GatewayConfig { router: router.0.clone(), domain, names, namespace, is_operator })
        };
        let config = config().map_err(raise)?;
        Gateway::start(station.station(), config, runtime::handle()).map(Self).map_err(raise)
    }

    fn status(&self) -> Status {
        let status = self.0.status();
        (status.is_connected, status.problem, status.planes, status.messages)
    }

    fn close(&self, py: Python<'_>) -> PyResult<()> {
        runtime::wait(py, None, self.0.close()).map(drop)
    }
}

/// Domain, name, how many topics it sends and hears, services that it answers.
type Node = (u32, String, usize, usize, usize);
/// Whether nothing arrives because of it, its stable name, in words.
type Finding = (bool, &'static str, String);

/// Why a router is not reached: stable name, message.
type Unreached = (&'static str, String);

/// Nodes at a router and findings; or why it is not reached.
#[pyfunction]
fn ros2_examine(
    py: Python<'_>,
    router: &PyRouter,
    domain: u32,
) -> PyResult<(Vec<Node>, Vec<Finding>, Option<Unreached>)> {
    let examined = runtime::wait(py, None, examine(&router.0, domain))?
        .ok_or_else(|| errors::raise("ClosedError", "interrupted"))?;
    let examined = match examined {
        Err(error @ FleetError::RosUnreached { code, .. }) => {
            return Ok((Vec::new(), Vec::new(), Some((code, error.to_string()))));
        }
        examined => examined.map_err(raise)?,
    };
    let nodes = examined.nodes.into_iter();
    let nodes = nodes.map(|node| (node.domain, node.name, node.publishers, node.subscriptions, node.services));
    let findings = examined.findings.into_iter().map(|finding| (finding.is_wrong, finding.code, finding.text));
    Ok((nodes.collect(), findings.collect(), None))
}

/// Type and hash of each message and service.
#[pyfunction]
fn ros2_types() -> Vec<(&'static str, &'static str)> {
    MESSAGES.iter().chain(SERVICES).copied().collect()
}
