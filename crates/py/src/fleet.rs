//! Aircraft of a fleet and their ground stations, for Python.

use std::collections::BTreeMap;
use std::path::PathBuf;

use pyo3::prelude::*;
use vencejo_fleet::authority::Role;
use vencejo_fleet::carrier::{
    Aircraft, AircraftConfig, Endpoint, Ground, GroundConfig, Membership, Organisation, join, standing, try_address,
    unix_now,
};
use vencejo_fleet::key::Name;
use vencejo_fleet::papers::certificate::{Facts, Identity, WARN_BEFORE_S};
use vencejo_fleet::signature::PublicKey;
use vencejo_fleet::{FleetError, operator};
use vencejo_vehicle::VehicleId;

use crate::station::PyStation;
use crate::{errors, runtime};

/// Adds this module's classes.
pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("FLEET_WARN_BEFORE_S", WARN_BEFORE_S)?;
    module.add_class::<PyAircraft>()?;
    module.add_class::<PyGround>()?;
    module.add_class::<PyOrganisation>()?;
    module.add_function(wrap_pyfunction!(fleet_join, module)?)?;
    module.add_function(wrap_pyfunction!(fleet_member, module)?)?;
    module.add_function(wrap_pyfunction!(fleet_standing, module)?)?;
    module.add_function(wrap_pyfunction!(fleet_try, module)?)
}

fn raise(error: FleetError) -> PyErr {
    let class = match error {
        FleetError::Network { .. } => "LinkError",
        FleetError::Refused(_) => "NotPossibleNow",
        FleetError::File { .. } | FleetError::NoRandom(_) => "VencejoError",
        _ => "InvalidRequest",
    };
    errors::raise(class, error)
}

/// Whether a router is reached, what the network said when it was not, who has control, states told a second, end of the certificate.
type Status = (bool, Option<String>, Option<String>, f64, Option<u64>);

/// An aircraft of a fleet, on board.
#[pyclass(frozen, name = "FleetAircraft", module = "vencejo._native")]
pub struct PyAircraft(Aircraft);

#[pymethods]
impl PyAircraft {
    #[new]
    #[pyo3(signature = (station, *, org, name, dial, trust, uplink_bit_s, member_file))]
    #[expect(clippy::too_many_arguments, reason = "all by name, in Python")]
    fn new(
        py: Python<'_>,
        station: &PyStation,
        org: Option<&str>,
        name: Option<&str>,
        dial: Option<&str>,
        trust: Vec<(String, bool)>,
        uplink_bit_s: Option<f64>,
        member_file: PathBuf,
    ) -> PyResult<Self> {
        let trusted = |(key, is_chief): (String, bool)| {
            let role = if is_chief { Role::Chief } else { Role::Operator };
            Ok((key.parse::<PublicKey>()?, role))
        };
        let config = || -> Result<Option<AircraftConfig>, FleetError> {
            let given = trust.into_iter().map(trusted).collect::<Result<BTreeMap<_, _>, FleetError>>()?;
            let member = Membership::read(&member_file)?;
            let (org, name) = match (org, name, &member) {
                (Some(org), Some(name), _) => (org.parse()?, name.parse()?),
                (None, None, Some(member)) => (member.org()?, member.name()?),
                _ => return Ok(None),
            };
            // Of another fleet, it is nothing here.
            let member =
                member.filter(|member| member.org().as_ref() == Ok(&org) && member.name().as_ref() == Ok(&name));
            let dial = match (dial, &member) {
                (Some(dial), _) => vec![dial.parse()?],
                (None, Some(member)) => member.routers()?,
                (None, None) => vec!["tcp/127.0.0.1:7447".parse()?],
            };
            let mut trust: BTreeMap<_, _> = match &member {
                Some(member) => member.trust()?.into_iter().map(|key| (key, Role::Operator)).collect(),
                None => BTreeMap::new(),
            };
            trust.extend(given);
            let member = member.map(|member| (member, member_file));
            Ok(Some(AircraftConfig { org, name, dial, member, trust, uplink_bit_s }))
        };
        let config = py.detach(config).map_err(raise)?.ok_or_else(|| {
            errors::raise(
                "InvalidRequest",
                "say which fleet (org) and which name in it; or join one first, with a token",
            )
        })?;
        Aircraft::start(station.station(), config, runtime::handle()).map(Self).map_err(raise)
    }

