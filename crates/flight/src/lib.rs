//! Flight: what to fly and where, without a vehicle at hand.
//!
//! Pure functions over plain values: no I/O, no clock, no task. Of our crates only `vencejo-proto` is used,
//! for ids and `MISSION_ITEM_INT`.
//!
//! | module | what it holds |
//! |---|---|
//! | [`plan`] | missions, fences, rally points; the table of commands; what an ArduPlane keeps of them |
//! | [`formats`] | plan files of ground stations, maps and receivers; parameter files |
//! | [`checks`] | errors and warnings in a plan, before it is sent |
//! | [`progress`] | how far and how long a mission still is |
//! | [`radius`] | radii of circles as an ArduPlane takes them |
//! | [`way`] | the line from place to place and the circles, as a plan is drawn |
//! | [`profile`] | the heights along it, and the ground below |
//! | [`alongside`] | a rehearsed flight along the profile |
//! | [`geodesy`] | distances, bearings, legs, local frames, polygons on WGS-84 |
//! | [`crs`] | coordinates of maps: Web Mercator and UTM |
//! | [`landing`] | the circle down, the final leg and the landing that end a mission |
//! | [`ending`] | the landing or return that ends a mission, and from where the plane comes to it |
//! | [`approaches`] | the landings of a runway or a point, ranked for a wind; a landing of which a part is moved |
//! | [`guidance`] | the laws that steer a plane: lateral, height and speed, attitude |
//! | [`rehearsal`] | a plan as this plane would fly it in this wind |
//! | [`separation`] | where two planned flights come too near to each other |
//! | [`survey`] | the lines from which a plane photographs an area or a corridor, and what its pictures show |
//!
//! # From a file to the wire and back
//!
//! ```
//! use vencejo_flight::checks::{CheckContext, check_plan, has_errors};
//! use vencejo_flight::formats::read_plan;
//! use vencejo_flight::plan::{Keeping, MissionItem, PlanKind, ardupilot_stored, items_from_wire, plans_equal_as_stored};
//! use vencejo_proto::{Address, MissionSeq};
//!
//! let file = "QGC WPL 110\n\
//!     0 1 0 16 0 0 0 0 40.3332 -3.7978 600 1\n\
//!     1 0 3 22 12 0 0 0 40.3332 -3.8013 60 1\n\
//!     2 0 3 16 0 0 0 0 40.3377 -3.8084 77.77 1\n\
//!     3 0 2 20 0 0 0 0 0 0 0 1\n";
//! let plan = read_plan(file.as_bytes(), Some("round.waypoints"))?.plan;
//!
//! // Before an upload: nothing that the vehicle would refuse or that cannot be intended.
//! let findings = check_plan(&plan, &CheckContext { on_ground: Some(true), ..CheckContext::default() });
//! assert!(!has_errors(&findings), "{findings:?}");
//!
//! // As sent: on ArduPilot item 0 is home, so `plan.mission.items[0]` has seq 1.
//! let wire = plan.mission.to_wire(Address::new(1, 1), true)?;
//! assert_eq!((wire[1].command, wire[1].x), (22, 403_332_000));
//!
//! // After the upload the list is read back and compared with what ArduPlane keeps: whole centimetres.
//! let sent = items_from_wire(&wire, PlanKind::Mission)?;
//! let kept: Vec<MissionItem> = sent.iter().map(ardupilot_stored).collect();
//! assert_eq!(kept[2].alt_m(), Some(77.76));
//! assert_eq!(plans_equal_as_stored(&sent, &kept, PlanKind::Mission, Keeping::ARDUPILOT), Ok(()));
//! # Ok::<(), vencejo_flight::FlightError>(())
//! ```
//!
//! # Conventions
//!
//! - Latitude and longitude in degrees on WGS-84, north and east positive; bearings in degrees clockwise from
//!   true north; heights in metres with their datum in the name (`alt_amsl_m`, `alt_rel_home_m`) or in the
//!   item's [`plan::MavFrame`].
//! - `plan.mission.items` does not hold home. "Item 3" in a message is the seq on ArduPilot, index + 1.
//! - Absent is `None`. NaN exists on the wire alone.
//! - What comes from a file or a vehicle is untrusted: every reader is bounded and returns [`FlightError`],
//!   which names the place, the fault and the remedy.

pub mod alongside;
pub mod approaches;
pub mod checks;
pub mod circled;
pub mod crs;
pub mod ending;
pub mod error;
pub mod formats;
pub mod geodesy;
pub mod ground;
pub mod guidance;
pub mod landing;
pub mod plan;
pub mod profile;
pub mod progress;
pub mod radius;
pub mod rehearsal;
pub mod separation;
pub mod survey;
pub mod way;
mod words;

pub use error::{FlightError, LandingProblem, Plain, Result, SurveyProblem};
