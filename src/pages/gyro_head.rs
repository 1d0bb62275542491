//! The head of a gyro's page: how it stands, by how much, since when, why, and what to do.

use super::gyro_facts::Facts;
use super::history::seat;
use super::history_plot::epoch_of;
use super::layout::day;
use super::prelude::*;
use super::verdicts::{self, SeenVerdict, seen};
use super::{bullet, gyro_attributes, status};
use crate::config::JudgedMethod;
use crate::core::changes::{ChangeCause, HistoryDiagnosis, NamedCause};
use crate::core::gyro_event::{GyroEvent, standing_decision};
use crate::core::judge::{Coefficient, Event, Finding, Load, Suggestion, SuggestionInput, Verdict, suggest};
use crate::core::message::text;
use crate::pipeline::{ExplainedHistory, Names, Violation, sample_of};
use crate::wire::note::NoteBody;

/// Causes of one coefficient's change in the head; all of them are on the page of the diagnosis.
const MOST_CAUSES: usize = 3;
/// A coefficient that is as bad as that at least is asked why it changes: what keeps a rule from deciding may be a change.
const ASKED_WHY: Status = Status::TooUncertain;

/// Since when a coefficient has been as it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Run {
    pub since: UtcMicros,
    pub records: usize,
}

/// How one coefficient stands at the newest record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct CoefficientSummary {
    pub column: usize,
    pub measured: Measured,
    pub status: Status,
    /// None while there is no level, or no budget.
    pub load: Option<Load>,
    /// The rule that says so, and its figure over its limit, where it is another than the load.
    pub by: Option<(Rule, Option<f64>)>,
    /// Where it is out of tolerance or drifts.
    pub run: Option<Run>,
}

impl Facts {
    /// D_I, D_S and D_O by the judged method; nothing for a gyro that was never calibrated.
    pub fn stands(&self, judged: JudgedMethod) -> Vec<CoefficientSummary> {
        let Some(newest) = self.course.figures.last() else { return Vec::new() };
        let sample = sample_of(newest, judged);
        let stand = |column: usize| {
            let of_verdict =
                seen(&self.verdicts).filter(|verdict| verdict.coefficient.name() == DRIFTS[column]).find_map(Load::of);
            CoefficientSummary {
                column,
                measured: sample.d[column],
                status: self.standing.as_ref().map_or(Status::NotEnoughData, |standing| standing.drift[column]),
                load: of_verdict.or_else(|| self.load_now(column, newest.at, sample.d[column])),
                by: self.violated(column),
                run: self.run(column),
            }
        };
        (0..3).map(stand).collect()
    }

    /// By today's limits and the level that is drawn, where the verdict was decided by others.
    fn load_now(&self, column: usize, at: UtcMicros, measured: Measured) -> Option<Load> {
        let level = epoch_of(&self.epochs[column], at)?
            .level
            .filter(|_| self.verdicts.iter().any(|said| said.seen.is_none()))?;
        let budget = self.course.limits.budgets()[column].filter(|budget| *budget > 0.0)?;
        Some(Load { deviation: Measured { value: measured.value - level, sd: measured.sd }, level, budget })
    }

    /// The rule by which a coefficient stands as badly as it does; none where it is its load that says so.
    fn violated(&self, column: usize) -> Option<(Rule, Option<f64>)> {
        let standing = self.standing.as_ref()?;
        if standing.drift[column] == Status::Borderline {
            return self.undecided(column);
        }
        let of_it = |one: &&Violation| one.coefficient.name() == DRIFTS[column] && one.status == standing.drift[column];
        let said: Vec<&Violation> = standing.violations.iter().filter(of_it).collect();
        let of_load = said.iter().any(|one| matches!(one.rule, Rule::Baseline | Rule::Closure));
        let worst = said.into_iter().max_by(|a, b| a.load.unwrap_or(0.0).total_cmp(&b.load.unwrap_or(0.0)));
        worst.filter(|_| !of_load).map(|one| (one.rule, one.load))
    }

