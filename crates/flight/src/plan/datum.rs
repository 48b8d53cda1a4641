//! Converting an item's height to another datum.

use super::item::{MavFrame, MissionItem};
use crate::way::rounded;
use crate::words::words;

words! {
    /// A level that is not known, so that no height can be counted from it, or from another.
    UnknownLevel {
        /// Home's, above mean sea level.
        Home = "home",
        /// That of the ground below the item.
        Ground = "ground",
        /// A frame without a datum known here.
        Frame = "frame",
    }
}

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
    fn amsl_m(self, frame: MavFrame) -> Result<f64, UnknownLevel> {
        match frame {
            MavFrame::Global | MavFrame::Mission => Ok(0.0),
            MavFrame::GlobalRelativeAlt => self.home_amsl_m.ok_or(UnknownLevel::Home),
            MavFrame::GlobalTerrainAlt => self.ground_amsl_m.ok_or(UnknownLevel::Ground),
            MavFrame::Other(_) => Err(UnknownLevel::Frame),
        }
    }
}

/// The item with its height counted from another level: at the same height in space, to the centimetre, where both
/// levels are known; else with the same number, with the first level that is not known. An item without position stays
/// as it is, and so does one in an unknown frame, which is reported likewise.
pub fn counted_from(item: &MissionItem, frame: MavFrame, levels: Levels) -> (MissionItem, Option<UnknownLevel>) {
    let mut counted = item.clone();
    if !item.has_position() || item.frame == frame {
        let is_strange = !item.frame.is_supported() && item.command.has_position() == Some(true);
        return (counted, is_strange.then_some(UnknownLevel::Frame));
    }
    counted.frame = frame;
    let by_m = levels.amsl_m(item.frame).and_then(|old_m| Ok(old_m - levels.amsl_m(frame)?));
    counted.params[6] = Some(rounded(item.alt_m().unwrap_or(0.0) + by_m.unwrap_or(0.0), 2));
    (counted, by_m.err())
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
        for (old, alt_m, new, levels, expected_m, lacks) in [
            (home, 80.0, amsl, levels, 770.0, None),
            (amsl, 770.0, home, levels, 80.0, None),
            (home, 80.0, terrain, levels, 57.66, None),
            (terrain, 57.66, amsl, levels, 770.0, None),
            (home, 80.0, home, blind, 80.0, None),
            // without both levels the number stays, which is reported
            (home, 80.0, amsl, blind, 80.0, Some(UnknownLevel::Home)),
            (home, 80.0, terrain, no_ground, 80.0, Some(UnknownLevel::Ground)),
            (terrain, 80.0, home, blind, 80.0, Some(UnknownLevel::Ground)),
            // an absurd height stays finite
            (home, -1e307, amsl, levels, -1e307, None),
        ] {
            let (counted, unknown) = counted_from(&from(old, alt_m), new, levels);
            assert_eq!((counted.frame, counted.alt_m()), (new, Some(expected_m)), "{old:?} {alt_m} to {new:?}");
            assert_eq!(unknown, lacks, "{old:?} to {new:?}");
        }
        let strange = from(MavFrame::Other(17), 80.0);
        assert_eq!(counted_from(&strange, home, levels), (strange.clone(), Some(UnknownLevel::Frame)));
        let returns = MissionItem::return_to_launch();
        assert_eq!(counted_from(&returns, amsl, blind), (returns, None));
    }
}
