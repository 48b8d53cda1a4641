//! A vehicle as state machines: its telemetry, requests to it, and their results. No I/O and no clock.
//!
//! # Entry point
//!
//! A [`Vehicle`] takes messages and times in and puts [`Output`]s out; its owner has the link and the clock:
//!
//! ```
//! use vencejo_proto::{Address, ComponentId, Heartbeat, Message, MonoTime};
//! use vencejo_vehicle::{Output, Request, Vehicle, VehicleConfig, VehicleError};
//!
//! let (plane, our) = (Address::new(1, 1), Address::new(255, 190));
//! let mut now = MonoTime::ZERO;
//! let mut vehicle = Vehicle::new(plane, our, VehicleConfig::default(), now);
//!
//! // What comes from the link goes in.
//! let heartbeat = Heartbeat { mav_type: 1, autopilot: 3, mavlink_version: 3, custom_mode: 11, ..Heartbeat::default() };
//! vehicle.on_message(ComponentId::AUTOPILOT, &Message::Heartbeat(heartbeat), now);
//! assert_eq!(vehicle.telemetry().mode().map(|mode| mode.to_string()), Some("RTL".into()));
//!
//! // A request sends something, and ends with exactly one result, within a bounded time.
//! let id = vehicle.request(Request::Arm { force: false }, now);
//! let result = loop {
//!     match vehicle.poll_output() {
//!         Some(Output::Send(_message)) => {} // to the link
//!         Some(Output::Finished { id: ended, result }) if ended == id => break result,
//!         Some(_) => {}
//!         // Nothing more to do now: wait for a message, at most until the deadline.
//!         None => {
//!             now = vehicle.deadline().expect("something is due");
//!             vehicle.on_time(now);
//!         }
//!     }
//! };
//! assert!(matches!(result, Err(VehicleError::CommandTimeout { .. })), "no answer came");
//! ```
//!
//! Call [`Vehicle::poll_output`] until it is empty after every call that takes `&mut self`.
//! [`Vehicles`] does the same for all the vehicles of a link.
//!
//! # Guarantees
//!
//! - Upload, arm, mode and start are separate acts; no request does another as a side effect.
//! - A request succeeds when the vehicle *shows* it: armed and mode in its HEARTBEAT, a plan by reading it back.
//! - A command without an answer is repeated only when that is harmless ([`command::is_idempotent`]), or when the vehicle's
//!   state, read since, shows that it was not executed.
//! - The vehicle's messages are not trusted: impossible values are `None` and counted, texts are cleaned, queues bounded.
//! - Unknown is `None`; every value has an age ([`telemetry::Sampled`]).
//! - Telemetry is read without allocation.
//!
//! # Modules
//!
//! | module | owns |
//! |---|---|
//! | [`telemetry`] | the newest values, their age and validity; texts; detection of restarts |
//! | [`modes`] | flight modes by name |
//! | [`command`] | commands and their acknowledgement |
//! | [`streams`] | which messages are requested, and at which rate |
//! | [`timesync`] | round trip; restarts by the clock |
//! | `reach` | whether the vehicle hears us |
//! | `events` | reasons of a PX4 that come as events |
//! | `refusal` | reasons of refusals, and their remedies |
//! | [`progress`] | progress in the mission |
//! | `conduct` | whether it follows its mission, lands, or circles now |
//! | [`signing`] | giving it a signing key and taking it away |
//! | [`heartbeat`] | which heartbeats are a vehicle's |
//! | `terrain` | its requests for terrain heights |
//! | [`transfer`] | plans, parameters and files, both ways |
//! | `overheard` | plans that a recording has |
//! | `id` | ids of a station's vehicles |
//! | `kind` | kinds of vehicles by `MAV_TYPE` |
//! | `autopilot` | autopilot and type by HEARTBEAT |
//! | [`registry`] | the vehicles of a link, and remote ones |

#![allow(deprecated, reason = "messages that MAVLink calls deprecated are what older vehicles speak")]

mod autopilot;
mod choice;
pub mod command;
mod conduct;
mod danger;
#[cfg(feature = "describe")]
mod described;
mod error;
mod events;
pub mod heartbeat;
mod id;
mod kind;
#[cfg(feature = "describe")]
pub mod misread;
pub mod modes;
mod overheard;
mod plan_record;
mod plan_state;
mod preparation;
pub mod progress;
mod reach;
mod refusal;
pub mod registry;
mod request;
#[cfg(feature = "describe")]
pub mod several;
pub mod signing;
mod sources;
pub mod streams;
pub mod telemetry;
mod terrain;
pub mod timesync;
pub mod transfer;
mod vehicle;

pub use autopilot::AutopilotType;
#[cfg(feature = "describe")]
pub use choice::RateChoice;
pub use choice::{AltFrame, MAX_RATE_HZ, MessageId, MessageRate, ModeChoice, SLOWEST_HZ, SpeedKind, Turn};
pub use conduct::Conduct;
pub use danger::Danger;
#[cfg(feature = "describe")]
pub use described::Described;
pub use error::{Recipient, VehicleError};
pub use id::VehicleId;
pub use kind::VehicleKind;
pub use overheard::{HeardPlan, Overheard};
pub use plan_record::{Doubt, PlanRecord, StoredRecord, VehicleKey, Writer};
pub use plan_state::{PlanState, Unknown};
pub use preparation::FlightPreparation;
pub use progress::MissionProgress;
pub use reach::UNREACHED_AFTER;
pub use refusal::Refusal;
pub use registry::{RegistryEvent, RegistryOutput, Vehicles};
pub use request::{Output, Reply, Request, RequestId, VehicleEvent};
pub use sources::{SourceId, Sources, Taken};
pub use terrain::{TERRAIN_REQUEST, TerrainBlock, TerrainRequests};
pub use transfer::{Param, ParamName, ParamType, ParamValue};
pub use vehicle::{FlightParameters, Vehicle, VehicleConfig};
