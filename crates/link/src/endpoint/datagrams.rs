//! Owns a datagram socket: it is polled for reading only, sends several datagrams with one system call where there is
//! one (Linux), and tells errors of one datagram from errors of the socket.

use std::io::{Error, ErrorKind, Result};
use std::net::{SocketAddr, UdpSocket};
use std::sync::Arc;

use crate::outlet::Sent;

/// A socket that never waits to send, so the runtime is not woken whenever the system has room to send more, as it is
/// with tokio's own socket.
#[cfg(unix)]
pub(super) struct Datagrams(UdpSocket);

#[cfg(unix)]
impl Datagrams {
    /// Takes a non-blocking socket.
    pub(super) fn new(socket: UdpSocket) -> Result<Self> {
        Ok(Self(socket))
    }

    pub(super) fn recv(&self, buffer: &mut [u8]) -> Result<usize> {
        self.0.recv(buffer)
    }

    pub(super) fn recv_from(&self, buffer: &mut [u8]) -> Result<(usize, SocketAddr)> {
        self.0.recv_from(buffer)
    }

    fn try_send(&self, (bytes, address): &Datagram<'_>) -> Result<usize> {
        match address {
            Some(address) => self.0.send_to(bytes, address),
            None => self.0.send(bytes),
        }
    }

    pub(super) fn local_addr(&self) -> Result<SocketAddr> {
        self.0.local_addr()
    }
}

#[cfg(unix)]
impl std::os::fd::AsRawFd for Datagrams {
    fn as_raw_fd(&self) -> std::os::fd::RawFd {
        self.0.as_raw_fd()
    }
}

/// While it lives, the runtime is woken when a socket becomes readable.
#[cfg(unix)]
pub(super) struct Watch(tokio::io::unix::AsyncFd<Arc<Datagrams>>);

#[cfg(unix)]
impl Watch {
    #[expect(
        deprecated,
        reason = "what takes its address is unsafe; a socket that is owned stays open and the same, which is all it asks"
    )]
    pub(super) fn new(socket: &Arc<Datagrams>) -> Result<Self> {
        Ok(Self(tokio::io::unix::AsyncFd::with_interest(socket.clone(), tokio::io::Interest::READABLE)?))
    }

    /// Waits until the socket is readable. It is edge-triggered: the socket must be drained then.
    pub(super) async fn readable(&self) -> Result<()> {
        self.0.readable().await?.clear_ready();
        Ok(())
    }
}

/// The same with tokio's own socket.
#[cfg(not(unix))]
pub(super) struct Datagrams(tokio::net::UdpSocket);

#[cfg(not(unix))]
impl Datagrams {
    /// Takes a non-blocking socket.
    pub(super) fn new(socket: UdpSocket) -> Result<Self> {
        Ok(Self(tokio::net::UdpSocket::from_std(socket)?))
    }

    /// Until the runtime has seen the socket writable, `try_send` sends nothing.
    pub(super) async fn writable(&self) -> Result<()> {
        self.0.writable().await
    }

    pub(super) fn recv(&self, buffer: &mut [u8]) -> Result<usize> {
        self.0.try_recv(buffer)
    }

    pub(super) fn recv_from(&self, buffer: &mut [u8]) -> Result<(usize, SocketAddr)> {
        self.0.try_recv_from(buffer)
    }

    fn try_send(&self, (bytes, address): &Datagram<'_>) -> Result<usize> {
        match address {
            Some(address) => self.0.try_send_to(bytes, *address),
            None => self.0.try_send(bytes),
        }
    }

    pub(super) fn local_addr(&self) -> Result<SocketAddr> {
        self.0.local_addr()
    }
}

/// Tokio's own socket is always watched.
#[cfg(not(unix))]
pub(super) struct Watch(Arc<Datagrams>);

#[cfg(not(unix))]
impl Watch {
    pub(super) fn new(socket: &Arc<Datagrams>) -> Result<Self> {
        Ok(Self(socket.clone()))
    }

    pub(super) async fn readable(&self) -> Result<()> {
        self.0.0.readable().await
    }
}

/// A datagram and its destination; `None` for a connected socket.
pub(super) type Datagram<'a> = (&'a [u8], Option<SocketAddr>);

