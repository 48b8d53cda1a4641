//! Cameras: distribution of images from feeders to viewers. Neither capture, encoding nor the transport to viewers is
//! part of this crate.
//!
//! A feeder adds a camera to the [`VideoHub`] and hands encoded images to its [`VideoFeed`]; each viewer takes them
//! from a bounded [`ViewerQueue`] of its own. JPEG and H.264 pass through unchanged. Feeders never wait for viewers,
//! nor viewers for each other. Only the feeder can take an image with its position, or record: a [`CameraRequest`] asks
//! it to.
//!
//! | module | owns |
//! |---|---|
//! | [`hub`] | the cameras and their feeds |
//! | [`camera`] | one camera: its state, the newest images for new viewers, its viewers |
//! | [`queue`] | images waiting for one viewer |
//! | [`picture`] | an image, its codec, and its wire format |
//! | [`status`], [`request`], [`error`], [`name`] | a feeder's reports, requests to it, errors, and names |
//! | [`footage`] | recordings and images on disk, and their durations |
//!
//! With the feature `describe`, the reports have JSON representations and schemas for the interfaces.

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
