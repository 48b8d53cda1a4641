//! Cameras: pictures from a feeder, and the viewers who see them. No front door, and no pixels: both ends are others' affair.
//!
//! A feeder adds a camera to the [`VideoHub`] and hands encoded pictures to its [`VideoFeed`]; each viewer takes them from a
//! bounded [`ViewerQueue`] of its own, and JPEG or H.264 passes as it came. Nothing waits for a viewer, and no viewer for
//! another. Only the feeder can take a picture with its position, or record: it is asked by a [`CameraRequest`].
//!
//! | module | owns |
//! |---|---|
//! | [`hub`] | which cameras there are, and the feed of each |
//! | [`camera`] | one camera: its state, the newest pictures for the next viewer, its viewers |
//! | [`queue`] | the pictures that wait for one viewer |
//! | [`picture`] | a picture, its encoding, and its form on the wire |
//! | [`status`], [`request`], [`error`], [`name`] | what a feeder reports, what it is asked for, why not, and names |
//! | [`footage`] | recordings and stills on the disk: which there are, and how long they are |
//!
//! With the feature `describe` the reports describe themselves for front doors: their JSON and its schema.

pub mod camera;
pub mod error;
pub mod footage;
pub mod hub;
pub mod name;
pub mod picture;
pub mod queue;
pub mod request;
pub mod status;
#[cfg(test)]
mod tests;

pub use camera::{Camera, Demand};
pub use error::{CameraError, MAX_CAMERAS, MAX_VIEWERS};
pub use hub::{VideoFeed, VideoHub};
pub use name::MAX_NAME;
pub use picture::{Accepts, HEADER_BYTES, MAX_FRAME_BYTES, Picture, VideoCodec, WireFrame};
pub use queue::{Outgoing, ViewerQueue};
pub use request::{Answer, CameraRequest, PendingRequest};
pub use status::{CameraRecording, CameraState, CameraStatus};
