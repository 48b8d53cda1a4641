//! Why a camera cannot do what it was asked for.

use thiserror::Error;

use crate::name::MAX_NAME;
use crate::picture::MAX_FRAME_BYTES;

/// Cameras at most.
pub const MAX_CAMERAS: usize = 16;
/// Viewers of all cameras at most: front doors refuse more.
pub const MAX_VIEWERS: usize = 32;

/// Why a camera cannot do what it was asked for.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum CameraError {
    /// A name that cannot be one.
    #[error("'{0}' is no name for a camera; one is 1 to {MAX_NAME} letters, digits, '-' or '_'")]
    BadName(String),
    /// The name is taken.
    #[error("there is a camera called '{0}' already; give this one another name")]
    Taken(String),
    /// All places are taken.
    #[error("{MAX_CAMERAS} cameras are there already")]
    TooMany,
    /// Nobody feeds the camera any more.
    #[error("the camera is gone")]
    Gone,
    /// The feeder has too much to do, or does not answer.
    #[error("the camera is busy; try again")]
    Busy,
    /// The feeder could not do it; its own words.
    #[error("{0}")]
    Refused(String),
    /// A picture that cannot be one.
    #[error("a picture of {0} bytes: it must have some, and {MAX_FRAME_BYTES} at most")]
    BadPicture(usize),
}