    fn status(&self) -> Status {
        let status = self.0.status();
        (status.is_connected, status.problem, status.holder, status.rate_hz, status.certificate_ends)
    }

    fn close(&self, py: Python<'_>) -> PyResult<()> {
        runtime::wait(py, None, self.0.close()).map(drop)
    }
}

/// Name, system id here, whether it is reachable, age of what it said, who has control, who asks for it.
type Far = (String, Option<u16>, bool, f64, Option<String>, Option<String>);

/// A ground station of a fleet.
#[pyclass(frozen, name = "FleetGround", module = "vencejo._native")]
pub struct PyGround(Ground);

#[pymethods]
impl PyGround {
    #[new]
    #[pyo3(signature = (station, *, org, listen, dial, door, key_file, folder))]
    #[expect(clippy::too_many_arguments, reason = "all by name, in Python")]
    fn new(
        py: Python<'_>,
        station: &PyStation,
        org: &str,
        listen: Option<&str>,
        dial: Option<&str>,
        door: Option<String>,
        key_file: PathBuf,
        folder: PathBuf,
    ) -> PyResult<Self> {
        let config = || -> Result<GroundConfig, FleetError> {
            let org: Name = org.parse()?;
            Ok(GroundConfig {
                listen: listen.map(str::parse).transpose()?,
                dial: dial.map(str::parse).transpose()?,
                signer: operator::key_of_file(&key_file)?,
                organisation: Some(Organisation::below(&folder, org.clone())).filter(Organisation::exists),
                door,
                org,
            })
        };
        let config = py.detach(config).map_err(raise)?;
        let started = runtime::wait(py, None, Ground::start(station.station(), config, runtime::handle()))?;
        let ground = started.ok_or_else(|| errors::raise("ClosedError", "the fleet was not joined"))?;
        ground.map(Self).map_err(raise)
    }

    /// Where the network is joined.
    #[getter]
    fn endpoint(&self) -> String {
        self.0.endpoint().to_string()
    }

    /// Where aircraft are enrolled.
    #[getter]
    fn door(&self) -> Option<&str> {
        self.0.door()
    }

    /// Its public key.
    #[getter]
    fn key(&self) -> String {
        self.0.key().to_string()
    }

    fn aircraft(&self) -> Vec<Far> {
        let far = |far: vencejo_fleet::carrier::Far| {
            (far.name, far.id.map(VehicleId::number), far.is_present, far.age.as_secs_f64(), far.holder, far.asking)
        };
        self.0.aircraft().into_iter().map(far).collect()
    }

    fn close(&self, py: Python<'_>) -> PyResult<()> {
        runtime::wait(py, None, self.0.close()).map(drop)
    }
}

/// From when to when a certificate is good, and for which names.
type Validity = (u64, u64, Vec<String>);

fn validity(facts: Facts) -> Validity {
    (facts.begins, facts.ends, facts.names)
}

/// Name, since when, end of its certificate, when it was revoked.
type Enrolled = (String, u64, u64, Option<u64>);

/// A fleet's authority and its roll, in a folder.
#[pyclass(frozen, name = "FleetOrganisation", module = "vencejo._native")]
pub struct PyOrganisation(Organisation);

impl PyOrganisation {
    fn detached<T: Send>(
        &self,
        py: Python<'_>,
        run: impl FnOnce(&Organisation) -> Result<T, FleetError> + Send,
    ) -> PyResult<T> {
        py.detach(|| run(&self.0)).map_err(raise)
    }
}

#[pymethods]
impl PyOrganisation {
    #[new]
    fn new(folder: PathBuf, org: &str) -> PyResult<Self> {
        let org: Name = org.parse().map_err(|error| raise(FleetError::Name(error)))?;
        Ok(Self(Organisation::below(&folder, org)))
    }

    fn exists(&self) -> bool {
        self.0.exists()
    }

    /// Whether the authority was made now; hosts that are new.
    fn init(
        &self,
        py: Python<'_>,
        hosts: Vec<String>,
        given: Option<(String, String)>,
    ) -> PyResult<(bool, Vec<String>)> {
        let made = self.detached(py, |org| org.init(&hosts, given, unix_now()))?;
        Ok((made.authority, made.hosts))
    }

    /// The token; where it is good; when it ends.
    fn enrol(&self, py: Python<'_>, name: &str, lasts_s: u64) -> PyResult<(String, Vec<String>, u64)> {
        let now = unix_now();
        let ticket = self.detached(py, |org| org.enrol(&name.parse()?, lasts_s, now))?;
        Ok((ticket.text(), ticket.doors, now + lasts_s))
    }

