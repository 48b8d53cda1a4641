//! Owns the life cycle of a link: connecting, reconnecting for ever, its state, and its end. Each kind of endpoint has
//! a file of its own.

mod datagrams;
mod reader;
mod serial;
mod stream;
mod tcp;
mod tlog;
mod udp;

use std::sync::Arc;
use std::time::Duration;

use tokio::sync::watch;
use tokio::task::JoinHandle;
use tokio_util::sync::CancellationToken;
use vencejo_proto::MonoTime;

use crate::address::{HostPort, LinkAddress};
use crate::fault::{FaultKind, LinkFault};
use crate::hub::{Hub, LinkError};
use crate::outlet::{NoOutlet, Outlet, StreamQueue};
use crate::port::{LinkId, LinkOptions, LinkState, Port};

/// The first wait before connecting again.
const FIRST_WAIT: Duration = Duration::from_millis(250);
/// The longest wait: a link that is available again is back within 2 s.
const LONGEST_WAIT: Duration = Duration::from_millis(1500);
/// After a connection that lasted at least this long the back-off starts anew.
const GOOD_LIFE: Duration = Duration::from_secs(5);
/// How long connecting may take.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(5);

/// An open link. Dropping the handle closes the link in the background; [`Self::close`] waits for it.
#[derive(Debug)]
pub struct LinkHandle {
    id: LinkId,
    address: LinkAddress,
    local: watch::Receiver<Option<std::net::SocketAddr>>,
    state: watch::Receiver<LinkState>,
    cancel: CancellationToken,
    task: Option<JoinHandle<()>>,
}

impl LinkHandle {
    /// The link's id in the hub.
    pub fn id(&self) -> LinkId {
        self.id
    }

    /// Where it goes.
    pub fn address(&self) -> &LinkAddress {
        &self.address
    }

    /// Its state now.
    pub fn state(&self) -> LinkState {
        self.state.borrow().clone()
    }

    /// Its state as it changes.
    pub fn watch(&self) -> watch::Receiver<LinkState> {
        self.state.clone()
    }

    /// Waits until its state is as wanted, or the link is closed. Returns the state.
    pub async fn wait_for(&mut self, wanted: impl FnMut(&LinkState) -> bool) -> LinkState {
        let found = self.state.wait_for(wanted).await.map(|state| state.clone());
        found.unwrap_or(LinkState::Down)
    }

    /// The local socket address while it is up; has the actual port when opened with port 0.
    pub fn local_address(&self) -> Option<std::net::SocketAddr> {
        *self.local.borrow()
    }

    /// Closes the link and waits until its tasks have ended.
    pub async fn close(mut self) {
        self.cancel.cancel();
        if let Some(task) = self.task.take() {
            // A join error is a panic, which the runtime has reported.
            let _ = task.await;
        }
    }
}

impl Drop for LinkHandle {
    fn drop(&mut self) {
        self.cancel.cancel();
    }
}

/// What an endpoint works with.
pub(crate) struct Context {
    pub(crate) hub: Hub,
    pub(crate) port: Arc<Port>,
    pub(crate) cancel: CancellationToken,
    state: watch::Sender<LinkState>,
    local: watch::Sender<Option<std::net::SocketAddr>>,
    up_since: std::sync::Mutex<Option<MonoTime>>,
}

impl Context {
    /// Reports that the link is open and takes frames.
    pub(crate) fn up(&self, local: Option<std::net::SocketAddr>, peers: usize) {
        let since = self.hub.clock().now();
        *self.up_since.lock().unwrap_or_else(std::sync::PoisonError::into_inner) = Some(since);
        self.hub.on_connected(&self.port);
        self.local.send_replace(local);
        self.state.send_replace(LinkState::Up { since, peers });
        self.hub.on_open(&self.port);
    }

    /// Reports the number of peers.
    pub(crate) fn peers(&self, count: usize) {
        self.state.send_if_modified(|state| match state {
            LinkState::Up { peers, .. } if *peers != count => {
                *peers = count;
                true
            }
            _ => false,
        });
    }
}

/// Why a connection ended.
#[derive(Debug)]
pub(crate) enum End {
    /// We closed the link.
    Closed,
    /// It broke; reconnect.
    Broken(LinkFault),
    /// Nothing more will come.
    Over(Option<String>),
}

