//! How a ground station joins the network, and what is to hold there: where it dials, what it shows, whom it lets in, and the list of
//! ground stations that it has.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use serde_json::Value;
use tokio::sync::Notify;
use zenoh::Session;

use super::super::door::{self, Door, blocking};
use super::super::endpoint::Endpoint;
use super::super::membership::{self, Membership};
use super::super::network::{self, Part};
use super::super::organisation::Organisation;
use super::super::unix_now;
use crate::error::FleetError;
use crate::papers::certificate::Identity;
use crate::signature::Signer;

/// How often a certificate that is due is asked for.
const RENEW_EVERY: Duration = Duration::from_secs(3600);

/// What a ground station has of its fleet.
#[derive(Debug, Clone, Default)]
pub enum Standing {
    /// Nothing: it is in the clear.
    #[default]
    Alone,
    /// The authority.
    Authority(Organisation),
    /// A place, in a file, by a token of the one that has the authority.
    Member(PathBuf),
}

/// How the network is joined, each time.
pub(super) struct Network {
    /// Where it is the router; else the routers that it was told to dial, and none for those of the list.
    pub given: Vec<Endpoint>,
    pub is_router: bool,
    pub standing: Standing,
    /// When a certificate was asked for last.
    asked: Mutex<Option<Instant>>,
}

/// What others are shown, and what a router lets them do: when it changes, the network is joined anew.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Terms {
    pub endpoints: Vec<Endpoint>,
    identity: Option<Identity>,
    access: Option<Value>,
}

/// A list of ground stations as it is signed, and its number.
pub(super) type List = Arc<(u64, Vec<u8>)>;

impl Network {
    pub(super) fn new(given: Vec<Endpoint>, is_router: bool, standing: Standing) -> Self {
        Self { given, is_router, standing, asked: Mutex::default() }
    }

    /// What is to hold now; and the list of ground stations, where it is not the one of this number.
    pub(super) async fn look(&self, have: u64) -> Result<(Terms, Option<List>), FleetError> {
        let (given, is_router) = (self.given.clone(), self.is_router);
        match self.standing.clone() {
            Standing::Alone => Ok((Terms { endpoints: given, ..Terms::default() }, None)),
            Standing::Authority(organisation) => {
                blocking(move || {
                    let access = if is_router { Some(organisation.access()?) } else { None };
                    let identity = Some(organisation.identity(unix_now())?);
                    let number = organisation.roll()?.number;
                    let list = if number == have { None } else { Some((number, organisation.stations()?).into()) };
                    Ok((Terms { endpoints: given, identity, access }, list))
                })
                .await
            }
            Standing::Member(file) => {
                let (path, none) = (file.clone(), format!("{}", file.display()));
                let member = blocking(move || Membership::read(&path)).await?.ok_or_else(|| FleetError::File {
                    path: none,
                    problem: "it is gone: join the fleet again with a new token".into(),
                })?;
                let member = self.renewed(member, &file).await;
                let endpoints = if given.is_empty() { member.routers()? } else { given };
                let number = member.stations()?.number;
                let list = if number == have { None } else { Some((number, member.signed_stations()?).into()) };
                Ok((Terms { endpoints, identity: Some(member.identity()), access: None }, list))
            }
        }
    }

    /// A place with its next certificate, where it is time and somebody gives it.
    async fn renewed(&self, member: Membership, file: &std::path::Path) -> Membership {
        if !member.facts().is_ok_and(|facts| facts.is_due(unix_now())) {
            return member;
        }
        {
            let mut asked = self.asked.lock().unwrap_or_else(PoisonError::into_inner);
            if asked.is_some_and(|asked| asked.elapsed() < RENEW_EVERY) {
                return member;
            }
            *asked = Some(Instant::now());
        }
        match membership::renew(&member, file).await {
            Ok(renewed) => renewed,
            Err(error) => {
                tracing::warn!(%error, "the certificate was not renewed; it is tried again each hour");
                member
            }
        }
    }

    pub(super) async fn open(&self, terms: &Terms) -> Result<Session, FleetError> {
        let identity = terms.identity.as_ref();
        match terms.endpoints.first() {
            Some(listen) if self.is_router => {
                network::open(Part::Router(listen, terms.access.as_ref()), identity).await
            }
            _ => network::dial(&terms.endpoints, identity).await,
        }
    }

    /// Opens the door, and takes note of where others find it and the router, and of our key.
    pub(super) async fn open_door(
        &self,
        organisation: &Organisation,
        address: &str,
        signer: &Signer,
        news: &Arc<Notify>,
    ) -> Result<(Door, String), FleetError> {
        let (listener, at) = door::listen(address).await?;
        let (noted, given, is_router) = (organisation.clone(), self.given.clone(), self.is_router);
        let operator = signer.public().to_string();
        blocking(move || {
            let routers = given.iter().map(|endpoint| noted.routers(endpoint, !is_router));
            let routers: Vec<_> = routers.collect::<Result<Vec<_>, _>>()?.concat();
            let doors = noted.doors(at)?;
            noted.change(|roll| {
                (roll.routers, roll.doors, roll.operator) = (routers, doors, Some(operator));
                Ok(())
            })
        })
        .await?;
        Ok((Door::open(listener, organisation.clone(), news.clone()), at.to_string()))
    }

    /// Keeps a newer list of ground stations that somebody has, where it is a place's: the next look finds it.
    pub(super) async fn keep(&self, lists: Vec<Vec<u8>>) {
        let Standing::Member(file) = self.standing.clone() else { return };
        let kept = blocking(move || lists.iter().try_for_each(|list| Membership::keep_stations(&file, list)));
        if let Err(error) = kept.await {
            tracing::warn!(%error, "a list of ground stations is not taken");
        }
    }
}
