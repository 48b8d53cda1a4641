//! What a height counts from, exchanged for another level.

use super::item::{MavFrame, MissionItem};

/// Heights above mean sea level from which those of items count, metres; `None` is not known.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Levels {
    /// Of home.
    pub home_amsl_m: Option<f64>,
    /// Of the ground below the item.
    pub ground_amsl_m: Option<f64>,
}

impl Levels {
    /// Of what a frame's heights count from.
    fn amsl_m(self, frame: MavFrame) -> Option<f64> {
        match frame {
            MavFrame::Global | MavFrame::Mission => Some(0.0),
            MavFrame::GlobalRelativeAlt => self.home_amsl_m,
            MavFrame::GlobalTerrainAlt => self.ground_amsl_m,
            MavFrame::Other(_) => None,
        }
    }
}

/// The item with its height counted from another level: at the same height in space, to the centimetre, where both levels are known;
/// else with the same number, since nobody can tell another. What has no position stays as it is.
#[must_use]
pub fn counted_from(item: &MissionItem, frame: MavFrame, levels: Levels) -> MissionItem {
    let mut counted = item.clone();
    if !item.has_position() || item.frame == frame {
        return counted;
    }
    counted.frame = frame;
    let by_m = levels.amsl_m(item.frame).zip(levels.amsl_m(frame)).map_or(0.0, |(old_m, new_m)| old_m - new_m);
    let alt_m = item.alt_m().unwrap_or(0.0) + by_m;
    counted.params[6] = Some((alt_m * 100.0).round() / 100.0);
    counted
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_height_in_space_stays_where_both_levels_are_known() {
        let levels = Levels { home_amsl_m: Some(690.0), ground_amsl_m: Some(712.344) };
        let from = |frame, alt_m| MissionItem { frame, ..MissionItem::waypoint(40.0, -3.0, alt_m) };
        let (amsl, home, terrain) = (MavFrame::Global, MavFrame::GlobalRelativeAlt, MavFrame::GlobalTerrainAlt);
        let blind = Levels::default();
        let no_ground = Levels { ground_amsl_m: None, ..levels };
        for (old, alt_m, new, levels, expected_m) in [
            (home, 80.0, amsl, levels, 770.0),
            (amsl, 770.0, home, levels, 80.0),
            (home, 80.0, terrain, levels, 57.66),
            (terrain, 57.66, amsl, levels, 770.0),
            (home, 80.0, home, blind, 80.0),
            // a number of which nobody can tell another stays
            (home, 80.0, amsl, blind, 80.0),
            (home, 80.0, terrain, no_ground, 80.0),
        ] {
            let counted = counted_from(&from(old, alt_m), new, levels);
            assert_eq!((counted.frame, counted.alt_m()), (new, Some(expected_m)), "{old:?} {alt_m} to {new:?}");
        }
        let returns = MissionItem::return_to_launch();
        assert_eq!(counted_from(&returns, amsl, levels), returns);
    }
}
