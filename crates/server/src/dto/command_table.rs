//! Table of the mission commands.

use serde::Serialize;
use utoipa::ToSchema;
use vencejo_flight::plan::Choice;

/// Category of a command.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum CommandCategory {
    /// Navigation command: flown until completed, one at a time.
    Nav,
    /// Delays the commands that follow it.
    Condition,
    /// Carried out at once, while the navigation command continues.
    Do,
    /// Belongs to a fence.
    Fence,
    /// Belongs to a rally list.
    Rally,
}

/// How ArduPlane handles a command.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum CommandSupport {
    /// Stored and carried out.
    Flown,
    /// Carried out by VTOL planes; skipped by others.
    NeedsVtol,
    /// Stored, but skipped in flight.
    Ignored,
    /// Accepted only in fence or rally lists.
    List,
}

/// One parameter of a command.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct CommandParam {
    /// Display name in English; empty when the command does not use the parameter.
    pub label: String,
    /// Unit symbol; empty when there is none.
    pub unit: String,
    /// Smallest sensible value.
    #[schema(required = true)]
    pub min: Option<f64>,
    /// Largest sensible value.
    #[schema(required = true)]
    pub max: Option<f64>,
    /// Default for a new item.
    #[schema(required = true)]
    pub default: Option<f64>,
    /// Named values, when the parameter is an enumeration; empty when it is a number or its values are not known.
    pub choices: &'static [Choice],
}

/// A command of the table.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct CommandInfo {
    /// `MAV_CMD` number.
    pub number: u16,
    /// Name without `MAV_CMD_`.
    pub name: String,
    /// Display name in English.
    pub title: String,
    /// Category of the command.
    pub category: CommandCategory,
    /// How ArduPlane handles it.
    pub support: CommandSupport,
    /// Whether parameters 5 to 7 are latitude, longitude and altitude.
    pub has_position: bool,
    /// Whether a plane flies to that position.
    pub is_destination: bool,
    /// Parameters 1 to 7.
    #[schema(min_items = 7, max_items = 7)]
    pub params: Vec<CommandParam>,
}
