//! Owns UDP links: listening, calling one address, and broadcasting until a peer answers.
//!
//! A listening link answers every peer that has sent MAVLink within the last minute, and no others. Each peer has its
//! own decoder, because some bridges split frames over datagrams.
//!
//! Peers are bounded by [`MAX_PEERS`]. When full, a newcomer replaces, in this order, a peer that never sent MAVLink,
//! one with fewer than [`EARNED_FRAMES`] frames, one silent for [`QUIET`]. So a flood from a thousand ports shuts no
//! vehicle out, and a vehicle that comes back on another port is heard at once.

use std::io::ErrorKind;
use std::net::{IpAddr, SocketAddr};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, PoisonError, RwLock};
use std::time::Duration;

use smallvec::SmallVec;
use socket2::{Domain, Protocol, SockAddr, Socket, Type};
use vencejo_proto::{Frame, MonoTime};

use super::datagrams::{Datagram, Datagrams, send_all};
use super::reader::{Listener, Paced, Reader};
use super::{Context, End, bind_error, resolve};
use crate::address::HostPort;
use crate::fault::{FaultKind, LinkFault};
use crate::onward::Onward;
use crate::outlet::{self, Class, Outlet, PeerId, Sent, To};
use crate::port::Intake;
use crate::systems::SystemSet;

/// Most peers of a link. A newcomer that may replace none is ignored.
pub(crate) const MAX_PEERS: usize = 128;
/// Frames after which a peer is not replaced …
const EARNED_FRAMES: u32 = 5;
/// … unless it is silent for longer than this.
const QUIET: Duration = Duration::from_secs(5);
/// A peer silent for this long is no longer answered.
pub(crate) const PEER_LIFE: Duration = Duration::from_secs(60);
/// The largest datagram.
const DATAGRAM_BYTES: usize = 65_536;
/// Requested size of the socket's receive buffer; the system may grant less.
const RECEIVE_BUFFER_BYTES: usize = 4 * 1024 * 1024;

/// The kind of a UDP link.
enum Mode {
    /// Listens, and answers its peers.
    Listen { bind: HostPort },
    /// Sends to an address until a peer is heard.
    Call { bind: Option<HostPort>, remote: HostPort, broadcast: bool },
    /// Connected to one address.
    Connect { remote: HostPort },
}

impl Mode {
    /// Whether datagrams from outside the private networks are ignored.
    fn hears_near_only(&self) -> bool {
        match self {
            Self::Listen { bind } | Self::Call { bind: Some(bind), .. } => bind.is_lan(),
            Self::Call { bind: None, .. } | Self::Connect { .. } => false,
        }
    }
}

/// A peer that has sent MAVLink.
struct Peer {
    number: PeerId,
    address: SocketAddr,
    systems: Arc<SystemSet>,
}

/// State shared by the reading task and the senders.
#[derive(Default)]
struct Shared {
    socket: Option<Arc<Datagrams>>,
    /// The socket is connected to its one peer.
    connected: bool,
    /// Where to send while there are no peers.
    fallback: Option<SocketAddr>,
    /// Peers that have sent MAVLink.
    peers: Vec<Peer>,
}

#[derive(Default)]
struct UdpOutlet {
    shared: RwLock<Shared>,
}

impl UdpOutlet {
    fn change(&self, change: impl FnOnce(&mut Shared)) {
        change(&mut self.shared.write().unwrap_or_else(PoisonError::into_inner));
    }
}

impl Shared {
    /// The destinations of a frame; `None` is the remote of a connected socket.
    fn destinations(&self, to: To) -> SmallVec<[Option<SocketAddr>; 8]> {
        let mut destinations: SmallVec<[Option<SocketAddr>; 8]> = SmallVec::new();
        if self.connected {
            destinations.push(None);
            return destinations;
        }
        destinations.extend(self.peers.iter().find(|peer| Some(peer.number) == to.peer).map(|peer| Some(peer.address)));
        if let (true, Some(system)) = (destinations.is_empty(), to.system) {
            destinations
                .extend(self.peers.iter().filter(|peer| peer.systems.contains(system)).map(|peer| Some(peer.address)));
        }
        if destinations.is_empty() && to.is_strict() {
            return destinations;
        }
        if destinations.is_empty() {
            destinations.extend(self.peers.iter().map(|peer| Some(peer.address)));
        }
        if destinations.is_empty() {
            destinations.extend(self.fallback.map(Some));
        }
        destinations
    }
}

impl Outlet for UdpOutlet {
    fn send(&self, frame: &Frame, to: To, class: Class) -> Sent {
        let mut result = Sent::NobodyThere;
        self.send_all(&[(frame, to)], class, &mut |_, sent| result = sent);
        result
    }