impl From<std::io::Error> for End {
    fn from(error: std::io::Error) -> Self {
        Self::Broken(error.into())
    }
}

enum Endpoint {
    Udp(udp::Udp),
    TcpClient(tcp::Client),
    TcpServer(tcp::Server),
    Serial(serial::Serial),
    Tlog(tlog::Replay),
}

impl Endpoint {
    /// Connects, and serves the connection until its end.
    async fn run(&mut self, context: &Arc<Context>) -> End {
        match self {
            Self::Udp(udp) => udp.run(context).await,
            Self::TcpClient(client) => client.run(context).await,
            Self::TcpServer(server) => server.run(context).await,
            Self::Serial(serial) => serial.run(context).await,
            Self::Tlog(replay) => replay.run(context).await,
        }
    }

    /// How long it may take to end by itself after the link is closed.
    fn grace(&self) -> Duration {
        match self {
            Self::TcpClient(_) => stream::GOOD_BYE * 2,
            _ => Duration::ZERO,
        }
    }

    /// Waits for whatever it has started.
    async fn finish(&mut self) {
        match self {
            Self::TcpServer(server) => server.finish().await,
            Self::Udp(udp) => udp.finish().await,
            Self::TcpClient(_) | Self::Serial(_) | Self::Tlog(_) => {}
        }
    }
}

impl Hub {
    /// Opens a link and keeps it open until [`LinkHandle::close`], reconnecting by itself.
    /// Must be called within a tokio runtime.
    ///
    /// # Errors
    /// [`LinkError::TooManyLinks`] only; connection errors show in the link's state.
    pub fn open(&self, address: LinkAddress, options: LinkOptions) -> Result<LinkHandle, LinkError> {
        let (endpoint, outlet): (Endpoint, Arc<dyn Outlet>) = match &address {
            LinkAddress::UdpIn { bind } => {
                let udp = udp::Udp::listen(bind.clone());
                let outlet = udp.outlet();
                (Endpoint::Udp(udp), outlet)
            }
            LinkAddress::UdpOut { remote, bind: Some(bind) } => {
                let udp = udp::Udp::listen_and_call(bind.clone(), remote.clone());
                let outlet = udp.outlet();
                (Endpoint::Udp(udp), outlet)
            }
            LinkAddress::UdpOut { remote, bind: None } => {
                let udp = udp::Udp::connect(remote.clone());
                let outlet = udp.outlet();
                (Endpoint::Udp(udp), outlet)
            }
            LinkAddress::UdpBroadcast { remote } => {
                let udp = udp::Udp::broadcast(remote.clone());
                let outlet = udp.outlet();
                (Endpoint::Udp(udp), outlet)
            }
            LinkAddress::TcpClient { remote } => {
                let queue = Arc::new(StreamQueue::default());
                (Endpoint::TcpClient(tcp::Client::new(remote.clone(), queue.clone())), queue)
            }
            LinkAddress::TcpServer { bind } => {
                let server = tcp::Server::new(bind.clone());
                let outlet = server.outlet();
                (Endpoint::TcpServer(server), outlet)
            }
            LinkAddress::Serial { path, baud } => {
                let queue = Arc::new(StreamQueue::default());
                (Endpoint::Serial(serial::Serial::new(path.clone(), *baud, queue.clone())), queue)
            }
            LinkAddress::Tlog { path, speed, repeat } => {
                (Endpoint::Tlog(tlog::Replay::new(path.clone(), *speed, *repeat)), Arc::new(NoOutlet))
            }
        };
        let (state, state_watch) = watch::channel(LinkState::Connecting { attempt: 1, last_error: None });
        let (local, local_watch) = watch::channel(None);
        let port = self.attach(address.clone(), options, outlet, state_watch.clone())?;
        let cancel = CancellationToken::new();
        let id = port.id;
        let context = Arc::new(Context {
            hub: self.clone(),
            port,
            cancel: cancel.clone(),
            state,
            local,
            up_since: std::sync::Mutex::new(None),
        });
        let task = tokio::spawn(live(endpoint, context));
        Ok(LinkHandle { id, address, local: local_watch, state: state_watch, cancel, task: Some(task) })
    }
}

