//! What a fleet's certificates are made of, and who gets one. No I/O; time comes in, as seconds since 1970.
//!
//! | module | owns |
//! |---|---|
//! | [`certificate`] | the organisation's own authority (CA), and what it signs |
//! | [`ticket`] | the token that brings an aircraft or a ground station in, as text |
//! | [`roll`] | who is enrolled, and which tokens are out |
//! | [`stations`] | the ground stations whose orders count: a list that the authority signs |
//! | [`access`] | what each may say and hear at a router: Zenoh's access control |
//! | [`wire`] | what is said at the door where they are enrolled |

pub mod access;
pub mod certificate;
pub mod roll;
pub mod stations;
pub mod ticket;
pub mod wire;

/// Seconds of a day.
pub const DAY_S: u64 = 86_400;
