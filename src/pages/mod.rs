//! The web pages: rendered here, whole without scripts; a script of our own draws plots and local times over them.
//!
//! A page is a function of what the pipeline answers. Everything it needs comes from this service: no other host is named,
//! and the content security policy allows none.

mod alerts;
mod assets;
mod before_after;
mod calibration;
mod chart;
mod confirm;
mod corrections;
mod diagnoses;
mod diagnosis;
mod downsample;
mod events;
pub(crate) mod figure;
mod fleet;
mod form;
mod gyro;
mod history;
mod hooks;
mod import;
mod imu;
mod layout;
mod notes;
mod parameters;
mod plot;
mod reference;
mod report;
mod residuals;
mod separation;
mod sign_in;
mod silences;
mod spark;
mod state;
mod stations;
mod status;
mod text;
mod upload_parts;
mod verdicts;
mod viewer;

use axum::Router;
use axum::routing::{get, post};

pub use state::Pages;
use state::off_the_loop;

/// Every page, and what they load.
pub fn router(pages: Pages) -> Router {
    Router::new()
        .route("/", get(fleet::page))
        .route("/gyros/{serial}", get(gyro::page))
        .route("/gyros/{serial}/events/new", get(events::ask).post(events::act))
        .route("/gyros/{serial}/report", get(report::gyro))
        .route("/imus/{imu}", get(imu::page))
        .route("/imus/{imu}/report", get(report::imu))
        .route("/alerts", get(alerts::page))
        .route("/alerts/{id}/{deed}", get(alerts::ask).post(alerts::act))
        .route("/silences/new", get(silences::ask_new).post(silences::begin))
        .route("/silences/{id}/end", get(silences::ask_end).post(silences::end))
        .route("/hooks", get(hooks::page))
        .route("/hooks/new", get(hooks::ask_add).post(hooks::add))
        .route("/hooks/{id}", get(hooks::one))
        .route("/hooks/{id}/test", post(hooks::test))
        .route("/hooks/{id}/enabled", post(hooks::switch))
        .route("/hooks/{id}/delete", get(hooks::ask_delete).post(hooks::delete))
        .route("/hooks/{id}/redeliver", post(hooks::redeliver_dead))
        .route("/hooks/{id}/deliveries/{delivery}/redeliver", post(hooks::redeliver))
        .route("/records/{id}", get(calibration::record))
        .route("/records/{id}/void", get(corrections::ask_record).post(corrections::void_record))
        .route("/records/{id}/confirm", get(confirm::ask).post(confirm::act))
        .route("/campaigns/{id}", get(calibration::campaign))
        .route("/campaigns/{id}/void", get(corrections::ask_record).post(corrections::void_record))
        .route("/bench-results/{id}/void", get(corrections::ask_bench).post(corrections::void_bench))
        .route("/campaigns/{id}/diagnosis", get(diagnosis::page))
        .route("/diagnoses", get(diagnoses::page).post(diagnoses::start))
        .route("/diagnoses/{id}/cancel", post(diagnoses::cancel))
        .route("/stations", get(stations::page))
        .route("/import", get(import::page))
        .route("/import/preview", post(import::preview))
        .route("/import/store", post(import::store))
        .route("/sign-in", get(sign_in::page).post(sign_in::enter))
        .route("/sign-out", post(sign_in::leave))
        .route("/preference", get(viewer::prefer))
        .route("/assets/{name}", get(assets::serve))
        .with_state(pages)
}
