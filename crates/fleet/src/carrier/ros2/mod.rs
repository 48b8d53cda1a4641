//! Planes of a station in ROS 2, by way of a Zenoh router.

mod acts;
mod doctor;
mod ends;
mod gateway;
mod params;
mod plane;
mod router;
mod setpoints;
#[cfg(test)]
mod tests;

pub use doctor::{Examined, examine};
pub use gateway::{Gateway, GatewayConfig, GatewayStatus};
pub use router::{RosPapers, RosRouter};
