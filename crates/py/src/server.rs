//! The HTTP and WebSocket server for Python: starts and ends it, on the station's runtime.

use std::net::SocketAddr;
use std::path::PathBuf;

use pyo3::prelude::*;
use vencejo_server::{Server, ServerConfig, ServerError, Tokens};
use vencejo_station::Station;

use crate::operator::PyOperator;
use crate::station::PyStation;
use crate::video::{self, PyVideoFeed};
use crate::{errors, runtime, storage};

/// Adds this module's class and functions.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<PyServer>()?;
    module.add_function(wrap_pyfunction!(renew_tokens, module)?)?;
    module.add_function(wrap_pyfunction!(has_app, module)?)
}

/// Makes new tokens in a file, for viewers, operators or both; gives back the viewer's and the operator's that hold
/// then.
#[pyfunction]
fn renew_tokens(py: Python<'_>, path: PathBuf, viewer: bool, operator: bool) -> PyResult<(String, String)> {
    let renewed = py.detach(|| Tokens::renew(&path, viewer, operator));
    let tokens = renewed.map_err(|error| errors::raise("VencejoError", format!("{}: {error}", path.display())))?;
    Ok((tokens.viewer, tokens.operator))
}

/// Whether the web app is in this build.
#[pyfunction]
fn has_app() -> bool {
    vencejo_server::has_app()
}

/// A running server.
#[pyclass(frozen, name = "Server", module = "vencejo._native")]
pub struct PyServer {
    server: Server,
    station: Station,
}

#[pymethods]
impl PyServer {
    #[new]
    #[pyo3(signature = (station, *, address, port, token_file, hosts, origins, tls, plain_http, on_board, maps_folder, video_folder=None, history_folder=None, draft_file=None, floors_mb=None))]
    #[allow(clippy::too_many_arguments, reason = "keyword arguments of one constructor")]
    fn new(
        py: Python<'_>,
        station: &PyStation,
        address: &str,
        port: u16,
        token_file: Option<String>,
        hosts: Vec<String>,
        origins: Vec<String>,
        tls: Option<(String, String)>,
        plain_http: bool,
        on_board: bool,
        maps_folder: Option<String>,
        video_folder: Option<String>,
        history_folder: Option<String>,
        draft_file: Option<String>,
        floors_mb: Option<(u64, u64, u64)>,
    ) -> PyResult<Self> {
        let ip = address.parse().map_err(|_| {
            errors::raise("InvalidRequest", format!("'{address}' is no address; one is like 127.0.0.1, 0.0.0.0 or ::"))
        })?;
        let config = ServerConfig {
            bind: SocketAddr::new(ip, port),
            token_file: token_file.map(Into::into),
            hosts,
            origins,
            tls: tls.map(|(certificate, key)| (certificate.into(), key.into())),
            plain_http,
            on_board,
            maps_folder: maps_folder.map(Into::into),
            video_folder: video_folder.map(Into::into),
            history_folder: history_folder.map(Into::into),
            draft_file: draft_file.map(Into::into),
            space: storage::space(floors_mb)?,
        };
        let started = runtime::wait(py, None, Server::start(station.station(), config, runtime::handle()))?;
        let server = started.ok_or_else(|| errors::raise("ClosedError", "the server was not started"))?;
        let server = server.map_err(|error| match error {
            ServerError::NoOrigin(_) | ServerError::NoHost(_) => errors::raise("InvalidRequest", error),
            _ => errors::raise("VencejoError", error),
        })?;
        Ok(Self { server, station: station.station() })
    }

    /// Address and port that it listens on.
    fn address(&self) -> (String, u16) {
        let address = self.server.address();
        (address.ip().to_string(), address.port())
    }

    /// The viewer's and the operator's token.
    fn tokens(&self) -> Option<(String, String)> {
        self.server.tokens().map(|tokens| (tokens.viewer, tokens.operator))
    }

    #[getter]
    fn is_tls(&self) -> bool {
        self.server.is_tls()
    }

    /// WebSocket clients now.
    #[getter]
    fn clients(&self) -> usize {
        self.server.clients()
    }

    /// Storage faults: kind of storage, name of the camera or map source, kind of fault, message.
    fn storage_problems(&self) -> Vec<storage::Problem> {
        self.server.storage_problems().iter().map(storage::problem).collect()
    }

    /// An operator's session of this program, by name.
    fn operator(&self, name: &str) -> PyResult<PyOperator> {
        let operator = self.server.operator(name);
        let operator = operator.map(|session| PyOperator::of_session(session, self.station.clone()));
        operator.ok_or_else(|| errors::raise("Busy", "all places for sessions are taken; close one"))
    }

    /// Adds a camera, which is there until its feed is closed.
    fn add_camera(&self, name: &str, source: &str) -> PyResult<PyVideoFeed> {
        self.server.video().add(name, source).map(PyVideoFeed::new).map_err(|error| video::raise(&error))
    }

    fn close(&self, py: Python<'_>) -> PyResult<()> {
        runtime::wait(py, None, self.server.close()).map(drop)
    }
}
