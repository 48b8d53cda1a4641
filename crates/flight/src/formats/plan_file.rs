//! What a plan file holds, whatever its format.

use crate::plan::Plan;

/// How a plan is written to a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PlanFormat {
    /// `.plan`: JSON of QGroundControl, version 1. Mission, fence and rally. `.mission`, its ancestor, is read.
    QgcPlan,
    /// `.waypoints`, `.txt`: "QGC WPL 110", tab-separated. Mission, fence or rally.
    Waypoints,
    /// `.fen`, `.ral`, `.txt`: a line for each point. Fence or rally of older programs; read, never written.
    Points,
}

/// What a plan file says beside the plan. QGroundControl plans for these; no vehicle is told.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PlanSettings {
    /// Speed to plan times with, metres per second (airspeed of a plane).
    pub cruise_speed_m_s: Option<f64>,
    /// Speed of a vehicle that hovers, metres per second.
    pub hover_speed_m_s: Option<f64>,
    /// `MAV_TYPE`; 1 is a fixed-wing plane.
    pub vehicle_type: Option<u8>,
    /// `MAV_AUTOPILOT`; 3 is ArduPilot.
    pub firmware_type: Option<u8>,
}

/// A plan as read from a file.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanFile {
    /// The plan.
    pub plan: Plan,
    /// What the file says beside it.
    pub settings: PlanSettings,
    /// How it was written.
    pub format: PlanFormat,
}