    /// The rule that cannot decide on a borderline coefficient, and how much of its limit is taken up.
    fn undecided(&self, column: usize) -> Option<(Rule, Option<f64>)> {
        let of_it = |said: &&SeenVerdict| {
            said.status() == Status::Borderline && said.body.coefficient == DRIFTS[column] && said.body.value.is_some()
        };
        let load = |said: &SeenVerdict| said.body.value.map(|value| value / said.body.limit);
        let all =
            self.verdicts.iter().filter(of_it).filter_map(|said| Some((Rule::from_name(&said.body.rule)?, load(said))));
        all.max_by(|a, b| a.1.unwrap_or(0.0).total_cmp(&b.1.unwrap_or(0.0)))
    }

    /// Since when it is out of tolerance, or drifts: as the alert says that fires, else the newest records that all are.
    fn run(&self, column: usize) -> Option<Run> {
        let out = |status: Status| (status >= Status::Drifting).then_some(status > Status::Drifting);
        let is_out = |row| out(self.statuses.get(row, column));
        let rows = &self.course.figures;
        let now = is_out(rows.last()?)?;
        let alerts = self.alerts.iter().filter(|alert| alert.coefficient == DRIFTS[column]);
        let alike = alerts.filter(|alert| alert.status().and_then(out) == Some(now));
        let told = alike.filter_map(|alert| time::parse(alert.since.as_deref()?).ok()).min();
        let run = rows.iter().rev().take_while(|row| is_out(row) == Some(now)).count();
        let since = told.unwrap_or(rows[rows.len() - run].at);
        Some(Run { since, records: rows.len() - rows.partition_point(|row| row.at < since) })
    }

    /// What the verdicts suggest; nothing for a gyro that is out of use.
    pub fn suggestion(&self, explained: Option<&ExplainedHistory>) -> Option<Suggestion> {
        let standing = self.standing.as_ref().filter(|standing| standing.out_of_use.is_none())?;
        let judged = self.verdicts.iter().filter(|said| said.body.value.is_some());
        let judged = judged.filter_map(|said| Some((Coefficient::from_name(&said.body.coefficient)?, said.status())));
        let told = standing.violations.iter().map(|violation| (violation.coefficient, violation.status));
        // A record that was left out is explained by nothing.
        let holds_now = |answer: &&HistoryDiagnosis| {
            explained.is_some_and(|explained| answer.newest_left_out(explained.as_of).is_none())
        };
        let mut out = self.answers(explained, Status::OutOfTolerance).peekable();
        let reaches_at = self.may_reach(explained);
        let newest = self.course.figures.last().map(|newest| newest.at);
        // A step scatters by itself, as long as it is among the newest records.
        let has_stepped = |of: Coefficient| {
            let mut answers = self.answers(explained, Status::Drifting).filter(holds_now);
            answers.any(|answer| answer.coefficient == of && answer.is_one_step())
        };
        let mut borderline = self.answers(explained, Status::Borderline).peekable();
        let ages = |answer: &HistoryDiagnosis| answer.causes.iter().any(|one| one.cause == ChangeCause::Ageing);
        let moves_on = |one: &&Violation| matches!(one.rule, Rule::Trend | Rule::RmsSuccessive);
        suggest(&SuggestionInput {
            // Of one that was never calibrated nothing is to be calibrated again.
            status: standing.status.filter(|of| standing.newest.is_some() || *of > Status::NotEnoughData),
            record_in_doubt: self.doubted.is_some(),
            is_stations: self.is_stations(explained),
            moved_together: !self.shared_shifts.is_empty(),
            verdicts: judged.chain(told).collect(),
            unsteady: standing.violations.iter().filter(moves_on).any(|one| !has_stepped(one.coefficient)),
            stepped_at_event: out.peek().is_some() && out.all(|answer| answer.is_one_event() && holds_now(&answer)),
            awaits_baseline: self.verdicts.iter().any(SeenVerdict::awaits_baseline),
            overdue: standing.overdue_days.is_some(),
            ages: borderline.peek().is_some() && borderline.all(ages),
            scatters: self.scatters(),
            reaches_in_days: reaches_at.zip(newest).map(|(at, newest)| at.days_since(newest)),
            may_have_reached: reaches_at.is_some_and(|at| at <= self.now),
            interval_days: self.course.limits.interval_days.map(|limit| limit.value),
        })
    }

