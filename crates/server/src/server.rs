//! The server: listening, its tasks, and shutting them down.

use std::future::Future;
use std::io;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::pin::Pin;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use axum_server::Handle;
use axum_server::accept::DefaultAcceptor;
use axum_server::tls_rustls::{RustlsAcceptor, RustlsConfig};
use hyper_util::rt::{TokioExecutor, TokioTimer};
use hyper_util::server::conn::auto::Builder;
use thiserror::Error;
use tokio::net::TcpSocket;
use tokio::runtime::Handle as Runtime;
use tokio::sync::mpsc;
use tokio::task::JoinHandle;
use vencejo_maps::{MapError, Maps, MapsConfig};
use vencejo_station::Station;
use vencejo_store::Space;
use vencejo_video::VideoHub;

use crate::access::{self, Access};
use crate::door::{Caller, Descriptors, Door, DoorLimits};
use crate::drafts::Drafts;
use crate::dto::storage::{StorageFault, StorageProblem};
use crate::operator::Operator;
use crate::routes;
use crate::state::{App, AppParts};
use crate::storage;
use crate::tokens::{TokenStore, Tokens};

/// Grace period for connections when the server is closed.
const DRAIN: Duration = Duration::from_secs(3);
/// Kernel send buffer of a connection, bytes. Small, because what a slow reader has not read is outdated.
const SEND_BUFFER: u32 = 128 * 1024;
/// Time limit for the headers of a request.
const HEADERS: Duration = Duration::from_secs(10);
/// Most concurrent requests on an HTTP/2 connection.
const MAX_STREAMS: u32 = 64;
/// Most connections waiting to be accepted.
const BACKLOG: u32 = 128;

/// Configuration of a server.
#[derive(Debug, Clone)]
pub struct ServerConfig {
    /// Address to listen on; port 0 selects a free one. Any address but loopback requires tokens.
    pub bind: SocketAddr,
    /// Token file; created if missing. `None`, allowed on loopback only: no tokens.
    pub token_file: Option<PathBuf>,
    /// Host names that the `Host` header may contain, besides addresses and `localhost`.
    pub hosts: Vec<String>,
    /// Other origins that may use the API.
    pub origins: Vec<String>,
    /// Certificate chain and private key (PEM files) for TLS.
    pub tls: Option<(PathBuf, PathBuf)>,
    /// Allows other machines without TLS, although everyone on the network can then read everything, tokens included.
    pub plain_http: bool,
    /// On board a vehicle: the heartbeat is sent only while an operator's session has a WebSocket, and 5 s longer,
    /// because the autopilot's ground-station failsafe monitors it.
    pub on_board: bool,
    /// Folder of map sources, cache and offline areas; created if missing. `None`: no maps are served.
    pub maps_folder: Option<PathBuf>,
    /// Folder of camera recordings and pictures. `None`: none are listed.
    pub video_folder: Option<PathBuf>,
    /// Folder of the history of remote aircraft. `None`: none is listed.
    pub history_folder: Option<PathBuf>,
    /// File of the plan draft. `None`: in memory only.
    pub draft_file: Option<PathBuf>,
    /// Minimum free disk space.
    pub space: Space,
}

impl Default for ServerConfig {
    fn default() -> Self {
        Self {
            bind: SocketAddr::from(([127, 0, 0, 1], 8765)),
            token_file: None,
            hosts: Vec::new(),
            origins: Vec::new(),
            tls: None,
            plain_http: false,
            on_board: false,
            maps_folder: None,
            video_folder: None,
            history_folder: None,
            draft_file: None,
            space: Space::default(),
        }
    }
}

/// Why a server could not be started.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ServerError {
    /// The address cannot be listened on.
    #[error("cannot listen on {address}: {reason}; is another server running there? choose another port")]
    Bind {
        /// The address.
        address: SocketAddr,
        /// The error of the system.
        reason: io::Error,
    },
    /// An address that other machines reach, without tokens.
    #[error("{0} can be reached by others, so tokens are needed; say where to keep them, or listen on 127.0.0.1")]
    NoTokens(SocketAddr),
    /// An address that other machines reach, without TLS and without `plain_http`.
    #[error(
        "{0} can be reached by others, and without TLS whoever is in the network reads along, tokens too; give a certificate and its key \
         (--cert, --key), or allow it where everyone in the network is trusted (--plain-http)"
    )]
    NoTls(SocketAddr),
    /// What is allowed as an origin and can be none.
    #[error("'{0}' is no origin of a page, which is like https://plane.example or http://localhost:5173")]
    NoOrigin(String),
    /// What is allowed as a host and can be none.
    #[error("'{0}' is no name of a machine, which is like plane.local, without a port")]
    NoHost(String),
    /// The token file cannot be read or created.
    #[error("the tokens in {}: {reason}", path.display())]
    Tokens {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: io::Error,
    },
    /// The certificate or key cannot be used.
    #[error("the certificate {} with key {}: {reason}; both must be PEM files and belong together", certificate.display(), key.display())]
    Tls {
        /// The certificate.
        certificate: PathBuf,
        /// The key.
        key: PathBuf,
        /// What is wrong.
        reason: io::Error,
    },
    /// The folder for maps cannot be used.
    #[error("the maps in {}: {reason}", path.display())]
    Maps {
        /// The folder.
        path: PathBuf,
        /// What is wrong.
        reason: MapError,
    },
}

