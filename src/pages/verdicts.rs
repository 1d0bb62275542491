//! Verdicts in words: the worst first, what has passed folded away.

use maud::{Markup, html};

use super::layout::symbol;
use super::text::{Language, Text};
use super::viewer::Viewer;
use crate::core::judge::{Coefficient, Rule, Status, Unit, Verdict, digits, sd_digits};
use crate::pages::status;
use crate::pipeline::Violation;
use crate::wire::answer::VerdictBody;

/// A verdict, and what its rule saw, from which words are made in the viewer's language.
#[derive(Clone)]
pub(super) struct Said {
    pub body: VerdictBody,
    pub seen: Option<Verdict>,
}

impl Said {
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

    fn status(&self) -> Status {
        Status::from_name(&self.body.status).unwrap_or(Status::NotEnoughData)
    }

    fn reason(&self, language: Language) -> String {
        self.body.reason.words(language)
    }
}

/// What is the matter in full, the worst first; the rest folded.
pub(super) fn list(viewer: &Viewer, verdicts: &[Said]) -> Markup {
    let t = viewer.text();
    let calm = |status: Status| matches!(status, Status::InTolerance | Status::NotEnoughData);
    let (rest, grave): (Vec<&Said>, Vec<&Said>) = sorted(verdicts).into_iter().partition(|said| calm(said.status()));
    let waiting = rest.iter().filter(|said| said.status() == Status::NotEnoughData).count();
    html! {
        ul.verdicts { @for verdict in grave { (one(viewer, verdict)) } }
        @if !rest.is_empty() {
            details {
                summary { (t.passed) " " (rest.len() - waiting) (t.stop) @if waiting > 0 { " " (t.too_few) " " (waiting) (t.stop) } }
                ul.verdicts { @for verdict in rest { (one(viewer, verdict)) } }
            }
        }
    }
}

/// All of them, nothing folded: on paper nothing can be unfolded.
pub(super) fn all(viewer: &Viewer, verdicts: &[Said]) -> Markup {
    html! {
        @if verdicts.is_empty() { p { (viewer.text().not_judged) } }
        ul.verdicts { @for verdict in sorted(verdicts) { (one(viewer, verdict)) } }
    }
}

/// The worst first; what has passed before what waits for data.
fn sorted(verdicts: &[Said]) -> Vec<&Said> {
    let mut sorted: Vec<&Said> = verdicts.iter().collect();
    sorted.sort_by_key(|said| {
        let status = said.status();
        (status == Status::NotEnoughData, std::cmp::Reverse(status))
    });
    sorted
}

fn one(viewer: &Viewer, said: &Said) -> Markup {
    let (t, verdict) = (viewer.text(), &said.body);
    let rule = Rule::from_name(&verdict.rule);
    let coefficient = Coefficient::from_name(&verdict.coefficient);
    html! {
        li {
            (status::badge(t, Some(said.status()))) " "
            span title=[coefficient.map(|coefficient| t.meaning(coefficient))] { (symbol(&verdict.coefficient)) } " "
            strong { (rule.map_or("", |rule| t.rule(rule))) }
            br;
            (said.reason(viewer.language))
            @if let Some((rule, coefficient)) = rule.zip(coefficient) { (figures(t, said, rule.unit(coefficient))) }
        }
    }
}

/// What the reason does not say: the figures of what has passed, and of what was judged by other limits; else the
/// limit, where there is nothing yet to compare with it.
fn figures(t: &Text, said: &Said, unit: Unit) -> Markup {
    let VerdictBody { value, limit, sd, limit_from, .. } = &said.body;
    let (p, unit) = (digits(*limit), t.word(&unit.word()));
    let unsaid = said.seen.as_ref().is_none_or(|seen| seen.phrase().is_some());
    html! {
        @match (value, limit_from) {
            (Some(value), _) if unsaid => span.note {
                " " (format!("{value:.p$}")) @if let Some(sd) = sd { " ± " (format!("{:.*}", sd_digits(*sd, *limit), sd)) }
                " " (unit) ", " (t.limit_within) " " (format!("{limit:.p$}")) (t.stop)
            },
            (None, Some(key)) => span.note { " " (t.limit) " " (format!("{limit:.p$}")) " " (unit) " (" code { (key) } ")" (t.stop) },
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::judge::{Finding, LimitKey, State};
    use crate::message;
    use crate::wire::reason::Reason;

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
        let said = Said { body, seen: None };
        let shown =
            |language: Language| figures(language.text(), &said, Rule::Cusum.unit(Coefficient::DI)).into_string();
        assert!(shown(Language::English).contains("40.30 standard deviations, limit 5.14."));
        assert!(shown(Language::Chinese).contains("40.30 倍标准差, 限值 5.14。"));
        assert!(!said.reason(Language::Chinese).is_ascii());
        // What has passed says no figures in its reason.
        let finding = Finding::Step { level: 3.0, now: 3.0012 };
        let passed = Verdict {
            coefficient: Coefficient::DI,
            rule: Rule::Step,
            state: State::Within,
            value: Some(0.0012),
            limit: 0.01,
            limit_from: LimitKey::BUDGET,
            sd: Some(0.0003),
            probability: Some(0.0),
            confirmed: false,
            finding,
        };
        let passed = |finding, state| {
            let verdict = Verdict { finding, state, ..passed };
            let said = Said { body: VerdictBody::of("A", &verdict), seen: Some(verdict) };
            figures(Language::English.text(), &said, Unit::Drift).into_string()
        };
        let shown = passed(finding, State::Within);
        assert!(shown.contains("0.0012 ± 0.0003 deg/(h g0), limit 0.0100."), "{shown}");
        assert_eq!(passed(finding, State::Exceeded), "", "its reason has them");
        let waiting = Said {
            body: VerdictBody { value: None, limit_from: Some("judging.budget".into()), ..said.body.clone() },
            seen: None,
        };
        let shown = figures(Language::English.text(), &waiting, Unit::Drift).into_string();
        assert!(shown.contains("Limit 5.14 deg/(h g0) (<code>judging.budget</code>)"), "{shown}");
    }
}