    /// Whether its station has done all that is wrong with it: by its history, or as the station's alert says.
    fn is_stations(&self, explained: Option<&ExplainedHistory>) -> bool {
        let of_station = |answer: &HistoryDiagnosis| {
            let is_all = answer.causes.iter().all(|one| one.cause == ChangeCause::Station);
            let holds = explained.is_some_and(|explained| answer.newest_left_out(explained.as_of).is_none());
            !answer.causes.is_empty() && is_all && holds
        };
        // Where nothing is bad, what a trend carries to the budget is asked.
        let is_quiet = self.standing.as_ref().is_some_and(|standing| standing.status < Some(Status::Borderline));
        let is_carried = |answer: &&HistoryDiagnosis| is_quiet && self.reach_by_trend(answer.coefficient).is_some();
        let carried = self.answers(explained, Status::InTolerance).filter(is_carried);
        let mut bad = self.answers(explained, Status::Borderline).chain(carried).peekable();
        let mut fire = self.alerts.iter().filter(|alert| alert.rule != Rule::Overdue.name()).peekable();
        let explains = |alert: &AlertBody| {
            let is_it = |id: &String| self.shared_shifts.iter().any(|one| one.is_of_station() && one.id == *id);
            alert.inhibited_by.as_ref().is_some_and(is_it)
        };
        bad.peek().is_some() && bad.all(of_station) || fire.peek().is_some() && fire.all(explains)
    }

    /// Until when all that drifts is within its budget with 95 %, where its history says so.
    fn calibrate_by(&self, explained: Option<&ExplainedHistory>) -> Option<UtcMicros> {
        let newest = explained?.as_of.newest?;
        let days = self.answers(explained, ASKED_WHY).filter_map(|answer| answer.due?.calibrate_by);
        days.min_by(f64::total_cmp).map(|days| newest.plus_days(days))
    }

    /// From when on it may be beyond its budget: by its history, and where that says nothing of a coefficient by the
    /// rule `trend`.
    fn may_reach(&self, explained: Option<&ExplainedHistory>) -> Option<UtcMicros> {
        let has_no_date = |verdict: &&Verdict| {
            let is_it = |answer: &HistoryDiagnosis| answer.coefficient == verdict.coefficient && answer.due.is_some();
            !self.answers(explained, ASKED_WHY).any(is_it)
        };
        let by_trend = seen(&self.verdicts).filter(has_no_date).filter_map(|verdict| match verdict.finding {
            Finding::Trend { reach: [early, ..], .. } => early,
            _ => None,
        });
        by_trend.chain(self.calibrate_by(explained)).min()
    }

    /// When the rule `trend` sees a coefficient reach its budget, where that lies ahead.
    fn reach_by_trend(&self, coefficient: Coefficient) -> Option<UtcMicros> {
        let newest = self.course.figures.last()?.at;
        seen(&self.verdicts).filter(|verdict| verdict.coefficient == coefficient).find_map(|verdict| {
            match verdict.finding {
                Finding::Trend { reach: [_, at, _], .. } => at.filter(|at| *at > newest),
                _ => None,
            }
        })
    }

    /// Whether a coefficient is so bad that its cause is asked for.
    fn is_asked_why(&self) -> bool {
        self.standing.as_ref().is_some_and(|standing| standing.drift.iter().any(|drift| *drift >= ASKED_WHY))
    }