    fn send_all(&self, frames: &[(&Frame, To)], _: Class, told: &mut dyn FnMut(&Frame, Sent)) {
        let shared = self.shared.read().unwrap_or_else(PoisonError::into_inner);
        let socket = shared.socket.clone();
        let mut datagrams: SmallVec<[Datagram<'_>; 8]> = SmallVec::new();
        // The number of the frame in each datagram.
        let mut numbers: SmallVec<[usize; 8]> = SmallVec::new();
        for (number, (frame, to)) in frames.iter().enumerate() {
            for address in shared.destinations(*to) {
                datagrams.push((frame.bytes(), address));
                numbers.push(number);
            }
        }
        drop(shared);
        let mut results: SmallVec<[Sent; 8]> = SmallVec::from_elem(Sent::NobodyThere, frames.len());
        if let Some(socket) = socket {
            send_all(&socket, &datagrams, |number, sent| {
                // Accepted when one of its datagrams is.
                let result = &mut results[numbers[number]];
                if *result != (Sent::Accepted { displaced: 0 }) {
                    *result = sent;
                }
            });
        }
        for ((frame, _), sent) in frames.iter().zip(results) {
            told(frame, sent);
        }
    }

    fn address(&self, peer: PeerId) -> Option<SocketAddr> {
        let shared = self.shared.read().unwrap_or_else(PoisonError::into_inner);
        shared.peers.iter().find(|other| other.number == peer).map(|other| other.address)
    }
}

/// A UDP link.
pub(super) struct Udp {
    mode: Mode,
    outlet: Arc<UdpOutlet>,
    /// The number of the newest peer, over all openings of the socket.
    numbers: Arc<AtomicU32>,
    /// The reading thread, while much comes.
    paced: Option<Paced<UdpReader>>,
}

impl Udp {
    pub(super) fn listen(bind: HostPort) -> Self {
        Self::new(Mode::Listen { bind })
    }

    pub(super) fn listen_and_call(bind: HostPort, remote: HostPort) -> Self {
        Self::new(Mode::Call { bind: Some(bind), remote, broadcast: false })
    }

    pub(super) fn connect(remote: HostPort) -> Self {
        Self::new(Mode::Connect { remote })
    }

    pub(super) fn broadcast(remote: HostPort) -> Self {
        Self::new(Mode::Call { bind: None, remote, broadcast: true })
    }

    fn new(mode: Mode) -> Self {
        Self { mode, outlet: Arc::default(), numbers: Arc::default(), paced: None }
    }

    pub(super) fn outlet(&self) -> Arc<dyn Outlet> {
        self.outlet.clone()
    }

    pub(super) async fn run(&mut self, context: &Arc<Context>) -> End {
        let socket = match self.open().await {
            Ok(socket) => socket,
            Err(end) => return end,
        };
        let callers = Callers::numbered_by(self.numbers.clone());
        let heard = match &self.mode {
            Mode::Connect { .. } => Peers::One(Intake::new()),
            Mode::Listen { .. } | Mode::Call { .. } if self.mode.hears_near_only() => Peers::Lan(callers),
            Mode::Listen { .. } | Mode::Call { .. } => Peers::Any(callers),
        };
        context.up(socket.local_addr().ok(), usize::from(matches!(heard, Peers::One(_))));
        let reader = UdpReader::new(context.clone(), self.outlet.clone(), heard);
        let Err(error) = Reader::new(socket, reader).run(&mut self.paced).await;
        self.outlet.change(|shared| *shared = Shared::default());
        error.into()
    }

    /// Waits until the reading thread has ended.
    pub(super) async fn finish(&mut self) {
        if let Some(paced) = self.paced.take() {
            // A join error is a panic, which the runtime has reported.
            let _ = paced.await;
        }
    }

