//! Gyros over one another: deviations from their own baselines on one scale.

use maud::{Markup, html};

use crate::core::judge::{Finding, Measured, Rule, Status};
use crate::core::time::UtcMicros;
use crate::pages::chart::{Across, Chart, Dot, Level, Track, bounds, millis, widened};
use crate::pages::gyro::{Facts, known};
use crate::pages::history_plot::{budgets, epoch_of};
use crate::pages::layout::{DRIFTS, Page, Section, encoded, symbol};
use crate::pages::text::Text;
use crate::pages::view::View;
use crate::pages::viewer::Viewer;
use crate::pages::{Pages, bullet, figure, history, status};
use crate::pipeline::{Names, sample_of};
use crate::wire::problem::Problem;

/// Records of one gyro that are drawn, the newest.
const MOST_RECORDS: usize = 200;
const DAY: f64 = 864e5;

struct Compared<'a> {
    serial: &'a str,
    facts: Facts,
}

/// `aligned`: x is the time since each gyro's newest baseline began.
pub(super) async fn page(pages: &Pages, viewer: &Viewer, serials: &[&str], aligned: bool) -> Result<Page, Problem> {
    let t = viewer.text();
    let view = View::whole(pages.config.judging.method);
    let mut all = Vec::new();
    for serial in serials {
        let number = known(pages, serial)?;
        all.push(Compared { serial, facts: Facts::of(pages, number, serial, &view, 0).await? });
    }
    let names = pages.pipeline.queries.names();
    let query: String = serials.iter().map(|serial| format!("&gyro={}", encoded(serial))).collect();
    let title = format!("{} {}", t.compare, serials.join(", "));
    let body = html! {
        h1 { (t.compare) }
        p.lead { @for (k, one) in all.iter().enumerate() {
            span.nowrap {
                svg.key aria-hidden="true" viewBox="-7 -7 14 14" { g class={ "k" (k) } { circle.plain r="4" {} } }
                a href={ "/gyros/" (encoded(one.serial)) } { (one.serial) } } " "
        } }
        (table(t, &view, &all, &names))
        section #history {
            div.tabs { nav aria-label=(t.span_word) {
                a href={ "?align=time" (query) } aria-current=[(!aligned).then_some("true")] { (t.same_time) }
                a href={ "?align=baseline" (query) } aria-current=[aligned.then_some("true")] {
                    (t.time_since_baseline)
                }
            } }
            div.charts { @for column in 0..3 { (chart(t, &view, &all, column, aligned).markup()) } }
            p.note { (t.compare_note) }
        }
    };
    Ok(Page { title, section: Section::Fleet, body })
}