    /// Whether what is too uncertain of it is so by its own scatter; where it is borderline, whether by that alone.
    fn scatters(&self) -> bool {
        if self.standing.as_ref().is_some_and(|standing| standing.status == Some(Status::Borderline)) {
            let mut undecided = (0..3).filter_map(|column| self.undecided(column)).peekable();
            return undecided.peek().is_some() && undecided.all(|(rule, _)| rule == Rule::RmsSuccessive);
        }
        let newest = self.course.figures.last().map(|newest| sample_of(newest, self.judged));
        let stated = |verdict: &Verdict| newest.as_ref()?.d[verdict.coefficient.column()?].sd;
        let too_uncertain = |said: &&SeenVerdict| said.status() == Status::TooUncertain;
        let mut all = self.verdicts.iter().filter(too_uncertain).peekable();
        let scatters = |said: &SeenVerdict| said.seen.is_some_and(|verdict| verdict.is_too_scattered(stated(&verdict)));
        all.peek().is_some() && all.all(scatters)
    }

    /// What the history says of the coefficients that are so bad at least.
    fn answers<'a>(
        &'a self,
        explained: Option<&'a ExplainedHistory>,
        least: Status,
    ) -> impl Iterator<Item = &'a HistoryDiagnosis> {
        let drift = self.standing.as_ref().map(|standing| standing.drift);
        let all = explained.into_iter().flat_map(|explained| explained.coefficients.iter().enumerate());
        all.filter(move |(column, _)| drift.is_some_and(|drift| drift[*column] >= least)).map(|(_, answer)| answer)
    }

    /// What was decided last, and how many records have come since.
    pub fn decision(&self) -> Option<(&GyroEvent, usize)> {
        let last = standing_decision(self.course.events.iter())?;
        Some((last, self.course.figures.iter().filter(|row| row.at > last.at).count()))
    }
}

pub(super) fn head(
    viewer: &Viewer,
    serial: &str,
    facts: &Facts,
    judged: JudgedMethod,
    explained: Option<&ExplainedHistory>,
    names: &Names<'_>,
) -> Markup {
    let t = viewer.text();
    html! {
        h1 { (serial) " " (facts.badge(t)) }
        @if let Some(standing) = &facts.standing { (gyro_attributes::line(t, &standing.attributes)) }
        @if let Some(figures) = facts.course.figures.last() {
            p.lead {
                a href={ "/imus/" (encoded(names.imu(figures.imu))) } { (seat(figures, names)) }
                " · " (t.station) " " (names.station(figures.station))
                " · " (t.calibrated) " " (instant(figures.at))
            }
            (last_repair_or_move(t, facts, names))
            @if let Some(successor) = &facts.successor {
                p.note { (t.seat_taken) " " a href={ "/gyros/" (encoded(successor)) } { (successor) } }
            }
        } @else {
            p.lead { (t.never_calibrated) }
        }
        (loads(t, &facts.stands(judged)))
        div.causes {
            (causes(t, facts, explained))
            @if explained.is_none() && facts.is_asked_why() {
                p { strong { (t.cause) (t.colon) } a href={ "/gyros/" (encoded(serial)) "/diagnosis" } { (t.cause_elsewhere) } }
            }
        }
        (decided(viewer, serial, facts, explained))
    }
}

/// The figure of a gyro: how much of each budget is taken up, since when it is too much.
pub(super) fn loads(t: &Text, stands: &[CoefficientSummary]) -> Markup {
    html! {
        @if !stands.is_empty() {
            (wide_table("loads", html! {
                th { (t.coefficient) } th.n { (t.load) } td.bars {} th { (t.status_word) }
                th.n { (t.axis_deviation) ", " (t.unit) } th.n { (t.value) } th.n.capital { (t.baseline_word) }
            }, html! { @for stand in stands { (load_row(t, stand)) } }))
        }
    }
}

/// When it was repaired or moved last: what was before says little of it.
fn last_repair_or_move(t: &Text, facts: &Facts, names: &Names<'_>) -> Markup {
    let repair = facts.course.events.iter().rev().find(|one| one.event == Event::Repair);
    let pairs = facts.course.figures.windows(2).rev();
    let moved = pairs.map(|pair| (&pair[0], &pair[1])).find(|(from, to)| (from.imu, from.slot) != (to.imu, to.slot));
    html! {
        @if repair.is_some() || moved.is_some() {
            p.note {
                @if let Some(repair) = repair { (t.event(Event::Repair)) " " (day(repair.at)) }
                @if repair.is_some() && moved.is_some() { " · " }
                @if let Some((from, to)) = moved { (t.moved) " " (day(to.at)) ": " (seat(from, names)) " → " (seat(to, names)) }
            }
        }
    }
}

