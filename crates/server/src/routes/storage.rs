//! Storage faults, and the draft of the plan.

use axum::Json;
use axum::extract::rejection::QueryRejection;
use axum::extract::{DefaultBodyLimit, Query, State};
use axum::http::StatusCode;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use crate::drafts::{Drafts, MAX_DRAFT};
use crate::dto::ServerMessage;
use crate::dto::storage::{DraftBase, NewPlanDraft, PlanDraft, PlanDrafts, StorageProblem};
use crate::extract::{Json as Body, Operator, Viewer};
use crate::outbox::Topic;
use crate::problem::Problem;
use crate::state::App;

pub(super) fn router() -> OpenApiRouter<App> {
    OpenApiRouter::new().routes(routes!(storage_problems))
}

pub(super) fn draft_router() -> OpenApiRouter<App> {
    let router = OpenApiRouter::new().routes(routes!(get_draft, put_draft, delete_draft));
    // Allowance for the JSON around the draft.
    router.layer(DefaultBodyLimit::max(MAX_DRAFT + 4096))
}

/// Lists storage faults, the flight recorder's first; empty when there are none.
#[utoipa::path(get, path = "/storage", tag = "station", responses((status = 200, body = Vec<StorageProblem>), Problem))]
async fn storage_problems(State(app): State<App>, _: Viewer) -> Json<Vec<StorageProblem>> {
    Json(app.storage_problems())
}

/// Returns the draft of the plan that operators edit, and conflicting drafts.
#[utoipa::path(get, path = "/draft", tag = "plans", responses((status = 200, body = PlanDrafts), Problem))]
async fn get_draft(State(app): State<App>, _: Viewer) -> Result<Json<PlanDrafts>, Problem> {
    app.with_drafts(Drafts::get).await.map(Json)
}

/// Saves the draft as a change of revision `base`. If another author has changed it since, the request is refused, and
/// the draft is kept as a conflicting one.
#[utoipa::path(put, path = "/draft", tag = "plans", request_body = NewPlanDraft,
    responses((status = 200, body = PlanDraft), Problem))]
async fn put_draft(
    State(app): State<App>,
    Operator(session): Operator,
    Body(new): Body<NewPlanDraft>,
) -> Result<Json<PlanDraft>, Problem> {
    let by = app.sessions().info(session).map(|info| info.name).unwrap_or_default();
    let draft = app.with_drafts(move |drafts| drafts.put(new, by)).await??;
    tell(&app, &draft.author, draft.revision);
    Ok(Json(draft))
}

/// Deletes the draft and conflicting drafts.
#[utoipa::path(delete, path = "/draft", tag = "plans", params(DraftBase), responses((status = 204), Problem))]
async fn delete_draft(
    State(app): State<App>,
    _: Operator,
    asked: Result<Query<DraftBase>, QueryRejection>,
) -> Result<StatusCode, Problem> {
    let Query(DraftBase { base }) = asked?;
    app.with_drafts(move |drafts| drafts.remove(base)).await??;
    tell(&app, "", base + 1);
    Ok(StatusCode::NO_CONTENT)
}

fn tell(app: &App, author: &str, revision: u64) {
    let message = ServerMessage::Draft { revision, author: author.to_owned() };
    app.outboxes().put_latest(Topic::Draft, &message);
}
