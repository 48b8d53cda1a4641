//! Owns when a datagram socket is read: the runtime waits for it and drains it. While thousands of datagrams come per
//! second, a thread of its own polls the socket at intervals instead: a wake-up costs as much as handling ten
//! datagrams, the runtime would be woken by each, and a sleeping runtime thread would hold up other tasks.

use std::convert::Infallible;
use std::io::{Error, ErrorKind, Result};
use std::sync::Arc;
use std::time::{Duration, Instant};

use tokio::task::JoinHandle;
use tokio::time::MissedTickBehavior;

use super::datagrams::{Datagrams, Watch, is_passing};
use crate::pace::Pace;

/// How late datagrams may be read while they come thousands a second.
const PAUSE: Duration = Duration::from_millis(1);
/// Readings in a row that found too little before the thread ends (hysteresis).
const PATIENCE: u32 = 10;
/// Datagrams read before yielding to other tasks.
const BURST: usize = 256;
/// How often [`Listener::sweep`] is called.
const SWEEP: Duration = Duration::from_secs(5);

/// Receives what is read.
pub(super) trait Listener: Send + 'static {
    /// Receives the next datagram, or returns `WouldBlock`.
    fn hear(&mut self, socket: &Datagrams) -> Result<()>;

    /// Called before and after each reading.
    fn begin(&mut self) {}
    fn end(&mut self) {}

    /// Called about every [`SWEEP`]. An error ends the socket.
    fn sweep(&mut self, _: &Datagrams) -> Result<()> {
        Ok(())
    }

    /// Whether the link is closed.
    fn is_closed(&self) -> bool {
        false
    }
}

/// Reads a socket for a listener.
pub(super) struct Reader<L> {
    socket: Arc<Datagrams>,
    listener: L,
    pace: Pace,
}

/// A thread that reads. It returns the reader at most one pause after the link was closed.
pub(super) type Paced<L> = JoinHandle<(Reader<L>, Result<()>)>;

impl<L: Listener> Reader<L> {
    pub(super) fn new(socket: Arc<Datagrams>, listener: L) -> Self {
        Self { socket, listener, pace: Pace::new(PAUSE) }
    }

    /// Reads until the socket breaks. After dropping this, wait for the thread that is left in `paced`.
    pub(super) async fn run(mut self, paced: &mut Option<Paced<L>>) -> Result<Infallible> {
        let mut sweep = tokio::time::interval(SWEEP);
        sweep.set_missed_tick_behavior(MissedTickBehavior::Delay);
        loop {
            let watch = Watch::new(&self.socket)?;
            loop {
                tokio::select! {
                    ready = watch.readable() => ready?,
                    _ = sweep.tick() => {
                        self.listener.sweep(&self.socket)?;
                        continue;
                    }
                }
                while !self.read()? {
                    tokio::task::yield_now().await;
                }
                if self.pace.pause(Instant::now()).is_some() {
                    break;
                }
                tokio::task::consume_budget().await;
            }
            drop(watch);
            let thread = tokio::task::spawn_blocking(move || {
                let read = self.read_paced();
                (self, read)
            });
            let ended = paced.insert(thread).await;
            // It must not be awaited a second time.
            *paced = None;
            let read;
            (self, read) = ended.map_err(Error::other)?;
            read?;
        }
    }

    /// Reads on this thread as long as datagrams come fast and the link is not closed.
    fn read_paced(&mut self) -> Result<()> {
        let (mut slow, mut swept) = (0, Instant::now());
        loop {
            std::thread::sleep(PAUSE);
            self.pace.on_paused();
            while !self.read()? && !self.listener.is_closed() {}
            let now = Instant::now();
            slow = if self.pace.pause(now).is_some() { 0 } else { slow + 1 };
            if slow == PATIENCE || self.listener.is_closed() {
                return Ok(());
            }
            if now - swept >= SWEEP {
                self.listener.sweep(&self.socket)?;
                swept = now;
            }
        }
    }

    /// Reads until the socket is drained, or other tasks are due; whether it is drained. An error ends the socket.
    fn read(&mut self) -> Result<bool> {
        self.listener.begin();
        let read = self.read_burst();
        self.listener.end();
        read
    }

    fn read_burst(&mut self) -> Result<bool> {
        for _ in 0..BURST {
            match self.listener.hear(&self.socket) {
                Ok(()) => self.pace.on_taken(),
                Err(error) if error.kind() == ErrorKind::WouldBlock => return Ok(true),
                Err(error) if is_passing(&error) => {}
                Err(error) => return Err(error),
            }
        }
        Ok(false)
    }
}