fn load_row(t: &Text, stand: &CoefficientSummary) -> Markup {
    let name = DRIFTS[stand.column];
    html! {
        tr {
            th scope="row" title=[Coefficient::from_name(name).map(|coefficient| t.meaning(coefficient))] {
                (symbol(name))
            }
            @if let Some(load) = &stand.load {
                td.n.load { (bullet::share(t, load.share())) }
                td.bars { (bullet::bar(load.share(), stand.status)) }
            } @else { td.n.load { "–" } td.bars {} }
            td.stands {
                (status::badge(t, Some(stand.status)))
                @if let Some((rule, load)) = stand.by {
                    (t.colon) " " (t.rule(rule))
                    @if let Some(load) = load {
                        " " (t.words(&message!("share_of_limit", percent = format!("{:.0}", 100.0 * load))))
                    }
                }
                @if let Some(run) = &stand.run {
                    " "
                    span.quiet { (t.since_then) " " (instant(run.since)) " (" (run.records) " " (t.records_short) ")" }
                } @else if stand.load.is_none() { " " span.quiet { (t.baseline_forming) } }
            }
            td.n data-label=(t.deviation) {
                @if let Some(load) = &stand.load { (figure::signed_drift(load.deviation.value, load.deviation.sd)) }
            }
            td.n.quiet data-label=(t.value) { (figure::drift(stand.measured.value, stand.measured.sd)) }
            td.n.quiet data-label=(t.baseline_word) {
                @if let Some(load) = &stand.load {
                    (format!("{:.*}", figure::places_beside(stand.measured.sd, 6), load.level))
                }
            }
        }
    }
}

/// Why those coefficients changed of which a rule speaks, or cannot decide, the gyro's own causes first; and when they
/// reach their budget.
pub(super) fn causes(t: &Text, facts: &Facts, explained: Option<&ExplainedHistory>) -> Markup {
    html! {
        @let drifting: Vec<Coefficient> = facts.answers(explained, Status::Drifting).map(|answer| answer.coefficient).collect();
        @let is_changed = |answer: &HistoryDiagnosis| explained.is_some_and(|explained| answer.is_changed(explained.as_of));
        @let is_told = |answer: &&HistoryDiagnosis| is_changed(answer) || drifting.contains(&answer.coefficient);
        @for alert in &facts.shared_shifts {
            p {
                strong { a href={ "/alerts/" (alert.id) } { (alert.name()) ", " (verdicts::violated(t, alert)) } (t.colon) } " "
                (t.reason(&alert.finding.reason))
            }
        }
        @for answer in facts.answers(explained, ASKED_WHY).filter(is_told) {
            p {
                strong { (t.cause) " " (symbol(answer.coefficient.name())) (t.colon) } " "
                (named(t, answer))
                @for said in explained.into_iter().flat_map(|explained| answer.in_brief(explained.as_of)) { (t.words(&said)) " " }
                @if let Some(at) = answer.due.as_ref().and(facts.reach_by_trend(answer.coefficient)) {
                    (t.words(&message!("history_due_by_trend", day = text(at.date()))))
                }
            }
        }
    }
}

/// The causes with their sizes, as a sentence; nothing where none is named.
pub(super) fn named(t: &Text, answer: &HistoryDiagnosis) -> Markup {
    html! {
        @for (k, cause) in own_first(answer).take(MOST_CAUSES).enumerate() {
            @if k > 0 { (t.semicolon) }
            (t.words(&cause.cause.word())) " ("
            (t.words(&cause.tie.message())) ") "
            span.nowrap {
                (figure::signed_drift(cause.estimate.value, Some(cause.estimate.sd))) " "
                (t.unit_of(cause.estimate.unit))
            }
            @for other in cause.class.iter().filter(|one| **one != cause.cause) {
                ", " (t.or_as_well) " " (t.words(&other.word()))
            }
        }
        @if !answer.causes.is_empty() { (t.stop) " " }
    }
}

