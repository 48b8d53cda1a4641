//! Requests to the feeder of a camera.

use tokio::sync::oneshot;

/// A request that only the feeder can carry out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CameraRequest {
    /// Take a still image with its position: the answer is a JPEG file.
    Snapshot,
    /// The same, and store it beside the recordings.
    KeepSnapshot,
    /// Start recording.
    StartRecording,
    /// Stop recording.
    StopRecording,
}

/// Answer of the feeder: an image for a snapshot, empty for the others, or the reason of its refusal.
pub type Answer = Result<Vec<u8>, String>;

/// A request to the feeder. Dropped without an answer, it counts as refused.
#[derive(Debug)]
pub struct PendingRequest {
    /// The request.
    pub request: CameraRequest,
    answer: oneshot::Sender<Answer>,
}

impl PendingRequest {
    /// A request, and the receiver of its answer.
    pub(crate) fn new(request: CameraRequest) -> (Self, oneshot::Receiver<Answer>) {
        let (answer, answered) = oneshot::channel();
        (Self { request, answer }, answered)
    }

    /// Answers the request: with an image for a snapshot, empty for the others, or with the reason of a refusal.
    pub fn answer(self, answer: Answer) {
        // Fails if the caller is gone, which does not matter.
        let _ = self.answer.send(answer);
    }
}
