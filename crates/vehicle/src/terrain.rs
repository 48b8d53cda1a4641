//! Requests of a vehicle for terrain heights (TERRAIN_REQUEST), and the answers (TERRAIN_DATA). The heights come from
//! the owner.
//!
//! A grid is 28 heights northward by 32 eastward from its south-west corner, asked for in blocks of 4 × 4. Bit n of the
//! mask is the block n % 8 blocks east and n / 8 blocks north of the corner; a block's heights go from its south-west
//! corner eastward first (ArduPilot, AP_Terrain: `grid_bitnum`, `handle_terrain_data`).

use std::collections::VecDeque;

use vencejo_flight::geodesy::wrap_180_deg;
use vencejo_proto::Message;
use vencejo_proto::dialect::{MavMessage, TERRAIN_DATA_DATA, TERRAIN_REQUEST_DATA};

/// Id of TERRAIN_REQUEST.
pub const TERRAIN_REQUEST: u32 = 133;
/// Heights along a side of a block.
const SIDE: u8 = 4;
/// Blocks from west to east in a grid.
const BLOCKS_EAST: u8 = 8;
/// Blocks from one grid to the next, northward and eastward: neighbours share one block.
const ROWS_APART: u8 = 6;
const COLUMNS_APART: u8 = 7;
/// Tolerance of a corner against its lattice, m: ArduPilot's single precision is off by some centimetres.
const SAME_M: f64 = 0.5;
/// The blocks of a whole grid: 8 × 7.
const WHOLE_GRID: u64 = (1 << 56) - 1;
/// Most open grids of one vehicle; the oldest are dropped, and requested again. ArduPilot holds 12
/// (`TERRAIN_GRID_BLOCK_CACHE_SIZE`).
const MAX_GRIDS: usize = 16;
/// Metres in 10⁻⁷ degrees of latitude, on ArduPilot's sphere (`LATLON_TO_M`).
const M_PER_E7: f64 = 0.011_131_884_502_145_034;

/// Length of a degree of longitude over that of one of latitude, as ArduPilot has it (`Location::longitude_scale`).
fn longitude_scale(lat_deg: f64) -> f64 {
    lat_deg.to_radians().cos().max(0.01)
}

/// A block of 4 × 4 heights that a vehicle requests.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TerrainBlock {
    /// South-west corner of its grid, 10⁻⁷ degrees.
    lat_e7: i32,
    lon_e7: i32,
    /// Between neighbouring heights.
    spacing_m: u16,
    /// Number in its grid, 0 to 55.
    bit: u8,
}

impl TerrainBlock {
    /// Latitude and longitude of its heights, degrees, in the order of the answer. They are where ArduPilot reads them:
    /// metres north and east of the whole degree south-west of the grid, a degree of longitude being as long as
    /// half-way north from there (`AP_Terrain::calculate_grid_info`, `Location::get_distance_NE`). Counted from the
    /// grid's own corner they would lie up to 24 m farther east or west. A grid that does not lie on that lattice
    /// counts from its corner.
    pub fn places(&self) -> [(f64, f64); 16] {
        let (lat_deg, lon_deg, north_m, east_m) = self.lattice();
        std::array::from_fn(|index| {
            let (row, column) = (index as u8 / SIDE, index as u8 % SIDE);
            let along = |block: u8, step: u8| f64::from(block * SIDE + step) * f64::from(self.spacing_m);
            let north_deg = (north_m + along(self.bit / BLOCKS_EAST, row)) / M_PER_E7 / 1e7;
            let east_deg = (east_m + along(self.bit % BLOCKS_EAST, column)) / M_PER_E7 / 1e7;
            (lat_deg + north_deg, wrap_180_deg(lon_deg + east_deg / longitude_scale(lat_deg + north_deg / 2.0)))
        })
    }