type Serving = Pin<Box<dyn Future<Output = io::Result<()>> + Send>>;

/// The serving task, and a channel that closes when all other tasks have ended.
type Tasks = (JoinHandle<io::Result<()>>, mpsc::Receiver<()>);

/// A running server.
#[derive(Debug)]
pub struct Server {
    app: App,
    address: SocketAddr,
    handle: Handle<Caller>,
    /// Its tasks, until it is closed.
    tasks: Mutex<Option<Tasks>>,
}

impl Server {
    /// Starts a server for a station. Returns once it listens. To be awaited on `runtime`.
    ///
    /// # Errors
    /// Any [`ServerError`]. Nothing is left running.
    pub async fn start(station: Station, config: ServerConfig, runtime: &Runtime) -> Result<Self, ServerError> {
        let limits = Descriptors::raise().door();
        Self::start_within(limits, station, config, runtime).await
    }

    /// [`Self::start`] with the given connection limits.
    pub(crate) async fn start_within(
        limits: DoorLimits,
        station: Station,
        config: ServerConfig,
        runtime: &Runtime,
    ) -> Result<Self, ServerError> {
        check_exposure(&config)?;
        check_names(&config)?;
        let (tokens, token_fault) = open_tokens(&config)?;
        let tls = load_tls(&config).await?;
        let cannot_bind = |reason| ServerError::Bind { address: config.bind, reason };
        let listener = bind(config.bind).map_err(cannot_bind)?;
        let address = listener.local_addr().map_err(cannot_bind)?;
        let maps = start_maps(&config).await?;
        let access = Access {
            tokens,
            bound: address,
            is_tls: tls.is_some(),
            hosts: config.hosts.clone(),
            origins: config.origins.clone(),
        };
        if config.on_board {
            station.set_heartbeat(false);
        }
        let parts = AppParts {
            on_board: config.on_board,
            maps: maps.clone(),
            drafts: Drafts::new(config.draft_file),
            video_folder: config.video_folder,
            history_folder: config.history_folder,
            token_fault,
        };
        let (alive, ended) = mpsc::channel(1);
        let app = App::new(station, access, parts, alive.clone());
        if let Some(maps) = maps {
            runtime.spawn(app.clone().tell_maps(maps, alive.clone()));
        }
        let service = routes::router(app.clone()).into_make_service_with_connect_info::<Caller>();
        let handle = Handle::new();
        let door = Door::new(listener, limits).map_err(cannot_bind)?;
        let mut server = axum_server::Server::<Caller>::from_listener(door).handle(handle.clone());
        limit(server.http_builder());
        let serving: Serving = match tls {
            None => Box::pin(server.serve(service)),
            Some(tls) => {
                let acceptor = RustlsAcceptor::new(tls).acceptor(DefaultAcceptor::new());
                Box::pin(server.acceptor(acceptor).serve(service))
            }
        };
        let serving = runtime.spawn(serving);
        if let Some(tokens) = app.access().tokens.clone() {
            runtime.spawn(app.clone().watch_tokens(tokens, alive.clone()));
        }
        runtime.spawn(storage::tell(app.clone(), alive.clone()));
        runtime.spawn(app.clone().tell(alive));
        Ok(Self { app, address, handle, tasks: Mutex::new(Some((serving, ended))) })
    }

    /// The shared state, for tests.
    #[cfg(test)]
    pub(crate) fn app(&self) -> &App {
        &self.app
    }

    /// Open connections, for tests.
    #[cfg(test)]
    pub(crate) fn connections(&self) -> usize {
        self.handle.connection_count()
    }

    /// The address it listens on.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// The valid tokens, if it uses any.
    pub fn tokens(&self) -> Option<Tokens> {
        self.app.access().tokens.as_ref().map(TokenStore::now)
    }

    /// Whether it speaks TLS.
    pub fn is_tls(&self) -> bool {
        self.app.access().is_tls
    }

    /// Opens an operator's session for this program; `None` if the limit of sessions is reached.
    pub fn operator(&self, name: &str) -> Option<Operator> {
        Operator::open(self.app.clone(), name)
    }

