//! Verdicts in words: the worst first, what has passed folded away.

use super::layout::remark;
use super::prelude::*;
use super::status;
use crate::core::judge::{Coefficient, Finding, Unit, Verdict, digits, sd_digits};
use crate::pipeline::Violation;
use crate::wire::answer::VerdictBody;

/// A verdict, and what its rule saw, from which words are made in the viewer's language.
#[derive(Clone)]
pub(super) struct SeenVerdict {
    pub body: VerdictBody,
    pub seen: Option<Verdict>,
}

impl SeenVerdict {
    /// Of one gyro, from the verdicts of a record and what was seen, side by side.
    pub fn of_gyro(serial: &str, bodies: &[VerdictBody], seen: &[Option<Verdict>]) -> Vec<Self> {
        let all = bodies.iter().zip(seen).filter(|(body, _)| body.serial == serial);
        all.map(|(body, seen)| Self { body: body.clone(), seen: *seen }).collect()
    }

    /// What an alert knows besides: a second record may have confirmed that a requirement is not met.
    pub fn is_known_to_be(&mut self, violation: &Violation) {
        let same = self.body.rule == violation.rule.name() && self.body.coefficient == violation.coefficient.name();
        if same && violation.status > self.status() {
            self.body.status = violation.status.name().into();
        }
    }

    /// Whether it cannot say yet how far a coefficient is from its baseline.
    pub fn awaits_baseline(&self) -> bool {
        self.body.rule == Rule::Baseline.name() && self.body.value.is_none()
    }

    pub fn status(&self) -> Status {
        Status::from_name(&self.body.status).unwrap_or(Status::NotEnoughData)
    }

    fn is_calm(&self) -> bool {
        matches!(self.status(), Status::InTolerance | Status::NotEnoughData)
    }

    fn reason(&self, t: &Text) -> String {
        t.reason(&self.body.reason)
    }
}

/// What the rules saw, where that is known.
pub(super) fn seen(verdicts: &[SeenVerdict]) -> impl Iterator<Item = &Verdict> {
    verdicts.iter().filter_map(|said| said.seen.as_ref())
}

/// What is the matter in full, the worst first; the rest folded.
pub(super) fn list(t: &Text, verdicts: &[SeenVerdict]) -> Markup {
    let (rest, grave): (Vec<&SeenVerdict>, Vec<&SeenVerdict>) =
        sorted(verdicts).into_iter().partition(|said| said.is_calm());
    html! {
        ul.verdicts { @for verdict in grave { (one(t, verdict)) } }
        (folded(t, &rest, &html! { ul.verdicts { @for verdict in &rest { (one(t, verdict)) } } }))
    }
}

/// What has passed, and what waits for data: counted, and shown when asked for.
fn folded(t: &Text, rest: &[&SeenVerdict], shown: &Markup) -> Markup {
    let waiting = rest.iter().filter(|said| said.status() == Status::NotEnoughData).count();
    html! {
        @if !rest.is_empty() {
            details.passed {
                summary {
                    (t.passed) " " (rest.len() - waiting) (t.stop)
                    @if waiting > 0 { " " (t.too_few) " " (waiting) (t.stop) }
                }
                (shown)
            }
        }
    }
}

/// One line for each verdict, the alert on it beside it, and the alerts that no verdict on this record stands for. What
/// is the matter comes first; the rest is folded.
pub(super) fn table(viewer: &Viewer, verdicts: &[SeenVerdict], alerts: &[AlertBody], here: Option<&str>) -> Markup {
    let t = viewer.text();
    let is_on = |alert: &AlertBody, said: &SeenVerdict| {
        (&alert.rule, &alert.coefficient) == (&said.body.rule, &said.body.coefficient)
    };
    let alert_of = |said: &SeenVerdict| alerts.iter().find(|alert| is_on(alert, said));
    let (rest, grave): (Vec<&SeenVerdict>, Vec<&SeenVerdict>) =
        sorted(verdicts).into_iter().partition(|said| said.is_calm() && alert_of(said).is_none());
    let alone: Vec<&AlertBody> =
        alerts.iter().filter(|alert| !verdicts.iter().any(|said| is_on(alert, said))).collect();
    let rows = |all: &[&SeenVerdict]| html! { @for said in all { (row(viewer, said, alert_of(said), here)) } };
    html! {
        @if verdicts.is_empty() && alerts.is_empty() { p { (t.not_judged) } }
        @if !grave.is_empty() || !alone.is_empty() {
            (framed(t, &html! { (rows(&grave)) @for alert in alone { (alert_row(viewer, alert, here)) } }))
        }
        (folded(t, &rest, &framed(t, &rows(&rest))))
    }
}

