//! The server as a whole: its socket, its tasks, and the end of all of them.

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

use crate::access::Access;
use crate::door::{Caller, Descriptors, Door, DoorLimits};
use crate::drafts::Drafts;
use crate::dto::storage::{StorageFault, StorageProblem};
use crate::operator::Operator;
use crate::routes;
use crate::state::{App, AppParts};
use crate::storage;
use crate::tokens::{TokenStore, Tokens};

/// How long connections may take to end when the server is closed.
const DRAIN: Duration = Duration::from_secs(3);
/// Bytes that the system may hold back for one connection: what a slow reader has not read is old.
const SEND_BUFFER: u32 = 128 * 1024;
/// How long a client may take to say what it wants.
const HEADERS: Duration = Duration::from_secs(10);
/// Requests at once on one HTTP/2 connection.
const MAX_STREAMS: u32 = 64;
/// Connections that wait to be accepted.
const BACKLOG: u32 = 128;

/// How a server is to be started.
#[derive(Debug, Clone)]
pub struct ServerConfig {
    /// Where to listen; port 0 takes a free one. Anything but loopback demands tokens.
    pub bind: SocketAddr,
    /// Where the tokens are kept; they are made when they are not there. `None` with a loopback address: no tokens.
    pub token_file: Option<PathBuf>,
    /// Names of this machine that `Host` may say, beside addresses and `localhost`.
    pub hosts: Vec<String>,
    /// Other origins that may use the API.
    pub origins: Vec<String>,
    /// Certificate chain and key, PEM files, for TLS.
    pub tls: Option<(PathBuf, PathBuf)>,
    /// Whether others may be let in without TLS, where whoever is in the network reads along, tokens too.
    pub plain_http: bool,
    /// On board a vehicle: our heartbeat is sent only while an operator's session has a WebSocket, and 5 s longer, because the
    /// autopilot's ground-station failsafe counts it.
    pub on_board: bool,
    /// Where map sources, their cache and offline areas are kept; made when it is not there. `None`: no maps are served.
    pub maps_folder: Option<PathBuf>,
    /// Where the recordings and pictures of cameras are kept. `None`: none are listed.
    pub video_folder: Option<PathBuf>,
    /// Where the history of aircraft far away is kept. `None`: none is listed.
    pub history_folder: Option<PathBuf>,
    /// Where the draft of the plan is kept. `None`: in memory alone.
    pub draft_file: Option<PathBuf>,
    /// How much of the disk stays free.
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
        /// Which.
        address: SocketAddr,
        /// What the system said.
        reason: io::Error,
    },
    /// An address that others reach, without tokens.
    #[error("{0} can be reached by others, so tokens are needed; say where to keep them, or listen on 127.0.0.1")]
    NoTokens(SocketAddr),
    /// An address that others reach, without TLS, and nobody said that it may be.
    #[error(
        "{0} can be reached by others, and without TLS whoever is in the network reads along, tokens too; give a certificate and its key \
         (--cert, --key), or allow it where everyone in the network is trusted (--plain-http)"
    )]
    NoTls(SocketAddr),
    /// The tokens cannot be read or made.
    #[error("the tokens in {}: {reason}", path.display())]
    Tokens {
        /// Their file.
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

/// The task that serves, and what ends when all others have.
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
    /// Starts a server for a station on a runtime, and gives it back once it listens. To be awaited on that runtime.
    ///
    /// # Errors
    /// [`ServerError`] in all its kinds. Nothing is left behind.
    pub async fn start(station: Station, config: ServerConfig, runtime: &Runtime) -> Result<Self, ServerError> {
        let limits = Descriptors::raise().door();
        Self::start_within(limits, station, config, runtime).await
    }

    /// As [`Self::start`], with other limits for connections.
    pub(crate) async fn start_within(
        limits: DoorLimits,
        station: Station,
        config: ServerConfig,
        runtime: &Runtime,
    ) -> Result<Self, ServerError> {
        check_exposure(&config)?;
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

    /// Its state, for tests.
    #[cfg(test)]
    pub(crate) fn app(&self) -> &App {
        &self.app
    }

    /// Connections that it serves now, for tests.
    #[cfg(test)]
    pub(crate) fn connections(&self) -> usize {
        self.handle.connection_count()
    }

    /// Where it listens.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Its tokens that hold now, when it has any.
    pub fn tokens(&self) -> Option<Tokens> {
        self.app.access().tokens.as_ref().map(TokenStore::now)
    }

    /// Whether it speaks TLS.
    pub fn is_tls(&self) -> bool {
        self.app.access().is_tls
    }

    /// Opens an operator's session for this very program; `None` when all places for sessions are taken.
    pub fn operator(&self, name: &str) -> Option<Operator> {
        Operator::open(self.app.clone(), name)
    }

    /// The cameras that it shows; whoever has one adds it.
    pub fn video(&self) -> &VideoHub {
        self.app.video()
    }

    /// What of the disk does not work, the flight recorder first.
    pub fn storage_problems(&self) -> Vec<StorageProblem> {
        self.app.storage_problems()
    }

    /// WebSocket clients now.
    pub fn clients(&self) -> usize {
        self.app.outboxes().count()
    }

    /// Ends all connections and tasks, and waits for them. The station goes on. May be called again.
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
        // Nothing is sent: it ends when the last task has dropped its end.
        if tokio::time::timeout(DRAIN, ended.recv()).await.is_err() {
            tracing::warn!("WebSocket clients were still being served when the server ended");
        }
    }
}

