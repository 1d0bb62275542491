//! `/diagnoses`: what the diagnoses of all campaigns say together, and the orders to make them.

mod orders;

use super::figure::percent;
use super::form::{choice, fault_list, said, see_other};
use super::layout::{effect_named, joined, query};
use super::prelude::*;
use super::residuals::closure_bar;
use crate::core::effects::CATALOGUE;
use crate::pipeline::DiagnosisOrder;
use crate::wire::diagnoses::{
    AtStationBody, DoubtBody, FindingBody, OverviewBody, SightingBody, SummaryBody, WhichBody,
};

pub(super) use orders::cancel;
use orders::{DiagnosisForm, beginning};

/// What the summary is narrowed down to; what is empty narrows nothing.
#[derive(Debug, Default, Clone, Deserialize)]
#[serde(default)]
pub(super) struct Filters {
    imu: String,
    station: String,
    effect: String,
    /// A date, or RFC 3339.
    since: String,
}

impl Filters {
    fn which(&self) -> WhichBody {
        let since = beginning(&self.since);
        WhichBody { imu: said(&self.imu), station: said(&self.station), since, ..WhichBody::default() }
    }

    /// The same summary from the interface.
    fn csv(&self) -> String {
        let since = beginning(&self.since).unwrap_or_default();
        let (imu, station, effect) = (self.imu.trim(), self.station.trim(), self.effect.trim());
        let all = [("format", "csv"), ("imu", imu), ("station", station), ("effect", effect), ("since", &since)];
        format!("/v1/diagnoses/summary?{}", query(all))
    }
}

pub(super) async fn start(visit: PageContext, Form(wanted): Form<DiagnosisForm>) -> Result<Response, Problem> {
    let diagnoses = &visit.0.pipeline.diagnoses;
    match diagnoses.check_wanted(wanted.which()) {
        Ok(order) => {
            diagnoses.order(DiagnosisOrder::Start(order)).await?;
            Ok(see_other("/diagnoses#orders"))
        }
        Err(faults) => Ok(build(&visit, &Filters::default(), &wanted, Some(&faults)).await?.into_response()),
    }
}

pub(super) async fn page(visit: PageContext, Query(filters): Query<Filters>) -> Result<(StatusCode, Page), Problem> {
    build(&visit, &filters, &DiagnosisForm::default(), None).await
}

/// The whole page; `wrong` is what is wrong with an order that was just sent.
async fn build(
    PageContext(pages, viewer): &PageContext,
    filters: &Filters,
    wanted: &DiagnosisForm,
    wrong: Option<&Faults>,
) -> Result<(StatusCode, Page), Problem> {
    let t = viewer.text();
    let filter = pages.pipeline.diagnoses.summary_filter(&filters.which(), said(&filters.effect).as_deref());
    let (summary, unusable) = match filter {
        Ok(filter) => (pages.pipeline.diagnoses.summary(&filter).await?, None),
        Err(faults) => (SummaryBody::default(), Some(faults)),
    };
    let orders = orders::section(pages, viewer).await?;
    let body = html! {
        h1 { (t.diagnoses) }
        p.note { (t.diagnoses_note) }
        (search(t, filters))
        @if let Some(faults) = &unusable { (fault_list(t, faults)) }
        @else { (shown(t, &summary, filters)) }
        (orders)
        @if viewer.may(Role::Engineer) { (orders::form(t, wanted, wrong)) }
    };
    let status = if wrong.is_some() {
        StatusCode::UNPROCESSABLE_ENTITY
    } else if unusable.is_some() {
        StatusCode::BAD_REQUEST
    } else {
        StatusCode::OK
    };
    Ok((status, Page { title: t.diagnoses.into(), section: Section::Diagnoses, body }))
}

fn search(t: &Text, filters: &Filters) -> Markup {
    let effects = CATALOGUE.iter().map(|entry| (entry.id, t.effect(entry.effect)));
    html! {
        form.search role="search" action="/diagnoses" method="get" {
            input type="search" name="imu" value=(filters.imu) placeholder=(t.imu) aria-label=(t.imu);
            input type="search" name="station" value=(filters.station) placeholder=(t.station) aria-label=(t.station);
            (choice(t, t.effect, "effect", effects, &filters.effect))
            label { (t.measured_since) " " input type="date" name="since" value=(filters.since); }
            button { (t.search) }
        }
    }
}

fn shown(t: &Text, summary: &SummaryBody, filters: &Filters) -> Markup {
    let c = &summary.campaigns;
    let counts = [
        (t.coverage_no_gap, c.no_gap),
        (t.coverage_explained, c.explained),
        (t.coverage_partly_explained, c.partly_explained),
        (t.coverage_unexplained, c.unexplained),
        (t.coverage_refused, c.refused),
        (t.coverage_waiting, c.waiting),
        (t.coverage_outdated, c.outdated),
    ];
    html! {
        section {
            h2 { (t.what_was_found) }
            p.lead { (t.campaigns_diagnosed) " " strong { (c.diagnosed) } }
            dl.facts { @for (name, count) in counts { @if count > 0 { dt { (name) } dd { (count) } } } }
            @if summary.effects.is_empty() { p { (t.no_effect) } } @else { (overview(t, &summary.effects)) }
        }
        @if !summary.findings.is_empty() {
            section {
                h2 { (t.gyro_by_gyro) }
                p.note { (t.findings_note) " " (t.unit) }
                (findings(t, &summary.findings))
                p { a href=(filters.csv()) { (t.csv) } }
            }
        }
        @if !summary.doubts.is_empty() {
            section { h2 { (t.not_explained) } p.note { (t.doubts_note) } (doubts(t, &summary.doubts)) }
        }
    }
}

