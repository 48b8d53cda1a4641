//! What only the feeder of a camera can do, on its way to it.

use tokio::sync::oneshot;

/// Something that only the feeder can do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CameraRequest {
    /// A still picture with its position: the answer is a JPEG file.
    Snapshot,
    /// The same, and that it is kept beside the recordings.
    KeepSnapshot,
    /// Begin to record.
    StartRecording,
    /// End the recording.
    StopRecording,
}

/// The feeder's answer: a picture for a snapshot, nothing for the others, or why not.
pub type Answer = Result<Vec<u8>, String>;

/// A request on its way to the feeder. Dropped without an answer, it counts as refused.
#[derive(Debug)]
pub struct PendingRequest {
    /// What is wanted.
    pub request: CameraRequest,
    answer: oneshot::Sender<Answer>,
}

impl PendingRequest {
    /// A request, and where its answer comes.
    pub(crate) fn new(request: CameraRequest) -> (Self, oneshot::Receiver<Answer>) {
        let (answer, answered) = oneshot::channel();
        (Self { request, answer }, answered)
    }

    /// Answers it: with a picture for a snapshot, with nothing for the others, or why it cannot be.
    pub fn answer(self, answer: Answer) {
        // Whoever asked may have gone.
        let _ = self.answer.send(answer);
    }
}
