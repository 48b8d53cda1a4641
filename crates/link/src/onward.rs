//! Owns the frames that one reading of a socket brought and that other links are to have: each link gets its own in one go,
//! which costs a system call and a wake-up where each frame alone costs one of its own.

use std::sync::Arc;

use smallvec::SmallVec;
use vencejo_proto::Frame;

use crate::outlet::To;
use crate::port::Port;

/// Frames that wait for the end of a reading at most.
const MOST: usize = 32;

/// A frame and the links that are to have it.
struct Passed {
    frame: Frame,
    to: To,
    ports: SmallVec<[Arc<Port>; 8]>,
}

/// Frames on their way to other links until the end of a reading. They are few, and none waits while the reading task does.
#[derive(Default)]
pub(crate) struct Onward {
    frames: Vec<Passed>,
}

impl Onward {
    /// Adds a frame; sends all when enough are there.
    pub(crate) fn add(&mut self, frame: &Frame, to: To, ports: SmallVec<[Arc<Port>; 8]>) {
        if ports.is_empty() {
            return;
        }
        self.frames.push(Passed { frame: frame.clone(), to, ports });
        if self.frames.len() >= MOST {
            self.send();
        }
    }

    /// Gives each link its frames, in the order in which they came.
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
