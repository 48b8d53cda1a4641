//! The ground of rehearsals for Python: heights of files, and of anything that can be called with a place.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

use pyo3::prelude::*;
use vencejo_flight::ground::{GroundMap, Square, SquareId, squares_around};
use vencejo_flight::plan::{Home, Plan};
use vencejo_maps::kinds::dem::Dem;
use vencejo_maps::live::HeightFile;

use crate::errors;

/// Heights of a file, or of a folder of files.
#[pyclass(frozen, module = "vencejo._native")]
pub struct Elevation {
    dem: Dem,
}

#[pymethods]
impl Elevation {
    #[new]
    fn new(py: Python<'_>, path: PathBuf, below_sea_level: bool) -> PyResult<Self> {
        let dem = py.detach(|| Dem::open(&path, below_sea_level)).map_err(|error| {
            // Its own faults name the file where it is one of a folder.
            errors::raise("FileFormatError", format!("{}: {error}", path.display()))
        })?;
        Ok(Self { dem })
    }

    fn __call__(&self, py: Python<'_>, lat_deg: f64, lon_deg: f64) -> PyResult<Option<f64>> {
        py.detach(|| self.dem.height(lat_deg, lon_deg))
            .map(|height| height.map(|height| height.alt_m))
            .map_err(|error| errors::raise("FileFormatError", error))
    }
}

/// The ground around a plan, by calling for each height of it; without anything to call none is known.
pub fn around(ground: Option<&Bound<'_, PyAny>>, plan: &Plan, home: Option<Home>) -> PyResult<GroundMap> {
    let Some(ground) = ground else { return Ok(GroundMap::default()) };
    let ids = squares_around(plan, home);
    let mut squares: HashMap<SquareId, Arc<Square>> = HashMap::new();
    for id in &ids {
        // So that Ctrl-C works while a slow one is called.
        ground.py().check_signals()?;
        let heights = id.places().map(|place| ground.call1(place)?.extract::<Option<f64>>());
        squares.insert(*id, Arc::new(Square::new(heights.collect::<PyResult<Vec<_>>>()?)));
    }
    Ok(GroundMap::new(&ids, |id| squares.get(&id).cloned()))
}