    async fn open(&self) -> Result<Arc<Datagrams>, End> {
        let (bind, remote) = match &self.mode {
            Mode::Listen { bind } => (Some(bind), None),
            Mode::Call { bind, remote, .. } => (bind.as_ref(), Some(remote)),
            Mode::Connect { remote } => (None, Some(remote)),
        };
        let mut address = match bind {
            Some(bind) if !bind.is_lan() => resolve(bind).await?[0],
            bind => SocketAddr::from(([0u8; 4], bind.map_or(0, |bind| bind.port))),
        };
        let remote = match remote {
            Some(name) => {
                let (to, from) = pair_of(&resolve(name).await?, address).ok_or_else(|| {
                    let detail = format!("cannot send from {address} to {name}: one is IPv4, the other IPv6");
                    End::Broken(LinkFault::new(FaultKind::NotOurAddress, detail))
                })?;
                address = from;
                Some(to)
            }
            None => None,
        };
        let socket = Socket::new(Domain::for_address(address), Type::DGRAM, Some(Protocol::UDP))?;
        socket.set_nonblocking(true)?;
        // Bursts of telemetry must not be lost while we work; less than requested is fine.
        let _ = socket.set_recv_buffer_size(RECEIVE_BUFFER_BYTES);
        if matches!(self.mode, Mode::Call { broadcast: true, .. }) {
            socket.set_broadcast(true)?;
        }
        socket.bind(&SockAddr::from(address)).map_err(|error| {
            bind_error(bind.unwrap_or(&HostPort::new(address.ip().to_string(), address.port())), &error)
        })?;
        let connected = matches!(self.mode, Mode::Connect { .. });
        if let (true, Some(remote)) = (connected, remote) {
            socket.connect(&SockAddr::from(remote))?;
        }
        let socket = Arc::new(Datagrams::new(socket.into())?);
        #[cfg(not(unix))]
        socket.writable().await?;
        self.outlet.change(|shared| {
            *shared = Shared { socket: Some(socket.clone()), connected, fallback: remote, peers: Vec::new() };
        });
        Ok(socket)
    }
}

impl Drop for Udp {
    fn drop(&mut self) {
        self.outlet.change(|shared| *shared = Shared::default());
    }
}

/// Which peers are heard.
enum Peers {
    /// The remote of a connected socket.
    One(Intake),
    /// All senders.
    Any(Callers),
    /// Senders in the private networks.
    Lan(Callers),
}

/// Reads the socket of a link.
struct UdpReader {
    context: Arc<Context>,
    outlet: Arc<UdpOutlet>,
    heard: Peers,
    onward: Onward,
    /// When the current reading began.
    now: MonoTime,
    buffer: Vec<u8>,
}

impl UdpReader {
    fn new(context: Arc<Context>, outlet: Arc<UdpOutlet>, heard: Peers) -> Self {
        let (onward, now, buffer) = (Onward::default(), MonoTime::ZERO, vec![0; DATAGRAM_BYTES]);
        Self { context, outlet, heard, onward, now, buffer }
    }
}

impl Listener for UdpReader {
    fn hear(&mut self, socket: &Datagrams) -> std::io::Result<()> {
        let Self { context, outlet, heard, onward, now, buffer } = self;
        let (callers, is_near_only) = match heard {
            Peers::One(intake) => {
                let count = socket.recv(buffer)?;
                intake.feed_datagram(&context.port, &buffer[..count], |frame| {
                    context.hub.receive(&context.port, outlet::Peer::default(), frame, *now, onward);
                });
                return Ok(());
            }
            Peers::Any(callers) => (callers, false),
            Peers::Lan(callers) => (callers, true),
        };
        let (count, address) = socket.recv_from(buffer)?;
        if is_near_only && !is_near(address.ip()) {
            tracing::debug!(link = %context.port.id, peer = %address, "not heard: from outside the private networks");
            Intake::ignore(&context.port, count);
        } else {
            hear(context, outlet, callers, address, &buffer[..count], *now, onward);
        }
        Ok(())
    }

    fn begin(&mut self) {
        self.now = self.context.hub.clock().now();
    }

    fn end(&mut self) {
        self.context.hub.end_reading(&mut self.onward);
    }

    fn sweep(&mut self, socket: &Datagrams) -> std::io::Result<()> {
        if let Peers::Any(callers) | Peers::Lan(callers) = &mut self.heard {
            callers.forget_silent(self.context.hub.clock().now());
            publish(&self.context, &self.outlet, callers);
        }
        still_ours(socket.local_addr()?)
    }

