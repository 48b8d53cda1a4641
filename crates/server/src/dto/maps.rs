//! Requests and answers about maps and terrain. Most of the types are those of [`vencejo_maps`] itself, since the
//! settings of a source are the same in the file, in the dialog and here. This file adds those that only the API uses.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use vencejo_maps::elevation::ElevationPoint;
use vencejo_maps::settings::{Attribution, SourceKind, SourceSettings};

use super::{LatLon, Plan};

/// Ids of map sources in drawing order.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct MapOrder {
    /// All ids or some of them; the others keep their positions.
    #[schema(max_items = 200)]
    pub ids: Vec<String>,
}

/// A map service whose capabilities are wanted.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct CapabilitiesRequest {
    /// `wms` or `wmts`.
    pub kind: SourceKind,
    /// Address of the service, or any of its request addresses.
    #[schema(max_length = 2000)]
    pub url: String,
    /// Key that replaces `{key}` in the address.
    #[serde(default)]
    pub key: Option<String>,
    /// Whether the service is in the local network; otherwise private addresses are refused.
    #[serde(default)]
    #[schema(required = false)]
    pub local_network: bool,
}

/// Attributions for a view of the map.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct MapAttributions {
    /// Plain texts with links.
    pub attribution: Vec<Attribution>,
    /// Highest zoom at which the view has images.
    #[schema(required = true)]
    pub max_zoom: Option<u8>,
}

/// A file in the maps folder.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct MapFileInfo {
    /// Path, as used in a source's `path`.
    pub path: String,
    /// Size of the file.
    pub bytes: u64,
    /// Source kind that can read it; null when unknown.
    #[schema(required = true)]
    pub kind: Option<SourceKind>,
}

/// An imported file and settings for a source that reads it.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct MapFileTaken {
    /// Path, as used in a source's `path`.
    pub path: String,
    /// Size of the file.
    pub bytes: u64,
    /// Proposed settings; the client sends them back, changed or not, to create the source.
    pub settings: SourceSettings,
}

/// Shape of an offline area.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum AreaShape {
    /// Between parallels and meridians; a west greater than the east crosses the antimeridian.
    Box(vencejo_maps::geo::Bounds),
    /// A polygon of three or more corners.
    Polygon {
        /// Corners in order.
        points: Vec<LatLon>,
    },
    /// A buffer around a line.
    Route {
        /// Points in order.
        points: Vec<LatLon>,
        /// Width of the buffer on each side.
        buffer_m: f64,
    },
    /// A buffer around a plan: its home, and its mission's positions and legs.
    Plan {
        /// The plan.
        plan: Box<Plan>,
        /// Width of the buffer on each side.
        buffer_m: f64,
    },
}

/// An offline area to create or to estimate.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct AreaRequest {
    /// Id of the map source.
    pub source: String,
    /// Display name.
    #[schema(max_length = 100)]
    pub name: String,
    /// Area to cover.
    pub shape: AreaShape,
    /// Coarsest level of the source's grid; for XYZ the zoom.
    pub min_level: u8,
    /// Finest level of the source's grid; for XYZ the zoom.
    pub max_level: u8,
}

/// Positions whose ground elevations are wanted.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ElevationRequest {
    /// Positions.
    #[schema(max_items = 2000)]
    pub points: Vec<LatLon>,
}

/// Ground elevations of positions.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Elevations {
    /// Elevations in the order of the request.
    pub points: Vec<ElevationPoint>,
    /// Why a source failed; null when none did.
    #[schema(required = true)]
    pub error: Option<String>,
}

/// A line whose terrain profile is wanted: points, or a plan.
#[derive(Debug, Clone, PartialEq, Default, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ProfileRequest {
    /// Points of the line.
    #[serde(default)]
    pub points: Vec<LatLon>,
    /// A plan, in place of `points`.
    #[serde(default)]
    pub plan: Option<Plan>,
    /// Largest distance between samples; 30 when absent. At most 2000 samples are returned.
    #[serde(default)]
    pub spacing_m: Option<f64>,
}