/// The gyro's own causes, then what its stations did.
pub(super) fn own_first(answer: &HistoryDiagnosis) -> impl Iterator<Item = &NamedCause> {
    let of_station = |cause: &&NamedCause| cause.cause == ChangeCause::Station;
    let own = answer.causes.iter().filter(move |cause| !of_station(cause));
    own.chain(answer.causes.iter().filter(of_station))
}

/// What the verdicts suggest, what was decided, and what can be done.
fn decided(viewer: &Viewer, serial: &str, facts: &Facts, explained: Option<&ExplainedHistory>) -> Markup {
    let t = viewer.text();
    let suggestion = facts.suggestion(explained);
    let path = format!("/gyros/{}", encoded(serial));
    let first = match suggestion {
        Some(Suggestion::Remove | Suggestion::RemoveOrAccept | Suggestion::AcceptOrRemove) => Event::DecisionRemove,
        Some(Suggestion::Release) => Event::DecisionRelease,
        _ => Event::DecisionRetest,
    };
    html! {
        div.decision {
            (doubted(t, facts))
            (suggested(t, facts, explained))
            (decision(t, facts))
            p.actions {
                @if viewer.may(Role::Engineer) {
                    a.action.primary href={ (path) "/events/new?event=" (first.name()) } { (t.record_decision) }
                    @if facts.decision().is_some() {
                        a.action href={ (path) "/events/new?event=decision_withdrawn" } { (t.withdraw_decision) }
                    }
                    a.action href={ (path) "/events/new" } { (t.add_event) }
                    a.action href={ (path) "/events/new?event=baseline" } { (t.start_baseline) }
                }
                @if !facts.course.figures.is_empty() { a.action href={ (path) "/diagnosis" } { (t.history_diagnosis) } }
                a.action href={ (path) "/report" } { (t.report) }
            }
        }
    }
}

/// What the verdicts suggest, and by when.
pub(super) fn suggested(t: &Text, facts: &Facts, explained: Option<&ExplainedHistory>) -> Markup {
    html! {
        @if let Some(suggestion) = facts.suggestion(explained) {
            p.suggestion {
                strong { (t.suggested) (t.colon) } " " (t.word(&suggestion.word()))
                @if let Some(by) = facts.calibrate_by(explained).filter(|_| suggestion.is_of_drift()) {
                    " " (t.calibrate_by) " " (day(by)) (t.stop)
                }
            }
        }
    }
}

/// Why the newest records may not be the gyro's.
pub(super) fn doubted(t: &Text, facts: &Facts) -> Markup {
    html! {
        @if let Some((record, notes)) = &facts.doubted { (doubts(t, *record, notes)) }
        @if let Some((before, notes)) = &facts.odd_before {
            p.lead {
                a href={ "/records/" (before.record) } {
                    (t.words(&message!("page_record_before_out", day = text(before.at.date()))))
                }
                @for note in notes { " " (note.detail) }
            }
        }
    }
}

/// Why the figures of a record may not be the gyro's.
pub(super) fn doubts(t: &Text, record: Id, doubts: &[NoteBody]) -> Markup {
    html! {
        @if !doubts.is_empty() {
            p.lead {
                strong { a href={ "/records/" (record) } { (t.record_doubted) } (t.colon) }
                @for note in doubts { " " (note.detail) }
            }
        }
    }
}

/// What was decided last, by whom and why.
pub(super) fn decision(t: &Text, facts: &Facts) -> Markup {
    html! {
        @if let Some((event, since)) = facts.decision() {
            p.decided {
                strong { (t.event(event.event)) } " · " (instant(event.at)) " · "
                span translate="no" { @if let Some(author) = &event.author { (author) ": " } (event.reason) }
                @if since > 0 { " " span.quiet { "(" (t.records_since) " " (since) ")" } }
            }
        }
    }
}
