//! What goes over the wire about maps and heights. Most of it is said by the maps themselves ([`vencejo_maps`]): a source's
//! settings are one thing in the file, in the dialog and here. This file adds what only requests hold.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use vencejo_maps::elevation::ElevationPoint;
use vencejo_maps::settings::{Attribution, SourceKind, SourceSettings};

use super::{LatLon, Plan};

/// Ids of sources in drawing order.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct MapOrder {
    /// All or some; the others keep their places.
    #[schema(max_items = 200)]
    pub ids: Vec<String>,
}

/// A service to ask what it offers.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct CapabilitiesRequest {
    /// `wms` or `wmts`.
    pub kind: SourceKind,
    /// Its address, or any address of it that somebody copied.
    #[schema(max_length = 2000)]
    pub url: String,
    /// For `{key}` in the address.
    #[serde(default)]
    pub key: Option<String>,
    /// Whether the service is in this network; without it no private address is asked.
    #[serde(default)]
    #[schema(required = false)]
    pub local_network: bool,
}

/// Whom to name for a view.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct MapAttributions {
    /// Plain text with links.
    pub attribution: Vec<Attribution>,
    /// Zoom up to which there are pictures in the view.
    #[schema(required = true)]
    pub max_zoom: Option<u8>,
}

/// A file of the maps folder.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct MapFileInfo {
    /// For a source's `path`.
    pub path: String,
    /// Its size.
    pub bytes: u64,
    /// What it can be; null for what is not known.
    #[schema(required = true)]
    pub kind: Option<SourceKind>,
}

/// A file that was taken, with settings that fit it.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct MapFileTaken {
    /// For a source's `path`.
    pub path: String,
    /// Its size.
    pub bytes: u64,
    /// To be put, changed or not.
    pub settings: SourceSettings,
}

/// Where an offline area is to be.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum AreaShape {
    /// Between parallels and meridians; west greater than east: over the date line.
    Box(vencejo_maps::geo::Bounds),
    /// Three or more corners.
    Polygon {
        /// In order.
        points: Vec<LatLon>,
    },
    /// What is near a line.
    Route {
        /// In order.
        points: Vec<LatLon>,
        /// How near.
        buffer_m: f64,
    },
    /// What is near a plan: its home, and its mission's positions and legs.
    Plan {
        /// The plan.
        plan: Box<Plan>,
        /// How near.
        buffer_m: f64,
    },
}

/// An offline area to make or to reckon.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct AreaRequest {
    /// Id of the source.
    pub source: String,
    /// What people call it.
    #[schema(max_length = 100)]
    pub name: String,
    /// Where.
    pub shape: AreaShape,
    /// Coarsest level of the source's grid; for XYZ the zoom.
    pub min_level: u8,
    /// Finest level of the source's grid; for XYZ the zoom.
    pub max_level: u8,
}

/// Places whose heights are wanted.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ElevationRequest {
    /// The places.
    #[schema(max_items = 2000)]
    pub points: Vec<LatLon>,
}

/// Heights of places.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Elevations {
    /// In the order that was asked.
    pub points: Vec<ElevationPoint>,
    /// Why a source failed.
    #[schema(required = true)]
    pub error: Option<String>,
}

/// A line whose ground is wanted: points, or a plan's.
#[derive(Debug, Clone, PartialEq, Default, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ProfileRequest {
    /// The line.
    #[serde(default)]
    pub points: Vec<LatLon>,
    /// Instead of it.
    #[serde(default)]
    pub plan: Option<Plan>,
    /// Between samples at most; 30 when absent. More samples than 2000 are not made.
    #[serde(default)]
    pub spacing_m: Option<f64>,
}
