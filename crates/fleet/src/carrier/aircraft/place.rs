//! An aircraft's membership in its fleet, kept up to date in flight: its certificate, and the list of ground stations
//! whose orders count.

use std::path::PathBuf;
use std::time::Duration;

use tokio::sync::mpsc;
use vencejo_proto::MonoTime;
use zenoh::Session;

use super::super::door::blocking;
use super::super::membership::{self, Membership};
use super::super::network::{self, Replies};
use super::super::unix_now;
use crate::budget::ECHO_LOST;
use crate::key::{Name, stations_key};

/// How often it is checked whether the certificate is to be renewed.
const RENEW_EVERY: Duration = Duration::from_secs(3600);
/// The pause after a vain request for a list: the station that reports a newer number may not have the list.
const ASK_AGAIN: Duration = Duration::from_secs(5);

/// An update of an aircraft's membership.
pub(super) enum Renewed {
    /// A new certificate.
    Certificate(Box<Membership>),
    /// A newer list of ground stations.
    Stations(Vec<u8>),
}

/// Its membership, the file of it, and when to check next.
pub(super) struct Place {
    pub member: Membership,
    file: PathBuf,
    certificate_due: MonoTime,
    stations_due: MonoTime,
}

impl Place {
    pub(super) fn new((member, file): (Membership, PathBuf)) -> Self {
        Self { member, file, certificate_due: MonoTime::ZERO, stations_due: MonoTime::ZERO }
    }

    /// Requests the next certificate in a task of its own, when it is due.
    pub(super) fn renew(&mut self, renewed: &mpsc::Sender<Renewed>, now: MonoTime) {
        if now < self.certificate_due {
            return;
        }
        // At each session: with a clock far ahead a new certificate is always due.
        self.certificate_due = now + RENEW_EVERY;
        if !self.member.facts().is_ok_and(|facts| facts.is_due(unix_now())) {
            return;
        }
        let (member, file, renewed) = (self.member.clone(), self.file.clone(), renewed.clone());
        tokio::spawn(async move {
            match membership::renew(&member, &file).await {
                // Without a receiver the session has ended; the next one begins with what it has, and asks again.
                Ok(member) => drop(renewed.send(Renewed::Certificate(Box::new(member))).await),
                Err(error) => tracing::warn!(%error, "the certificate was not renewed; it is tried again each hour"),
            }
        });
    }

    /// A ground station has the list of this number: requests it in a task of its own when it is newer.
    pub(super) fn on_number(
        &mut self,
        number: u64,
        session: &Session,
        org: &Name,
        renewed: &mpsc::Sender<Renewed>,
        now: MonoTime,
    ) {
        let Ok(have) = self.member.stations().map(|list| list.number) else { return };
        if number <= have || now < self.stations_due {
            return;
        }
        self.stations_due = now + ASK_AGAIN;
        let (session, org, renewed) = (session.clone(), org.clone(), renewed.clone());
        tokio::spawn(async move {
            for list in ask_list(&session, &stations_key(&org), have).await {
                drop(renewed.send(Renewed::Stations(list)).await);
            }
        });
    }

    /// Stores a received list if it is valid and newer; whether it was.
    pub(super) fn take(&mut self, list: Vec<u8>) -> bool {
        match self.member.take(&list) {
            Ok(true) => {}
            Ok(false) => return false,
            Err(error) => {
                tracing::warn!(%error, "a list of ground stations is not taken");
                return false;
            }
        }
        // The next one may be requested at once.
        self.stations_due = MonoTime::ZERO;
        let file = self.file.clone();
        tokio::spawn(async move {
            // A list that is not stored is requested again after the next start.
            if let Err(error) = blocking(move || Membership::keep_stations(&file, &list)).await {
                tracing::warn!(%error, "the list of ground stations was not kept");
            }
        });
        true
    }
}

/// Queries all stations for lists under a key that are newer than this number.
pub(in super::super) async fn ask_list(session: &Session, key: &str, have: u64) -> Vec<Vec<u8>> {
    match network::ask(session, &format!("{key}?have={have}"), Vec::new(), ECHO_LOST).await {
        Replies::Answers(lists) => lists,
        Replies::Nobody | Replies::Silence => Vec::new(),
    }
}
