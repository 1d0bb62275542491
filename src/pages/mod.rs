//! The web pages: rendered here, whole without scripts; a script of our own draws plots and local times over them.
//!
//! A page is a function of what the pipeline answers. Everything it needs comes from this service: no other host is
//! named, and the content security policy allows none.

mod adoption;
mod alerts;
mod api;
mod assets;
mod before_after;
mod book;
mod bullet;
mod calibration;
mod chart;
mod compare;
mod confirm;
mod corrections;
mod course;
mod diagnoses;
mod diagnosis;
mod downsample;
mod events;
pub(crate) mod figure;
mod find;
mod fleet;
mod forecast;
mod form;
mod gyro;
mod gyro_attributes;
mod gyro_diagnosis;
mod gyro_facts;
mod gyro_head;
mod history;
mod history_plot;
mod hooks;
mod import;
mod imu;
mod layout;
mod parameters;
mod prelude;
mod reference;
mod report;
mod residuals;
mod sent;
mod separation;
mod setup;
mod sign_in;
mod silences;
mod spark;
mod state;
mod station;
mod stations;
mod status;
mod suspect;
mod table;
mod text;
mod today;
mod upload_parts;
mod verdicts;
mod view;
mod viewer;

use axum::http::header::ACCEPT;
use axum::http::{HeaderMap, Uri};
use axum::middleware::from_fn_with_state;
use axum::response::{IntoResponse, Response};

use crate::message;
use crate::routes::{ADMIN, ANYONE, ENGINEER, Routes, STATION, VIEWER};
use crate::wire::problem::Problem;

pub use diagnosis::{Subject, report as diagnosis_report};
pub use state::Pages;
use state::off_the_loop;

/// Every page within its frame, and what they load; and the answer where no route has the path.
pub fn router(of: Pages) -> Routes {
    let frame = from_fn_with_state(of.clone(), layout::framed);
    routes().map(|router| router.fallback(no_such_path).layer(frame)).with_state(of)
}

/// 404: a page for a browser, a problem document for a program.
async fn no_such_path(uri: Uri, headers: HeaderMap) -> Response {
    let path = uri.path().to_owned();
    let mut answer = Problem::new(404, "title_no_such_path", message!("no_such_path", path)).into_response();
    let accepted = headers.get(ACCEPT).and_then(|accepted| accepted.to_str().ok()).unwrap_or_default();
    if !accepted.contains("text/html") {
        answer.extensions_mut().remove::<Problem>();
    }
    answer
}

/// Every page, and what they load.
pub fn routes() -> Routes<Pages> {
    Routes::default()
        .get(VIEWER, "/", today::page)
        .get(VIEWER, "/fleet", fleet::page)
        .get(VIEWER, "/find", find::page)
        .get(ENGINEER, "/setup", setup::page)
        .get(VIEWER, "/gyros/{serial}", gyro::page)
        .get(ENGINEER, "/gyros/{serial}/events/new", events::ask)
        .post(ENGINEER, "/gyros/{serial}/events/new", events::act)
        .get(VIEWER, "/gyros/{serial}/report", report::gyro)
        .get(VIEWER, "/reports", report::several)
        .get(VIEWER, "/imus/{imu}", imu::page)
        .get(VIEWER, "/imus/{imu}/report", report::imu)
        .action::<adoption::UndoModel>(ENGINEER, "/imus/{imu}/model/undo")
        .get(VIEWER, "/compare", compare::page)
        .get(VIEWER, "/alerts", alerts::page)
        .get(ENGINEER, "/alerts/bulk", alerts::ask_bulk)
        .post(ENGINEER, "/alerts/bulk", alerts::act_bulk)
        .get(VIEWER, "/alerts/{id}", alerts::one)
        .get(ENGINEER, "/alerts/{id}/{deed}", alerts::ask)
        .post(ENGINEER, "/alerts/{id}/{deed}", alerts::act)
        .get(ENGINEER, "/silences/new", silences::ask_new)
        .post(ENGINEER, "/silences/new", silences::begin)
        .action::<silences::EndSilence>(ENGINEER, "/silences/{id}/end")
        .get(ENGINEER, "/hooks", hooks::page)
        .get(ADMIN, "/hooks/new", hooks::ask_add)
        .post(ADMIN, "/hooks/new", hooks::add)
        .get(ENGINEER, "/hooks/{id}", hooks::one)
        .post(ENGINEER, "/hooks/{id}/test", hooks::test)
        .post(ADMIN, "/hooks/{id}/enabled", hooks::switch)
        .action::<hooks::DeleteHook>(ADMIN, "/hooks/{id}/delete")
        .post(ENGINEER, "/hooks/{id}/redeliver", hooks::redeliver_dead)
        .post(ENGINEER, "/hooks/{id}/deliveries/{delivery}/redeliver", hooks::redeliver)
        .get(VIEWER, "/records/{id}", calibration::record)
        .action::<corrections::VoidCalibration>(ENGINEER, "/records/{id}/void")
        .action::<confirm::ConfirmTime>(ENGINEER, "/records/{id}/confirm")
        .get(VIEWER, "/campaigns/{id}", calibration::campaign)
        .action::<corrections::VoidCalibration>(ENGINEER, "/campaigns/{id}/void")
        .action::<corrections::VoidBench>(ENGINEER, "/bench-results/{id}/void")
        .get(VIEWER, "/campaigns/{id}/diagnosis", diagnosis::page)
        .action::<adoption::Adopt>(ENGINEER, "/campaigns/{id}/adopt")
        .get(VIEWER, "/diagnoses", diagnoses::page)
        .post(ENGINEER, "/diagnoses", diagnoses::start)
        .post(ENGINEER, "/diagnoses/{id}/cancel", diagnoses::cancel)
        .get(VIEWER, "/stations", stations::page)
        .get(VIEWER, "/stations/{name}", station::page)
        .get(ENGINEER, "/stations/{name}/suspect", suspect::ask::<false>)
        .post(ENGINEER, "/stations/{name}/suspect", suspect::act::<false>)
        .get(ENGINEER, "/stations/{name}/trust", suspect::ask::<true>)
        .post(ENGINEER, "/stations/{name}/trust", suspect::act::<true>)
        .get(ENGINEER, "/gyros/{serial}/attributes", gyro_attributes::ask)
        .post(ENGINEER, "/gyros/{serial}/attributes", gyro_attributes::act)
        .get(VIEWER, "/gyros/{serial}/diagnosis", gyro_diagnosis::page)
        .get(VIEWER, "/docs", api::all)
        .get(VIEWER, "/docs/{group}", api::group)
        .get(VIEWER, "/book", book::first)
        .get(VIEWER, "/book/{*name}", book::one)
        .get(STATION, "/import", import::page)
        .post(STATION, "/import/preview", import::preview)
        .post(STATION, "/import/store", import::store)
        .post(ENGINEER, "/import/replace", import::in_place::act)
        .get(ANYONE, "/sign-in", sign_in::page)
        .post(ANYONE, "/sign-in", sign_in::enter)
        .post(ANYONE, "/sign-out", sign_in::leave)
        .get(ANYONE, "/preference", viewer::prefer)
        .get(ANYONE, "/assets/{name}", assets::serve)
}
