//! Capabilities of a service: its layers, their styles and systems, its attribution.

use serde::Serialize;
use utoipa::ToSchema;

use crate::geo::Bounds;
use crate::settings::{Attribution, SourceKind};

/// Capabilities of a service.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
#[schema(as = MapCapabilities)]
pub struct Capabilities {
    /// WMS or WMTS.
    pub kind: SourceKind,
    /// The version that it answered with.
    pub version: String,
    /// Title of the service.
    #[schema(required = true)]
    pub title: Option<String>,
    /// Abstract.
    #[schema(required = true)]
    pub r#abstract: Option<String>,
    /// Fees.
    #[schema(required = true)]
    pub fees: Option<String>,
    /// Access constraints.
    #[schema(required = true)]
    pub access_constraints: Option<String>,
    /// Whom to name, where the service itself says so.
    #[schema(required = true)]
    pub attribution: Option<Attribution>,
    /// Formats of its pictures that browsers show.
    pub formats: Vec<String>,
    /// Layers, parents first.
    pub layers: Vec<CapLayer>,
}

/// A style of a layer.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
#[schema(as = MapCapStyle)]
pub struct CapStyle {
    /// To ask with.
    pub name: String,
    /// To show.
    pub title: String,
}

/// A set of tile matrices that a WMTS layer comes in.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
#[schema(as = MapCapMatrixSet)]
pub struct CapMatrixSet {
    /// To ask with.
    pub id: String,
    /// Its coordinate reference system.
    pub crs: String,
    /// Matrices.
    pub levels: u32,
}

/// A layer that a service offers.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
#[schema(as = MapCapLayer)]
pub struct CapLayer {
    /// To ask with; null for a heading.
    #[schema(required = true)]
    pub name: Option<String>,
    /// To show.
    pub title: String,
    /// Abstract.
    #[schema(required = true)]
    pub r#abstract: Option<String>,
    /// How deep under other layers.
    pub depth: u32,
    /// Its styles, the default first.
    pub styles: Vec<CapStyle>,
    /// Coordinate reference systems that both sides know.
    pub crs: Vec<String>,
    /// How many more it knows.
    pub other_crs: u32,
    /// WMTS: its formats.
    pub formats: Vec<String>,
    /// WMTS: its matrix sets that both sides know.
    pub matrix_sets: Vec<CapMatrixSet>,
    /// Where it has something.
    #[schema(required = true)]
    pub bounds: Option<Bounds>,
    /// Whom to name.
    #[schema(required = true)]
    pub attribution: Option<Attribution>,
    /// Whether it hides what is under it.
    pub opaque: bool,
    /// Zoom from which it shows something.
    #[schema(required = true)]
    pub min_zoom: Option<u8>,
    /// Zoom up to which it shows something.
    #[schema(required = true)]
    pub max_zoom: Option<u8>,
}
