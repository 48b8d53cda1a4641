//! Owns TCP links: the client, and the server with its clients.

use std::net::SocketAddr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use socket2::{SockRef, TcpKeepalive};
use tokio::net::{TcpListener, TcpStream};
use tokio::task::JoinSet;
use vencejo_proto::{Frame, SystemId};

use super::{CONNECT_TIMEOUT, Context, End, bind_error, resolve, stream};
use crate::address::HostPort;
use crate::outlet::{Class, Outlet, Sent, StreamQueue};
use crate::systems::SystemSet;

/// Clients of one server; more are turned away.
pub(crate) const MAX_CLIENTS: usize = 32;
/// What is handed to the system at once.
const BATCH_BYTES: usize = 16 * 1024;

/// Sets a connection up: no waiting for full packets, and a silent death is noticed within about 15 s.
fn prepare(stream: &TcpStream) -> std::io::Result<()> {
    stream.set_nodelay(true)?;
    let keepalive = TcpKeepalive::new().with_time(Duration::from_secs(5)).with_interval(Duration::from_secs(3));
    SockRef::from(stream).set_tcp_keepalive(&keepalive)?;
    #[cfg(target_os = "linux")]
    SockRef::from(stream).set_tcp_user_timeout(Some(Duration::from_secs(15)))?;
    Ok(())
}

/// Connects to a server.
pub(super) struct Client {
    remote: HostPort,
    queue: Arc<StreamQueue>,
}

impl Client {
    pub(super) fn new(remote: HostPort, queue: Arc<StreamQueue>) -> Self {
        Self { remote, queue }
    }

    pub(super) async fn run(&mut self, context: &Context) -> End {
        let stream = match self.connect().await {
            Ok(stream) => stream,
            Err(end) => return end,
        };
        let local = stream.local_addr().ok();
        let (reader, writer) = stream.into_split();
        self.queue.open();
        context.up(local, 1);
        let end = stream::serve(context, reader, writer, &self.queue, BATCH_BYTES, |_| {}).await;
        self.queue.close();
        end
    }

    async fn connect(&self) -> Result<TcpStream, End> {
        let place = resolve(&self.remote).await?;
        let connected = tokio::time::timeout(CONNECT_TIMEOUT, TcpStream::connect(place)).await;
        let stream = match connected {
            Ok(Ok(stream)) => stream,
            Ok(Err(error)) => return Err(End::Broken(format!("cannot connect to {}: {error}", self.remote))),
            Err(_) => return Err(End::Broken(format!("{} does not answer", self.remote))),
        };
        prepare(&stream)?;
        Ok(stream)
    }
}

impl Drop for Client {
    fn drop(&mut self) {
        self.queue.close();
    }
}

/// One client of a server.
struct Joined {
    queue: Arc<StreamQueue>,
    systems: Arc<SystemSet>,
}

/// Sends to all clients, or to those behind whom the addressed system was heard.
#[derive(Default)]
struct Clients {
    joined: Mutex<Vec<Joined>>,
}

impl Clients {
    fn joined(&self) -> MutexGuard<'_, Vec<Joined>> {
        self.joined.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn remove(&self, queue: &Arc<StreamQueue>) -> usize {
        let mut joined = self.joined();
        joined.retain(|client| !Arc::ptr_eq(&client.queue, queue));
        joined.len()
    }
}

impl Outlet for Clients {
    fn send(&self, frame: &Frame, to: Option<SystemId>, class: Class) -> Sent {
        let joined = self.joined();
        let knows = |client: &&Joined| to.is_some_and(|system| client.systems.contains(system));
        let narrowed = joined.iter().any(|client| knows(&client));
        let mut result = Sent::NobodyThere;
        for client in joined.iter().filter(|client| !narrowed || knows(client)) {
            result = match (client.queue.push(frame, class), result) {
                (Sent::Accepted { displaced }, Sent::Accepted { displaced: before }) => {
                    Sent::Accepted { displaced: displaced + before }
                }
                (accepted @ Sent::Accepted { .. }, _) | (_, accepted @ Sent::Accepted { .. }) => accepted,
                (Sent::Full, _) => Sent::Full,
                (Sent::NobodyThere, before) => before,
            };
        }
        result
    }
}

/// Listens for clients.
pub(super) struct Server {
    bind: HostPort,
    clients: Arc<Clients>,
    serving: JoinSet<()>,
}

impl Server {
    pub(super) fn new(bind: HostPort) -> Self {
        Self { bind, clients: Arc::default(), serving: JoinSet::new() }
    }

    pub(super) fn outlet(&self) -> Arc<dyn Outlet> {
        self.clients.clone()
    }

    pub(super) async fn run(&mut self, context: &Arc<Context>) -> End {
        let listener = match self.listen().await {
            Ok(listener) => listener,
            Err(end) => return end,
        };
        context.up(listener.local_addr().ok(), 0);
        loop {
            tokio::select! {
                accepted = listener.accept() => match accepted {
                    Ok((stream, place)) => self.welcome(context, stream, place),
                    // Of one connection (aborted) or of the machine (descriptors, memory): the listener stays good.
                    Err(error) => {
                        tracing::debug!(link = %context.port.id, %error, "could not accept a client");
                        tokio::time::sleep(Duration::from_millis(100)).await;
                    }
                },
                Some(_) = self.serving.join_next() => {}
            }
        }
    }

    /// Ends what serves the clients, and waits for it.
    pub(super) async fn finish(&mut self) {
        self.serving.shutdown().await;
        self.clients.joined().clear();
    }

    async fn listen(&self) -> Result<TcpListener, End> {
        let place = resolve(&self.bind).await?;
        TcpListener::bind(place).await.map_err(|error| bind_error(&self.bind, &error))
    }

    fn welcome(&mut self, context: &Arc<Context>, stream: TcpStream, place: SocketAddr) {
        if self.serving.len() >= MAX_CLIENTS {
            tracing::warn!(link = %context.port.id, %place, "turned away: {MAX_CLIENTS} clients are connected");
            return;
        }
        self.serving.spawn(serve_client(context.clone(), self.clients.clone(), stream, place));
    }
}

async fn serve_client(context: Arc<Context>, clients: Arc<Clients>, stream: TcpStream, place: SocketAddr) {
    if let Err(error) = prepare(&stream) {
        tracing::debug!(link = %context.port.id, %place, %error, "a client left at once");
        return;
    }
    let queue = Arc::new(StreamQueue::default());
    let systems = Arc::new(SystemSet::default());
    queue.open();
    let count = {
        let mut joined = clients.joined();
        joined.push(Joined { queue: queue.clone(), systems: systems.clone() });
        joined.len()
    };
    context.peers(count);
    let (reader, writer) = stream.into_split();
    let heard = |frame: &Frame| {
        if frame.is_known() {
            systems.insert(frame.source().system);
        }
    };
    let end = stream::serve(&context, reader, writer, &queue, BATCH_BYTES, heard).await;
    tracing::debug!(link = %context.port.id, %place, ?end, "a client left");
    context.peers(clients.remove(&queue));
}
