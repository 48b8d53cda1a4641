//! Errors of cameras.

use thiserror::Error;

use crate::name::MAX_NAME;
use crate::picture::MAX_FRAME_BYTES;

/// Largest number of cameras.
pub const MAX_CAMERAS: usize = 16;
/// Largest number of viewers of all cameras; interfaces refuse more.
pub const MAX_VIEWERS: usize = 32;

/// Why a camera could not carry out a request.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum CameraError {
    /// Invalid camera name.
    #[error("'{0}' is not a camera name; it must be 1 to {MAX_NAME} letters, digits, '-' or '_'")]
    BadName(String),
    /// The name is taken.
    #[error("there is already a camera called '{0}'; choose another name")]
    Taken(String),
    /// The limit of cameras is reached.
    #[error("there are {MAX_CAMERAS} cameras already")]
    TooMany,
    /// The camera's feeder is gone.
    #[error("the camera is gone")]
    Gone,
    /// The feeder is overloaded, or does not answer.
    #[error("the camera is busy; try again")]
    Busy,
    /// The feeder refused, for the reason given.
    #[error("{0}")]
    Refused(String),
    /// Invalid image.
    #[error("an image has {0} bytes, should be 1 to {MAX_FRAME_BYTES}")]
    BadPicture(usize),
}
