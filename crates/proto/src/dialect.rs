//! The generated ArduPilot dialect (`ardupilotmega`, which includes `common`), under one name.
//!
//! Source: the `mavlink` crate, generated from the message definitions of mavlink.io.

pub use mavlink::dialects::ardupilotmega::*;