fn framed(t: &Text, rows: &Markup) -> Markup {
    html! {
        (wide_table("judged cards", html! {
            th { (t.status_word) } th { (t.rule_word) } th.n { (t.value) } th.n { (t.limit) } th.n { "%" }
            th { (t.since) } th.n { (t.probability) } th { (t.alert_word) }
        }, html! { (rows) }))
    }
}

fn row(viewer: &Viewer, said: &SeenVerdict, alert: Option<&AlertBody>, here: Option<&str>) -> Markup {
    let (t, VerdictBody { value, limit, .. }) = (viewer.text(), &said.body);
    let (rule, coefficient) = (Rule::from_name(&said.body.rule), Coefficient::from_name(&said.body.coefficient));
    let unit = rule.zip(coefficient).map(|(rule, coefficient)| rule.unit(coefficient));
    // The bounds of a requirement are two; and where no trend is established, no line leads anywhere.
    let no_trend = rule == Some(Rule::Trend) && said.status() == Status::InTolerance;
    let bounded = rule.is_some_and(|rule| rule != Rule::Requirement) && !no_trend;
    html! {
        tr {
            td { (status::badge(t, Some(said.status()))) }
            th.words scope="row" {
                details.why {
                    summary { (symbol(&said.body.coefficient)) " " (rule.map_or("", |rule| t.rule(rule))) }
                    p { (said.reason(t)) @if let Some(unit) = unit.filter(|_| !no_trend) { (figures(t, said, unit)) } }
                }
            }
            td.n data-label=(t.value) {
                @if let Some(value) = value.filter(|_| !no_trend) {
                    (found(said, value))
                    @if let Some(Finding::Trend { horizon_days, .. }) = said.seen.map(|seen| seen.finding) {
                        " " span.quiet { (t.words(&message!("in_days", days = format!("{horizon_days:.0}")))) }
                    }
                }
            }
            td.n data-label=(t.limit) { @if !no_trend { (limits(said)) } }
            td.n data-label="%" {
                @if let Some(value) = value.filter(|_| bounded && *limit > 0.0) {
                    (format!("{:.0}", 100.0 * value / limit))
                }
            }
            td data-label=(t.since) {
                @if let Some(since) = alert.and_then(|alert| alert.since.as_ref()) { (written(since)) }
            }
            td.n data-label=(t.probability) {
                @if let Some(probability) = said.body.probability { (certainty(probability)) }
            }
            td { @if let Some(alert) = alert {
                (told(viewer, alert, here))
                @if said.status() < Status::Drifting {
                    " " span.quiet { (t.ends_in_tolerance) }
                }
            } }
        }
    }
}

/// Of an alert that no verdict on the newest record stands for: methods that disagree, a calibration that is overdue.
fn alert_row(viewer: &Viewer, alert: &AlertBody, here: Option<&str>) -> Markup {
    let t = viewer.text();
    html! {
        tr {
            td { (status::badge(t, alert.status())) }
            th.words scope="row" {
                details.why {
                    summary { (violated(t, alert)) }
                    p { (t.reason(&alert.finding.reason)) }
                }
            }
            td.n {} td.n {} td.n {}
            td data-label=(t.since) { @if let Some(since) = &alert.since { (written(since)) } }
            td.n {}
            td { (told(viewer, alert, here)) }
        }
    }
}

