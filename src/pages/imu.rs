//! `/imus/{imu}`: the gyros in it, its newest parameters against what is required, its calibrations.

use std::collections::HashMap;

use super::alerts;
use super::layout::query;
use super::parameters::{self, Parameters};
use super::prelude::*;
use super::{bullet, forecast, status};
use crate::core::effects::Effect;
use crate::core::kind::{Kind, RecordEntry};
use crate::pipeline::{Conclusion, GyroStatus, Names, Seats, sample_of};
use crate::wire::campaign::CampaignBody;
use crate::wire::record::RecordBody;

/// Calibrations that are listed.
const RECORDS: u32 = 60;
/// Campaigns of which it is shown what was foretold.
const FORECASTS: u32 = 20;

/// What is known of an IMU.
pub(super) struct Facts {
    pub seats: Seats,
    /// Newest first.
    pub records: Vec<RecordEntry>,
    /// The newest, as tables.
    pub parameters: Option<Markup>,
    /// Of the IMU as a whole, those that are not resolved.
    pub alerts: Vec<AlertBody>,
}

impl Facts {
    pub async fn of(pages: &Pages, viewer: &Viewer, imu: &str) -> Result<Self, Problem> {
        let number = pages.pipeline.queries.names().imu_number(imu);
        let unknown = || Problem::new(404, "title_unknown_imu", pages.pipeline.queries.names().unknown_imu(imu));
        let number = number.ok_or_else(unknown)?;
        let records = pages.pipeline.queries.records.of_imu(number, RECORDS).await?;
        let seats = pages.pipeline.queries.fleet.seated_in(number).await?;
        let parameters = match records.first() {
            Some(head) => parameters_of(pages, viewer.text(), head.id, None).await?,
            None => None,
        };
        let alerts = alerts::open_ones_of_imu(pages, imu).await?;
        Ok(Self { seats, records, parameters, alerts })
    }
}

pub(super) async fn page(
    PageContext(ref pages, ref viewer): PageContext,
    Path(ref imu): Path<String>,
) -> Result<Page, Problem> {
    let t = viewer.text();
    let Facts { seats, records, parameters, alerts: open } = Facts::of(pages, viewer, imu).await?;
    let number = pages.pipeline.queries.names().imu_number(imu);
    let forecasts = match number {
        Some(number) => pages.pipeline.diagnoses.forecasts_of_imu(number, FORECASTS).await?,
        None => Vec::new(),
    };
    let models = pages.pipeline.diagnoses.models(imu).await?.unwrap_or_default();
    let concluded = match number {
        Some(number) => pages.pipeline.diagnoses.conclusions(number).await?,
        None => HashMap::new(),
    };
    let body = html! {
        h1 { (imu) }
        p.actions {
            a.action href={ "/imus/" (encoded(imu)) "/report" } { (t.report) }
            @if seats.now.len() > 1 {
                @let gyros = seats.now.iter().map(|gyro| ("gyro", &*gyro.serial));
                a.action href={ "/compare?" (query(gyros)) } { (t.compare_gyros) }
            }
        }
        @if !open.is_empty() { (alerts::table(viewer, open.iter(), false, None)) }
        (seated(pages, t, &seats))
        @if let Some(newest) = parameters { section { h2 { (t.newest_parameters) } (newest) } }
        (forecast::versions(viewer, imu, &models))
        (forecast::series(t, &forecasts))
        section { h2 { (t.records) } (list(t, &pages.pipeline.queries.names(), &records, &concluded)) }
    };
    Ok(Page { title: imu.to_owned(), section: Section::Fleet, body })
}

/// E, G and P of a record, with what is required of them: of one gyro, or of all.
pub(super) async fn parameters_of(
    pages: &Pages,
    t: &Text,
    record: Id,
    serial: Option<&str>,
) -> Result<Option<Markup>, Problem> {
    let records = &pages.pipeline.queries.records;
    let Some(sent) = records.sent(record).await? else { return Ok(None) };
    let (imu, geometry, mut gyros) = match sent.kind {
        Kind::Campaign => {
            let stored = records.campaign(record).await?;
            let body = serde_json::from_str::<CampaignBody>(&sent.body).ok();
            let Some((stored, body)) = stored.zip(body) else { return Ok(None) };
            let gyros: Vec<_> = stored.answer.calibration.gyros.iter().map(Parameters::fitted).collect();
            (body.imu, body.geometry, gyros)
        }
        Kind::Record => {
            let Ok(body) = serde_json::from_str::<RecordBody>(&sent.body) else { return Ok(None) };
            let gyros = body.gyros.iter().map(Parameters::stated).collect();
            (body.imu, body.geometry, gyros)
        }
    };
    gyros.retain(|gyro| serial.is_none_or(|serial| gyro.serial == serial));
    Ok(Some(parameters::tables(t, &gyros, parameters::required(&pages.config.judging, &imu, &geometry))))
}