/// Sends datagrams in order without waiting, and reports the result of each by its number, in the same order.
pub(super) fn send_all(socket: &Datagrams, datagrams: &[Datagram<'_>], mut told: impl FnMut(usize, Sent)) {
    let mut number = 0;
    while let rest @ [first, ..] = &datagrams[number..] {
        let sent = if rest.len() > 1 { send_some(socket, rest) } else { 0 };
        (number..number + sent).for_each(|number| told(number, Sent::Accepted { displaced: 0 }));
        number += sent;
        if sent == 0 {
            // The system reports the error of a datagram only when it is sent alone.
            told(number, send(socket, first));
            number += 1;
        }
    }
}

fn send(socket: &Datagrams, datagram: &Datagram<'_>) -> Sent {
    // The ICMP refusal of an earlier datagram is reported by a later call, which then sends nothing: call again.
    let sent = match socket.try_send(datagram) {
        Err(error) if is_refusal(&error) => socket.try_send(datagram),
        result => result,
    };
    match sent {
        Ok(_) => Sent::Accepted { displaced: 0 },
        Err(error) if error.kind() == ErrorKind::WouldBlock => Sent::Full,
        Err(_) => Sent::NobodyThere,
    }
}

/// Sends as many of the first datagrams as the system takes with one call.
#[cfg(target_os = "linux")]
fn send_some(socket: &Datagrams, datagrams: &[Datagram<'_>]) -> usize {
    use std::io::IoSlice;

    use rustix::net::addr::SocketAddrArg;
    use rustix::net::{MMsgHdr, SendAncillaryBuffer, SendFlags, sendmmsg};

    let addresses: Vec<_> = datagrams.iter().map(|(_, address)| address.map(|address| address.as_any())).collect();
    let bytes: Vec<_> = datagrams.iter().map(|(bytes, _)| [IoSlice::new(bytes)]).collect();
    let mut controls: Vec<_> = datagrams.iter().map(|_| SendAncillaryBuffer::default()).collect();
    let mut messages: Vec<_> = addresses
        .iter()
        .zip(&bytes)
        .zip(&mut controls)
        .map(|((address, bytes), control)| match address {
            Some(address) => MMsgHdr::new_with_addr(address, bytes, control),
            None => MMsgHdr::new(bytes, control),
        })
        .collect();
    sendmmsg(&socket.0, &mut messages, SendFlags::empty()).unwrap_or(0)
}

/// None: Rust's libraries offer no such call on this system.
#[cfg(not(target_os = "linux"))]
const fn send_some(_: &Datagrams, _: &[Datagram<'_>]) -> usize {
    0
}

fn is_refusal(error: &Error) -> bool {
    matches!(error.kind(), ErrorKind::ConnectionRefused | ErrorKind::ConnectionReset)
}

/// Errors of one datagram (no room now, no receiver yet) that do not mean that the socket is broken.
pub(super) fn is_passing(error: &Error) -> bool {
    is_refusal(error)
        || matches!(
            error.kind(),
            ErrorKind::Interrupted
                | ErrorKind::HostUnreachable
                | ErrorKind::NetworkUnreachable
                | ErrorKind::NetworkDown
        )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::in_time;

    const ACCEPTED: Sent = Sent::Accepted { displaced: 0 };

    async fn pair() -> (Datagrams, tokio::net::UdpSocket) {
        let to = tokio::net::UdpSocket::bind("127.0.0.1:0").await.unwrap();
        let from = open();
        from.connect(to.local_addr().unwrap()).unwrap();
        (Datagrams::new(from).unwrap(), to)
    }

    fn open() -> UdpSocket {
        let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
        socket.set_nonblocking(true).unwrap();
        socket
    }

    fn sent(socket: &Datagrams, datagrams: &[Datagram<'_>]) -> Vec<Sent> {
        let mut all = Vec::new();
        send_all(socket, datagrams, |number, sent| {
            assert_eq!(number, all.len(), "in their order");
            all.push(sent);
        });
        all
    }

    async fn next(socket: &tokio::net::UdpSocket) -> Vec<u8> {
        let mut buffer = [0; 100];
        let count = in_time(socket.recv(&mut buffer)).await.unwrap();
        buffer[..count].to_vec()
    }

    #[tokio::test]
    async fn what_the_system_refuses_in_the_middle_costs_only_itself() {
        let (from, to) = pair().await;
        let oversized = vec![0; 70_000];
        assert_eq!(sent(&from, &[]), []);
        let datagrams: [Datagram<'_>; 6] =
            [(b"a", None), (b"b", None), (&oversized, None), (&oversized, None), (b"c", None), (b"d", None)];
        let expected = [ACCEPTED, ACCEPTED, Sent::NobodyThere, Sent::NobodyThere, ACCEPTED, ACCEPTED];
        assert_eq!(sent(&from, &datagrams), expected);
        for expected in [b"a", b"b", b"c", b"d"] {
            assert_eq!(next(&to).await, expected);
        }
    }

    #[tokio::test]
    async fn each_goes_to_its_own_place() {
        let ((_, one), (_, two), socket) = (pair().await, pair().await, Datagrams::new(open()).unwrap());
        let addresses = [&one, &two].map(|socket| Some(socket.local_addr().unwrap()));
        let nowhere = Some(SocketAddr::from(([255, 255, 255, 255], 9)));
        let datagrams: [Datagram<'_>; 4] =
            [(b"a", addresses[0]), (b"b", addresses[1]), (b"c", nowhere), (b"d", addresses[0])];
        assert_eq!(sent(&socket, &datagrams), [ACCEPTED, ACCEPTED, Sent::NobodyThere, ACCEPTED]);
        assert_eq!([next(&one).await, next(&two).await, next(&one).await], [b"a", b"b", b"d"]);
    }

    #[tokio::test]
    async fn a_refusal_of_an_earlier_datagram_costs_no_later_one() {
        let (from, to) = pair().await;
        let address = to.local_addr().unwrap();
        drop(to);
        let datagrams: [Datagram<'_>; 3] = [(b"a", None), (b"b", None), (b"c", None)];
        for _ in 0..10 {
            assert_eq!(sent(&from, &datagrams), [ACCEPTED; 3], "each is on its way, and the answer to it comes later");
        }
        let to = tokio::net::UdpSocket::bind(address).await.unwrap();
        assert_eq!(sent(&from, &datagrams), [ACCEPTED; 3]);
        for expected in [b"a", b"b", b"c"] {
            assert_eq!(next(&to).await, expected);
        }
    }
}
