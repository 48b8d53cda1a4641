//! What speaks for and against a landing.

use crate::rehearsal::Ending;
use crate::words::words;

/// Distance between the point and the place where a rehearsed plane comes to rest that is doubtful, m.
const FAR_OFF_M: f64 = 30.0;

words! {
    /// How a landing suits.
    Verdict {
        /// No reason against it.
        Good = "good",
        /// It can be flown, with reasons against it.
        Doubtful = "doubtful",
        /// The rehearsed plane does not come down where it should.
        Bad = "bad",
    }
}

/// What speaks for or against a landing.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "describe", derive(serde::Serialize, utoipa::ToSchema))]
#[cfg_attr(feature = "describe", serde(tag = "code", rename_all = "kebab-case"))]
pub enum LandingReason {
    /// The wind is too weak to matter.
    Calm {},
    /// The wind comes from ahead.
    Headwind {
        /// Its part along the final leg.
        speed_m_s: f64,
    },
    /// The wind comes from behind.
    Tailwind {
        /// Its part along the final leg.
        speed_m_s: f64,
    },
    /// The wind comes from the side.
    Crosswind {
        /// Its part across the final leg.
        speed_m_s: f64,
        /// Whether it comes from the right.
        is_from_right: bool,
    },
    /// The final leg is steep.
    Steep {
        /// Height over distance.
        slope: f64,
    },
    /// The ground comes near the final leg or the circle.
    GroundNear {
        /// How near, at the worst place; negative below the ground.
        clearance_m: f64,
        /// The clearance required there.
        wanted_m: f64,
        /// How far from the point.
        distance_m: f64,
    },
    /// Where the rehearsed plane comes to rest.
    ComesToRest {
        /// Distance from the point.
        distance_m: f64,
        /// Whether that is beyond the point.
        is_beyond: bool,
    },
    /// The rehearsed plane touches the ground before the runway begins.
    BeforeRunway {
        /// By how much.
        distance_m: f64,
    },
    /// The rehearsed plane rolls over the runway's end.
    BeyondRunway {
        /// By how much.
        distance_m: f64,
    },
    /// The rehearsed plane does not land.
    DoesNotLand {
        /// What happens.
        ending: Ending,
    },
}

impl LandingReason {
    /// A stable name, fit for scripts.
    pub const fn as_str(&self) -> &'static str {
        match self {
            Self::Calm {} => "calm",
            Self::Headwind { .. } => "headwind",
            Self::Tailwind { .. } => "tailwind",
            Self::Crosswind { .. } => "crosswind",
            Self::Steep { .. } => "steep",
            Self::GroundNear { .. } => "ground-near",
            Self::ComesToRest { .. } => "comes-to-rest",
            Self::BeforeRunway { .. } => "before-runway",
            Self::BeyondRunway { .. } => "beyond-runway",
            Self::DoesNotLand { .. } => "does-not-land",
        }
    }

    pub(super) const fn verdict(&self) -> Verdict {
        match self {
            Self::Calm {} | Self::Headwind { .. } | Self::Crosswind { .. } => Verdict::Good,
            Self::ComesToRest { distance_m, .. } if *distance_m <= FAR_OFF_M => Verdict::Good,
            Self::GroundNear { clearance_m, .. } if *clearance_m <= 0.0 => Verdict::Bad,
            Self::Tailwind { .. } | Self::Steep { .. } | Self::GroundNear { .. } | Self::ComesToRest { .. } => {
                Verdict::Doubtful
            }
            Self::BeforeRunway { .. } | Self::BeyondRunway { .. } | Self::DoesNotLand { .. } => Verdict::Bad,
        }
    }
}

impl std::fmt::Display for LandingReason {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Calm {} => f.write_str("next to no wind"),
            Self::Headwind { speed_m_s } => write!(f, "{speed_m_s:.0} m/s of headwind"),
            Self::Tailwind { speed_m_s } => write!(f, "{speed_m_s:.0} m/s of tailwind"),
            Self::Crosswind { speed_m_s, is_from_right } => {
                write!(f, "{speed_m_s:.0} m/s of crosswind from the {}", if *is_from_right { "right" } else { "left" })
            }
            Self::Steep { slope } => write!(f, "a steep final leg, 1 in {:.1}", 1.0 / slope),
            Self::GroundNear { clearance_m, distance_m, .. } if *clearance_m <= 0.0 => {
                write!(f, "the ground is in the way {distance_m:.0} m before the point")
            }
            Self::GroundNear { clearance_m, wanted_m, distance_m } => write!(
                f,
                "only {clearance_m:.0} m above the ground {distance_m:.0} m before the point, where {wanted_m:.0} m are wanted"
            ),
            Self::ComesToRest { distance_m, is_beyond } => {
                write!(f, "comes to rest {distance_m:.0} m {} the point", if *is_beyond { "beyond" } else { "before" })
            }
            Self::BeforeRunway { distance_m } => write!(f, "touches the ground {distance_m:.0} m before the runway"),
            Self::BeyondRunway { distance_m } => write!(f, "rolls {distance_m:.0} m beyond the runway's end"),
            Self::DoesNotLand { ending } => f.write_str(match ending {
                Ending::Ground => "hits the ground on the way",
                Ending::Held => "is held by the wind on the way",
                _ => "does not come down",
            }),
        }
    }
}
