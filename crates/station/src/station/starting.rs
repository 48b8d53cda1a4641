//! The start of a station: its clock, recorder, keys and records, and the receiver of its links.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU64};
use std::sync::{Arc, Mutex};

use tokio::runtime::Handle;
use tokio::sync::watch;
use vencejo_link::{Clock, Folder, Hub, Origin, Recorder, RecorderConfig, SinkScope, SystemClock};
use vencejo_proto::Frame;
use vencejo_store::Class;
use vencejo_vehicle::{VehicleConfig, Vehicles};

use super::driving::{drive, keep_keys};
use super::shared::{Core, Owned, Shared, Station};
use crate::config::StationConfig;
use crate::control::Control;
use crate::error::StationError;
use crate::namesake::Namesake;
use crate::records::{self, Records};
use crate::signing::Vault;
use crate::subscriptions::Subscriptions;

impl Station {
    /// Starts a station without links on a tokio runtime.
    ///
    /// # Errors
    /// [`StationError::Vehicle`] for a rate out of range, [`StationError::CannotRecord`] when the recorder cannot be
    /// started.
    pub fn start(config: StationConfig, runtime: Handle) -> Result<Self, StationError> {
        let _guard = runtime.enter();
        Self::with_clock(config, runtime.clone(), Arc::new(SystemClock::new()))
    }

    /// Starts a station with a clock of the caller.
    ///
    /// # Errors
    /// As [`Self::start`].
    pub fn with_clock(config: StationConfig, runtime: Handle, clock: Arc<dyn Clock>) -> Result<Self, StationError> {
        let hub = Hub::new(vec![config.address], clock.clone());
        let vehicle_config = VehicleConfig {
            streams: config.streams()?,
            // Two runs of the program must not share MAVFTP session numbers.
            seed: clock.unix_us() as u32,
            // A station that only listens sends nothing by itself.
            reads_back: config.request_streams,
            only_listens: !config.request_streams,
            keeps_records: config.missions_dir.is_some(),
            ..VehicleConfig::default()
        };
        let start = |dir: &PathBuf| {
            let free_floor_bytes = config.space.floors().bytes(Class::Telemetry);
            let folder = Folder::new(dir).with_space(config.space.clone());
            let limits = RecorderConfig { free_floor_bytes, ..RecorderConfig::default() };
            Recorder::start_with(Box::new(folder), limits, clock.clone())
        };
        let recorder = config.record_dir.as_ref().map(start).transpose();
        let recorder = recorder.map_err(|error| StationError::CannotRecord { reason: error.to_string() })?;
        hub.set_recorder(recorder.as_ref().map(Recorder::handle));
        let remembered = config.missions_dir.as_deref().map(records::read_all).unwrap_or_default();
        let health = watch::channel(recorder.as_ref().map(Recorder::status)).0;
        // Unreadable keys do not prevent flying; the fault is reported.
        let vault = config.signing_dir.as_deref().map(|dir| Vault::open(dir, &hub)).transpose();
        let (vault, vault_fault) = match vault {
            Ok(vault) => (vault, None),
            Err(error) => {
                tracing::error!(%error, "nothing is signed, and nothing is checked");
                (None, Some(error))
            }
        };
        let control = Control::default();
        let operator = Arc::new(control.enlist(&config.operator, clock.now()).yielding());
        // It is present for as long as the station.
        operator.attach(clock.now());
        let shared = Arc::new(Shared {
            health,
            networks: watch::channel(Vec::new()).0,
            control,
            operator,
            confirmations: Mutex::default(),
            runtime: runtime.clone(),
            core: Mutex::new(Core {
                vehicles: Vehicles::new(config.address, vehicle_config),
                remembered,
                requests: HashMap::new(),
                ended: Vec::new(),
                waiting: Vec::new(),
                next_waiting: 0,
                watchers: HashMap::new(),
                adopted: HashMap::new(),
                subscriptions: Subscriptions::default(),
                namesake: Namesake::default(),
            }),
            heartbeat: AtomicBool::new(config.heartbeat),
            driver_alarm_us: AtomicU64::new(0),
            wake_driver: tokio::sync::Notify::new(),
            closing: watch::channel(false).0,
            vault,
            vault_fault,
            owned: Mutex::new(Owned { recorder, ..Owned::default() }),
            records: Mutex::new(None),
            replays: Mutex::default(),
            hub,
            clock,
            config,
        });
        let sink = {
            // The hub must not keep the station alive.
            let shared = Arc::downgrade(&shared);
            Arc::new(move |origin: Origin, frame: &Frame, now| {
                if let Some(shared) = shared.upgrade() {
                    shared.on_frame(origin, frame, now);
                }
            })
        };
        shared.hub.add_sink(SinkScope::All, sink);
        let weak = Arc::downgrade(&shared);
        shared.hub.set_on_read(Arc::new(move || {
            if let Some(shared) = weak.upgrade() {
                shared.on_read();
            }
        }));
        let weak = Arc::downgrade(&shared);
        shared.hub.set_on_open(Arc::new(move |link| {
            if let Some(shared) = weak.upgrade() {
                shared.on_link_open(link);
            }
        }));
        if let Some(folder) = shared.config.missions_dir.clone() {
            let weak = Arc::downgrade(&shared);
            let started = Records::start(folder, move |system, ticket| {
                if let Some(shared) = weak.upgrade() {
                    shared.on_kept(system, ticket);
                }
            });
            match started {
                Ok(records) => *shared.records() = Some(records),
                Err(error) => tracing::error!(%error, "what is known of missions cannot be written down"),
            }
        }
        let driver = runtime.spawn(drive(Arc::downgrade(&shared), shared.closing.subscribe()));
        shared.owned().driver = Some(driver);
        if shared.vault.is_some() {
            let keeper = runtime.spawn(keep_keys(Arc::downgrade(&shared), shared.closing.subscribe()));
            shared.owned().keeper = Some(keeper);
        }
        Ok(Self { shared })
    }
}
