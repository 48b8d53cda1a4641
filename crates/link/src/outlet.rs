//! Owns the sending side of links: the trait that the hub sends through, and the bounded queue in front of a stream's
//! writer.

use std::collections::VecDeque;
use std::net::SocketAddr;
use std::sync::{Mutex, MutexGuard, PoisonError};

use tokio::sync::Notify;
use vencejo_proto::{Frame, SystemId};

use crate::systems::SystemSet;

/// Bytes that may be queued for a stream in each class, our own frames and forwarded ones.
const QUEUE_BYTES: usize = 64 * 1024;

/// What became of a frame given to a link.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Sent {
    /// It was taken. `displaced` older frames were dropped for it.
    Accepted { displaced: u64 },
    /// No peer is connected.
    NobodyThere,
    /// The queue is full.
    Full,
}

/// Identifies a peer of a link; 0 on a link with a single peer. Not reused while the link is open.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct PeerId(pub u32);

/// A peer of a link, as the reading task knows it.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Peer<'a> {
    pub(crate) id: PeerId,
    /// The systems heard from it, for links with several peers.
    pub(crate) systems: Option<&'a SystemSet>,
}

/// The addressees of a frame among the peers of a link.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct To {
    /// Peers behind which this system was heard; all peers when it was heard behind none.
    pub(crate) system: Option<SystemId>,
    /// This peer only. When it is gone: the peers that `system` selects, or no peer without `system`.
    pub(crate) peer: Option<PeerId>,
}

impl To {
    /// By the target system of a frame.
    pub(crate) fn target_of(frame: &Frame) -> Self {
        Self { system: frame.target().named_system(), peer: None }
    }

    /// Whether no other peer may get it.
    pub(crate) fn is_strict(self) -> bool {
        self.peer.is_some() && self.system.is_none()
    }
}

/// The class of a frame: our own go first and are never displaced.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Class {
    Own,
    Forwarded,
}

/// The sending side of an endpoint. Lives as long as the link, across its connections.
pub(crate) trait Outlet: Send + Sync + 'static {
    /// Sends a frame without waiting.
    fn send(&self, frame: &Frame, to: To, class: Class) -> Sent;

    /// Sends frames in order without waiting, and reports the result of each in the same order.
    fn send_all(&self, frames: &[(&Frame, To)], class: Class, told: &mut dyn FnMut(&Frame, Sent)) {
        for (frame, to) in frames {
            told(frame, self.send(frame, *to, class));
        }
    }

    /// The address of a peer, for links with several peers.
    fn address(&self, _: PeerId) -> Option<SocketAddr> {
        None
    }
}

/// The outlet of links that cannot send.
pub(crate) struct NoOutlet;

impl Outlet for NoOutlet {
    fn send(&self, _: &Frame, _: To, _: Class) -> Sent {
        Sent::NobodyThere
    }
}

#[derive(Default)]
struct Waiting {
    frames: VecDeque<Frame>,
    bytes: usize,
}

impl Waiting {
    fn push(&mut self, frame: Frame) {
        self.bytes += frame.bytes().len();
        self.frames.push_back(frame);
    }

    fn pop(&mut self) -> Option<Frame> {
        let frame = self.frames.pop_front()?;
        self.bytes -= frame.bytes().len();
        Some(frame)
    }

    fn has_room(&self, frame: &Frame) -> bool {
        self.bytes + frame.bytes().len() <= QUEUE_BYTES
    }
}

#[derive(Default)]
struct Queues {
    open: bool,
    own: Waiting,
    forwarded: Waiting,
}

/// Frames on their way to a stream's writer, 64 KiB of our own and 64 KiB of forwarded ones.
///
/// Overflow: the oldest forwarded frames are dropped (of telemetry the newest counts); our own are refused, so that a
/// command fails loudly. While the stream is not connected everything is refused, so nothing stale is sent later.
#[derive(Default)]
pub(crate) struct StreamQueue {
    queues: Mutex<Queues>,
    filled: Notify,
}

