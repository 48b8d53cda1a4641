//! Owns TCP links: the client, and the server with its clients.

use std::net::SocketAddr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use socket2::{SockRef, TcpKeepalive};
use tokio::net::{TcpListener, TcpStream};
use tokio::task::JoinSet;
use vencejo_proto::Frame;

use super::{CONNECT_TIMEOUT, Context, End, bind_error, resolve, stream};
use crate::address::HostPort;
use crate::fault::{FaultKind, LinkFault};
use crate::outlet::{Class, Outlet, Peer, PeerId, Sent, StreamQueue, To};
use crate::systems::SystemSet;

/// Most clients of a server; more are turned away.
pub(crate) const MAX_CLIENTS: usize = 32;
/// Bytes handed to the system at once.
const BATCH_BYTES: usize = 16 * 1024;

/// Configures a connection: no Nagle delay, and a dead peer is noticed within about 15 s.
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
        let connected = tokio::select! {
            biased;
            () = context.cancel.cancelled() => return End::Closed,
            connected = self.connect() => connected,
        };
        let stream = match connected {
            Ok(stream) => stream,
            Err(end) => return end,
        };
        let local = stream.local_addr().ok();
        let (reader, writer) = stream.into_split();
        self.queue.open();
        context.up(local, 1);
        let end = stream::serve(context, Peer::default(), reader, writer, &self.queue, BATCH_BYTES).await;
        self.queue.close();
        end
    }

    async fn connect(&self) -> Result<TcpStream, End> {
        let stream = connect_to_one_of(&resolve(&self.remote).await?, &self.remote).await?;
        prepare(&stream)?;
        Ok(stream)
    }
}

/// Connects to the first address of a name that accepts: `localhost` is ::1 too, where a simulator does not listen.
/// Each has the full timeout, so that an address that does not answer does not use up the time of the next.
async fn connect_to_one_of(addresses: &[SocketAddr], name: &HostPort) -> Result<TcpStream, End> {
    let mut failed = LinkFault::new(FaultKind::NoHost, format!("{name} has no address"));
    for address in addresses {
        match tokio::time::timeout(CONNECT_TIMEOUT, TcpStream::connect(address)).await {
            Ok(Ok(stream)) => return Ok(stream),
            Ok(Err(error)) => {
                let fault = LinkFault::from(error);
                failed = LinkFault::new(fault.kind, format!("cannot connect to {name}: {fault}"));
            }
            Err(_) => failed = LinkFault::new(FaultKind::NoAnswer, format!("{name} does not answer")),
        }
    }
    Err(End::Broken(failed))
}

impl Drop for Client {
    fn drop(&mut self) {
        self.queue.close();
    }
}

/// A client of a server.
struct Joined {
    number: PeerId,
    queue: Arc<StreamQueue>,
    systems: Arc<SystemSet>,
}

/// Sends to all clients, or to those behind which the addressed system was heard.
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
    fn send(&self, frame: &Frame, to: To, class: Class) -> Sent {
        let joined = self.joined();
        if let Some(client) = joined.iter().find(|client| Some(client.number) == to.peer) {
            return client.queue.push(frame, class);
        }
        if to.is_strict() {
            return Sent::NobodyThere;
        }
        let knows = |client: &&Joined| to.system.is_some_and(|system| client.systems.contains(system));
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
    /// The number of the newest client.
    welcomed: u32,
}

impl Server {
    pub(super) fn new(bind: HostPort) -> Self {
        Self { bind, clients: Arc::default(), serving: JoinSet::new(), welcomed: 0 }
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
                    Ok((stream, address)) => self.welcome(context, stream, address),
                    // An error of one connection (aborted) or of the machine (descriptors, memory): the listener stays
                    // usable.
                    Err(error) => {
                        tracing::debug!(link = %context.port.id, %error, "could not accept a client");
                        tokio::time::sleep(Duration::from_millis(100)).await;
                    }
                },
                Some(_) = self.serving.join_next() => {}
            }
        }
    }

    /// Ends the tasks of the clients and waits for them.
    pub(super) async fn finish(&mut self) {
        self.serving.shutdown().await;
        self.clients.joined().clear();
    }

    async fn listen(&self) -> Result<TcpListener, End> {
        let addresses = resolve(&self.bind).await?;
        TcpListener::bind(&addresses[..]).await.map_err(|error| bind_error(&self.bind, &error))
    }

    fn welcome(&mut self, context: &Arc<Context>, stream: TcpStream, address: SocketAddr) {
        if self.serving.len() >= MAX_CLIENTS {
            tracing::warn!(link = %context.port.id, peer = %address, "turned away: {MAX_CLIENTS} clients are connected");
            return;
        }
        self.welcomed = self.welcomed.wrapping_add(1);
        let number = PeerId(self.welcomed);
        self.serving.spawn(serve_client(context.clone(), self.clients.clone(), number, stream, address));
    }
}