/// What an alert is about: a coefficient and a rule.
pub(super) fn violated(t: &Text, alert: &AlertBody) -> Markup {
    html! { (symbol(&alert.coefficient)) " " (Rule::from_name(&alert.rule).map_or("", |rule| t.rule(rule))) }
}

fn certainty(probability: f64) -> String {
    let percent = 100.0 * probability;
    match percent {
        above if above > 99.9 => "> 99.9 %".into(),
        below if below < 0.1 => "< 0.1 %".into(),
        percent => format!("{percent:.1} %"),
    }
}

/// How the alert stands, and what can be done about it.
fn told(viewer: &Viewer, alert: &AlertBody, here: Option<&str>) -> Markup {
    let t = viewer.text();
    html! { a href={ "/alerts/" (alert.id) } { (t.standing(&alert.state)) } (remarks(t, alert)) (actions(viewer, alert, here)) }
}

/// Who knows of an alert, and who wants nobody to be told, until when.
pub(super) fn remarks(t: &Text, alert: &AlertBody) -> Markup {
    html! {
        @if let Some(said) = &alert.acknowledged { (remark(t.said_by, &said.by, &said.reason)) }
        @if let Some(said) = &alert.silenced {
            " " (t.until) " " (written(&said.until)) (remark(t.said_by, &said.by, &said.reason))
        }
    }
}

/// What a viewer can do about an alert, coming back `here`.
pub(super) fn actions(viewer: &Viewer, alert: &AlertBody, here: Option<&str>) -> Markup {
    let t = viewer.text();
    let deed = |deed: &str, here: &str| format!("/alerts/{}/{deed}?back={}", alert.id, encoded(here));
    html! {
        @if let Some(here) = here.filter(|_| viewer.may(Role::Engineer)) {
            " " span.actions.no-print {
                @if alert.acknowledged.is_none() { a href=(deed("acknowledge", here)) { (t.acknowledge) } }
                @else { a href=(deed("unacknowledge", here)) { (t.unacknowledge) } }
                @if alert.silenced.is_none() { a href=(deed("silence", here)) { (t.silence) } }
                @else { a href=(deed("unsilence", here)) { (t.unsilence) } }
            }
        }
    }
}

/// The worst first; what has passed before what waits for data.
fn sorted(verdicts: &[SeenVerdict]) -> Vec<&SeenVerdict> {
    let mut sorted: Vec<&SeenVerdict> = verdicts.iter().collect();
    sorted.sort_by_key(|said| {
        let status = said.status();
        (status == Status::NotEnoughData, std::cmp::Reverse(status))
    });
    sorted
}

fn one(t: &Text, said: &SeenVerdict) -> Markup {
    let verdict = &said.body;
    let rule = Rule::from_name(&verdict.rule);
    let coefficient = Coefficient::from_name(&verdict.coefficient);
    html! {
        li {
            (status::badge(t, Some(said.status()))) " "
            span title=[coefficient.map(|coefficient| t.meaning(coefficient))] { (symbol(&verdict.coefficient)) } " "
            strong { (rule.map_or("", |rule| t.rule(rule))) }
            br;
            (said.reason(t))
            @if let Some((rule, coefficient)) = rule.zip(coefficient) { (figures(t, said, rule.unit(coefficient))) }
        }
    }
}

/// What the reason does not say: the figures of what has passed, and of what was judged by other limits; else the
/// limit, where there is nothing yet to compare with it.
fn figures(t: &Text, said: &SeenVerdict, unit: Unit) -> Markup {
    let (VerdictBody { value, limit_from, .. }, unit) = (&said.body, t.word(&unit.word()));
    let unsaid = said.seen.as_ref().is_none_or(|seen| seen.phrase().is_some());
    html! {
        @match (value, limit_from) {
            (Some(value), _) if unsaid => span.note {
                " " (found(said, *value)) " " (unit) ", " (t.limit_within) " " (limits(said)) (t.stop)
            },
            (None, Some(key)) => span.note { " " (t.limit) " " (limits(said)) " " (unit) " (" code { (key) } ")" (t.stop) },
            _ => {}
        }
    }
}

