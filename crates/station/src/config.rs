//! The settings of a station.

use std::collections::BTreeMap;
use std::path::PathBuf;

use vencejo_proto::{Address, ComponentId, SystemId};
use vencejo_store::Space;
use vencejo_vehicle::MessageRate;
use vencejo_vehicle::streams::StreamConfig;

use crate::error::StationError;

/// A station's settings.
#[derive(Debug, Clone, PartialEq)]
pub struct StationConfig {
    /// Our address: 255/190 on the ground; on board the vehicle's system id and component 191 (to 194).
    pub address: Address,
    /// Whether to send our heartbeat each second. The vehicle's ground-station failsafe counts it: on board it comes
    /// from the system id that an ArduPilot counts (`MAV_GCS_SYSID`, 255 until that is read), and our component.
    pub heartbeat: bool,
    /// How often each vehicle is asked to send its state, Hz, 4 to 50.
    pub rate_hz: f64,
    /// Other rates for single messages, by message id, Hz.
    pub message_rates: BTreeMap<u32, f64>,
    /// Whether to ask for message rates at all. If not, only our heartbeat is sent to a vehicle until a request is
    /// made.
    pub request_streams: bool,
    /// Name of the operator in whose name the program acts.
    pub operator: String,
    /// Where to record; `None` records nothing.
    pub record_dir: Option<PathBuf>,
    /// Folder in which the knowledge of the missions on board is kept between runs, a small file per vehicle; `None`
    /// keeps none.
    pub missions_dir: Option<PathBuf>,
    /// How much of the disk stays free.
    pub space: Space,
    /// Where signing keys are kept; `None` keeps none, and no vehicle is asked to sign.
    pub signing_dir: Option<PathBuf>,
}

impl Default for StationConfig {
    fn default() -> Self {
        Self {
            address: Address { system: SystemId::GROUND_STATION, component: ComponentId::GROUND_STATION },
            heartbeat: true,
            rate_hz: 10.0,
            message_rates: BTreeMap::new(),
            request_streams: true,
            operator: "program".into(),
            record_dir: None,
            missions_dir: None,
            space: Space::default(),
            signing_dir: None,
        }
    }
}

impl StationConfig {
    /// What vehicles are asked to send.
    pub(crate) fn streams(&self) -> Result<StreamConfig, StationError> {
        if !self.request_streams {
            return Ok(StreamConfig::listen_only());
        }
        let mut streams = StreamConfig::new(self.rate_hz)?;
        for (message_id, rate_hz) in &self.message_rates {
            streams.set_rate(*message_id, MessageRate::Hz(*rate_hz))?;
        }
        Ok(streams)
    }
}