    /// Where the grid's lattice begins, degrees, and how far north and east of that the grid does, m.
    fn lattice(&self) -> (f64, f64, f64, f64) {
        let (lat_deg, lon_deg) = (f64::from(self.lat_e7) / 1e7, f64::from(self.lon_e7) / 1e7);
        let multiple = |metres: f64, of: u16| {
            let of_m = f64::from(of * u16::from(SIDE)) * f64::from(self.spacing_m);
            Some((metres / of_m).round() * of_m).filter(|near_m| (near_m - metres).abs() < SAME_M)
        };
        // South of the equator the corner of a grid at a degree's eastern edge may lie in the next.
        [lon_deg.floor(), lon_deg.floor() - 1.0]
            .into_iter()
            .find_map(|begin_deg| {
                let south_deg = lat_deg.floor();
                let metres = |degrees: f64| degrees * 1e7 * M_PER_E7;
                let north_m = multiple(metres(lat_deg - south_deg), u16::from(ROWS_APART))?;
                let scale = longitude_scale((south_deg + lat_deg) / 2.0);
                let east_m = multiple(metres(lon_deg - begin_deg) * scale, u16::from(COLUMNS_APART))?;
                Some((south_deg, begin_deg, north_m, east_m))
            })
            .unwrap_or((lat_deg, lon_deg, 0.0, 0.0))
    }

    /// The answer, with heights above mean sea level in the order of [`Self::places`]; `None` when one of them is
    /// unknown or does not fit the message.
    pub fn answer(&self, alt_amsl_m: impl IntoIterator<Item = Option<f64>>) -> Option<Message> {
        let whole = |alt_m: f64| {
            let rounded = alt_m.round();
            (f64::from(i16::MIN)..=f64::from(i16::MAX)).contains(&rounded).then_some(rounded as i16)
        };
        let heights: Option<Vec<i16>> = alt_amsl_m.into_iter().map(|alt_m| alt_m.and_then(whole)).collect();
        Some(Message::Dialect(MavMessage::TERRAIN_DATA(TERRAIN_DATA_DATA {
            lat: self.lat_e7,
            lon: self.lon_e7,
            grid_spacing: self.spacing_m,
            data: heights?.try_into().ok()?,
            gridbit: self.bit,
        })))
    }
}

/// The unanswered terrain requests of one vehicle.
#[derive(Debug, Default)]
pub struct TerrainRequests {
    open: VecDeque<TERRAIN_REQUEST_DATA>,
}

impl TerrainRequests {
    /// Takes in a TERRAIN_REQUEST: its mask is all that the vehicle still lacks of the grid. Other messages, and grids
    /// that are not on Earth, are ignored.
    pub fn ask(&mut self, message: &Message) {
        let Message::Dialect(MavMessage::TERRAIN_REQUEST(asked)) = message else { return };
        let is_place = asked.lat.unsigned_abs() < 900_000_000 && asked.lon.unsigned_abs() <= 1_800_000_000;
        self.open.retain(|open| {
            (open.lat, open.lon, open.grid_spacing) != (asked.lat, asked.lon, asked.grid_spacing) && open.mask != 0
        });
        if !is_place || asked.grid_spacing == 0 {
            return;
        }
        if self.open.len() == MAX_GRIDS {
            self.open.pop_front();
        }
        self.open.push_back(TERRAIN_REQUEST_DATA { mask: asked.mask & WHOLE_GRID, ..*asked });
    }
}

impl Iterator for TerrainRequests {
    type Item = TerrainBlock;