fn overview(t: &Text, effects: &[OverviewBody]) -> Markup {
    html! {
        (wide_table("", html! {
            th { (t.effect) } th { (t.imu) } th.n.capital { (t.gyros) } th { (t.station) } th.n { (t.campaigns) }
            th { (t.first_seen) } th { (t.last_seen_in) }
        }, html! { @for one in effects { tr {
            th.words scope="row" { a href={ "/diagnoses?effect=" (encoded(&one.effect)) } { (effect_named(t, &one.effect)) } }
            td.words { (joined(", ", one.imus.iter().map(|imu| imu_link(imu)))) }
            td.n { (one.gyros) }
            td.words translate="no" { (names(&one.stations)) }
            td.n { (one.campaigns) }
            td { (written(&one.first_at)) } td { (written(&one.last_at)) }
        } } }))
    }
}

fn findings(t: &Text, all: &[FindingBody]) -> Markup {
    html! {
        (wide_table("findings", html! {
            th { (t.effect) } th { (t.serial) } th { (t.imu) }
            th { (t.station) } th { (t.last_clear) } th { (t.first_seen) }
            th { (t.last_seen_in) } th.n { (t.campaigns) } th { (t.closed) }
            th.n { (t.shift) " " (symbol("D_I")) } th.n { (t.shift) " " (symbol("D_S")) }
        }, html! { @for one in all { (finding(t, one)) } }))
    }
}

fn finding(t: &Text, one: &FindingBody) -> Markup {
    let others = || one.class.iter().filter(|id| **id != one.effect);
    html! {
        tr {
            th.words scope="row" {
                (effect_named(t, &one.effect))
                @if others().count() > 0 {
                    br; span.quiet { (t.or_as_well) " " (joined("; ", others().map(|id| effect_named(t, id)))) }
                }
            }
            td translate="no" { a.id href={ "/gyros/" (encoded(&one.serial)) } { (one.serial) } " " (one.slot) }
            td { (imu_link(&one.imu)) }
            td.words translate="no" { (joined(", ", one.stations.iter().map(at_station))) }
            td { (or_dash(one.clear_at.as_deref().map(written))) }
            td { (sighting(&one.first)) } td { (sighting(&one.last)) }
            td.n { (one.campaigns) " / " (one.of_since) " / " (one.of) }
            td.nowrap { (closure_bar(one.closure.median, Some([one.closure.least, one.closure.greatest]))) (percent(one.closure.median)) }
            @for coefficient in ["D_I", "D_S"] {
                td.n {
                    @if let Some(i) = one.impact.iter().find(|i| i.coefficient == coefficient) {
                        a href={ "/campaigns/" (i.campaign) "/diagnosis" } { (format!("{:+.6}", i.shift)) } " (" (percent(i.of_budget)) ")"
                    } @else { "–" }
                }
            }
        }
    }
}

fn doubts(t: &Text, all: &[DoubtBody]) -> Markup {
    html! {
        (wide_table("", html! {
            th { (t.imu) } th { (t.verdict_word) } th { (t.serial) } th { (t.signs_word) } th { (t.station) }
            th.n { (t.campaigns) } th { (t.first_seen) } th { (t.last_seen_in) }
        }, html! { @for one in all { tr {
            th scope="row" { (imu_link(&one.imu)) }
            td { (if one.verdict == "unexplained" { t.coverage_unexplained } else { t.coverage_partly_explained }) }
            td.words translate="no" { (names(&one.gyros)) }
            td.words { (joined("; ", one.signs.iter().map(|sign| t.sign(sign)))) }
            td.words translate="no" { (names(&one.stations)) }
            td.n { (one.campaigns) " / " (one.of) }
            td { (sighting(&one.first)) } td { (sighting(&one.last)) }
        } } }))
    }
}

fn imu_link(imu: &str) -> Markup {
    html! { a.id href={ "/imus/" (encoded(imu)) } translate="no" { (imu) } }
}

fn names(all: &[String]) -> Markup {
    joined(", ", all.iter().map(|name| html! { span.id { (name) } }))
}

fn at_station(station: &AtStationBody) -> Markup {
    html! { span.id { (station.station) } " " span.quiet { (station.campaigns) "/" (station.of) } }
}

fn sighting(seen: &SightingBody) -> Markup {
    html! { a href={ "/campaigns/" (seen.campaign) "/diagnosis" } { (written(&seen.measured_at)) } }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_way_to_the_csv_keeps_the_filters() {
        let filters = Filters { imu: "A&B".into(), since: "2026-03-01".into(), ..Filters::default() };
        assert_eq!(filters.csv(), "/v1/diagnoses/summary?format=csv&imu=A%26B&since=2026-03-01T00%3A00%3A00Z");
    }
}
