//! Landing requests, designed landings, and fixes of findings.

use vencejo_flight::FlightError;
use vencejo_flight::approaches::{Alternative, Flown};
use vencejo_flight::checks::{Finding, Fix};
use vencejo_flight::landing::{Landing, LandingCaution, LandingOptions};

use super::plan::item;
use super::units::point;
use crate::dto;

/// Design options of a landing; missing ones are taken from `usual`.
pub(crate) fn landing_options(
    asked: &dto::LandingRequest,
    usual: LandingOptions,
) -> Result<LandingOptions, FlightError> {
    Ok(LandingOptions {
        course_deg: asked.course_deg,
        coming_from: asked.coming_from.map(point).transpose()?,
        wind: asked.wind,
        ground_rel_home_m: asked.ground_rel_home_m,
        airspeed_m_s: asked.airspeed_m_s.unwrap_or(usual.airspeed_m_s),
        slope: asked.slope.unwrap_or(usual.slope),
        final_height_m: asked.final_height_m.unwrap_or(usual.final_height_m),
        radius_m: asked.radius_m.unwrap_or(usual.radius_m),
        is_clockwise: asked.is_clockwise.unwrap_or(usual.is_clockwise),
        has_land_start: asked.has_land_start.unwrap_or(usual.has_land_start),
    })
}

pub(crate) fn landing_alternative(one: &Alternative) -> dto::LandingAlternative {
    let Flown { ending, touch_down_m, rest_m, duration_s } = one.flown;
    dto::LandingAlternative {
        landing: landing(&one.landing),
        is_clockwise: one.is_clockwise,
        crosswind_m_s: one.crosswind_m_s,
        ending,
        touch_down_m,
        rest_m,
        duration_s,
        verdict: one.verdict,
        reasons: one
            .reasons
            .iter()
            .map(|reason| dto::LandingReasonText { message: reason.to_string(), reason: *reason })
            .collect(),
    }
}

pub(crate) fn landing(landing: &Landing) -> dto::Landing {
    let caution = |caution: &LandingCaution| dto::LandingCaution {
        code: caution.as_str().to_owned(),
        message: caution.to_string(),
    };
    dto::Landing {
        items: landing.items.iter().map(item).collect(),
        course_deg: landing.course_deg,
        direction: landing.direction,
        leaves: dto::LatLon { lat_deg: landing.leaves.lat_deg(), lon_deg: landing.leaves.lon_deg() },
        leaves_alt_rel_home_m: landing.leaves_alt_rel_home_m,
        final_m: landing.final_m,
        slope: landing.slope,
        radius_m: landing.radius_m,
        headwind_m_s: landing.headwind_m_s,
        groundspeed_m_s: landing.groundspeed_m_s,
        cautions: landing.cautions.iter().map(caution).collect(),
    }
}

pub(crate) fn finding_fix(finding: Finding, fix: Fix) -> dto::FindingFix {
    dto::FindingFix {
        finding,
        message: fix.message(),
        first_item: fix.first + 1,
        count: fix.count,
        items: fix.items.iter().map(item).collect(),
        kind: fix.kind,
    }
}
