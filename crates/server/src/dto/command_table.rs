//! The commands that a plan can be made of.

use serde::Serialize;
use utoipa::ToSchema;
use vencejo_flight::plan::Choice;

/// What a command is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum CommandCategory {
    /// Flown until done; one at a time.
    Nav,
    /// Holds back the actions that follow it.
    Condition,
    /// Done at once, beside the flying.
    Do,
    /// Part of a fence list.
    Fence,
    /// Part of a rally list.
    Rally,
}

/// What an ArduPlane does with a command.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum CommandSupport {
    /// Stored and done.
    Flown,
    /// Done by a plane that can hover; skipped by others.
    NeedsVtol,
    /// Stored, but skipped in flight.
    Ignored,
    /// Taken in fence or rally lists only.
    List,
}

/// What one parameter of a command means.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct CommandParam {
    /// Name to show, English; empty when the command does not use the parameter.
    pub label: String,
    /// Symbol to show after a value; empty when there is none.
    pub unit: String,
    /// Smallest value that makes sense.
    #[schema(required = true)]
    pub min: Option<f64>,
    /// Largest value that makes sense.
    #[schema(required = true)]
    pub max: Option<f64>,
    /// Value to offer for a new item.
    #[schema(required = true)]
    pub default: Option<f64>,
    /// Its values, where it is one of a few with a meaning each; empty where it is a number, or no list of them is known.
    pub choices: &'static [Choice],
}

/// A command of the table.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct CommandInfo {
    /// `MAV_CMD` number.
    pub number: u16,
    /// Name without `MAV_CMD_`.
    pub name: String,
    /// Name to show, English.
    pub title: String,
    /// What it is for.
    pub category: CommandCategory,
    /// What an ArduPlane does with it.
    pub support: CommandSupport,
    /// Whether parameters 5 to 7 are latitude, longitude and height.
    pub has_position: bool,
    /// Whether a plane flies to that position.
    pub is_destination: bool,
    /// Parameters 1 to 7.
    #[schema(min_items = 7, max_items = 7)]
    pub params: Vec<CommandParam>,
}