    fn revoke(&self, py: Python<'_>, name: &str) -> PyResult<()> {
        self.detached(py, |org| {
            let name = name.parse()?;
            org.change(|roll| roll.revoke(&name, unix_now()))
        })
    }

    /// The settings of a router, as JSON.
    fn router_config(&self, py: Python<'_>) -> PyResult<String> {
        self.detached(py, |org| Ok(format!("{:#}", org.router_config()?)))
    }

    /// The authority's certificate, and the ground station's.
    fn certificates(&self, py: Python<'_>) -> PyResult<(Validity, Validity)> {
        let (ca, station) = self.detached(py, Organisation::facts)?;
        Ok((validity(ca), validity(station)))
    }

    /// Routers, doors.
    fn addresses(&self, py: Python<'_>) -> PyResult<(Vec<String>, Vec<String>)> {
        let roll = self.detached(py, Organisation::roll)?;
        Ok((roll.routers, roll.doors))
    }

    /// Who is enrolled.
    fn aircraft(&self, py: Python<'_>) -> PyResult<Vec<Enrolled>> {
        let roll = self.detached(py, Organisation::roll)?;
        Ok(roll.aircraft.into_iter().map(|(name, entry)| (name, entry.enrolled, entry.ends, entry.revoked)).collect())
    }

    /// Tokens that are out: for whom, until when.
    fn tokens(&self, py: Python<'_>) -> PyResult<Vec<(String, u64)>> {
        let roll = self.detached(py, Organisation::roll)?;
        Ok(roll.open_tokens(unix_now()).map(|out| (out.name.clone(), out.ends)).collect())
    }

    /// What is wrong with whoever is at an address, asked as the ground station; `None` where nothing is.
    fn try_address(&self, py: Python<'_>, address: &str) -> PyResult<Option<String>> {
        let identity = self.detached(py, |org| org.identity(unix_now()))?;
        tried(py, address, &identity)
    }
}

fn tried(py: Python<'_>, address: &str, identity: &Identity) -> PyResult<Option<String>> {
    let address: Endpoint = address.parse().map_err(raise)?;
    Ok(runtime::wait(py, None, try_address(&address, identity))?.and_then(Result::err))
}

/// Organisation, name, from when to when its certificate is good, routers, doors.
type Member = (String, String, u64, u64, Vec<String>, Vec<String>);

fn shown(member: &Membership) -> Result<Member, FleetError> {
    let Facts { begins, ends, .. } = member.facts()?;
    let routers = member.routers()?.iter().map(Endpoint::to_string).collect();
    Ok((member.org()?.to_string(), member.name()?.to_string(), begins, ends, routers, member.doors().to_vec()))
}

/// Joins a fleet; what is in the file then, and whether it was done now.
#[pyfunction]
fn fleet_join(py: Python<'_>, token: &str, file: PathBuf) -> PyResult<(Member, bool)> {
    let joined =
        runtime::wait(py, None, join(token, &file))?.ok_or_else(|| errors::raise("ClosedError", "interrupted"))?;
    let (member, is_new) = joined.map_err(raise)?;
    Ok((shown(&member).map_err(raise)?, is_new))
}

/// What the file of a computer on board says; `None` where it is in no fleet.
#[pyfunction]
fn fleet_member(py: Python<'_>, file: PathBuf) -> PyResult<Option<Member>> {
    py.detach(|| Membership::read(&file)?.as_ref().map(shown).transpose()).map_err(raise)
}

/// Why the aircraft of this file would not get its next certificate; `None` where it would.
#[pyfunction]
fn fleet_standing(py: Python<'_>, file: PathBuf) -> PyResult<Option<String>> {
    let member = py.detach(|| Membership::read(&file)).map_err(raise)?;
    let Some(member) = member else { return Ok(None) };
    Ok(runtime::wait(py, None, standing(&member))?.and_then(Result::err))
}

/// What is wrong with whoever is at an address, asked as the aircraft of this file; `None` where nothing is.
#[pyfunction]
fn fleet_try(py: Python<'_>, address: &str, file: PathBuf) -> PyResult<Option<String>> {
    let member = py.detach(|| Membership::read(&file)).map_err(raise)?;
    member.map_or(Ok(None), |member| tried(py, address, &member.identity()))
}