async fn serve_client(
    context: Arc<Context>,
    clients: Arc<Clients>,
    number: PeerId,
    stream: TcpStream,
    address: SocketAddr,
) {
    if let Err(error) = prepare(&stream) {
        tracing::debug!(link = %context.port.id, peer = %address, %error, "a client left at once");
        return;
    }
    let queue = Arc::new(StreamQueue::default());
    let systems = Arc::new(SystemSet::default());
    queue.open();
    let count = {
        let mut joined = clients.joined();
        joined.push(Joined { number, queue: queue.clone(), systems: systems.clone() });
        joined.len()
    };
    context.peers(count);
    let (reader, writer) = stream.into_split();
    let peer = Peer { id: number, systems: Some(&systems) };
    let end = stream::serve(&context, peer, reader, writer, &queue, BATCH_BYTES).await;
    tracing::debug!(link = %context.port.id, peer = %address, ?end, "a client left");
    context.peers(clients.remove(&queue));
}

#[cfg(test)]
mod tests {
    use rand::rngs::StdRng;
    use rand::{Rng, SeedableRng};
    use tokio::io::{AsyncReadExt, AsyncWriteExt};
    use vencejo_proto::{FrameDecoder, MavVersion};

    use super::*;
    use crate::testing::{Listening, US, command_to, heartbeat, in_time, say_something};
    use crate::{LinkState, Route};

    /// The next frame of a stream that carries one at a time.
    async fn hears(stream: &mut TcpStream) -> Frame {
        let mut decoder = FrameDecoder::new();
        loop {
            if let Some(frame) = decoder.next_frame() {
                return frame;
            }
            decoder.push(&[in_time(stream.read_u8()).await.expect("the link is open")]);
        }
    }

    #[tokio::test]
    async fn a_client_comes_back_after_the_server_went() {
        let mut listening = Listening::new();
        let server = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = server.local_addr().unwrap();
        let link =
            listening.hub.open(format!("tcp:{address}").parse().unwrap(), crate::LinkOptions::default()).unwrap();
        for round in 0..3 {
            let (mut stream, _) = in_time(server.accept()).await.unwrap();
            stream.write_all(heartbeat(1, 1, round).bytes()).await.unwrap();
            assert_eq!(listening.next().await, heartbeat(1, 1, round));
            assert_eq!(say_something(&listening.hub), 1);
            assert_eq!(hears(&mut stream).await.source(), US);
            // Half a frame at the end of a connection does not harm the next.
            stream.write_all(&heartbeat(1, 1, 99).bytes()[..9]).await.unwrap();
        }
        let stats = listening.hub.stats(link.id()).unwrap();
        assert_eq!((stats.received.frames, stats.sent.frames, stats.lost), (3, 3, 0));
        link.close().await;
    }

    #[tokio::test]
    async fn each_address_of_a_name_is_tried() {
        let gone = TcpListener::bind("127.0.0.1:0").await.unwrap().local_addr().unwrap();
        let server = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let name = HostPort { host: "a.plane".into(), port: 5760 };
        let there = server.local_addr().unwrap();
        let stream = in_time(connect_to_one_of(&[gone, there], &name)).await.expect("one of them is there");
        assert_eq!(stream.peer_addr().unwrap(), there);
        let Err(End::Broken(error)) = in_time(connect_to_one_of(&[gone], &name)).await else {
            panic!("nobody is there")
        };
        assert_eq!(error.kind, FaultKind::Refused);
        assert!(error.detail.starts_with("cannot connect to a.plane:5760: "), "{error}");
    }

    #[tokio::test]
    async fn a_closed_client_has_said_its_last_words() {
        let mut listening = Listening::new();
        let server = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = format!("tcp:{}", server.local_addr().unwrap()).parse().unwrap();
        let link = listening.hub.open(address, crate::LinkOptions::default()).unwrap();
        let (mut stream, _) = in_time(server.accept()).await.unwrap();
        stream.write_all(heartbeat(1, 1, 0).bytes()).await.unwrap();
        listening.next().await;
        // Bytes that it never reads: closing a socket on them would reset the connection.
        stream.write_all(&[0; 1000]).await.unwrap();
        for _ in 0..100 {
            assert_eq!(say_something(&listening.hub), 1);
        }
        let closing = tokio::spawn(link.close());
        let mut heard = Vec::new();
        in_time(stream.read_to_end(&mut heard)).await.expect("no reset");
        drop(stream);
        in_time(closing).await.expect("closed");
        let mut decoder = FrameDecoder::new();
        decoder.push(&heard);
        assert_eq!(std::iter::from_fn(|| decoder.next_frame()).count(), 100);
    }