impl StreamQueue {
    fn queues(&self) -> MutexGuard<'_, Queues> {
        self.queues.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Starts taking frames.
    pub(crate) fn open(&self) {
        *self.queues() = Queues { open: true, ..Queues::default() };
    }

    /// Refuses frames from now on and drops the queued ones.
    pub(crate) fn close(&self) {
        *self.queues() = Queues::default();
    }

    /// Puts a frame into the queue.
    pub(crate) fn push(&self, frame: &Frame, class: Class) -> Sent {
        let mut queues = self.queues();
        if !queues.open {
            return Sent::NobodyThere;
        }
        let mut displaced = 0;
        let waiting = match class {
            Class::Own if !queues.own.has_room(frame) => return Sent::Full,
            Class::Own => &mut queues.own,
            Class::Forwarded => {
                while !queues.forwarded.has_room(frame) && queues.forwarded.pop().is_some() {
                    displaced += 1;
                }
                &mut queues.forwarded
            }
        };
        waiting.push(frame.clone());
        drop(queues);
        self.filled.notify_one();
        Sent::Accepted { displaced }
    }

    /// Waits until the queue may have frames.
    pub(crate) async fn filled(&self) {
        self.filled.notified().await;
    }

    /// Appends whole frames to `batch`, our own first, until it holds `enough` bytes.
    pub(crate) fn take(&self, batch: &mut Vec<u8>, enough: usize) {
        let mut queues = self.queues();
        while batch.len() < enough {
            let Some(frame) = queues.own.pop().or_else(|| queues.forwarded.pop()) else { return };
            batch.extend_from_slice(frame.bytes());
        }
    }
}

impl Outlet for StreamQueue {
    fn send(&self, frame: &Frame, _: To, class: Class) -> Sent {
        self.push(frame, class)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::heartbeat;

    fn taken(queue: &StreamQueue, enough: usize) -> Vec<u8> {
        let mut batch = Vec::new();
        queue.take(&mut batch, enough);
        batch
    }

    #[test]
    fn a_closed_queue_refuses_and_keeps_nothing() {
        let queue = StreamQueue::default();
        assert_eq!(queue.push(&heartbeat(1, 1, 0), Class::Own), Sent::NobodyThere);
        queue.open();
        assert_eq!(queue.push(&heartbeat(1, 1, 0), Class::Own), Sent::Accepted { displaced: 0 });
        queue.close();
        queue.open();
        assert!(taken(&queue, 1000).is_empty(), "a command of before the break is not sent after it");
    }

    #[test]
    fn our_own_go_first() {
        let queue = StreamQueue::default();
        queue.open();
        queue.push(&heartbeat(1, 1, 0), Class::Forwarded);
        queue.push(&heartbeat(255, 190, 0), Class::Own);
        let expected = [heartbeat(255, 190, 0).bytes(), heartbeat(1, 1, 0).bytes()].concat();
        assert_eq!(taken(&queue, 1000), expected);
    }

    #[test]
    fn overflow_drops_the_oldest_forwarded_and_refuses_our_own() {
        let queue = StreamQueue::default();
        queue.open();
        let (mut displaced, mut refused) = (0, 0);
        let each = heartbeat(1, 1, 0).bytes().len();
        let room = QUEUE_BYTES / each;
        for n in 0..room + 10 {
            if let Sent::Accepted { displaced: more } = queue.push(&heartbeat(1, 1, n as u8), Class::Forwarded) {
                displaced += more;
            }
            refused += usize::from(queue.push(&heartbeat(255, 190, n as u8), Class::Own) == Sent::Full);
        }
        assert_eq!((displaced, refused), (10, 10));
        let all = taken(&queue, usize::MAX);
        assert_eq!(all.len(), 2 * room * each);
        assert_eq!(&all[room * each..(room + 1) * each], heartbeat(1, 1, 10).bytes(), "the oldest forwarded are gone");
    }
}