/// The gyros that are in it, and apart from them those that another one has replaced.
pub(super) fn seated(pages: &Pages, t: &Text, seats: &Seats) -> Markup {
    html! {
        section {
            h2 { (t.gyros_in_it) }
            @if !seats.now.is_empty() { (standings(pages, t, &seats.now, t.calibrated)) }
            @else if seats.used { p { (t.none_in_it) } }
            @else { p { (t.never_in_it) } }
        }
        @if !seats.before.is_empty() {
            section {
                h2 { (t.gyros_before) }
                p.note { (t.gyros_before_note) }
                (standings(pages, t, &seats.before, t.last_calibrated_in_it))
            }
        }
    }
}

fn standings(pages: &Pages, t: &Text, gyros: &[GyroStatus], when: &str) -> Markup {
    html! {
        (wide_table("cards", html! {
            th { (t.slot) } th { (t.serial) } th { (t.status_word) } @for name in DRIFTS { th.n { (symbol(name)) } } th { (when) }
        }, html! { @for gyro in gyros {
            @if let Some(newest) = &gyro.newest {
                tr {
                    td { (newest.slot.name()) }
                    th scope="row" { a href={ "/gyros/" (encoded(&gyro.serial)) } { (gyro.serial) } }
                    td { (status::badge(t, gyro.status)) " " (status::out_of_use(t, gyro.out_of_use)) }
                    @for (column, measured) in sample_of(newest, pages.config.judging.method).d.into_iter().enumerate() {
                        td.n {
                            (label("", DRIFTS[column]))
                            @if let Some(load) = gyro.projection.load[column] {
                                strong { (bullet::share(t, load)) } br;
                                span.quiet { (figure::drift(measured.value, measured.sd)) }
                            } @else { (figure::drift(measured.value, measured.sd)) }
                        }
                    }
                    td { (instant(newest.at)) }
                }
            }
        } }))
        p.note { (t.load_word) ". " (t.unit) }
    }
}

/// Where there are two campaigns, two of them can be chosen to be compared.
fn list(t: &Text, names: &Names<'_>, records: &[RecordEntry], concluded: &HashMap<Id, Conclusion>) -> Markup {
    let campaigns = records.iter().filter(|head| head.kind == Kind::Campaign);
    let newest: Vec<Id> = campaigns.take(2).map(|head| head.id).collect();
    let choice = newest.len() == 2;
    html! {
        form action="/compare" method="get" {
            (tall_table("", html! {
                @if choice { th { (t.compare) } }
                th { (t.calibrated) } th { (t.station) } th { (t.kind) } th { (t.diagnosis) }
            }, html! { @for head in records {
                @let campaign = head.kind == Kind::Campaign;
                tr {
                    @if choice { td { @if campaign {
                        input type="checkbox" name="campaign" value=(head.id) checked[newest.contains(&head.id)]
                            aria-label={ (t.compare) " " (head.calibrated_at.date()) };
                    } } }
                    td { a href={ (if campaign { "/campaigns/" } else { "/records/" }) (head.id) } { (instant(head.calibrated_at)) } }
                    td { (names.station(head.station)) }
                    td { @if campaign { (t.kind_campaign) } @else { (t.kind_record) } }
                    td.words { @if campaign { (conclusion(t, head.id, concluded.get(&head.id))) } }
                }
            } }))
            @if choice { p { button { (t.compare_chosen) } } }
        }
    }
}

/// What the diagnosis of a campaign came to, and what it named.
fn conclusion(t: &Text, campaign: Id, concluded: Option<&Conclusion>) -> Markup {
    let verdict = match concluded.map(|one| one.verdict.as_str()) {
        Some("no_gap") => t.coverage_no_gap,
        Some("explained") => t.coverage_explained,
        Some("partly_explained") => t.coverage_partly_explained,
        Some("unexplained") => t.coverage_unexplained,
        Some(_) => t.coverage_refused,
        None => t.coverage_waiting,
    };
    let effects = concluded.into_iter().flat_map(|one| one.effects.iter().filter_map(|id| Effect::from_id(id)));
    let effects: Vec<&str> = effects.map(|effect| t.effect(effect)).collect();
    html! {
        a href={ "/campaigns/" (campaign) "/diagnosis" } { (verdict) }
        @if !effects.is_empty() { (t.colon) " " (effects.join("; ")) }
    }
}