    fn is_closed(&self) -> bool {
        self.context.cancel.is_cancelled()
    }
}

/// Processes a datagram.
fn hear(
    context: &Context,
    outlet: &UdpOutlet,
    callers: &mut Callers,
    address: SocketAddr,
    datagram: &[u8],
    now: MonoTime,
    onward: &mut Onward,
) {
    let Some(caller) = callers.find_or_add(address, now) else {
        return Intake::ignore(&context.port, datagram.len());
    };
    let mut is_new = false;
    let Caller { number, intake, systems, frames, .. } = caller;
    let number = *number;
    // The peer must be known before the hub answers what it hears.
    intake.feed_datagram(&context.port, datagram, |frame| {
        if frame.is_known() {
            if *frames == 0 {
                is_new = true;
                outlet.change(|shared| {
                    shared.peers.push(Peer { number, address, systems: systems.clone() });
                });
            }
            *frames = frames.saturating_add(1);
        }
        context.hub.receive(&context.port, outlet::Peer { id: number, systems: Some(systems) }, frame, now, onward);
    });
    if is_new || std::mem::take(&mut callers.has_dropped_a_peer) {
        publish(context, outlet, callers);
    }
}

/// The first remote address that can be reached from `bind`, and the address to bind for it: an unspecified address is
/// bound in the remote's IP version.
fn pair_of(remotes: &[SocketAddr], bind: SocketAddr) -> Option<(SocketAddr, SocketAddr)> {
    if let Some(remote) = remotes.iter().find(|remote| remote.is_ipv4() == bind.is_ipv4()) {
        return Some((*remote, bind));
    }
    let remote = *remotes.first().filter(|_| bind.ip().is_unspecified())?;
    let every = if remote.is_ipv4() { IpAddr::from([0u8; 4]) } else { IpAddr::from([0u16; 8]) };
    Some((remote, SocketAddr::new(every, bind.port())))
}

/// Checks that this machine still has a socket's address: after a change of network or an expired DHCP lease nothing is
/// sent or received any more, and the system reports no error on the socket.
fn still_ours(mut local: SocketAddr) -> std::io::Result<()> {
    if local.ip().is_unspecified() {
        return Ok(());
    }
    local.set_port(0);
    match std::net::UdpSocket::bind(local) {
        Err(error) if error.kind() == ErrorKind::AddrNotAvailable => Err(error),
        // Other errors say nothing about the address.
        _ => Ok(()),
    }
}

/// Publishes the peers to the senders and to the link's state.
fn publish(context: &Context, outlet: &UdpOutlet, callers: &Callers) {
    let peers: Vec<Peer> = callers.spoken().collect();
    context.peers(peers.len());
    outlet.change(|shared| shared.peers = peers);
}

/// Whether an address is of this machine or of a network that is not routed on the internet (RFC 1918, RFC 3927, RFC
/// 4193).
fn is_near(ip: IpAddr) -> bool {
    match ip.to_canonical() {
        IpAddr::V4(ip) => ip.is_loopback() || ip.is_private() || ip.is_link_local(),
        IpAddr::V6(ip) => ip.is_loopback() || ip.is_unicast_link_local() || ip.is_unique_local(),
    }
}

/// A sender, of MAVLink or not.
struct Caller {
    number: PeerId,
    address: SocketAddr,
    intake: Intake,
    systems: Arc<SystemSet>,
    heard_at: MonoTime,
    /// Frames received.
    frames: u32,
}

/// Recent senders, at most [`MAX_PEERS`].
#[derive(Default)]
struct Callers {
    list: Vec<Caller>,
    /// Index of the last sender, which probably sends next.
    last: usize,
    /// The number of the newest sender.
    numbers: Arc<AtomicU32>,
    /// Whether a peer was replaced since this was read.
    has_dropped_a_peer: bool,
}

impl Callers {
    fn numbered_by(numbers: Arc<AtomicU32>) -> Self {
        Self { numbers, ..Self::default() }
    }

    fn find_or_add(&mut self, address: SocketAddr, now: MonoTime) -> Option<&mut Caller> {
        let found = match self.list.get(self.last) {
            Some(caller) if caller.address == address => Some(self.last),
            _ => self.list.iter().position(|caller| caller.address == address),
        };
        let index = match found {
            Some(index) => index,
            None => {
                if self.list.len() >= MAX_PEERS {
                    let index = self.least_worthy(now)?;
                    let gone = self.list.swap_remove(index);
                    self.has_dropped_a_peer |= gone.frames > 0;
                }
                let number = self.numbers.fetch_add(1, Ordering::Relaxed).wrapping_add(1);
                self.list.push(Caller {
                    number: PeerId(number),
                    address,
                    intake: Intake::new(),
                    systems: Arc::default(),
                    heard_at: now,
                    frames: 0,
                });
                self.list.len() - 1
            }
        };
        self.last = index;
        let caller = &mut self.list[index];
        caller.heard_at = now;
        Some(caller)
    }

    /// The sender that a newcomer replaces; `None` when all are to stay.
    fn least_worthy(&self, now: MonoTime) -> Option<usize> {
        let longest_silent = |is_candidate: &dyn Fn(&Caller) -> bool| {
            let candidates = self.list.iter().enumerate().filter(|(_, caller)| is_candidate(caller));
            candidates.min_by_key(|(_, caller)| caller.heard_at).map(|(index, _)| index)
        };
        let never_spoke = |caller: &Caller| caller.frames == 0;
        longest_silent(&never_spoke)
            .or_else(|| {
                // Of the host with most of them: a crowd from one host replaces itself first.
                let is_passer_by = |caller: &Caller| caller.frames < EARNED_FRAMES;
                let mut crowd: SmallVec<[(IpAddr, usize); 8]> = SmallVec::new();
                for ip in self.list.iter().filter(|caller| is_passer_by(caller)).map(|caller| caller.address.ip()) {
                    match crowd.iter_mut().find(|(other, _)| *other == ip) {
                        Some((_, count)) => *count += 1,
                        None => crowd.push((ip, 1)),
                    }
                }
                let most = crowd.into_iter().max_by_key(|(_, count)| *count).map(|(ip, _)| ip)?;
                longest_silent(&|caller| is_passer_by(caller) && caller.address.ip() == most)
            })
            .or_else(|| longest_silent(&|caller| now.since(caller.heard_at) > QUIET))
    }

    fn forget_silent(&mut self, now: MonoTime) {
        self.list.retain(|caller| now.since(caller.heard_at) < PEER_LIFE);
    }

