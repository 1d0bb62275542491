//! Gyros over one another: deviations from their own baselines on one scale.

use crate::core::figures::Figures;
use crate::core::gyro_event::GyroEvent;
use crate::core::judge::limits::DEFAULT_BUDGET;
use crate::core::judge::{Finding, Verdict};
use crate::pages::chart::{Chart, DataPoint, Flag, Level, Track, XAxis, bounds, millis, widened};
use crate::pages::gyro_facts::Facts;
use crate::pages::history::event_label;
use crate::pages::history_plot::{MOST_FLAGS, epoch_of, list};
use crate::pages::prelude::*;
use crate::pages::verdicts::{SeenVerdict, seen};
use crate::pages::view::View;
use crate::pages::{bullet, history, status};
use crate::pipeline::{Names, StoredRecord, sample_of};
use crate::wire::answer::{FigureBody, VerdictBody};

/// Records of one gyro that are drawn, the newest.
const MOST_RECORDS: usize = 200;
const DAY: f64 = 864e5;

struct Compared<'a> {
    serial: &'a str,
    facts: Facts,
    /// Of its newest record, and of the one with which its newest baseline began.
    scale_factors: [Option<FigureBody>; 2],
}

impl Compared<'_> {
    /// Where x is time, or the time since the newest baseline began.
    fn place(&self, at: UtcMicros, column: usize, aligned: bool) -> f64 {
        if aligned { at.days_since(self.began(column)) } else { millis(at) }
    }

    fn began(&self, column: usize) -> UtcMicros {
        self.facts.epochs[column].last().map_or(UtcMicros(0), |epoch| epoch.from)
    }
}

/// `aligned`: x is the time since each gyro's newest baseline began.
pub(super) async fn page(pages: &Pages, viewer: &Viewer, serials: &[&str], aligned: bool) -> Result<Page, Problem> {
    let t = viewer.text();
    let view = View::whole(pages.config.judging.method);
    let mut all = Vec::new();
    for serial in serials {
        let number = pages.gyro_number(serial)?;
        let facts = Facts::of(pages, number, serial, &view, 0).await?;
        let rows = &facts.course.figures;
        let began = facts.epochs[0].last().map_or(UtcMicros(0), |epoch| epoch.from);
        let (now, began) = (rows.last(), rows.iter().find(|row| row.at >= began));
        let scale_factors = [scale_factor(pages, now, serial).await?, scale_factor(pages, began, serial).await?];
        all.push(Compared { serial, facts, scale_factors });
    }
    let happened = happened(t, &all, aligned);
    let names = pages.pipeline.queries.names();
    let query: String = serials.iter().map(|serial| format!("&gyro={}", encoded(serial))).collect();
    let title = format!("{} {}", t.compare, serials.join(", "));
    let body = html! {
        h1 { (t.compare) }
        p.lead { @for (k, one) in all.iter().enumerate() {
            span.nowrap {
                svg.key.line aria-hidden="true" viewBox="-24 -7 48 14" {
                    path class={ "join k" (k) } d="M-24 0H24" {}
                    g class={ "k" (k) } { circle.plain r="4" {} }
                }
                a href={ "/gyros/" (encoded(one.serial)) } { (one.serial) } } " "
        } }
        (table(t, &view, &all, &names))
        (scale_factor_table(t, &all))
        section #history {
            div.tabs { nav aria-label=(t.span_word) {
                a href={ "?align=time" (query) } aria-current=[(!aligned).then_some("true")] { (t.same_time) }
                a href={ "?align=baseline" (query) } aria-current=[aligned.then_some("true")] {
                    (t.time_since_baseline)
                }
            } }
            div.charts { @for column in 0..3 { (chart(t, &view, &all, column, aligned, &happened).markup()) } }
            (list(&happened))
            p.note { (t.compare_note) }
        }
    };
    Ok(Page { title, section: Section::Fleet, body })
}