/// How each stands, and how it behaves.
fn table(t: &Text, view: &View, all: &[Compared<'_>], names: &Names<'_>) -> Markup {
    html! {
        div.scroll tabindex="0" { table.cards.wrapped {
            thead { tr {
                th { (t.serial) } th { (t.imu) } th { (t.station) } th { (t.status_word) }
                @for name in DRIFTS { th.n { (t.axis_deviation) " " (symbol(name)) ", %" } }
                @for name in &DRIFTS[..2] { th.n { (t.trend_a_year) " " (symbol(name)) ", %" } }
                @for name in &DRIFTS[..2] { th.n { (t.scatter) " " (symbol(name)) } }
                th { (t.baseline_word) } th.n { (t.records_word) }
            } }
            tbody { @for one in all { (row(t, view, one, names)) } }
        } }
        p.note { "%: " (t.percent_of_budget) ". " (t.scatter) ": " (t.unit) }
    }
}

fn row(t: &Text, view: &View, one: &Compared<'_>, names: &Names<'_>) -> Markup {
    let facts = &one.facts;
    let stands = facts.stands(view.judged);
    let newest = facts.course.figures.last();
    let scatter =
        |column: usize| facts.epochs[column].last().and_then(|epoch| epoch.control).map(|control| control / 3.0);
    html! {
        tr {
            th scope="row" { a href={ "/gyros/" (encoded(one.serial)) } { (one.serial) } }
            td { @if let Some(figures) = newest { (history::seat(figures, names)) } }
            td { @if let Some(figures) = newest { (names.station(figures.station)) } }
            td { (status::badge(t, facts.standing.as_ref().and_then(|standing| standing.status))) }
            @for (column, name) in DRIFTS.iter().enumerate() {
                td.n data-label=(name) {
                    @if let Some(load) = stands.get(column).and_then(|stand| stand.load) {
                        (bullet::percent(load.share())) " %"
                    } @else {
                        "–"
                    }
                }
            }
            @for name in &DRIFTS[..2] {
                td.n data-label={ (t.trend_a_year) " " (name) } {
                    @if let Some(slope) = slope(facts, name) {
                        (bullet::percent(slope)) " %"
                    } @else {
                        "–"
                    }
                }
            }
            @for (column, name) in DRIFTS[..2].iter().enumerate() {
                td.n data-label={ (t.scatter) " " (name) } {
                    @if let Some(scatter) = scatter(column) { (figure::short(scatter)) } @else { "–" }
                }
            }
            td.nowrap { @if let Some(epoch) = facts.epochs[0].last() { (epoch.from.date()) } }
            td.n data-label=(t.records_word) { (facts.course.figures.len()) }
        }
    }
}

/// What the trend rule has established of the newest record, budgets a year.
fn slope(facts: &Facts, name: &str) -> Option<Measured> {
    let seen = facts.verdicts.iter().filter_map(|said| said.seen.as_ref());
    let of_trend = seen.filter(|verdict| verdict.rule == Rule::Trend && verdict.coefficient.name() == name);
    of_trend.into_iter().find_map(|verdict| match verdict.finding {
        Finding::Trend { per_year: Measured { value, sd }, .. } => {
            Some(Measured { value: value / verdict.limit, sd: sd.map(|sd| sd / verdict.limit) })
        }
        _ => None,
    })
}

fn chart(t: &Text, view: &View, all: &[Compared<'_>], column: usize, aligned: bool) -> Chart {
    let name = DRIFTS[column];
    let budget = all.iter().find_map(|one| budgets(&one.facts.course.limits)[column]);
    let track = |(k, one): (usize, &Compared<'_>)| {
        let (facts, epochs) = (&one.facts, &one.facts.epochs[column]);
        let began = epochs.last().map_or(UtcMicros(0), |epoch| epoch.from);
        let rows = facts.course.figures.iter().filter(|row| !aligned || row.at >= began);
        let mut dots: Vec<Dot> = rows
            .map(|row| {
                let measured = sample_of(row, view.judged).d[column];
                let y = measured.value - epoch_of(epochs, row.at).map_or(0.0, |epoch| epoch.zero);
                let status = facts.statuses.get(row, column);
                let said =
                    format!("{} · {} {name} {}", row.at.date(), one.serial, figure::signed_drift(y, measured.sd));
                Dot {
                    x: if aligned { row.at.days_since(began) } else { millis(row.at) },
                    y,
                    sd: measured.sd,
                    href: Some(format!("/records/{}", row.record)),
                    said: format!("{said} · {}", t.status(status)),
                    // What is beyond a limit has its shape; its colour is the gyro's.
                    status: (status >= Status::Drifting).then_some(status),
                    ..Dot::default()
                }
            })
            .collect();
        dots.drain(..dots.len().saturating_sub(MOST_RECORDS));
        let place = |at: UtcMicros| if aligned { at.days_since(began) } else { millis(at) };
        let breaks = epochs.iter().skip(1).map(|epoch| place(epoch.from)).collect();
        Track { class: format!("k{k}"), dots, breaks, joined: true, envelope: Vec::new() }
    };
    let tracks: Vec<Track> = all.iter().enumerate().map(track).collect();
    let ends = bounds(tracks.iter().flat_map(|track| track.dots.iter().map(|dot| dot.x))).unwrap_or((0.0, 0.0));
    let x = widened(ends, 0.02, if aligned { 15.0 } else { 15.0 * DAY });
    let caption = html! {
        span { (symbol(name)) ", " (t.deviation) ", " (t.unit) }
        span.quiet { (t.percent_of_budget) }
    };
    let serials: Vec<&str> = all.iter().map(|one| one.serial).collect();
    let label = format!("{name}, {}: {}. {}", t.deviation, serials.join(", "), t.chart_keys);
    Chart {
        around: budget.unwrap_or(crate::core::judge::limits::DEFAULT_BUDGET),
        whole: budget,
        signed: true,
        clips: true,
        levels: vec![Level { from: x.0, until: x.1, budget, ..Level::default() }],
        tracks,
        ..Chart::new(
            label,
            caption,
            if aligned { Across::Figure(t.days_since_baseline.to_owned()) } else { Across::Time },
            x,
        )
    }
}
