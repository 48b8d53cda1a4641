//! Flight: plans, their file formats and checks, geodesy and plane guidance. Pure functions, no I/O, no clock.

pub mod checks;
pub mod error;
pub mod formats;
pub mod geodesy;
pub mod guidance;
pub mod plan;
pub mod progress;

pub use error::{FlightError, Result};