    fn spoken(&self) -> impl Iterator<Item = Peer> {
        self.list.iter().filter(|caller| caller.frames > 0).map(|caller| Peer {
            number: caller.number,
            address: caller.address,
            systems: caller.systems.clone(),
        })
    }
}

#[cfg(test)]
mod tests {
    use tokio::net::UdpSocket;

    use super::*;
    use crate::testing::{Listening, US, command_to, heartbeat, in_time, say_something};
    use crate::{LinkOptions, LinkState, Origin, Route};
    use vencejo_proto::{FrameDecoder, MavVersion};

    async fn peer() -> UdpSocket {
        UdpSocket::bind("127.0.0.1:0").await.unwrap()
    }

    /// The frames of the next datagram.
    async fn hears(socket: &UdpSocket) -> Frame {
        let mut buffer = [0; 300];
        let count = in_time(socket.recv(&mut buffer)).await.unwrap();
        let mut decoder = FrameDecoder::new();
        decoder.push(&buffer[..count]);
        decoder.next_frame().expect("a frame")
    }

    fn hears_nothing(socket: &UdpSocket) -> bool {
        socket.try_recv(&mut [0; 300]).is_err_and(|error| error.kind() == ErrorKind::WouldBlock)
    }

    #[tokio::test]
    async fn a_listening_link_answers_those_who_speak() {
        let mut listening = Listening::new();
        let mut link = listening.open("udpin:127.0.0.1:0").await;
        let address = link.local_address().unwrap();
        let (one, two, noisy) = (peer().await, peer().await, peer().await);
        assert_eq!(say_something(&listening.hub), 0, "nobody is there");

        noisy.send_to(b"GET / HTTP/1.1\r\n\r\n", address).await.unwrap();
        for (system, socket) in [(1, &one), (2, &two)] {
            socket.send_to(heartbeat(system, 1, 0).bytes(), address).await.unwrap();
            assert_eq!(listening.next().await, heartbeat(system, 1, 0));
        }
        in_time(link.wait_for(|state| matches!(state, LinkState::Up { peers: 2, .. }))).await;
        assert_eq!(say_something(&listening.hub), 1, "one link");
        assert_eq!(hears(&one).await.source(), US);
        assert_eq!(hears(&two).await.source(), US);

        let report = listening.hub.send_message(&command_to(2, 400), US, MavVersion::V2, Route::Target);
        assert!(report.is_sent());
        assert_eq!(hears(&two).await.message_id(), 76);
        say_something(&listening.hub);
        assert_eq!(hears(&one).await.message_id(), 0, "the command did not come here, the heartbeat after it did");
        assert!(hears_nothing(&noisy), "who speaks no MAVLink is not answered");

        let stats = listening.hub.stats(link.id()).unwrap();
        assert_eq!(stats.received.frames, 2);
        assert_eq!(stats.garbage_bytes, 18);
        assert_eq!(stats.sources.len(), 2);
        link.close().await;
    }

    #[tokio::test]
    async fn what_is_for_one_peer_goes_to_no_other_of_its_system() {
        let mut listening = Listening::new();
        let link = listening.open("udpin:127.0.0.1:0").await;
        let (one, two) = (peer().await, peer().await);
        for (sequence, socket) in [(0, &one), (1, &two)] {
            socket.send_to(heartbeat(1, 1, sequence).bytes(), link.local_address().unwrap()).await.unwrap();
            listening.next().await;
        }
        let send = |number| {
            let route = Route::Peer(Origin { link: link.id(), peer: PeerId(number) });
            listening.hub.send_message(&command_to(1, 400), US, MavVersion::V2, route)
        };
        assert!(send(1).is_sent());
        assert_eq!(hears(&one).await.message_id(), 76);
        assert!(!send(3).is_sent(), "there is no such peer");
        say_something(&listening.hub);
        assert_eq!((hears(&one).await.message_id(), hears(&two).await.message_id()), (0, 0));
        link.close().await;
    }

    #[test]
    fn a_socket_that_was_opened_anew_gives_no_number_again() {
        let udp = Udp::listen(HostPort::new("127.0.0.1", 0));
        let mut numbers = Vec::new();
        for _ in 0..3 {
            let mut callers = Callers::numbered_by(udp.numbers.clone());
            numbers.extend([1, 2].map(|port| callers.find_or_add(address(port), MonoTime::ZERO).unwrap().number.0));
        }
        assert_eq!(numbers, [1, 2, 3, 4, 5, 6]);
    }

