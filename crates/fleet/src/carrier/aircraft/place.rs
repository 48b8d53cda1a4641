//! An aircraft's place in its fleet, kept new while it flies: its certificate, and the list of ground stations whose orders count.

use std::path::PathBuf;
use std::time::Duration;

use tokio::sync::mpsc;
use vencejo_proto::MonoTime;
use zenoh::Session;

use super::super::door::blocking;
use super::super::membership::{self, Membership};
use super::super::network::{self, Heard};
use super::super::unix_now;
use crate::budget::ECHO_LOST;
use crate::key::{Name, stations_key};

/// How often it is looked whether the certificate is to be renewed.
const RENEW_EVERY: Duration = Duration::from_secs(3600);
/// How long after a list was asked for in vain it is asked for again: who tells of a newer one may not have it.
const ASK_AGAIN: Duration = Duration::from_secs(5);

/// What is new of an aircraft's place.
pub(super) enum Renewed {
    /// It has another certificate.
    Certificate(Box<Membership>),
    /// Somebody has a newer list of ground stations.
    Stations(Vec<u8>),
}

/// Its place, with the file that has it, and when what is looked at next.
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

    /// Gets the next certificate, where it is time, aside.
    pub(super) fn renew(&mut self, renewed: &mpsc::Sender<Renewed>, now: MonoTime) {
        if now < self.certificate_due {
            return;
        }
        // From session to session: where the clock is far ahead, a new certificate is due as well.
        self.certificate_due = now + RENEW_EVERY;
        if !self.member.facts().is_ok_and(|facts| facts.is_due(unix_now())) {
            return;
        }
        let (member, file, renewed) = (self.member.clone(), self.file.clone(), renewed.clone());
        tokio::spawn(async move {
            match membership::renew(&member, &file).await {
                // Without a reader the session is at its end; the next one begins with what it has, and asks again.
                Ok(member) => drop(renewed.send(Renewed::Certificate(Box::new(member))).await),
                Err(error) => tracing::warn!(%error, "the certificate was not renewed; it is tried again each hour"),
            }
        });
    }

    /// A ground station has the list of this number: a newer one is asked for, aside.
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

    /// Takes a list that somebody brought, and keeps it, where it is good and newer; whether it was.
    pub(super) fn take(&mut self, list: Vec<u8>) -> bool {
        match self.member.take(&list) {
            Ok(true) => {}
            Ok(false) => return false,
            Err(error) => {
                tracing::warn!(%error, "a list of ground stations is not taken");
                return false;
            }
        }
        // The next may come at once.
        self.stations_due = MonoTime::ZERO;
        let file = self.file.clone();
        tokio::spawn(async move {
            // What is not kept is asked for again after the next start.
            if let Err(error) = blocking(move || Membership::keep_stations(&file, &list)).await {
                tracing::warn!(%error, "the list of ground stations was not kept");
            }
        });
        true
    }
}

/// The lists under a key that are newer than one of this number, of all who have one.
pub(in super::super) async fn ask_list(session: &Session, key: &str, have: u64) -> Vec<Vec<u8>> {
    match network::ask(session, &format!("{key}?have={have}"), Vec::new(), ECHO_LOST).await {
        Heard::Answers(lists) => lists,
        Heard::Nobody | Heard::Silence => Vec::new(),
    }
}