/// The one task of a link.
async fn live(mut endpoint: Endpoint, context: Arc<Context>) {
    let mut attempt = 1;
    let grace = endpoint.grace();
    let last = loop {
        let cut_off = async {
            context.cancel.cancelled().await;
            if !grace.is_zero() {
                tokio::time::sleep(grace).await;
            }
        };
        let end = tokio::select! {
            biased;
            () = cut_off => End::Closed,
            end = endpoint.run(&context) => end,
        };
        context.local.send_replace(None);
        let up_since = context.up_since.lock().unwrap_or_else(std::sync::PoisonError::into_inner).take();
        let error = match end {
            End::Closed => break LinkState::Down,
            End::Over(remark) => break LinkState::Ended { remark },
            End::Broken(error) => error,
        };
        if let Some(since) = up_since {
            tracing::info!(link = %context.port.id, %error, "the link broke");
            if context.hub.clock().now().since(since) >= GOOD_LIFE {
                attempt = 1;
            }
        } else {
            tracing::debug!(link = %context.port.id, attempt, %error, "could not connect");
        }
        let wait = backoff(attempt, chance());
        attempt = attempt.saturating_add(1);
        context.state.send_replace(LinkState::Connecting { attempt, last_error: Some(error) });
        tokio::select! {
            biased;
            () = context.cancel.cancelled() => break LinkState::Down,
            () = tokio::time::sleep(wait) => {}
        }
    };
    endpoint.finish().await;
    drop(endpoint);
    if matches!(last, LinkState::Ended { .. }) {
        // A replay that has ended stays listed with its remark until it is closed.
        context.state.send_replace(last);
        context.cancel.cancelled().await;
        context.hub.detach(&context.port);
        context.state.send_replace(LinkState::Down);
        return;
    }
    context.hub.detach(&context.port);
    context.state.send_replace(last);
}

/// The wait before attempt `attempt` + 1: doubles from 0.25 s to 1.5 s, with jitter down to half, so that links that
/// broke together do not come back together.
fn backoff(attempt: u32, chance: f64) -> Duration {
    let doubled = FIRST_WAIT.saturating_mul(1 << attempt.saturating_sub(1).min(8)).min(LONGEST_WAIT);
    doubled.mul_f64(0.5 + 0.5 * chance).max(FIRST_WAIT)
}

/// A random number from 0 to 1.
fn chance() -> f64 {
    use std::hash::{BuildHasher, RandomState};
    (RandomState::new().hash_one(0u8) >> 11) as f64 / (1u64 << 53) as f64
}

/// Resolves a host, anew each time: at least one address, IPv4 first, which nearly every autopilot and simulator
/// listens on.
async fn resolve(address: &HostPort) -> Result<Vec<std::net::SocketAddr>, End> {
    let found =
        tokio::time::timeout(CONNECT_TIMEOUT, tokio::net::lookup_host((address.host.as_str(), address.port))).await;
    let broken = |kind, detail| Err(End::Broken(LinkFault::new(kind, detail)));
    let found = match found {
        Ok(Ok(found)) => found,
        Ok(Err(error)) => return broken(FaultKind::NoHost, format!("cannot find {}: {error}", address.host)),
        Err(_) => return broken(FaultKind::NoHost, format!("looking up {} took too long", address.host)),
    };
    let mut addresses: Vec<_> = found.collect();
    addresses.sort_by_key(std::net::SocketAddr::is_ipv6);
    if addresses.is_empty() {
        return broken(FaultKind::NoHost, format!("{} has no address", address.host));
    }
    Ok(addresses)
}

/// Why a socket could not be bound, with a hint for the usual reasons.
fn bind_error(address: &HostPort, error: &std::io::Error) -> End {
    use std::io::ErrorKind;
    let (kind, hint) = match error.kind() {
        ErrorKind::AddrInUse => (FaultKind::AddressInUse, "; another program listens there (another ground station?)"),
        ErrorKind::AddrNotAvailable => (
            FaultKind::NotOurAddress,
            "; this machine does not have that address: to send there write `udpout:` or `tcp:`, to listen write 0.0.0.0",
        ),
        ErrorKind::PermissionDenied => (FaultKind::NoPermission, "; ports below 1024 are the administrator's"),
        _ => (FaultKind::Other, ""),
    };
    End::Broken(LinkFault::new(kind, format!("cannot listen on {address}: {error}{hint}")))
}

#[cfg(test)]
mod tests;
