//! How a plan that is edited differs from the one on board: what was put in, taken out and changed.

use std::ops::Range;

use crate::plan::difference::{Field, Keeping};
use crate::plan::item::MissionItem;
use crate::words::words;

/// Most pairs of items that are compared for the shortest list of changes; beyond that items are compared index by
/// index.
const MOST_PAIRS: usize = 1_000_000;

words! {
    /// What has changed in an item.
    ChangedField {
        /// The command.
        Command = "command",
        /// Where.
        Place = "place",
        /// How high, or what the height counts from.
        Height = "height",
        /// Any other parameter.
        Parameters = "parameters",
    }
}

/// One step from the list on board to the one that is edited. Numbers count from 1, home of a mission left out.
#[derive(Debug, Clone, PartialEq, Eq)]
#[cfg_attr(feature = "describe", derive(serde::Serialize, utoipa::ToSchema), schema(as = PlanChange))]
#[cfg_attr(feature = "describe", serde(tag = "kind", rename_all = "snake_case"))]
pub enum Change {
    /// An item that is not on board.
    Added {
        /// Its number in the plan that is edited.
        item: usize,
    },
    /// An item on board that the plan has no more.
    Removed {
        /// Its number on board.
        on_board: usize,
    },
    /// An item where another is on board.
    Changed {
        /// Its number in the plan that is edited.
        item: usize,
        /// The number of the one on board.
        on_board: usize,
        /// The fields that have changed, in this order.
        fields: Vec<ChangedField>,
    },
}

/// The shortest list of changes from the items on board to the edited ones. Unchanged items are left out; a removal and
/// an insertion at one place are reported as a change. Empty when the vehicle has the items, as it stores them.
///
/// Of lists of a fence or of rally points the numbers are those of their corners and points in order.
pub fn plan_changes(edited: &[MissionItem], on_board: &[MissionItem], keeping: Keeping) -> Vec<Change> {
    // Those on board too: the return point of a fence is read without the frame that it is stored in.
    let [edited, on_board] =
        [edited, on_board].map(|items| items.iter().map(|item| keeping.kept(item)).collect::<Vec<MissionItem>>());
    let fields = |at: usize, other: usize| keeping.fields_that_differ(&edited[at], &on_board[other]);
    let is_same = |at: usize, other: usize| fields(at, other).next().is_none();
    let (mut ends, most) = ((edited.len(), on_board.len()), edited.len().min(on_board.len()));
    let begin = (0..most).take_while(|&at| is_same(at, at)).count();
    while ends.0 > begin && ends.1 > begin && is_same(ends.0 - 1, ends.1 - 1) {
        ends = (ends.0 - 1, ends.1 - 1);
    }
    let mut changes = Vec::new();
    let mut tell = |added: Range<usize>, removed: Range<usize>| {
        for step in 0..added.len().max(removed.len()) {
            let (item, on_board) = (added.start + step, removed.start + step);
            changes.extend(match (item < added.end, on_board < removed.end) {
                (true, true) => {
                    let mut named: Vec<_> = fields(item, on_board).map(|field| changed(field, &edited[item])).collect();
                    named.sort_unstable();
                    named.dedup();
                    // within a run of changes an item may be unchanged
                    (!named.is_empty()).then_some(Change::Changed {
                        item: item + 1,
                        on_board: on_board + 1,
                        fields: named,
                    })
                }
                (true, false) => Some(Change::Added { item: item + 1 }),
                (false, true) => Some(Change::Removed { on_board: on_board + 1 }),
                (false, false) => None,
            });
        }
    };
    let mut from = (begin, begin);
    for (at, other) in kept_in_order(begin..ends.0, begin..ends.1, is_same) {
        tell(from.0..at, from.1..other);
        from = (at + 1, other + 1);
    }
    tell(from.0..ends.0, from.1..ends.1);
    changes
}