    #[tokio::test]
    async fn a_server_has_several_clients() {
        let mut listening = Listening::new();
        let mut link = listening.open("tcpin:127.0.0.1:0").await;
        let address = link.local_address().unwrap();
        let mut clients = Vec::new();
        for system in 1..=3u8 {
            let mut client = TcpStream::connect(address).await.unwrap();
            client.write_all(heartbeat(system, 1, 0).bytes()).await.unwrap();
            assert_eq!(listening.next().await.source().system.0, system);
            clients.push(client);
        }
        assert_eq!(say_something(&listening.hub), 1);
        for client in &mut clients {
            assert_eq!(hears(client).await.source(), US);
        }
        let _ = listening.hub.send_message(&command_to(2, 400), US, MavVersion::V2, Route::Target);
        say_something(&listening.hub);
        assert_eq!(hears(&mut clients[0]).await.message_id(), 0, "not addressed to it");
        assert_eq!(hears(&mut clients[1]).await.message_id(), 76);
        clients.remove(0);
        in_time(link.wait_for(|state| matches!(state, LinkState::Up { peers: 2, .. }))).await;
        link.close().await;
        assert!(in_time(clients[1].read_to_end(&mut Vec::new())).await.is_ok(), "closed with the link");
    }

    #[tokio::test]
    async fn too_many_clients_are_turned_away() {
        let listening = Listening::new();
        let mut link = listening.open("tcpin:127.0.0.1:0").await;
        let address = link.local_address().unwrap();
        let mut clients = Vec::new();
        for _ in 0..MAX_CLIENTS {
            clients.push(TcpStream::connect(address).await.unwrap());
        }
        in_time(link.wait_for(|state| matches!(state, LinkState::Up { peers: MAX_CLIENTS, .. }))).await;
        let mut late = TcpStream::connect(address).await.unwrap();
        assert_eq!(in_time(late.read(&mut [0])).await.unwrap_or(0), 0);
        link.close().await;
    }

    // fault 8 (1 seeds): 100,000 pieces of noise and wrong checksums: same link, at least 28 of the next 40 frames heard (what is held up is one frame of 280 bytes), one source
    /// 100,000 pieces of noise change nothing but the garbage counters.
    #[tokio::test]
    async fn noise_changes_nothing() {
        let mut listening = Listening::new();
        let link = listening.open("tcpin:127.0.0.1:0").await;
        let mut vehicle = TcpStream::connect(link.local_address().unwrap()).await.unwrap();
        vehicle.write_all(heartbeat(1, 1, 0).bytes()).await.unwrap();
        assert_eq!(listening.next().await, heartbeat(1, 1, 0));
        let state = link.state();

        let mut random = StdRng::seed_from_u64(2026);
        let good = heartbeat(1, 1, 1);
        let mut noise = Vec::new();
        for n in 0..100_000 {
            if n % 2 == 0 {
                let len = random.random_range(1..60);
                noise.extend((0..len).map(|_| random.random::<u8>()));
            } else {
                // A frame with one bit turned over, behind its start.
                let mut damaged = good.bytes().to_vec();
                let at = random.random_range(8..damaged.len() * 8);
                damaged[at / 8] ^= 1 << (at % 8);
                noise.extend(damaged);
            }
        }
        let (mut reader, mut writer) = vehicle.split();
        writer.write_all(&noise).await.unwrap();
        // What looks like the start of a frame may hide what follows, but not for longer than a frame.
        for sequence in 1..=40 {
            writer.write_all(heartbeat(1, 1, sequence).bytes()).await.unwrap();
        }
        loop {
            let frame = listening.next().await;
            if frame == heartbeat(1, 1, 40) {
                break;
            }
            assert!(!frame.is_known() || frame.source() == heartbeat(1, 1, 0).source(), "{frame:?}");
        }
        assert_eq!(link.state(), state);
        let stats = listening.hub.stats(link.id()).unwrap();
        assert_eq!(stats.sources.len(), 1, "{:?}", stats.sources);
        assert!(stats.sources[0].received.frames >= 28, "{}", stats.sources[0].received.frames);
        assert!(stats.bad_crc > 40_000, "{}", stats.bad_crc);
        assert!(stats.garbage_bytes > 2_000_000, "{}", stats.garbage_bytes);
        assert_eq!(say_something(&listening.hub), 1);
        assert!(in_time(reader.read(&mut [0; 300])).await.unwrap() > 0);
        link.close().await;
    }
}
