//! Aircraft and ground stations on Eclipse Zenoh.

mod aircraft;
mod endpoint;
mod ground;
mod network;

pub use aircraft::{Aircraft, AircraftConfig, AircraftStatus};
pub use endpoint::Endpoint;
pub use ground::{Far, Ground, GroundConfig};
