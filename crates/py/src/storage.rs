//! Files and free space for Python: the one way to the disk.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;
use vencejo_server::dto::storage::{StorageFault, StorageProblem};
use vencejo_server::history::{AircraftHistory, HistoryGap};
use vencejo_store::{Access, Class, Floors, Space};

use crate::errors;
use crate::runtime::detached;

/// Adds this module's functions.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(write_file, module)?)?;
    module.add_function(wrap_pyfunction!(create_file, module)?)?;
    module.add_function(wrap_pyfunction!(install_file, module)?)?;
    module.add_function(wrap_pyfunction!(make_folder, module)?)?;
    module.add_function(wrap_pyfunction!(sync_folder, module)?)?;
    module.add_function(wrap_pyfunction!(history_kept, module)?)?;
    module.add_function(wrap_pyfunction!(check_floors_mb, module)?)?;
    module.add_function(wrap_pyfunction!(default_floors_mb, module)?)
}

/// Floors of maps, video and telemetry in MB; the defaults when absent.
pub fn space(floors_mb: Option<(u64, u64, u64)>) -> PyResult<Space> {
    let Some((maps, video, telemetry)) = floors_mb else { return Ok(Space::default()) };
    let floors = Floors::from_mb(maps, video, telemetry).map_err(|error| errors::raise("InvalidRequest", error))?;
    Ok(Space::new(floors))
}

/// Numbers that are missing: boot, stream, first and last, and whether they are not to be had.
type Gap = (String, String, u64, u64, bool);
/// What is kept of an aircraft: its name; name and size of each file; how many records of each stream; what is missing,
/// where that is noted; why that is not known.
type Kept = (String, Vec<(String, u64)>, BTreeMap<String, u64>, Option<Vec<Gap>>, Option<String>);

/// The history archives in a folder.
#[pyfunction]
fn history_kept(py: Python<'_>, folder: PathBuf) -> PyResult<Vec<Kept>> {
    let kept = detached(py, || vencejo_server::history::in_folder("", &folder))?;
    let of = |aircraft: AircraftHistory| {
        let files = aircraft.files.into_iter().map(|file| (file.name, file.bytes)).collect();
        let gap = |gap: HistoryGap| (gap.boot, gap.stream, gap.first, gap.last, gap.is_lost);
        let gaps = aircraft.gaps.map(|gaps| gaps.into_iter().map(gap).collect());
        (aircraft.name, files, aircraft.records, gaps, aircraft.problem)
    };
    Ok(kept.into_iter().map(of).collect())
}

/// What, of which camera or map source, kind of fault, in words.
pub type Problem = (String, Option<String>, String, String);

/// A problem for Python.
pub fn problem(problem: &StorageProblem) -> Problem {
    let what = serde_name(&problem.what);
    let kind = match problem.fault {
        StorageFault::LowSpace { .. } => "low_space",
        StorageFault::Unwritable { .. } => "unwritable",
        StorageFault::Unreadable { .. } => "unreadable",
        StorageFault::Stalled => "stalled",
        StorageFault::SetAside { .. } => "set_aside",
        StorageFault::Ended { .. } => "ended",
    };
    (what.to_owned(), problem.name.clone(), kind.to_owned(), problem.text.clone())
}

const fn serde_name(what: &vencejo_server::dto::storage::StorageClass) -> &'static str {
    use vencejo_server::dto::storage::StorageClass;
    match what {
        StorageClass::Telemetry => "telemetry",
        StorageClass::Maps => "maps",
        StorageClass::Missions => "missions",
        StorageClass::Video => "video",
        StorageClass::Draft => "draft",
        StorageClass::Tokens => "tokens",
        StorageClass::Signing => "signing",
        StorageClass::SigningTimes => "signing_times",
    }
}

/// Writes a file as a whole, in the place of one that may be there.
#[pyfunction]
fn write_file(py: Python<'_>, path: PathBuf, data: Vec<u8>) -> PyResult<()> {
    detached(py, || vencejo_store::write(&path, &data, Access::Usual)).map_err(|error| raise(error, &path))
}

/// Creates a file atomically; false if one of that name exists.
#[pyfunction]
fn create_file(py: Python<'_>, path: PathBuf, data: Vec<u8>) -> PyResult<bool> {
    detached(py, || vencejo_store::create(&path, &data, Access::Usual)).map_err(|error| raise(error, &path))
}

/// Puts a finished file under its name, in the place of one that may be there.
#[pyfunction]
fn install_file(py: Python<'_>, temporary: PathBuf, path: PathBuf) -> PyResult<()> {
    detached(py, || vencejo_store::install(&temporary, &path)).map_err(|error| raise(error, &path))
}

/// Makes a folder that survives a power cut.
#[pyfunction]
fn make_folder(py: Python<'_>, path: PathBuf) -> PyResult<()> {
    detached(py, || vencejo_store::make_folder(&path)).map_err(|error| raise(error, &path))
}

/// Makes the names in a folder durable.
#[pyfunction]
fn sync_folder(py: Python<'_>, path: PathBuf) -> PyResult<()> {
    detached(py, || vencejo_store::sync_folder(&path)).map_err(|error| raise(error, &path))
}

/// Refuses floors of maps, video and telemetry that are out of range or in the wrong order.
#[pyfunction]
fn check_floors_mb(floors_mb: (u64, u64, u64)) -> PyResult<()> {
    space(Some(floors_mb)).map(drop)
}

/// Free space below which maps, video and telemetry are not written, MB.
#[pyfunction]
fn default_floors_mb() -> (u64, u64, u64) {
    let mb = |class| Floors::default().bytes(class) / 1_000_000;
    (mb(Class::Maps), mb(Class::Video), mb(Class::Telemetry))
}

/// As Python's own file functions raise it.
fn raise(error: std::io::Error, path: &Path) -> PyErr {
    match error.raw_os_error() {
        Some(number) => {
            // The number is said by Python itself.
            let text = error.to_string();
            let text = text.split(" (os error").next().unwrap_or_default().to_owned();
            PyOSError::new_err((number, text, path.display().to_string()))
        }
        None => PyOSError::new_err(error.to_string()),
    }
}