/// Refuses an address that others reach where tokens or TLS are missing.
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

/// The tokens, and what is wrong with their file where they hold in memory alone.
fn open_tokens(config: &ServerConfig) -> Result<(Option<TokenStore>, Option<StorageFault>), ServerError> {
    let Some(path) = &config.token_file else { return Ok((None, None)) };
    let opened = TokenStore::open(path);
    let (tokens, fault) = opened.map_err(|reason| ServerError::Tokens { path: path.clone(), reason })?;
    Ok((Some(tokens), fault))
}

async fn load_tls(config: &ServerConfig) -> Result<Option<RustlsConfig>, ServerError> {
    let Some((certificate, key)) = &config.tls else { return Ok(None) };
    // The binary has only this provider. An error says that it is installed already.
    let _ = rustls::crypto::ring::default_provider().install_default();
    let loaded = RustlsConfig::from_pem_file(certificate, key).await;
    loaded.map(Some).map_err(|reason| ServerError::Tls { certificate: certificate.clone(), key: key.clone(), reason })
}

async fn start_maps(config: &ServerConfig) -> Result<Option<Maps>, ServerError> {
    let Some(folder) = &config.maps_folder else { return Ok(None) };
    let maps = MapsConfig { space: config.space.clone(), ..MapsConfig::new(folder.clone()) };
    let started = Maps::start(maps).await;
    started.map(Some).map_err(|reason| ServerError::Maps { path: folder.clone(), reason })
}

/// Ends connections whose request does not come.
fn limit(builder: &mut Builder<TokioExecutor>) {
    builder.http1().timer(TokioTimer::new()).header_read_timeout(HEADERS);
    builder.http2().timer(TokioTimer::new()).keep_alive_interval(HEADERS).max_concurrent_streams(MAX_STREAMS);
}

/// A socket that listens. What is sent to slow readers stays small.
fn bind(address: SocketAddr) -> io::Result<std::net::TcpListener> {
    let socket = if address.is_ipv4() { TcpSocket::new_v4()? } else { TcpSocket::new_v6()? };
    socket.set_reuseaddr(true)?;
    // Accepted sockets inherit both: telemetry and pictures are not to wait for the answer to the piece before.
    socket.set_send_buffer_size(SEND_BUFFER)?;
    socket.set_nodelay(true)?;
    socket.bind(address)?;
    socket.listen(BACKLOG)?.into_std()
}
