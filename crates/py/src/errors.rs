//! One table from the core's errors to the exceptions of `vencejo.errors`.

use pyo3::call::PyCallArgs;
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use vencejo_flight::plan::Command;
use vencejo_station::{SigningError, StationError};
use vencejo_vehicle::VehicleError;
use vencejo_vehicle::transfer::TransferError;

/// Adds the functions of this module.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(error_classes, module)?)?;
    module.add_function(wrap_pyfunction!(error_examples, module)?)
}

/// Names of the exceptions that this module raises; a test looks each up in `vencejo.errors`.
const CLASSES: &[&str] = &[
    "Busy",
    "Cancelled",
    "ClosedError",
    "CommandRefused",
    "CommandTimeout",
    "ConfirmationNeeded",
    "ControlHeld",
    "FileFormatError",
    "InvalidLink",
    "InvalidRequest",
    "LinkError",
    "NoVehicleError",
    "NotPossibleNow",
    "ParameterError",
    "PlanMismatch",
    "TransferError",
    "VehicleLost",
    "VencejoError",
];

#[pyfunction]
fn error_classes() -> Vec<&'static str> {
    CLASSES.to_vec()
}

/// One exception for each kind of error of the core, by the kind's name: what the tests walk.
#[pyfunction]
fn error_examples(py: Python<'_>) -> Vec<(String, Py<PyAny>)> {
    let name = |error: &StationError| {
        let kind = |debug: String| debug.split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default().to_owned();
        match error {
            StationError::Vehicle(VehicleError::Transfer(error)) => format!("Transfer.{}", kind(format!("{error:?}"))),
            StationError::Vehicle(error) => format!("Vehicle.{}", kind(format!("{error:?}"))),
            StationError::Signing(error) => format!("Signing.{}", kind(format!("{error:?}"))),
            error => format!("Station.{}", kind(format!("{error:?}"))),
        }
    };
    let examples = StationError::examples();
    examples.iter().map(|error| (name(error), from_station(error).into_value(py).into_any())).collect()
}

/// The exception of `vencejo.errors` with this name and message.
pub fn raise(class: &str, message: impl std::fmt::Display) -> PyErr {
    let message = message.to_string();
    Python::attach(|py| raise_with(py, class, (message,)))
}

fn raise_with<'py>(py: Python<'py>, class: &str, args: impl PyCallArgs<'py>) -> PyErr {
    debug_assert!(CLASSES.contains(&class), "{class} is missing in CLASSES");
    let exception = py.import("vencejo.errors").and_then(|errors| errors.getattr(class)?.call1(args));
    exception.map_or_else(|error| error, PyErr::from_value)
}

/// The exception for an error of the station.
pub fn from_station(error: &StationError) -> PyErr {
    match error {
        StationError::Vehicle(error) => from_vehicle(error),
        StationError::Address(_) => raise("InvalidLink", error),
        StationError::Link(_) => raise("LinkError", error),
        StationError::NoVehicle { .. } => raise("NoVehicleError", error),
        StationError::Closed | StationError::Dismissed => raise("ClosedError", error),
        StationError::Signing(kind) => raise(
            match kind {
                SigningError::BadName { .. } | SigningError::NameTaken { .. } | SigningError::NoSuchKey { .. } => {
                    "InvalidRequest"
                }
                SigningError::Busy => "Busy",
                SigningError::Unproven => "CommandTimeout",
                SigningError::Storage { .. } | SigningError::NoFolder => "VencejoError",
                _ => "NotPossibleNow",
            },
            error,
        ),
        StationError::Control { holder, .. } => {
            Python::attach(|py| raise_with(py, "ControlHeld", (error.to_string(), holder.as_str())))
        }
        StationError::NeedsConfirmation { challenge } => {
            let code = challenge.danger.code();
            let text = format!("{error} by confirm='{code}'");
            Python::attach(|py| raise_with(py, "ConfirmationNeeded", (text, code)))
        }
        StationError::BadConfirmation => raise("ConfirmationNeeded", error),
        StationError::BadRecording { .. } => raise("FileFormatError", error),
        StationError::TooManyReplays | StationError::TooManyVehicles => raise("Busy", error),
        StationError::RemoteRefused { .. } | StationError::Replayed { .. } => raise("NotPossibleNow", error),
        _ => raise("VencejoError", error),
    }
}

/// A command by its name, else by its number.
fn name_of(command: Command) -> String {
    if command.name().is_some() { command.to_string() } else { command.0.to_string() }
}

fn tuple<T: AsRef<str>>(py: Python<'_>, texts: &[T]) -> Py<PyAny> {
    PyTuple::new(py, texts.iter().map(AsRef::as_ref)).map_or_else(|_| py.None(), |texts| texts.into_any().unbind())
}

fn from_vehicle(error: &VehicleError) -> PyErr {
    match error {
        VehicleError::CommandRefused { command, result, reasons, cure, .. } => Python::attach(|py| {
            let told = tuple(py, reasons);
            let result_name = result.name().trim_start_matches("MAV_RESULT_");
            let cure = cure.map(|mode| mode.to_string());
            let facts = (error.to_string(), name_of(*command), result_name, told, cure, tuple(py, &error.remedies()));
            raise_with(py, "CommandRefused", facts)
        }),
        VehicleError::CommandTimeout { command, reasons, .. } | VehicleError::NotConfirmed { command, reasons, .. } => {
            Python::attach(|py| {
                raise_with(py, "CommandTimeout", (error.to_string(), name_of(*command), tuple(py, reasons)))
            })
        }
        VehicleError::MessageNotReceived { .. } => raise("CommandTimeout", error),
        VehicleError::CommandBusy { .. } | VehicleError::TransferBusy { .. } | VehicleError::TooManyRequests { .. } => {
            raise("Busy", error)
        }
        VehicleError::Transfer(transfer) => from_transfer(transfer),
        VehicleError::UnknownMode(_)
        | VehicleError::NoModeFor { .. }
        | VehicleError::InvalidValue { .. }
        | VehicleError::Plan(_)
        | VehicleError::TooOld { .. } => raise("InvalidRequest", error),
        VehicleError::PlanUnknown { .. }
        | VehicleError::OutOfReach { .. }
        | VehicleError::HomeUnknown
        | VehicleError::Armed { .. }
        | VehicleError::InTheAir { .. }
        | VehicleError::NotFlying { .. }
        | VehicleError::Landing { .. } => raise("NotPossibleNow", error),
        VehicleError::NotHeard { .. } | VehicleError::Rebooted => raise("VehicleLost", error),
        VehicleError::Cancelled => raise("Cancelled", error),
        _ => raise("VencejoError", error),
    }
}

fn from_transfer(error: &TransferError) -> PyErr {
    match error {
        TransferError::NotAsSent { differences, .. } => Python::attach(|py| {
            let lines: Vec<String> = differences.iter().map(ToString::to_string).collect();
            let lines = PyTuple::new(py, lines).map_or_else(|_| py.None(), |lines| lines.into_any().unbind());
            raise_with(py, "PlanMismatch", (error.to_string(), lines))
        }),
        TransferError::Cancelled => raise("Cancelled", error),
        TransferError::UnknownParam { .. }
        | TransferError::ParamRefused { .. }
        | TransferError::ParamNotKept { .. }
        | TransferError::Param(_) => raise("ParameterError", error),
        TransferError::Item(_) | TransferError::BadList { .. } | TransferError::OnlyMission { .. } => {
            raise("InvalidRequest", error)
        }
        _ => raise("TransferError", error),
    }
}