/// The longest run of pairs that are the same, in order (longest common subsequence, by the table of its lengths).
fn kept_in_order(
    edited: Range<usize>,
    on_board: Range<usize>,
    is_same: impl Fn(usize, usize) -> bool,
) -> Vec<(usize, usize)> {
    let (rows, columns) = (edited.len(), on_board.len());
    if rows.saturating_mul(columns) > MOST_PAIRS {
        return Vec::new();
    }
    let width = columns + 1;
    let mut longest = vec![0_u32; (rows + 1) * width];
    let same: Vec<bool> = edited
        .clone()
        .flat_map(|at| on_board.clone().map(move |other| (at, other)))
        .map(|(a, b)| is_same(a, b))
        .collect();
    for row in (0..rows).rev() {
        for column in (0..columns).rev() {
            let (below, beside) = (longest[(row + 1) * width + column], longest[row * width + column + 1]);
            longest[row * width + column] = if same[row * columns + column] {
                longest[(row + 1) * width + column + 1] + 1
            } else {
                below.max(beside)
            };
        }
    }
    let mut kept = Vec::new();
    let (mut row, mut column) = (0, 0);
    while row < rows && column < columns {
        if same[row * columns + column] {
            kept.push((edited.start + row, on_board.start + column));
            (row, column) = (row + 1, column + 1);
        } else if longest[(row + 1) * width + column] >= longest[row * width + column + 1] {
            row += 1;
        } else {
            column += 1;
        }
    }
    kept
}

/// The field of an item that a difference is about.
fn changed(field: Field, item: &MissionItem) -> ChangedField {
    match field {
        Field::Item | Field::Command => ChangedField::Command,
        Field::Param(4 | 5) if item.has_position() => ChangedField::Place,
        Field::Param(6) | Field::Frame if item.has_position() => ChangedField::Height,
        Field::Param(_) | Field::Frame => ChangedField::Parameters,
    }
}

#[cfg(test)]
mod tests {
    use std::slice;

    use super::*;
    use crate::geodesy::GeoPoint;
    use crate::plan::{Fence, FenceShape, FenceZone, MavFrame, Rally, RallyPoint};

    const BOTH: [Keeping; 2] = [Keeping::ARDUPILOT, Keeping::AS_SENT];

    fn circuit() -> Vec<MissionItem> {
        vec![
            MissionItem::takeoff(40.3332, -3.7978, 50.0, 12.0),
            MissionItem::waypoint(40.3361, -3.7978, 80.0),
            MissionItem::loiter_turns(40.3361, -3.7942, 80.0, 2.0, 60.0),
            MissionItem::waypoint(40.3332, -3.7942, 80.0),
            MissionItem::change_airspeed(14.0),
            MissionItem::return_to_launch(),
        ]
    }

    fn with(item: &MissionItem, index: usize, value: f64) -> MissionItem {
        let mut item = item.clone();
        item.params[index] = Some(value);
        item
    }

    #[test]
    fn nothing_differs_in_what_the_vehicle_rounds() {
        let edited = circuit();
        // a position by less than half of a degE7; an ArduPilot keeps centimetres besides, and no throttle of a speed
        let moved = |item: &MissionItem| with(item, 4, item.params[4].unwrap_or(0.0) + 3e-8);
        for keeping in BOTH {
            let on_board: Vec<_> = edited.iter().map(|item| moved(&keeping.kept(item))).collect();
            assert_eq!(plan_changes(&edited, &on_board, keeping), []);
        }
        let higher: Vec<_> = edited.iter().map(|item| with(item, 6, item.params[6].unwrap_or(0.0) + 0.009)).collect();
        let placed =
            |items: &[MissionItem]| items.iter().filter(|item| item.has_position()).cloned().collect::<Vec<_>>();
        assert_eq!(plan_changes(&placed(&edited), &placed(&higher), Keeping::ARDUPILOT), []);
        assert_eq!(plan_changes(&placed(&edited), &placed(&higher), Keeping::AS_SENT).len(), 4);
        // an ArduPilot keeps whole turns
        let turns = [with(&edited[2], 0, 2.3)];
        assert_eq!(plan_changes(&turns, &edited[2..3], Keeping::ARDUPILOT), []);
        // unset values come back as 0
        let mut unset = edited[4].clone();
        unset.params[3] = None;
        for keeping in BOTH {
            assert_eq!(plan_changes(slice::from_ref(&unset), &[keeping.kept(&edited[4])], keeping), []);
        }
    }

