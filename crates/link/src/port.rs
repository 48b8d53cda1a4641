//! Owns what the hub and an endpoint share of a link: name, options, state, outlet and intake.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use tokio::sync::watch;
use vencejo_proto::{DecoderStats, Frame, FrameDecoder, MonoTime};

use crate::address::LinkAddress;
use crate::fault::LinkFault;
use crate::outlet::{Class, Outlet, Sent, To};
use crate::router::Slot;
use crate::signing::UnsignedPolicy;
use crate::stats::PortCounters;

/// Identifies an open link; never reused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LinkId(pub u32);

impl fmt::Display for LinkId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "link {}", self.0)
    }
}

/// Options of a link.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct LinkOptions {
    /// A display name; the link string by default.
    pub name: Option<String>,
    /// Whether frames are forwarded between this link and all others. Two links forward to each other when at least one
    /// of them has this set: set it on a tee for another ground station, and leave it off (the default) on the links of
    /// vehicles, so that vehicles' telemetry does not fill each other's radios.
    pub forwards: bool,
    /// Whether unsigned frames of a vehicle that must sign are accepted over it.
    pub unsigned: UnsignedPolicy,
}

impl LinkOptions {
    /// The options of a tee: a link through which another ground station reaches the vehicles.
    pub fn tee() -> Self {
        Self { forwards: true, ..Self::default() }
    }
}

/// The state of a link.
#[derive(Debug, Clone, PartialEq)]
pub enum LinkState {
    /// Connecting, for the `attempt`th time since it was last up.
    Connecting {
        /// 1 for the first.
        attempt: u32,
        /// Why the last attempt failed.
        last_error: Option<LinkFault>,
    },
    /// Open, whether or not a peer was heard yet.
    Up {
        /// Since when.
        since: MonoTime,
        /// Number of peers: on listening links those heard lately, otherwise 1.
        peers: usize,
    },
    /// Closed by us.
    Down,
    /// A replay has ended.
    Ended {
        /// What was wrong with the recording, if anything.
        remark: Option<String>,
    },
}

impl LinkState {
    /// Whether it is [`LinkState::Up`].
    pub fn is_up(&self) -> bool {
        matches!(self, Self::Up { .. })
    }
}

/// The hub's side of one open link, shared with its tasks.
pub(crate) struct Port {
    pub(crate) id: LinkId,
    pub(crate) slot: Slot,
    pub(crate) name: String,
    pub(crate) address: LinkAddress,
    pub(crate) forwards: bool,
    pub(crate) unsigned: UnsignedPolicy,
    /// Whether unsigned frames are accepted, by what the address was when it last connected.
    pub(crate) believed: AtomicBool,
    pub(crate) outlet: Arc<dyn Outlet>,
    pub(crate) state: watch::Receiver<LinkState>,
    pub(crate) counters: PortCounters,
}

impl Port {
    pub(crate) fn is_replay(&self) -> bool {
        matches!(self.address, LinkAddress::Tlog { .. })
    }

    /// Whether unsigned frames are accepted over it.
    pub(crate) fn is_believed(&self) -> bool {
        self.believed.load(Ordering::Relaxed)
    }

    /// Re-evaluates the address: a device may not have been plugged in before, and a name in `/dev/serial/by-id` may
    /// point to another one now.
    pub(crate) fn look_at_address(&self) {
        self.believed.store(self.unsigned.believes(&self.address), Ordering::Relaxed);
    }

    /// Sends one of our own frames; whether the link took it.
    pub(crate) fn send(&self, frame: &Frame, to: To) -> bool {
        self.count(frame, self.outlet.send(frame, to, Class::Own))
    }

    /// Forwards frames of other links, in order.
    pub(crate) fn forward(&self, frames: &[(&Frame, To)]) {
        self.outlet.send_all(frames, Class::Forwarded, &mut |frame, sent| {
            self.count(frame, sent);
        });
    }

    fn count(&self, frame: &Frame, sent: Sent) -> bool {
        match sent {
            Sent::Accepted { displaced } => {
                self.counters.add_sent(frame.bytes().len());
                self.counters.add_dropped(displaced);
                true
            }
            Sent::NobodyThere | Sent::Full => {
                self.counters.add_dropped(1);
                false
            }
        }
    }
}

/// Decodes what a socket receives into frames for the hub, and counts the rest.
#[derive(Default)]
pub(crate) struct Intake {
    decoder: FrameDecoder,
    counted: DecoderStats,
}

impl Intake {
    pub(crate) fn new() -> Self {
        Self::default()
    }

    /// Decodes bytes of a stream; calls `each` with every frame, already counted.
    pub(crate) fn feed(&mut self, port: &Port, bytes: &[u8], each: impl FnMut(&Frame)) {
        self.decoder.push(bytes);
        self.hand_out(port, each);
    }

    /// Decodes a datagram. Some bridges split frames over datagrams, so an incomplete frame is kept until a datagram
    /// begins with a whole frame of its own.
    pub(crate) fn feed_datagram(&mut self, port: &Port, bytes: &[u8], each: impl FnMut(&Frame)) {
        self.decoder.push_datagram(bytes);
        self.hand_out(port, each);
    }

    fn hand_out(&mut self, port: &Port, mut each: impl FnMut(&Frame)) {
        while let Some(frame) = self.decoder.next_frame() {
            self.count(port);
            each(&frame);
        }
        self.count(port);
    }

    fn count(&mut self, port: &Port) {
        let stats = self.decoder.stats();
        port.counters.add_decoded(self.counted, stats);
        self.counted = stats;
    }

    /// Counts bytes from a peer that is ignored.
    pub(crate) fn ignore(port: &Port, bytes: usize) {
        port.counters.add_ignored(bytes as u64);
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use rand::rngs::StdRng;
    use rand::{Rng, SeedableRng};

    use super::*;
    use crate::testing::{Listening, heartbeat, unknown};

    #[test]
    fn messages_that_the_dialect_does_not_have_come_whole_and_at_once() {
        let (listening, mut rng) = (Listening::new(), StdRng::seed_from_u64(1));
        let (_, state) = watch::channel(LinkState::Down);
        let outlet = Arc::new(crate::outlet::NoOutlet);
        let port = listening.hub.attach("udpin:".parse().unwrap(), LinkOptions::default(), outlet, state).unwrap();
        let mut intake = Intake::new();
        for n in 0..1000 {
            let sequence = n as u8;
            // As a vendor's message of which any byte may look like the beginning of a frame.
            let mut bytes = unknown(1, 1, sequence).bytes()[..10].to_vec();
            bytes[1] = 60;
            bytes.extend((0..62).map(|_| rng.random::<u8>()));
            for datagram in [bytes.as_slice(), heartbeat(1, 1, sequence).bytes()] {
                let mut framed = Vec::new();
                intake.feed_datagram(&port, datagram, |frame| framed.extend_from_slice(frame.bytes()));
                assert_eq!(framed, datagram, "{n}");
            }
        }
    }
}