/// What was found, to as many places as its limit; that of a requirement to those of its standard deviation.
fn found(said: &SeenVerdict, value: f64) -> String {
    let VerdictBody { rule, limit, sd, .. } = &said.body;
    match sd {
        _ if rule == Rule::Requirement.name() => figure::with_sd(value, *sd, digits(*limit)),
        Some(sd) => format!("{value:.*} ± {sd:.*}", digits(*limit), sd_digits(*sd, *limit)),
        None => format!("{value:.*}", digits(*limit)),
    }
}

/// The limit; of a requirement both ends, where they are known.
fn limits(said: &SeenVerdict) -> String {
    match said.seen.map(|seen| seen.finding) {
        Some(Finding::Requirement { low, high, .. }) => format!("{low} … {high}"),
        _ => format!("{:.*}", digits(said.body.limit), said.body.limit),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::judge::{LimitKey, State};
    use crate::message;
    use crate::wire::reason::Reason;
    use crate::words::Language;

    #[test]
    fn a_verdict_of_an_earlier_version_shows_its_stored_figures() {
        let body = VerdictBody {
            serial: "A".into(),
            coefficient: "D_I".into(),
            rule: "cusum".into(),
            state: "exceeded".into(),
            status: "drifting".into(),
            value: Some(40.3),
            limit: 5.14,
            limit_from: None,
            sd: None,
            probability: None,
            confirmed: false,
            reason: Reason(vec![message!("decided_before")]),
        };
        let earlier = SeenVerdict { body, seen: None };
        let shown =
            |language: Language| figures(language.text(), &earlier, Rule::Cusum.unit(Coefficient::DI)).into_string();
        assert!(shown(Language::English).contains("40.30 standard deviations, limit 5.14."));
        assert!(shown(Language::Chinese).contains("40.30 倍标准差, 限值 5.14。"));
        assert!(!earlier.reason(Language::Chinese.text()).is_ascii());
        // What has passed says no figures in its reason.
        let finding = Finding::Step { level: 3.0, now: 3.0012 };
        let whole = Verdict {
            coefficient: Coefficient::DI,
            rule: Rule::Step,
            state: State::Within,
            value: Some(0.0012),
            limit: 0.01,
            limit_from: LimitKey::BUDGET,
            sd: Some(0.0003),
            probability: Some(0.0),
            between: None,
            confirmed: false,
            finding,
        };
        let passed = |finding, state| {
            let verdict = Verdict { finding, state, ..whole };
            let said = SeenVerdict { body: VerdictBody::of("A", &verdict), seen: Some(verdict) };
            figures(Language::English.text(), &said, Unit::Drift).into_string()
        };
        let shown = passed(finding, State::Within);
        assert!(shown.contains("0.0012 ± 0.0003 deg/(h g0), limit 0.0100."), "{shown}");
        assert_eq!(passed(finding, State::Exceeded), "", "its reason has them");
        // What has to lie within a range is shown with both of its ends.
        let range = Finding::Requirement { figure: "|E|", low: 1.0, high: 3.0, others: Default::default() };
        let required = Verdict { rule: Rule::Requirement, value: Some(1.47), sd: Some(3e-6), limit: 1.0, ..whole };
        let required = Verdict { finding: range, coefficient: Coefficient::E, ..required };
        let said = |seen| SeenVerdict { body: VerdictBody::of("A", &required), seen };
        assert_eq!(limits(&said(Some(required))), "1 … 3");
        assert_eq!(found(&said(None), 1.47), "1.4700000 ± 0.0000030");
        let waiting = SeenVerdict {
            body: VerdictBody { value: None, limit_from: Some("judging.budget".into()), ..earlier.body.clone() },
            seen: None,
        };
        let shown = figures(Language::English.text(), &waiting, Unit::Drift).into_string();
        assert!(shown.contains("Limit 5.14 deg/(h g0) (<code>judging.budget</code>)"), "{shown}");
    }
}
