//! Owns the frames of one reading of a socket that are to be forwarded: each link gets its frames in one batch, which
//! costs one system call and one wake-up instead of one for each frame.

use std::sync::Arc;

use smallvec::SmallVec;
use vencejo_proto::Frame;

use crate::outlet::To;
use crate::port::Port;

/// Most frames that wait for the end of a reading.
const MOST: usize = 32;

/// A frame and the links to forward it to.
struct Passed {
    frame: Frame,
    to: To,
    ports: SmallVec<[Arc<Port>; 8]>,
}

/// Frames to be forwarded at the end of a reading.
#[derive(Default)]
pub(crate) struct Onward {
    frames: Vec<Passed>,
}

impl Onward {
    /// Adds a frame; sends all when there are [`MOST`].
    pub(crate) fn add(&mut self, frame: &Frame, to: To, ports: SmallVec<[Arc<Port>; 8]>) {
        if ports.is_empty() {
            return;
        }
        self.frames.push(Passed { frame: frame.clone(), to, ports });
        if self.frames.len() >= MOST {
            self.send();
        }
    }

    /// Sends each link its frames, in the order in which they came.
    pub(crate) fn send(&mut self) {
        let mut ports: SmallVec<[&Arc<Port>; 8]> = SmallVec::new();
        for port in self.frames.iter().flat_map(|passed| &passed.ports) {
            if !ports.iter().any(|other| Arc::ptr_eq(other, port)) {
                ports.push(port);
            }
        }
        for port in ports {
            let is_for_it = |passed: &&Passed| passed.ports.iter().any(|other| Arc::ptr_eq(other, port));
            let frames: SmallVec<[(&Frame, To); MOST]> =
                self.frames.iter().filter(is_for_it).map(|passed| (&passed.frame, passed.to)).collect();
            port.forward(&frames);
        }
        self.frames.clear();
    }
}