    #[test]
    fn the_socket_has_the_ip_version_of_the_remote() {
        let address = |text: &str| text.parse::<SocketAddr>().unwrap();
        let pair = |remotes: &[&str], bind| {
            let remotes: Vec<_> = remotes.iter().map(|remote| address(remote)).collect();
            pair_of(&remotes, address(bind)).map(|(remote, bind)| (remote.to_string(), bind.to_string()))
        };
        let (four, six) = ("10.0.0.1:9", "[2001:db8::1]:9");
        let some = |remote: &str, bind: &str| Some((remote.to_owned(), bind.to_owned()));
        assert_eq!(pair(&[four, six], "0.0.0.0:14550"), some(four, "0.0.0.0:14550"));
        assert_eq!(pair(&[four, six], "[::]:14550"), some(six, "[::]:14550"));
        assert_eq!(pair(&[six], "0.0.0.0:14550"), some(six, "[::]:14550"));
        assert_eq!(pair(&[four], "[::]:14550"), some(four, "0.0.0.0:14550"));
        assert_eq!(pair(&[four, six], "[::1]:14550"), some(six, "[::1]:14550"));
        assert_eq!(pair(&[six], "127.0.0.1:14550"), None);
    }

    // fault 13: a socket whose address this machine has no more is given up, and opened anew
    #[test]
    fn an_address_that_went_away_is_noticed() {
        let is_ours = |address: &str| still_ours(address.parse().unwrap()).map_err(|error| error.kind());
        // TEST-NET-1 (RFC 5737) and the prefix for documentation (RFC 3849) are no machine's.
        for gone in ["192.0.2.1:14550", "[2001:db8::1]:14550"] {
            assert_eq!(is_ours(gone), Err(ErrorKind::AddrNotAvailable), "{gone}");
        }
        let taken = std::net::UdpSocket::bind("127.0.0.1:0").unwrap();
        for ours in [taken.local_addr().unwrap().to_string().as_str(), "0.0.0.0:14550", "[::]:14550"] {
            assert_eq!(is_ours(ours), Ok(()), "{ours}");
        }
    }

    // fault 7: frames cut at every offset over two datagrams of two peers are put together
    #[tokio::test]
    async fn frames_cut_anywhere_are_put_together_per_peer() {
        let mut listening = Listening::new();
        let link = listening.open("udpin:127.0.0.1:0").await;
        let address = link.local_address().unwrap();
        let (one, two) = (peer().await, peer().await);
        let (a, b) = (heartbeat(1, 1, 0), heartbeat(2, 1, 0));
        for cut in 1..a.bytes().len() {
            one.send_to(&a.bytes()[..cut], address).await.unwrap();
            two.send_to(&b.bytes()[..cut], address).await.unwrap();
            one.send_to(&a.bytes()[cut..], address).await.unwrap();
            two.send_to(&b.bytes()[cut..], address).await.unwrap();
            let mut systems = [listening.next().await.source().system.0, listening.next().await.source().system.0];
            systems.sort_unstable();
            assert_eq!(systems, [1, 2], "cut at {cut}");
        }
        let stats = listening.hub.stats(link.id()).unwrap();
        assert_eq!((stats.bad_crc, stats.garbage_bytes), (0, 0));
        link.close().await;
    }

    // fault 7: 1,332 datagrams cut at every offset cost themselves alone
    /// Whatever is cut off, every whole frame is found.
    #[tokio::test]
    async fn truncated_datagrams_cost_only_themselves() {
        let mut listening = Listening::new();
        let link = listening.open("udpin:127.0.0.1:0").await;
        let address = link.local_address().unwrap();
        let vehicle = peer().await;
        let len = heartbeat(1, 1, 0).bytes().len();
        let mut whole = 0u32;
        let mut heard = 0u32;
        for n in 0..1998u32 {
            let frame = heartbeat(1, 1, n as u8);
            // Every third is cut, at each place in turn.
            let cut = if n % 3 == 0 { 1 + (n / 3) as usize % (len - 1) } else { len };
            whole += u32::from(cut == len);
            vehicle.send_to(&frame.bytes()[..cut], address).await.unwrap();
            if n % 3 == 2 {
                while heard < whole {
                    let frame = listening.next().await;
                    assert_eq!(frame.source().system.0, 1);
                    heard += 1;
                }
            }
        }
        let stats = listening.hub.stats(link.id()).unwrap();
        assert_eq!((heard, stats.received.frames), (1332, 1332));
        assert_eq!(stats.received.bytes, stats.garbage_bytes + 1332 * len as u64);
        link.close().await;
    }