    /// The cameras that it shows. Programs add theirs here.
    pub fn video(&self) -> &VideoHub {
        self.app.video()
    }

    /// Storage faults, the flight recorder's first; empty if there are none.
    pub fn storage_problems(&self) -> Vec<StorageProblem> {
        self.app.storage_problems()
    }

    /// Number of connected WebSocket clients.
    pub fn clients(&self) -> usize {
        self.app.outboxes().count()
    }

    /// Ends all connections and tasks and waits for them. The station keeps running. May be called again.
    pub async fn close(&self) {
        let tasks = self.tasks.lock().unwrap_or_else(PoisonError::into_inner).take();
        let Some((serving, mut ended)) = tasks else { return };
        self.app.close();
        self.handle.graceful_shutdown(Some(DRAIN));
        match serving.await {
            Ok(Ok(())) => {}
            Ok(Err(error)) => tracing::error!(%error, "the server did not end in order"),
            Err(error) => tracing::error!(%error, "the server's task died"),
        }
        // Nothing is ever sent: `recv` returns when the last task has dropped its sender.
        if tokio::time::timeout(DRAIN, ended.recv()).await.is_err() {
            tracing::warn!("WebSocket clients were still being served when the server ended");
        }
    }
}

/// Refuses an address that other machines reach if tokens or TLS are missing.
fn check_exposure(config: &ServerConfig) -> Result<(), ServerError> {
    if config.bind.ip().is_loopback() {
        Ok(())
    } else if config.token_file.is_none() {
        Err(ServerError::NoTokens(config.bind))
    } else if config.tls.is_none() && !config.plain_http {
        Err(ServerError::NoTls(config.bind))
    } else {
        Ok(())
    }
}

/// What no request can have would be allowed in vain.
fn check_names(config: &ServerConfig) -> Result<(), ServerError> {
    if let Some(origin) = config.origins.iter().find(|origin| !access::is_origin(origin)) {
        return Err(ServerError::NoOrigin(origin.clone()));
    }
    config
        .hosts
        .iter()
        .find(|host| !access::is_host(host))
        .map_or(Ok(()), |host| Err(ServerError::NoHost(host.clone())))
}

/// The tokens, and the fault of their file if they exist in memory only.
fn open_tokens(config: &ServerConfig) -> Result<(Option<TokenStore>, Option<StorageFault>), ServerError> {
    let Some(path) = &config.token_file else { return Ok((None, None)) };
    let opened = TokenStore::open(path);
    let (tokens, fault) = opened.map_err(|reason| ServerError::Tokens { path: path.clone(), reason })?;
    Ok((Some(tokens), fault))
}

async fn load_tls(config: &ServerConfig) -> Result<Option<RustlsConfig>, ServerError> {
    let Some((certificate, key)) = &config.tls else { return Ok(None) };
    // The binary has only this provider. An error means that it is already installed.
    let _ = rustls::crypto::ring::default_provider().install_default();
    let loaded = match (vencejo_store::read_small(certificate), vencejo_store::read_small(key)) {
        (Ok(certificate), Ok(key)) => RustlsConfig::from_pem(certificate, key).await,
        (Err(reason), _) | (_, Err(reason)) => Err(reason),
    };
    loaded.map(Some).map_err(|reason| ServerError::Tls { certificate: certificate.clone(), key: key.clone(), reason })
}

async fn start_maps(config: &ServerConfig) -> Result<Option<Maps>, ServerError> {
    let Some(folder) = &config.maps_folder else { return Ok(None) };
    let maps = MapsConfig { space: config.space.clone(), ..MapsConfig::new(folder.clone()) };
    let started = Maps::start(maps).await;
    started.map(Some).map_err(|reason| ServerError::Maps { path: folder.clone(), reason })
}

/// Limits the time for headers and the number of concurrent requests.
fn limit(builder: &mut Builder<TokioExecutor>) {
    builder.http1().timer(TokioTimer::new()).header_read_timeout(HEADERS);
    builder.http2().timer(TokioTimer::new()).keep_alive_interval(HEADERS).max_concurrent_streams(MAX_STREAMS);
}

/// A listening socket with a small send buffer.
fn bind(address: SocketAddr) -> io::Result<std::net::TcpListener> {
    let socket = if address.is_ipv4() { TcpSocket::new_v4()? } else { TcpSocket::new_v6()? };
    socket.set_reuseaddr(true)?;
    // Accepted sockets inherit both. Nagle's algorithm would delay telemetry and pictures by a round trip.
    socket.set_send_buffer_size(SEND_BUFFER)?;
    socket.set_nodelay(true)?;
    socket.bind(address)?;
    socket.listen(BACKLOG)?.into_std()
}
