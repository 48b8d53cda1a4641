//! Findings from a survey's rehearsed flight: missed lines and holes in the coverage.

use super::finding::{Finding, FindingKind, Severity};
use crate::plan::MissionItem;
use crate::survey::{Coverage, Survey};

/// Findings of a survey's rehearsed flight: lines that were missed, and ground that no picture shows.
///
/// `items` are those of the mission, in which the survey's begin at index `first_item`.
pub fn check_survey(survey: &Survey, coverage: &Coverage, items: &[MissionItem], first_item: usize) -> Vec<Finding> {
    let missed = survey.lines.iter().zip(&coverage.lines).enumerate().filter(|(_, (_, flown))| flown.is_missed);
    let mut found: Vec<Finding> = missed
        .map(|(number, (line, flown))| {
            let index = first_item + line.entry;
            let kind = FindingKind::SurveyLineMissed { line: number + 1, distance_m: flown.off_m };
            Finding::new(Severity::Warning, kind, items.get(index).map(|item| (index, item)))
        })
        .collect();
    if let Some(largest) = coverage.holes.first() {
        let kind = FindingKind::SurveyHoles { holes: coverage.holes.len(), side_m: largest.area_m2.sqrt() };
        found.push(Finding::new(Severity::Warning, kind, None));
    }
    found
}
