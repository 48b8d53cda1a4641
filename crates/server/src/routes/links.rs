//! Links: list, open and close.

use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use vencejo_link::{LinkAddress, LinkId, LinkOptions, UnsignedPolicy, serial_ports};
use vencejo_station::StationError;

use crate::convert;
use crate::dto::cause::{Cause, ResourceKind};
use crate::dto::{FleetNetwork, LinkInfo, NewLink, SerialPort};
use crate::extract::{Id, Json as Body, Pilot, Viewer};
use crate::problem::Problem;
use crate::state::App;
use crate::turns::quickly;

pub(super) fn router() -> OpenApiRouter<App> {
    OpenApiRouter::new()
        .routes(routes!(list_links, open_link))
        .routes(routes!(close_link))
        .routes(routes!(list_serial_ports))
        .routes(routes!(list_networks))
}

/// Lists the fleets that this station is in, and whether their networks are connected.
#[utoipa::path(get, path = "/networks", tag = "links", responses((status = 200, body = Vec<FleetNetwork>), Problem))]
async fn list_networks(State(app): State<App>, _: Viewer) -> Json<Vec<FleetNetwork>> {
    Json(convert::networks(app.station()))
}

/// Lists the links with their traffic counters.
#[utoipa::path(get, path = "/links", tag = "links", responses((status = 200, body = Vec<LinkInfo>), Problem))]
async fn list_links(State(app): State<App>, _: Viewer) -> Json<Vec<LinkInfo>> {
    Json(convert::links(app.station()))
}

/// Opens another link. It connects, and reconnects, by itself.
#[utoipa::path(post, path = "/links", tag = "links", request_body = NewLink,
    responses((status = 201, body = LinkInfo), Problem))]
async fn open_link(
    State(app): State<App>,
    pilot: Pilot,
    Body(new): Body<NewLink>,
) -> Result<(StatusCode, Json<LinkInfo>), Problem> {
    pilot.still_in_control(&app)?;
    // A recording link names a file path, which network clients may not do, however the address is spelt.
    if matches!(new.address.parse(), Ok(LinkAddress::Tlog { .. })) {
        return Err(Problem::new(
            Cause::RecordingAsLink,
            "recordings are opened on the server's own command line, not over the network",
        ));
    }
    let unsigned = match new.accept_unsigned {
        None => UnsignedPolicy::ByAddress,
        Some(true) => UnsignedPolicy::Accept,
        Some(false) => UnsignedPolicy::Refuse,
    };
    let options = LinkOptions { name: new.name, forwards: new.forward, unsigned };
    let id = app.station().open_link(&new.address, options)?;
    let link = find(&app, id).ok_or_else(Problem::closed)?;
    Ok((StatusCode::CREATED, Json(link)))
}

/// Closes a link.
#[utoipa::path(delete, path = "/links/{id}", tag = "links", params(("id" = u32, Path, description = "The link's id")),
    responses((status = 204), Problem))]
async fn close_link(State(app): State<App>, _: Pilot, Id(id): Id) -> Result<StatusCode, Problem> {
    let id = u32::try_from(id).map_err(|_| Problem::not_found(ResourceKind::Link, id, "there is no such link"))?;
    app.station().close_link(LinkId(id)).await.map_err(|error: StationError| Problem::from(error))?;
    Ok(StatusCode::NO_CONTENT)
}

/// Lists the serial ports of the server's machine: autopilots on USB first, then adapters, then the others.
#[utoipa::path(get, path = "/serial-ports", tag = "links", responses((status = 200, body = Vec<SerialPort>), Problem))]
async fn list_serial_ports(State(app): State<App>, _: Viewer) -> Result<Json<Vec<SerialPort>>, Problem> {
    quickly(move || Ok(Json(convert::serial_ports(app.station(), serial_ports())))).await
}

fn find(app: &App, id: LinkId) -> Option<LinkInfo> {
    convert::links(app.station()).into_iter().find(|link| link.id == id.0)
}