    /// Two peers, one of whose datagrams is torn, and one that cuts its frames in two, all before the link is read
    /// once.
    #[tokio::test]
    async fn what_waits_is_read_and_passed_on_in_one_go() {
        let mut listening = Listening::new();
        let link = listening.open("udpin:127.0.0.1:0").await;
        let far_end = peer().await;
        let tee = format!("udpout:{}", far_end.local_addr().unwrap());
        let mut tee = listening.hub.open(tee.parse().unwrap(), LinkOptions::tee()).unwrap();
        in_time(tee.wait_for(LinkState::is_up)).await;

        let address = link.local_address().unwrap();
        let [one, two] = [0; 2].map(|_| std::net::UdpSocket::bind("127.0.0.1:0").unwrap());
        let mut whole = Vec::new();
        // Nothing is read meanwhile: this test's thread is the only one.
        for sequence in 0..100 {
            let (a, b) = (heartbeat(1, 1, sequence), heartbeat(2, 1, sequence));
            let cut = 1 + usize::from(sequence) % 20;
            let is_torn = sequence % 10 == 4;
            two.send_to(&b.bytes()[..cut], address).unwrap();
            one.send_to(&a.bytes()[..if is_torn { cut } else { a.bytes().len() }], address).unwrap();
            two.send_to(&b.bytes()[cut..], address).unwrap();
            whole.extend(if is_torn { None } else { Some(a) }.into_iter().chain([b]));
        }
        for frame in &whole {
            assert_eq!(listening.next().await, *frame);
            assert_eq!(hears(&far_end).await, *frame);
        }
        let (stats, onward) = (listening.hub.stats(link.id()).unwrap(), listening.hub.stats(tee.id()).unwrap());
        assert_eq!((stats.received.frames, stats.lost, stats.dropped), (190, 10, 0));
        assert_eq!((onward.sent.frames, onward.dropped), (190, 0));
        assert!(stats.garbage_bytes > 0);
        link.close().await;
    }

    #[tokio::test]
    async fn calling_survives_that_nobody_is_there_yet() {
        let mut listening = Listening::new();
        let reserved = peer().await;
        let address = reserved.local_addr().unwrap();
        drop(reserved);
        let link = listening.open(&format!("udpout:{address}")).await;
        let state = link.state();
        for _ in 0..20 {
            // The first is on its way; later ones meet the refusal of earlier ones.
            assert_eq!(say_something(&listening.hub), 1);
            tokio::task::yield_now().await;
        }
        let vehicle = UdpSocket::bind(address).await.unwrap();
        say_something(&listening.hub);
        assert_eq!(hears(&vehicle).await.source(), US);
        vehicle.send_to(heartbeat(1, 1, 0).bytes(), link.local_address().unwrap()).await.unwrap();
        assert_eq!(listening.next().await, heartbeat(1, 1, 0));
        assert_eq!(link.state(), state, "the link was up all the time");

        let stranger = peer().await;
        stranger.send_to(heartbeat(66, 1, 0).bytes(), link.local_address().unwrap()).await.unwrap();
        vehicle.send_to(heartbeat(1, 1, 1).bytes(), link.local_address().unwrap()).await.unwrap();
        assert_eq!(listening.next().await, heartbeat(1, 1, 1), "a stranger is not heard");
        link.close().await;
    }

    #[tokio::test]
    async fn listening_and_calling_talks_to_the_remote_until_somebody_speaks() {
        let mut listening = Listening::new();
        let (remote, other) = (peer().await, peer().await);
        let link = listening.open(&format!("udp://127.0.0.1:0@{}", remote.local_addr().unwrap())).await;
        say_something(&listening.hub);
        assert_eq!(hears(&remote).await.source(), US);
        other.send_to(heartbeat(1, 1, 0).bytes(), link.local_address().unwrap()).await.unwrap();
        listening.next().await;
        say_something(&listening.hub);
        assert_eq!(hears(&other).await.source(), US);
        assert!(hears_nothing(&remote));
        link.close().await;
    }

    #[cfg(target_os = "linux")]
    #[tokio::test]
    async fn broadcasting_ends_when_somebody_answers() {
        let mut listening = Listening::new();
        // The loopback interface has a broadcast address too.
        let everybody = UdpSocket::bind("127.255.255.255:0").await.unwrap();
        let mut link = listening.open(&format!("udpbcast:{}", everybody.local_addr().unwrap())).await;
        say_something(&listening.hub);
        assert_eq!(hears(&everybody).await.source(), US);
        let vehicle = peer().await;
        let ours = SocketAddr::from(([127, 0, 0, 1], link.local_address().unwrap().port()));
        vehicle.send_to(heartbeat(1, 1, 0).bytes(), ours).await.unwrap();
        listening.next().await;
        in_time(link.wait_for(|state| matches!(state, LinkState::Up { peers: 1, .. }))).await;
        say_something(&listening.hub);
        assert_eq!(hears(&vehicle).await.source(), US);
        assert!(hears_nothing(&everybody));
        link.close().await;
    }

    #[test]
    fn near_is_what_no_router_of_the_internet_passes_on() {
        for (ip, expected) in [
            ("127.0.0.1", true),
            ("10.1.2.3", true),
            ("172.31.0.1", true),
            ("192.168.4.1", true),
            ("169.254.1.1", true),
            ("::1", true),
            ("fe80::1", true),
            ("fd00::1", true),
            ("::ffff:192.168.1.1", true),
            ("8.8.8.8", false),
            ("172.32.0.1", false),
            ("100.64.0.1", false),
            ("2001:db8::1", false),
        ] {
            assert_eq!(is_near(ip.parse().unwrap()), expected, "{ip}");
        }
    }