    /// The next block to answer, of the grid that was requested first.
    fn next(&mut self) -> Option<TerrainBlock> {
        while self.open.front().is_some_and(|grid| grid.mask == 0) {
            self.open.pop_front();
        }
        let grid = self.open.front_mut()?;
        let bit = grid.mask.trailing_zeros() as u8;
        grid.mask &= grid.mask - 1;
        Some(TerrainBlock { lat_e7: grid.lat, lon_e7: grid.lon, spacing_m: grid.grid_spacing, bit })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asked(lat: i32, lon: i32, grid_spacing: u16, mask: u64) -> Message {
        Message::Dialect(MavMessage::TERRAIN_REQUEST(TERRAIN_REQUEST_DATA { mask, lat, lon, grid_spacing }))
    }

    fn bits(requests: &mut TerrainRequests) -> Vec<(i32, u8)> {
        requests.map(|block| (block.lat_e7, block.bit)).collect()
    }

    #[test]
    fn every_block_of_the_mask_is_due_once_and_a_new_mask_takes_the_place_of_the_old() {
        let mut requests = TerrainRequests::default();
        requests.ask(&asked(10, 0, 100, 1 | 1 << 9 | 1 << 55 | 1 << 60));
        requests.ask(&asked(20, 0, 100, 2));
        assert_eq!(bits(&mut requests), [(10, 0), (10, 9), (10, 55), (20, 1)]);
        requests.ask(&asked(10, 0, 100, u64::MAX));
        assert_eq!(requests.by_ref().take(2).count(), 2);
        requests.ask(&asked(10, 0, 100, 1 << 40));
        assert_eq!(bits(&mut requests), [(10, 40)]);
    }

    #[test]
    fn what_is_no_grid_is_passed_over_and_the_rest_is_bounded() {
        let mut requests = TerrainRequests::default();
        for (lat, lon, spacing) in
            [(900_000_000, 0, 100), (0, 1_800_000_001, 100), (0, 0, 0), (i32::MIN, i32::MIN, 100)]
        {
            requests.ask(&asked(lat, lon, spacing, 1));
        }
        assert_eq!(bits(&mut requests), []);
        (0..100).for_each(|lat| requests.ask(&asked(lat, 0, 100, 1)));
        assert_eq!(bits(&mut requests).len(), MAX_GRIDS);
    }

    #[test]
    fn places_are_metres_north_and_east_of_the_corner() {
        let corner = (403_000_000, -38_000_000);
        let place = |bit, index: usize| {
            TerrainBlock { lat_e7: corner.0, lon_e7: corner.1, spacing_m: 100, bit }.places()[index]
        };
        assert_eq!(place(0, 0).0, 40.3);
        assert!((place(0, 0).1 + 3.8).abs() < 1e-12);
        // 100 m are 8.983204953 × 10⁻⁴ degrees of latitude; of longitude, divided by the cosine of 40.3°.
        let (lat_deg, lon_deg) = place(0, 1);
        assert_eq!(lat_deg, 40.3);
        assert!((lon_deg + 3.8 - 8.983_204_953e-4 / 40.3_f64.to_radians().cos()).abs() < 1e-12);
        // The last height of the last block: 27 north, 31 east.
        let (lat_deg, lon_deg) = place(55, 15);
        assert!((lat_deg - 40.3 - 27.0 * 8.983_204_953e-4).abs() < 1e-11);
        let scale = (40.3 + 13.5 * 8.983_204_953e-4_f64).to_radians().cos();
        assert!((lon_deg + 3.8 - 31.0 * 8.983_204_953e-4 / scale).abs() < 1e-11);
        let (_, over_the_date_line) =
            TerrainBlock { lat_e7: 0, lon_e7: 1_799_999_999, spacing_m: 100, bit: 7 }.places()[3];
        assert!(over_the_date_line < -179.9);
    }

    /// `AP_Terrain::calculate_grid_info` for a place: the grid's corner as it is sent, and rows and columns in it with
    /// their fractions.
    fn grid_of(lat_e7: i64, lon_e7: i64, spacing_m: f64) -> ((i32, i32), [f64; 2]) {
        let degree = |e7: i64| e7.div_euclid(10_000_000) * 10_000_000;
        let (south, west) = (degree(lat_e7), degree(lon_e7));
        let scale = |e7: i64| (e7 as f64 * 1e-7).to_radians().cos().max(0.01);
        let north_m = (lat_e7 - south) as f64 * M_PER_E7;
        let east_m = (lon_e7 - west) as f64 * M_PER_E7 * scale((lat_e7 + south) / 2);
        let corner = |metres: f64, apart: f64| (metres / spacing_m / apart).floor() * apart * spacing_m;
        let (grid_n, grid_e) = (corner(north_m, 24.0), corner(east_m, 28.0));
        let dlat = (grid_n / M_PER_E7) as i64;
        let dlon = (grid_e / M_PER_E7 / scale(south + dlat / 2)) as i64;
        let at = [(north_m - grid_n) / spacing_m, (east_m - grid_e) / spacing_m];
        (((south + dlat) as i32, (west + dlon) as i32), at)
    }

    #[test]
    fn heights_are_those_of_the_places_where_ardupilot_reads_them() {
        let mut farthest_m: f64 = 0.0;
        for (lat_deg, lon_deg, spacing_m) in [
            (40.999, -3.0005, 100_u16),
            (40.3332, -3.7978, 30),
            (-35.3632, 149.1652, 100),
            (-60.03, 11.999_95, 100),
            (64.9, -21.0001, 100),
            (0.001, 0.001, 200),
        ] {
            let (lat_e7, lon_e7) = ((lat_deg * 1e7) as i64, (lon_deg * 1e7) as i64);
            let (corner, [row, column]) = grid_of(lat_e7, lon_e7, f64::from(spacing_m));
            let place = |row: u8, column: u8| {
                let bit = row / SIDE * BLOCKS_EAST + column / SIDE;
                let block = TerrainBlock { lat_e7: corner.0, lon_e7: corner.1, spacing_m, bit };
                block.places()[usize::from(row % SIDE * SIDE + column % SIDE)]
            };
            // It reads between the four heights around it as if they stood in a square.
            let (south, west) = (row.floor() as u8, column.floor() as u8);
            let (up, right) = (row.fract(), column.fract());
            let mut read = (0.0, 0.0);
            for (weight, row, column) in [
                ((1.0 - up) * (1.0 - right), south, west),
                ((1.0 - up) * right, south, west + 1),
                (up * (1.0 - right), south + 1, west),
                (up * right, south + 1, west + 1),
            ] {
                let (lat, lon) = place(row, column);
                read = (read.0 + weight * (lat - lat_deg), read.1 + weight * (lon - lon_deg));
            }
            let metres = 1e7 * M_PER_E7;
            let off_m = (read.0 * metres).hypot(read.1 * metres * longitude_scale(lat_deg));
            assert!(off_m < 0.1, "{lat_deg} {lon_deg}: {off_m} m");
            let by_corner = TerrainBlock { lat_e7: corner.0 + 1_000, lon_e7: corner.1 + 1_000, spacing_m, bit: 0 };
            farthest_m = farthest_m.max((by_corner.lattice().2 + by_corner.lattice().3).abs());
        }
        assert_eq!(farthest_m, 0.0, "what is none of the lattice counts from its corner");
    }

    #[test]
    fn an_answer_has_all_heights_or_is_none() {
        let block = TerrainBlock { lat_e7: 1, lon_e7: 2, spacing_m: 30, bit: 13 };
        let heights = || (0..16).map(|height| Some(f64::from(height) - 0.6));
        let Some(Message::Dialect(MavMessage::TERRAIN_DATA(data))) = block.answer(heights()) else {
            panic!("all known")
        };
        assert_eq!((data.lat, data.lon, data.grid_spacing, data.gridbit), (1, 2, 30, 13));
        assert_eq!(data.data, [-1, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14]);
        for bad in [None, Some(40_000.0), Some(f64::NAN)] {
            assert_eq!(block.answer(heights().take(15).chain([bad])), None, "{bad:?}");
        }
        assert_eq!(block.answer(heights().take(15)), None);
    }
}
