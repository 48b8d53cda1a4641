//! Positions that somebody in ROS 2 wants a plane to fly to, as long as this lives.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::mpsc;
use vencejo_proto::MonoTime;
use vencejo_station::VehicleHandle;
use vencejo_vehicle::telemetry::Telemetry;
use zenoh::Session;
use zenoh::pubsub::Subscriber;
use zenoh::sample::Sample;

use super::acts::{Acting, READS};
use crate::carrier::network;
use crate::error::FleetError;
use crate::ros2::cdr::Cdr;
use crate::ros2::message::GeoPoseStamped;
use crate::ros2::setpoint::{Stream, TOPIC, Target, barred_by};
use crate::ros2::token::Attachment;

/// The positions for one plane.
pub(super) struct Setpoints {
    acting: Arc<Acting>,
    heard: Arc<Mutex<Heard>>,
    lines: mpsc::Sender<(bool, String)>,
    _subscriber: Subscriber<()>,
}

#[derive(Default)]
struct Heard {
    /// The newest message that was not looked at yet.
    newest: Option<Vec<u8>>,
    stream: Stream,
}

fn locked(heard: &Mutex<Heard>) -> MutexGuard<'_, Heard> {
    heard.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Puts what there is to say in the log. Nobody has to read it.
fn say(lines: &mpsc::Sender<(bool, String)>, vehicle: &VehicleHandle, said: Option<(bool, String)>) {
    if let Some((is_good, words)) = said {
        let line = format!("{TOPIC}: {words}");
        tracing::info!(vehicle = %vehicle.id(), line, "wanted by ROS 2");
        let _ = lines.try_send((is_good, line));
    }
}

impl Setpoints {
    /// Listens.
    pub(super) async fn declare(
        session: &Session,
        key: String,
        acting: Arc<Acting>,
        lines: mpsc::Sender<(bool, String)>,
    ) -> Result<Self, FleetError> {
        let heard = Arc::new(Mutex::new(Heard::default()));
        let newest = heard.clone();
        // Never waits: a thread of the network calls.
        let on_sample = move |sample: Sample| {
            // What does not say who sends it is nobody of ROS.
            let attachment = sample.attachment().map(|bytes| bytes.to_bytes().into_owned());
            if attachment.as_deref().and_then(Attachment::read).is_some() {
                locked(&newest).newest = Some(sample.payload().to_bytes().into_owned());
            }
        };
        let subscriber = session.declare_subscriber(key).callback(on_sample).await.map_err(network::failed)?;
        Ok(Self { acting, heard, lines, _subscriber: subscriber })
    }

    /// Looks at the newest position, and has the plane fly there where that is due.
    pub(super) fn go_on(&self, vehicle: &VehicleHandle, telemetry: &Telemetry, now: MonoTime) {
        let barred = if self.acting.is_operator() { barred_by(telemetry, now) } else { Some(READS.to_owned()) };
        let mut heard = locked(&self.heard);
        if barred.is_some() {
            heard.stream.left();
        }
        if let Some(bytes) = heard.newest.take() {
            let target = match (GeoPoseStamped::from_bytes(&bytes), barred) {
                (_, Some(why)) => Err(why),
                (read, None) => read.map(|message| Target::of(&message)).map_err(|error| error.to_string()),
            };
            say(&self.lines, vehicle, heard.stream.on_target(target));
        }
        let Some(target) = heard.stream.due(now) else { return };
        drop(heard);
        let (heard, lines, of) = (self.heard.clone(), self.lines.clone(), vehicle.clone());
        self.acting.start(vehicle, target.request(), move |end| {
            let said = locked(&heard).stream.ended(end);
            say(&lines, &of, said);
        });
    }
}
