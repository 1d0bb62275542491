//! One table of alerts, wherever some are shown.

use crate::core::alert_decision::AlertState;
use crate::core::alert_filter::AlertFilter;
use crate::core::judge::Severity;
use crate::pages::prelude::*;
use crate::pages::status;
use crate::pages::verdicts::{actions, remarks, violated};

/// Alerts of one gyro, one for each coefficient and rule: never more than so many.
const MOST_OF_A_GYRO: u32 = 200;

/// Alerts of a gyro that are not resolved, critical ones first, then the newest.
pub(in crate::pages) async fn open_ones(pages: &Pages, gyro: u32) -> Result<Vec<AlertBody>, Problem> {
    let filter = AlertFilter { gyro: Some(gyro), ..AlertFilter::default() };
    let found = pages.pipeline.alerts.find(&filter, None, MOST_OF_A_GYRO).await?;
    let mut open: Vec<AlertBody> = found.into_iter().filter(is_open).collect();
    open.sort_by_key(|alert| alert.severity != Severity::Critical.name());
    Ok(open)
}

/// Alerts of an IMU as a whole that are not resolved.
pub(in crate::pages) async fn open_ones_of_imu(pages: &Pages, imu: &str) -> Result<Vec<AlertBody>, Problem> {
    let told = pages.pipeline.alerts.of_no_gyro(&AlertFilter::default()).await?;
    let is_its = |alert: &AlertBody| alert.subject == AlertBody::OF_IMU && alert.name() == imu && is_open(alert);
    Ok(told.into_iter().filter(is_its).collect())
}

/// Whether it has not been resolved.
pub(in crate::pages) fn is_open(alert: &AlertBody) -> bool {
    alert.state != AlertState::Resolved.name()
}

/// Whether the figure that it followed last is within its limit again, which is not to say that it is in tolerance.
fn is_back_within(alert: &AlertBody) -> bool {
    let of_one_limit = alert.rule != Rule::Requirement.name();
    of_one_limit && alert.finding.value.is_some_and(|value| value <= alert.finding.limit)
}

/// `named`: whether each line names its gyro, or what else it is of: all of them the same kind. `here`: where to come
/// back to from what is done; none where nothing can be.
pub(in crate::pages) fn table<'a>(
    viewer: &Viewer,
    alerts: impl Iterator<Item = &'a AlertBody>,
    named: bool,
    here: Option<&str>,
) -> Markup {
    let t = viewer.text();
    let mut alerts = alerts.peekable();
    let of_what = match alerts.peek().map(|alert| &*alert.subject) {
        Some(AlertBody::OF_STATION) => t.station,
        Some(AlertBody::OF_BATCH) => t.batch,
        Some(AlertBody::OF_IMU) => t.imu,
        _ => t.serial,
    };
    html! {
        (wide_table("alerts", html! {
            th { (t.status_word) }
            @if named { th { (of_what) } }
            th { (t.violates) } th { (t.reason_word) } th { (t.since) } th { (t.fired) } th { (t.handling) }
        }, html! { @for alert in alerts { (line(viewer, alert, named, here)) } }))
    }
}

fn line(viewer: &Viewer, alert: &AlertBody, named: bool, here: Option<&str>) -> Markup {
    let t = viewer.text();
    let open = is_open(alert);
    html! {
        tr {
            td { (status::badge(t, alert.status())) }
            @if named { th scope="row" { a.id href=(alert.page()) { (alert.name()) } } }
            td.nowrap { (violated(t, alert)) }
            td.words {
                (t.reason(&alert.finding.reason))
                @if let Some(record) = alert.finding.record.as_ref().filter(|_| alert.rule != Rule::Agreement.name()) {
                    @if alert.subject == AlertBody::OF_IMU {
                        " " a href={ "/campaigns/" (record) "/diagnosis#forecast" } { (t.forecast) }
                    } @else { " " a href={ "/records/" (record) } { (t.record) } }
                }
            }
            td data-label=(t.since) { @if let Some(since) = &alert.since { (written(since)) } }
            td data-label=(t.fired) { a href={ "/alerts/" (alert.id) } { (written(&alert.fired_at)) } }
            td.words {
                (t.standing(&alert.state))
                @if open && is_back_within(alert) { " " span.quiet { (t.ends_in_tolerance) } }
                @if let Some(station) = &alert.inhibited_by { " " a href={ "/alerts/" (station) } { (t.explained_by_another) } }
                (remarks(t, alert))
                @if let Some(at) = &alert.resolved_at { " " (written(at)) }
                (actions(viewer, alert, here.filter(|_| open)))
            }
        }
    }
}

pub(super) async fn known(pages: &Pages, id: &str) -> Result<(Id, AlertBody), Problem> {
    let number = problem::id(id, Problem::unknown_alert)?;
    Ok((number, pages.pipeline.alerts.get(number).await?.ok_or_else(|| Problem::unknown_alert(id))?.alert))
}