#[cfg(test)]
mod tests {
    use std::net::{SocketAddr, UdpSocket};
    use std::thread::ThreadId;

    use tokio::sync::mpsc::{UnboundedSender, unbounded_channel};

    use super::*;
    use crate::testing::in_time;

    /// Tells of each datagram, a number, and of the thread that read it.
    struct Teller(UnboundedSender<(u32, ThreadId)>);

    impl Listener for Teller {
        fn hear(&mut self, socket: &Datagrams) -> Result<()> {
            let mut number = [0; 4];
            socket.recv(&mut number)?;
            self.0.send((u32::from_le_bytes(number), std::thread::current().id())).map_err(Error::other)
        }

        fn is_closed(&self) -> bool {
            // So that each pause is the last, and the runtime has it back.
            true
        }
    }

    /// Finds a datagram each time.
    struct Flooded(usize);

    impl Listener for Flooded {
        fn hear(&mut self, _: &Datagrams) -> Result<()> {
            self.0 += 1;
            Ok(())
        }
    }

    /// Breaks as soon as another thread than this reads it.
    struct Brittle(ThreadId);

    impl Listener for Brittle {
        fn hear(&mut self, socket: &Datagrams) -> Result<()> {
            assert_eq!(std::thread::current().id(), self.0, "it breaks, as it shall");
            socket.recv(&mut [0; 4]).map(|_| ())
        }
    }

    /// Finds its socket to be no good any more.
    struct Leaving;

    impl Listener for Leaving {
        fn hear(&mut self, _: &Datagrams) -> Result<()> {
            Err(ErrorKind::WouldBlock.into())
        }

        fn sweep(&mut self, _: &Datagrams) -> Result<()> {
            Err(ErrorKind::AddrNotAvailable.into())
        }
    }

    #[tokio::test]
    async fn a_socket_that_is_no_good_any_more_is_read_no_longer() {
        let Err(error) = in_time(Reader::new(socket().0, Leaving).run(&mut None)).await;
        assert_eq!(error.kind(), ErrorKind::AddrNotAvailable);
    }

    fn socket() -> (Arc<Datagrams>, SocketAddr) {
        let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
        socket.set_nonblocking(true).unwrap();
        let place = socket.local_addr().unwrap();
        (Arc::new(Datagrams::new(socket).unwrap()), place)
    }

    #[tokio::test]
    async fn each_datagram_is_read_once_and_in_order_by_the_runtime_or_by_a_thread() {
        let ((socket, place), (sender, mut heard)) = (socket(), unbounded_channel());
        let from = UdpSocket::bind("127.0.0.1:0").unwrap();
        from.connect(place).unwrap();
        let (mut paced, here) = (None, std::thread::current().id());
        let changes = async {
            let (mut number, mut changes, mut last) = (0_u32, 0, here);
            // Until a thread has taken over from the runtime, which takes over again, three times. Bursts are so short
            // that a slow machine takes less for one than what counts as fast.
            while changes < 6 {
                let burst = number..number + 10;
                burst.clone().for_each(|number| _ = from.send(&number.to_le_bytes()).unwrap());
                for expected in burst {
                    let (found, reader) = in_time(heard.recv()).await.unwrap();
                    assert_eq!(found, expected);
                    changes += u32::from((reader == here) != (last == here));
                    last = reader;
                }
                number += 10;
            }
        };
        tokio::select! {
            end = Reader::new(socket, Teller(sender)).run(&mut paced) => panic!("{end:?}"),
            () = in_time(changes) => {}
        }
    }

    #[tokio::test]
    async fn a_thread_that_breaks_is_told_of_and_not_waited_for_again() {
        let ((socket, place), mut paced) = (socket(), None);
        let from = UdpSocket::bind("127.0.0.1:0").unwrap();
        from.connect(place).unwrap();
        let flood = async {
            loop {
                (0..10_u32).for_each(|number| _ = from.send(&number.to_le_bytes()).unwrap());
                tokio::task::yield_now().await;
            }
        };
        let end = tokio::select! {
            end = Reader::new(Arc::clone(&socket), Brittle(std::thread::current().id())).run(&mut paced) => end,
            () = in_time(flood) => unreachable!("it goes on"),
        };
        assert!(end.is_err_and(|error| error.to_string().contains("panicked")));
        assert!(paced.is_none());
    }

    #[test]
    fn a_flood_lets_others_have_their_turn() {
        let mut reader = Reader::new(socket().0, Flooded(0));
        assert!(!reader.read().unwrap(), "more is there");
        assert_eq!(reader.listener.0, BURST);
    }
}
