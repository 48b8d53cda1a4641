//! The queues of a vehicle's subscribers.

use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, PoisonError};

use vencejo_link::LinkId;
use vencejo_proto::{Frame, MonoTime};
use vencejo_vehicle::VehicleEvent;

use crate::queue::DropOldest;

/// A message as it was received.
#[derive(Debug, Clone, PartialEq)]
pub struct Received {
    /// The link that it came over; `None`: from far away.
    pub link: Option<LinkId>,
    /// The whole frame; it shares its memory.
    pub frame: Frame,
    /// When it came.
    pub at: MonoTime,
}

/// An event and its moment.
#[derive(Debug, Clone, PartialEq)]
pub struct Observed {
    /// What happened.
    pub event: VehicleEvent,
    /// When.
    pub at: MonoTime,
}

#[derive(Debug)]
struct MessageQueue {
    /// Only these ids; all when absent.
    ids: Option<BTreeSet<u32>>,
    queue: Arc<DropOldest<Received>>,
}

/// The queues of the subscribers of one vehicle, or of all. A queue whose reader is gone is dropped.
#[derive(Debug, Default)]
pub(crate) struct Subscriptions {
    messages: Mutex<Vec<MessageQueue>>,
    pub(crate) events: Mutex<Vec<Arc<DropOldest<Observed>>>>,
}

fn is_read<T>(queue: &Arc<DropOldest<T>>) -> bool {
    Arc::strong_count(queue) > 1 && !queue.is_closed()
}

impl Subscriptions {
    /// Messages from now on, all or some ids, at most `capacity` waiting.
    pub(crate) fn subscribe(&self, ids: Option<BTreeSet<u32>>, capacity: usize) -> Arc<DropOldest<Received>> {
        let queue = Arc::new(DropOldest::new(capacity));
        let mut messages = self.messages.lock().unwrap_or_else(PoisonError::into_inner);
        messages.push(MessageQueue { ids, queue: queue.clone() });
        queue
    }

    /// Whether there is a subscriber to messages.
    pub(crate) fn has_readers(&self) -> bool {
        !self.messages.lock().unwrap_or_else(PoisonError::into_inner).is_empty()
    }

    /// Passes a message on to the subscribers that want it.
    pub(crate) fn on_message(&self, link: Option<LinkId>, frame: &Frame, at: MonoTime) {
        let mut messages = self.messages.lock().unwrap_or_else(PoisonError::into_inner);
        if messages.is_empty() {
            return;
        }
        messages.retain(|subscriber| is_read(&subscriber.queue));
        let id = frame.message_id();
        for subscriber in messages.iter() {
            if subscriber.ids.as_ref().is_none_or(|ids| ids.contains(&id)) {
                subscriber.queue.push(Received { link, frame: frame.clone(), at });
            }
        }
    }

    /// Passes an event on.
    pub(crate) fn on_event(&self, observed: &Observed) {
        let mut events = self.events.lock().unwrap_or_else(PoisonError::into_inner);
        events.retain(is_read);
        for queue in events.iter() {
            queue.push(observed.clone());
        }
    }

    /// Ends all queues.
    pub(crate) fn close(&self) {
        for subscriber in self.messages.lock().unwrap_or_else(PoisonError::into_inner).drain(..) {
            subscriber.queue.close();
        }
        for queue in self.events.lock().unwrap_or_else(PoisonError::into_inner).drain(..) {
            queue.close();
        }
    }
}

impl Drop for Subscriptions {
    /// The vehicle, or the whole station, is gone: ends the wait of blocked readers.
    fn drop(&mut self) {
        self.close();
    }
}