/// How each stands, and how it behaves.
fn table(t: &Text, view: &View, all: &[Compared<'_>], names: &Names<'_>) -> Markup {
    html! {
        (wide_table("cards wrapped", html! {
            th { (t.serial) } th { (t.imu) } th { (t.station) } th { (t.status_word) }
            @for name in DRIFTS { th.n { (t.axis_deviation) " " (symbol(name)) ", %" } }
            @for name in &DRIFTS[..2] { th.n { (t.trend_a_year) " " (symbol(name)) ", %" } }
            @for name in &DRIFTS[..2] { th.n { (t.scatter) " " (symbol(name)) " / " (t.limit_within) } }
            th.capital { (t.baseline_word) } th.n { (t.records_word) }
        }, html! { @for one in all { (row(t, view, one, names)) } }))
        p.note { "%: " (t.percent_of_budget) }
    }
}

fn row(t: &Text, view: &View, one: &Compared<'_>, names: &Names<'_>) -> Markup {
    let facts = &one.facts;
    let stands = facts.stands(view.judged);
    let newest = facts.course.figures.last();
    let of_scatter = |said: &&SeenVerdict| said.body.rule == Rule::RmsSuccessive.name();
    let share = |of: Option<Measured>| or_dash(of.map(|of| bullet::share(t, of)));
    let scatter = |name: &str| facts.verdicts.iter().filter(of_scatter).find(|said| said.body.coefficient == name);
    html! {
        tr {
            th scope="row" { a href={ "/gyros/" (encoded(one.serial)) } { (one.serial) } }
            td data-label=(t.imu) { @if let Some(figures) = newest { (history::seat(figures, names)) } }
            td data-label=(t.station) { @if let Some(figures) = newest { (names.station(figures.station)) } }
            td data-label=(t.status_word) { (status::badge(t, facts.standing.as_ref().and_then(|standing| standing.status))) }
            @for (column, name) in DRIFTS.iter().enumerate() {
                td.n { (label("", name)) (share(stands.get(column).and_then(|stand| Some(stand.load?.share())))) }
            }
            @for name in &DRIFTS[..2] { td.n { (label(t.trend_a_year, name)) (share(slope(facts, name))) } }
            @for name in &DRIFTS[..2] {
                td.n {
                    (label(t.scatter, name))
                    @if let Some(VerdictBody { value: Some(value), limit, .. }) = scatter(name).map(|said| &said.body) {
                        (figure::percent(value / limit))
                    } @else { "–" }
                }
            }
            td.nowrap data-label=(t.baseline_word) { @if let Some(epoch) = facts.epochs[0].last() { (epoch.from.date()) } }
            td.n data-label=(t.records_word) { (facts.course.figures.len()) }
        }
    }
}

/// |E| of a gyro in a record.
async fn scale_factor(pages: &Pages, row: Option<&Figures>, serial: &str) -> Result<Option<FigureBody>, Problem> {
    let Some(row) = row else { return Ok(None) };
    let stored = pages.pipeline.queries.records.record(row.record).await?;
    let own = |stored: StoredRecord| stored.answer.separations.into_iter().find(|one| one.serial == serial);
    Ok(stored.and_then(own).map(|one| one.scale_factor))
}

fn scale_factor_table(t: &Text, all: &[Compared<'_>]) -> Markup {
    html! {
        (wide_table("cards wrapped", html! {
            th { (t.serial) } th.n { "|E|, pulse/arcsec" } th.n { "Δ|E|, ppm, " (t.scale_factor_moved) }
        }, html! { @for one in all { @if let [Some(now), began] = one.scale_factors { tr {
            th scope="row" { (one.serial) }
            td.n data-label="|E|, pulse/arcsec" { (figure::with_sd(now.value, now.sd, 6)) }
            td.n data-label={ "Δ|E|, ppm, " (t.scale_factor_moved) } {
                @if let Some(began) = began {
                    @let ppm = |value: f64| 1e6 * value / began.value;
                    @let sd = now.sd.zip(began.sd).map(|(now, began)| ppm(now.hypot(began)));
                    (figure::with_sd(ppm(now.value - began.value), sd, 1))
                } @else { "–" }
            }
        } } } }))
    }
}

/// What happened to the gyros, numbered in the order of time as in the list under the pictures.
fn happened(t: &Text, all: &[Compared<'_>], aligned: bool) -> Vec<Flag> {
    let of_gyro = |one: &Compared<'_>| -> Vec<(UtcMicros, Flag)> {
        let place = |at: UtcMicros| one.place(at, 0, aligned);
        let flag = |event: &GyroEvent| Flag {
            x: place(event.at),
            until: event.until.map(place),
            number: 0,
            anchor: String::new(),
            label: format!("{} {} · {}", event.at.date(), one.serial, event_label(t, event)),
        };
        one.facts.course.events.iter().map(|event| (event.at, flag(event))).collect()
    };
    let mut flags: Vec<(UtcMicros, Flag)> = all.iter().flat_map(of_gyro).collect();
    flags.sort_by_key(|(at, _)| *at);
    flags.drain(..flags.len().saturating_sub(MOST_FLAGS));
    let numbered =
        |(k, (_, flag)): (usize, (UtcMicros, Flag))| Flag { number: k + 1, anchor: format!("event-{}", k + 1), ..flag };
    flags.into_iter().enumerate().map(numbered).collect()
}

/// What the trend rule has established of the newest record, budgets a year.
fn slope(facts: &Facts, name: &str) -> Option<Measured> {
    let is_trend = |verdict: &&Verdict| verdict.rule == Rule::Trend && verdict.coefficient.name() == name;
    seen(&facts.verdicts).filter(is_trend).find_map(|verdict| match verdict.finding {
        Finding::Trend { per_year: Measured { value, sd }, .. } => {
            Some(Measured { value: value / verdict.limit, sd: sd.map(|sd| sd / verdict.limit) })
        }
        _ => None,
    })
}

fn chart(t: &Text, view: &View, all: &[Compared<'_>], column: usize, aligned: bool, happened: &[Flag]) -> Chart {
    let name = DRIFTS[column];
    let budget = all.iter().find_map(|one| one.facts.course.limits.budgets()[column]);
    let track = |(k, one): (usize, &Compared<'_>)| {
        let (facts, epochs) = (&one.facts, &one.facts.epochs[column]);
        let rows = facts.course.figures.iter().filter(|row| !aligned || row.at >= one.began(column));
        let mut dots: Vec<DataPoint> = rows
            .map(|row| {
                let measured = sample_of(row, view.judged).d[column];
                let y = measured.value - epoch_of(epochs, row.at).map_or(0.0, |epoch| epoch.zero);
                let status = facts.statuses.get(row, column);
                let said =
                    format!("{} · {} {name} {}", row.at.date(), one.serial, figure::signed_drift(y, measured.sd));
                DataPoint {
                    x: one.place(row.at, column, aligned),
                    y,
                    sd: measured.sd,
                    href: Some(format!("/records/{}", row.record)),
                    said: format!("{said} · {}", t.status(status)),
                    // What is beyond a limit has its shape; its colour is the gyro's.
                    status: (status >= Status::Drifting).then_some(status),
                    ..DataPoint::default()
                }
            })
            .collect();
        dots.drain(..dots.len().saturating_sub(MOST_RECORDS));
        let breaks = epochs.iter().skip(1).map(|epoch| one.place(epoch.from, column, aligned)).collect();
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
        around: budget.unwrap_or(DEFAULT_BUDGET),
        whole: budget,
        signed: true,
        clips: true,
        levels: vec![Level { from: x.0, until: x.1, budget, ..Level::default() }],
        tracks,
        flags: happened.iter().filter(|flag| (x.0..=x.1).contains(&flag.x)).cloned().collect(),
        ..Chart::new(
            label,
            caption,
            if aligned { XAxis::Figure(t.days_since_baseline.to_owned()) } else { XAxis::Time },
            x,
        )
    }
}