    #[test]
    fn what_was_added_removed_and_changed_is_told_by_number() {
        let on_board = circuit();
        let mut edited = on_board[..5].to_vec();
        edited[3] = with(&on_board[3], 6, 99.0);
        edited.insert(2, MissionItem::waypoint(40.34, -3.79, 80.0));
        let height = vec![ChangedField::Height];
        for keeping in BOTH {
            let on_board: Vec<_> = on_board.iter().map(|item| keeping.kept(item)).collect();
            assert_eq!(
                plan_changes(&edited, &on_board, keeping),
                [
                    Change::Added { item: 3 },
                    Change::Changed { item: 5, on_board: 4, fields: height.clone() },
                    Change::Removed { on_board: 6 },
                ]
            );
        }
    }

    #[test]
    fn each_field_has_its_word() {
        let was = MissionItem::loiter_turns(40.0, -3.0, 80.0, 2.0, 60.0);
        let higher = MissionItem { frame: MavFrame::Global, ..was.clone() };
        let other = MissionItem::waypoint(41.0, -3.0, 90.0);
        let speed = MissionItem::change_airspeed(14.0);
        let both = with(&with(&was, 5, -3.1), 2, 70.0);
        use ChangedField::{Command as C, Height, Parameters, Place};
        for (item, was, fields) in [
            (&higher, &was, &[Height][..]),
            (&other, &was, &[C]),
            (&both, &was, &[Place, Parameters]),
            (&with(&speed, 1, 15.0), &speed, &[Parameters]),
        ] {
            for keeping in BOTH {
                let told = plan_changes(slice::from_ref(item), &[keeping.kept(was)], keeping);
                assert_eq!(told, [Change::Changed { item: 1, on_board: 1, fields: fields.to_vec() }], "{item:?}");
            }
        }
        // across the date line it is as near
        let (west, east) = (MissionItem::waypoint(0.0, -180.0, 50.0), MissionItem::waypoint(0.0, 180.0, 50.0));
        assert_eq!(plan_changes(&[west], &[east], Keeping::ARDUPILOT), []);
    }

    #[test]
    fn an_ardupilot_keeps_of_a_landing_the_side_alone_and_px4_its_heading() {
        let land = MissionItem::land(40.0, -3.0, 0.0);
        let one = |keeping, from: f64, kept: f64| {
            plan_changes(&[with(&land, 3, from)], &[with(&land, 3, kept)], keeping).len()
        };
        assert_eq!(one(Keeping::ARDUPILOT, 0.0, 1.0), 0);
        assert_eq!(one(Keeping::ARDUPILOT, 0.0, -1.0), 1);
        assert_eq!(one(Keeping::AS_SENT, 0.0, 1.0), 1);
        let unset = MissionItem {
            params: {
                let mut params = land.params;
                params[3] = None;
                params
            },
            ..land.clone()
        };
        assert_eq!(plan_changes(&[unset], &[with(&land, 3, 1.0)], Keeping::ARDUPILOT), []);
    }

    #[test]
    fn an_old_plane_has_what_its_floats_can_hold() {
        let old = Keeping { is_ardupilot: true, in_floats: true };
        let sent = MissionItem::waypoint(40.333_223_3, -3.797_812_3, 50.0);
        let rounded = with(&sent, 4, f64::from(40.333_223_3_f64 as f32));
        let changes =
            |on_board: &MissionItem, keeping| plan_changes(slice::from_ref(&sent), slice::from_ref(on_board), keeping);
        assert_eq!(changes(&rounded, old), []);
        assert_eq!(changes(&rounded, Keeping::ARDUPILOT).len(), 1);
        assert_eq!(changes(&with(&sent, 4, 40.333_243_3), old).len(), 1);
    }

