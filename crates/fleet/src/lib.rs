//! Aircraft far away: what goes over a network between the station on board and those on the ground, and who decides.
//!
//! The station on board speaks MAVLink with its autopilot, over a wire; what crosses the network is what it saw, an
//! order, and what became of it. It alone decides who may act ([`authority`]); the network only carries, and is trusted
//! with nothing: orders are signed ([`signature`]), done at most once, and mean nothing once somebody else has control.
//!
//! | module | owns |
//! |---|---|
//! | [`key`] | names, and the keys under which data goes |
//! | [`wire`] | what all payloads share |
//! | [`deed`] | what an order can be about |
//! | [`content`] | lists of items and parameters: packed, named, put together |
//! | [`outcome`] | what an order yields, and how a transfer failed |
//! | [`payload`] | samples, orders and answers made of these |
//! | [`state_source`] | the states of an aircraft: their source on board, their listener on the ground |
//! | [`rivals`] | whether two computers speak as one aircraft |
//! | [`stamp`] | the states that orders are based on |
//! | [`signature`] | signatures of orders |
//! | [`authority`] | who may act on an aircraft; on board |
//! | [`judge`] | what becomes of an order that came; on board |
//! | [`plans`] | what is known of the plans on board, numbered |
//! | [`delivery`] | the delivery of an order, on the ground |
//! | [`pull`] | one list on its way down; on the ground |
//! | [`budget`] | how often an aircraft speaks |
//! | [`act`] | requests as orders, results as answers |
//! | [`history`] | what was said and done, kept on board and on the ground |
//! | [`ros2`] | a plane as ROS 2 sees it |
//! | [`operator`] | a ground station's own key |
//! | `papers` | certificates, tokens, who is enrolled and what each may do (feature `papers`) |
//! | `carrier` | the network: Eclipse Zenoh, named nowhere else (feature `carrier`) |
//!
//! All but `operator` and `carrier` are without I/O: time comes in.

pub mod act;
pub mod authority;
pub mod budget;
#[cfg(feature = "carrier")]
pub mod carrier;
pub mod content;
pub mod deed;
pub mod delivery;
mod error;
pub mod history;
pub mod judge;
pub mod key;
pub mod operator;
pub mod outcome;
#[cfg(feature = "papers")]
pub mod papers;
pub mod payload;
pub mod plans;
pub mod pull;
pub mod rivals;
pub mod ros2;
pub mod signature;
pub mod stamp;
pub mod state_source;
pub mod wire;

pub use error::FleetError;
