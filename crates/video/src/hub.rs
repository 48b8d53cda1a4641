//! The cameras of this process, by name, and their feeds.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::{mpsc, watch};

use crate::camera::{Camera, Demand};
use crate::error::{CameraError, MAX_CAMERAS};
use crate::name::{MAX_NAME, is_name};
use crate::picture::Picture;
use crate::request::PendingRequest;
use crate::status::CameraStatus;

/// Largest number of requests waiting for one feeder.
const MAX_REQUESTS: usize = 8;

/// The cameras. Clones share the same state.
#[derive(Debug, Clone, Default)]
pub struct VideoHub {
    cameras: Arc<Mutex<BTreeMap<String, Arc<Camera>>>>,
}

impl VideoHub {
    /// Adds a camera, until its feed is closed. `source` is shown as the origin of its images, so it must not contain
    /// secrets.
    ///
    /// # Errors
    /// [`CameraError::BadName`], [`CameraError::Taken`] and [`CameraError::TooMany`].
    pub fn add(&self, name: &str, source: &str) -> Result<VideoFeed, CameraError> {
        if !is_name(name) {
            return Err(CameraError::BadName(name.chars().take(MAX_NAME).collect()));
        }
        let mut cameras = self.lock();
        if cameras.contains_key(name) {
            return Err(CameraError::Taken(name.to_owned()));
        }
        if cameras.len() >= MAX_CAMERAS {
            return Err(CameraError::TooMany);
        }
        let (requests, waiting) = mpsc::channel(MAX_REQUESTS);
        let camera = Arc::new(Camera::new(name, source, requests));
        cameras.insert(name.to_owned(), camera.clone());
        let waiting = tokio::sync::Mutex::new(waiting);
        Ok(VideoFeed { hub: self.clone(), camera, waiting, is_closed: watch::channel(false).0 })
    }

    /// A camera by name.
    pub fn camera(&self, name: &str) -> Option<Arc<Camera>> {
        self.lock().get(name).cloned()
    }

    /// All cameras, by name.
    pub fn cameras(&self) -> Vec<Arc<Camera>> {
        self.lock().values().cloned().collect()
    }

    /// Number of viewers of all cameras.
    pub fn viewers(&self) -> usize {
        self.cameras().iter().map(|camera| camera.viewers()).sum()
    }

    /// Names of the files being recorded.
    pub(crate) fn being_recorded(&self) -> Vec<String> {
        let recordings = self.cameras().into_iter().filter_map(|camera| camera.status().recording);
        recordings.filter(|recording| recording.problem.is_none()).map(|recording| recording.file).collect()
    }

    fn lock(&self) -> MutexGuard<'_, BTreeMap<String, Arc<Camera>>> {
        self.cameras.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Feed of one camera. Closing or dropping it removes the camera.
#[derive(Debug)]
pub struct VideoFeed {
    hub: VideoHub,
    camera: Arc<Camera>,
    waiting: tokio::sync::Mutex<mpsc::Receiver<PendingRequest>>,
    is_closed: watch::Sender<bool>,
}

impl VideoFeed {
    /// The feed's camera.
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Distributes an image to all viewers of its codec. Never blocks.
    ///
    /// # Errors
    /// [`CameraError::BadPicture`], and [`CameraError::Gone`] when the feed has been closed.
    pub fn publish(&self, picture: &Picture<'_>) -> Result<(), CameraError> {
        self.camera.publish(picture)
    }

    /// Reports the camera's state; viewers are notified if it changed.
    pub fn set_status(&self, status: CameraStatus) {
        self.camera.set_status(status);
    }

    /// Number of viewers by codec.
    pub fn demand(&self) -> Demand {
        self.camera.demand()
    }

    /// Waits until viewers are added or change their codec; check regularly for viewers that leave.
    pub async fn demand_changed(&self) {
        tokio::select! {
            () = self.camera.demand_changed() => {}
            () = self.closed() => {}
        }
    }

    /// Next request; `None` once the feed is closed.
    pub async fn next_request(&self) -> Option<PendingRequest> {
        let mut waiting = self.waiting.lock().await;
        tokio::select! {
            biased;
            () = self.closed() => {
                refuse_all(&mut waiting);
                None
            }
            request = waiting.recv() => request,
        }
    }

    /// Removes the camera and notifies its viewers. Idempotent.
    pub fn close(&self) {
        let mut cameras = self.hub.lock();
        if cameras.get(self.camera.name()).is_some_and(|camera| Arc::ptr_eq(camera, &self.camera)) {
            cameras.remove(self.camera.name());
        }
        drop(cameras);
        self.camera.end();
        self.is_closed.send_replace(true);
        // Otherwise a caller of `next_request` holds them, and refuses them.
        if let Ok(mut waiting) = self.waiting.try_lock() {
            refuse_all(&mut waiting);
        }
    }

    async fn closed(&self) {
        // The sender is ours, so this cannot fail.
        let _ = self.is_closed.subscribe().wait_for(|is_closed| *is_closed).await;
    }
}

/// Refuses waiting requests.
fn refuse_all(waiting: &mut mpsc::Receiver<PendingRequest>) {
    waiting.close();
    while waiting.try_recv().is_ok() {}
}

impl Drop for VideoFeed {
    fn drop(&mut self) {
        self.close();
    }
}
