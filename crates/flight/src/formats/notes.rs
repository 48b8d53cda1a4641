//! Notes about what a reader assumed or left out, and what a writer could not keep.

use std::collections::BTreeMap;

use crate::words::words;

macro_rules! codes {
    ($($(#[doc = $doc:literal])* $name:ident = $code:literal: $sentence:literal,)*) => {
        words! {
            /// Kind of note about a plan file, as in `heights-missing`.
            #[cfg_attr(feature = "describe", schema(as = PlanFileNoteCode))]
            #[non_exhaustive]
            NoteCode { $($(#[doc = $doc])* $name = $code,)* }
        }

        impl NoteCode {
            /// English text in ASCII, without the number.
            pub const fn sentence(self) -> &'static str {
                match self { $(Self::$name => $sentence,)* }
            }
        }
    };
}

codes! {
    /// Read: heights that the format counts from the sea.
    HeightsAboveSeaLevel = "heights-above-sea-level": "heights count from mean sea level, as this format has them",
    /// Read: heights that the file counts from the ground.
    HeightsAboveTerrain = "heights-above-terrain": "heights count from the terrain below, as the file says",
    /// Read: heights that by the standard count from the ellipsoid, which no plan can say.
    HeightsTakenAboveSeaLevel = "heights-taken-above-sea-level":
        "heights were taken as above mean sea level; the format counts them from the ellipsoid, tens of metres away in places, so compare one that you know",
    /// Read: heights of which the file does not say what they count from.
    HeightsTakenAboveHome = "heights-taken-above-home":
        "heights were taken as above home, for the file does not say what they count from",
    /// Read: items without a height.
    HeightsMissing = "heights-missing": "places have no height; set it before the plan is sent",
    /// Read: drawn features that are not places.
    NotPlaces = "not-places": "entries of the file are no places and were left out",
    /// Read: points in a file that has a route.
    PointsLeftOut = "points-left-out": "points beside the route were left out",
    /// Read: recorded tracks in a file that has a route.
    TracksLeftOut = "tracks-left-out": "tracks beside the route were left out",
    /// Read: a file of ours that another program has saved without some of its items.
    ItemsMissing = "items-missing": "items that the plan had when it was written are no longer in the file",
    /// Read: rows whose index is not that of the row before plus 1.
    ItemsRenumbered = "items-renumbered":
        "indices of the file are not in sequence; its items were numbered anew, in the order of the rows",
    /// Read: complex items without their items.
    ItemsElsewhere = "items-elsewhere":
        "complex items are of a kind that only their program can lay out, and stand as USER_1, which no vehicle takes; send the plan from QGroundControl to a vehicle or a simulator, read it back there and save that",
    /// Read: several lines in one file.
    LinesJoined = "lines-joined": "lines were joined to one mission, in the order of the file",
    /// Read: areas that do not say whether to stay inside.
    AreasTakenAsFence = "areas-taken-as-fence": "areas were taken as zones to stay inside",
    /// Read: holes in areas.
    HolesTakenAsFence = "holes-taken-as-fence": "holes in areas were taken as zones to stay outside",
    /// Read: heights of the corners of areas.
    AreaHeightsNotKept = "area-heights-not-kept": "areas have heights, which were not kept: a fence has none",
    /// Read: names and descriptions.
    NamesNotKept = "names-not-kept": "names and descriptions were not kept: a plan has none",
    /// Read: how to land at rally points.
    RallyLandingsNotKept = "rally-landings-not-kept":
        "rally points have a break altitude, a landing direction or flags, which were not kept: a vehicle circles at one, and lands where its mission says",
    /// Written: heights above home in a format that knows the sea alone.
    HeightsWrittenAboveSeaLevel = "heights-written-above-sea-level":
        "heights above home were written as above mean sea level, by the height of the planned home",
    /// Written: heights that the format cannot hold.
    HeightsNotWritten = "heights-not-written":
        "heights were not written: this format counts them from the sea, the plan from terrain or from a home that it does not have",
    /// Written: heights above home that other programs see as above the sea.
    HeightsDrawnAboveSeaLevel = "heights-drawn-above-sea-level":
        "heights above home are drawn as above mean sea level, by the height of the planned home; the data beside them keep them as they are",
    /// Written: heights that other programs do not see.
    HeightsNotDrawn = "heights-not-drawn": "heights are not drawn; the data beside the places keep them as they are",
    /// Written: items of which the place and the height are all that was kept.
    CommandsNotWritten = "commands-not-written": "items are more than waypoints; their place and height alone were written",
    /// Written: items that the format has no place for.
    ItemsNotWritten = "items-not-written": "items without a place were not written",
    /// Written: home.
    HomeNotWritten = "home-not-written": "the planned home was not written",
    /// Written: zones and the return point of the fence.
    FenceNotWritten = "fence-not-written": "parts of the fence were not written",
    /// Written: rally points.
    RallyNotWritten = "rally-not-written": "rally points were not written",
    /// Written: complex items that were changed.
    ComplexItemsEdited = "complex-items-edited":
        "surveys, landing patterns or other complex items were changed, and are written item by item",
    /// Written: speeds and kind of vehicle that a `.plan` says beside the plan.
    SettingsNotWritten = "settings-not-written": "settings beside the plan (speeds, kind of vehicle) were not written",
}

/// One thing that a file did not say, could not say, or said in vain.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "describe", derive(serde::Serialize, utoipa::ToSchema), schema(as = PlanFileNote))]
pub struct Note {
    /// What.
    pub code: NoteCode,
    /// How many heights, items, areas… it concerns; at least 1.
    pub count: usize,
}

impl std::fmt::Display for Note {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} ({})", self.code.sentence(), self.count)
    }
}

/// Notes while they are gathered: each code once.
#[derive(Debug, Default)]
pub(super) struct Notes(BTreeMap<NoteCode, usize>);

impl Notes {
    /// Adds to the count of a note; no effect for 0.
    pub(super) fn add(&mut self, code: NoteCode, count: usize) {
        if count > 0 {
            *self.0.entry(code).or_default() += count;
        }
    }

    /// The notes in the order of their codes.
    pub(super) fn into_vec(self) -> Vec<Note> {
        self.0.into_iter().map(|(code, count)| Note { code, count }).collect()
    }
}
