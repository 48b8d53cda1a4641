//! A plane as ROS 2 sees it, without ROS: names, types and hashes, what its topics say, and how others are found.
//! Without I/O.
//!
//! | module | owns |
//! |---|---|
//! | [`name`] | names of topics, nodes and frames |
//! | [`message`] | types, fields and hashes |
//! | [`cdr`] | messages as bytes |
//! | [`token`] | keys, liveliness tokens and attachments, as `rmw_zenoh_cpp` has them |
//! | [`frames`] | from MAVLink's axes to those of ROS |
//! | [`moment`] | a plane at a moment |
//! | [`topics`] | what a plane says, and how often |
//! | [`news`] | what it says when it happens |
//! | [`diagnosis`] | its health as a `DiagnosticArray` |
//! | [`mission`] | missions as MAVROS has them |
//! | [`params`] | parameters as those of a node |
//! | [`offer`] | what a plane can be asked for, and how that ends |
//! | [`services`] | its services |
//! | [`setpoint`] | positions to fly to, which come as a stream |
//! | [`doctor`] | why somebody sees nothing |

pub mod cdr;
pub mod diagnosis;
pub mod doctor;
pub mod frames;
pub mod message;
pub mod mission;
pub mod moment;
pub mod name;
pub mod news;
pub mod offer;
pub mod params;
pub mod services;
pub mod setpoint;
pub mod token;
pub mod topics;