    #[tokio::test]
    async fn a_link_of_the_private_networks_hears_them() {
        let mut listening = Listening::new();
        for address in ["udpin:lan:0", "udp://lan:0@127.0.0.1:9"] {
            let link = listening.open(address).await;
            assert_eq!(link.address().to_string(), address);
            let there = SocketAddr::from(([127, 0, 0, 1], link.local_address().unwrap().port()));
            peer().await.send_to(heartbeat(1, 1, 0).bytes(), there).await.unwrap();
            assert_eq!(listening.next().await, heartbeat(1, 1, 0));
            link.close().await;
            listening = Listening::new();
        }
    }

    #[test]
    fn lan_hears_the_private_networks_alone_in_each_form() {
        let [lan, all, remote] = ["lan", "0.0.0.0", "10.9.9.9"].map(|host| HostPort::new(host, 14550));
        for (bind, is_near_only) in [(&lan, true), (&all, false)] {
            let call = Mode::Call { bind: Some(bind.clone()), remote: remote.clone(), broadcast: false };
            let modes = [Mode::Listen { bind: bind.clone() }, call];
            assert_eq!(modes.each_ref().map(Mode::hears_near_only), [is_near_only; 2], "{bind}");
        }
    }

    fn address(port: u16) -> SocketAddr {
        SocketAddr::from(([127, 0, 0, 1], port))
    }

    #[test]
    fn callers_are_bounded_and_those_who_spoke_stay() {
        let mut callers = Callers::default();
        for n in 0..MAX_PEERS as u16 {
            let caller = callers.find_or_add(address(n + 1), MonoTime::from_millis(u64::from(n))).unwrap();
            caller.frames = if n != 5 && n != 9 { EARNED_FRAMES } else { 0 };
        }
        for port in [60_000, 60_001] {
            let newcomer = callers.find_or_add(address(port), MonoTime::from_millis(500)).unwrap();
            newcomer.frames = EARNED_FRAMES;
        }
        assert_eq!(callers.list.len(), MAX_PEERS);
        assert!(!callers.list.iter().any(|caller| [address(6), address(10)].contains(&caller.address)));
        assert!(
            callers.find_or_add(address(60_002), MonoTime::from_millis(501)).is_none(),
            "all are worth their destinations"
        );
        assert_eq!(callers.spoken().count(), MAX_PEERS);
        // The one silent for longest makes room once it is taken for gone.
        assert!(callers.find_or_add(address(60_002), MonoTime::from_millis(5_001)).is_some());
        assert!(!callers.list.iter().any(|caller| caller.address == address(1)));
    }

    #[test]
    fn a_crowd_makes_room_for_itself_first() {
        let mut callers = Callers::default();
        let passer_by = |host: u8, port: u16| SocketAddr::from(([10, 0, 0, host], port));
        callers.find_or_add(passer_by(1, 1), MonoTime::ZERO).unwrap().frames = 1;
        for n in 0..10_000 {
            callers.find_or_add(passer_by(2, n + 1), MonoTime::from_millis(1 + u64::from(n) / 100)).unwrap().frames = 1;
        }
        assert_eq!(callers.list.len(), MAX_PEERS);
        assert!(callers.list.iter().any(|caller| caller.address == passer_by(1, 1)), "it may yet earn its address");
    }

    /// A vehicle that comes back on another port while the places are full of those who said one frame and went.
    #[tokio::test]
    async fn one_frame_from_each_of_many_shuts_nobody_out() {
        let mut listening = Listening::new();
        let link = listening.open("udpin:127.0.0.1:0").await;
        let there = link.local_address().unwrap();
        for system in 0..MAX_PEERS as u8 {
            peer().await.send_to(heartbeat(100 + system % 100, 1, system).bytes(), there).await.unwrap();
            listening.next().await;
        }
        let vehicle = peer().await;
        vehicle.send_to(heartbeat(1, 1, 7).bytes(), there).await.unwrap();
        assert_eq!(listening.next().await, heartbeat(1, 1, 7), "it is heard");
        let report = listening.hub.send_message(&command_to(1, 400), US, MavVersion::V2, Route::Target);
        assert!(report.is_sent());
        assert_eq!(hears(&vehicle).await.message_id(), 76, "and answered");
        link.close().await;
    }

    #[test]
    fn the_silent_are_forgotten() {
        let mut callers = Callers::default();
        for (port, ms) in [(1, 0), (2, 30_000)] {
            callers.find_or_add(address(port), MonoTime::from_millis(ms)).unwrap().frames = 1;
        }
        callers.forget_silent(MonoTime::from_millis(60_001));
        assert_eq!(callers.spoken().map(|peer| peer.address).collect::<Vec<_>>(), [address(2)]);
        callers.forget_silent(MonoTime::from_millis(120_000));
        assert_eq!(callers.spoken().count(), 0);
    }
}