    #[test]
    fn fences_and_rally_points_are_the_same_as_a_vehicle_keeps_them() {
        let point = |lat_deg, lon_deg| GeoPoint::new(lat_deg, lon_deg).unwrap();
        let corners = vec![point(40.33, -3.80), point(40.34, -3.80), point(40.34, -3.79)];
        let circle = |radius_m| FenceShape::Circle { center: point(40.335, -3.795), radius_m };
        let zone = |inclusion, shape| FenceZone { inclusion, shape };
        let fence = |inclusion, radius_m, return_point| {
            let zones =
                vec![zone(inclusion, FenceShape::Polygon { vertices: corners.clone() }), zone(false, circle(radius_m))];
            Fence { zones, return_point }.to_items()
        };
        let back = Some((point(40.334, -3.797), 60.0));
        let rally = |alt_m, frame| Rally { points: vec![RallyPoint { point: corners[0], alt_m, frame }] }.to_items();
        let (home, terrain) = (MavFrame::GlobalRelativeAlt, MavFrame::GlobalTerrainAlt);
        for keeping in BOTH {
            let count = |edited: &[MissionItem], on_board: &[MissionItem]| {
                let on_board: Vec<_> = on_board.iter().map(|item| keeping.kept(item)).collect();
                plan_changes(edited, &on_board, keeping).len()
            };
            let on_board = fence(true, 80.0, back);
            assert_eq!(count(&fence(true, 80.000_001, back), &on_board), 0);
            let read = Fence::from_items(&on_board.iter().map(|item| keeping.kept(item)).collect::<Vec<_>>()).unwrap();
            assert_eq!(plan_changes(&on_board, &read.to_items(), keeping), [], "as the station has read it");
            assert_eq!(count(&fence(true, 81.0, back), &on_board), 1);
            assert_eq!(count(&fence(true, 80.0, None), &on_board), 1);
            assert_eq!(count(&fence(false, 80.0, back), &on_board), 3);
            assert_eq!(count(&on_board[..3], &on_board), 2);
            assert_eq!(count(&rally(60.0, home), &rally(60.0, home)), 0);
            assert_eq!(count(&rally(62.0, home), &rally(60.0, home)), 1);
            assert_eq!(count(&rally(60.0, terrain), &rally(60.0, home)), 1);
            // an ArduPilot keeps whole metres
            assert_eq!(count(&rally(60.7, home), &rally(60.0, home)), usize::from(!keeping.is_ardupilot));
        }
    }

    #[test]
    fn whole_missions_differ_at_once() {
        let item = |index: usize| MissionItem::waypoint(40.0 + index as f64 * 1e-4, -3.0, 50.0);
        let many: Vec<_> = (0..650).map(item).collect();
        let backwards: Vec<_> = many.iter().rev().cloned().collect();
        let added = plan_changes(&many, &[], Keeping::ARDUPILOT);
        assert!(added.len() == 650 && added[649] == Change::Added { item: 650 });
        assert_eq!(plan_changes(&[], &many, Keeping::ARDUPILOT).len(), 650);
        assert!(plan_changes(&backwards, &many, Keeping::ARDUPILOT).len() > 600);
        // too long for the shortest list: index by index
        let actions = |airspeed_m_s: f64| vec![MissionItem::change_airspeed(airspeed_m_s); 1_001];
        let mut edited = actions(14.0);
        edited[500] = with(&edited[500], 1, 15.0);
        (edited[0], edited[1_000]) = (edited[500].clone(), edited[500].clone());
        assert_eq!(plan_changes(&edited, &actions(14.0), Keeping::AS_SENT).len(), 3);
    }
}
