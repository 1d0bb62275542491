//! Verdicts in words: what is broken first, what is kept folded away.

use maud::{Markup, html};

use super::layout::symbol;
use super::standing::Grade;
use super::text::{Language, reason};
use super::viewer::Viewer;
use crate::core::judge::{Coefficient, Rule, State, Verdict};
use crate::pipeline::Figures;
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

    fn reason(&self, language: Language) -> String {
        match (language, &self.seen) {
            (Language::Chinese, Some(verdict)) => reason::in_chinese(verdict),
            (Language::English, Some(verdict)) => verdict.reason(),
            (_, None) => language.text().spoken(&self.body.reason),
        }
    }
}

/// The worst that any rule that could judge says of the newest record; of the drift none may have, however well E and G keep to
/// their requirements.
pub(super) fn worst(newest: &Figures, verdicts: &[Said]) -> State {
    let of_drift = newest.states.worst().unwrap_or(State::Indeterminate);
    let judged = verdicts.iter().filter(|said| said.body.value.is_some());
    judged.filter_map(|said| State::from_name(&said.body.state)).fold(of_drift, State::max)
}

/// What is broken and what is undecided in full, the rest folded.
pub(super) fn list(viewer: &Viewer, verdicts: &[Said]) -> Markup {
    let t = viewer.text();
    let of_state = |state: State| verdicts.iter().filter(move |said| said.body.state == state.name());
    // A rule that found too few records has decided nothing.
    let (undecided, waiting): (Vec<_>, Vec<_>) =
        of_state(State::Indeterminate).partition(|said| said.body.value.is_some());
    let kept = of_state(State::Within).count();
    html! {
        ul.verdicts {
            @for verdict in of_state(State::Exceeded).chain(undecided) { (one(viewer, verdict)) }
        }
        @if kept + waiting.len() > 0 {
            details {
                summary { (t.verdicts_within) " " (kept) @if !waiting.is_empty() { " · " (t.too_few) " " (waiting.len()) } }
                ul.verdicts { @for verdict in of_state(State::Within).chain(waiting) { (one(viewer, verdict)) } }
            }
        }
    }
}

/// All of them, nothing folded: on paper nothing can be unfolded.
pub(super) fn all(viewer: &Viewer, verdicts: &[Said]) -> Markup {
    let of_state = |state: State| verdicts.iter().filter(move |said| said.body.state == state.name());
    html! {
        @if verdicts.is_empty() { p { (viewer.text().not_judged) } }
        ul.verdicts {
            @for state in [State::Exceeded, State::Indeterminate, State::Within] {
                @for verdict in of_state(state) { (one(viewer, verdict)) }
            }
        }
    }
}

fn one(viewer: &Viewer, said: &Said) -> Markup {
    let (t, verdict) = (viewer.text(), &said.body);
    let state = State::from_name(&verdict.state).unwrap_or(State::Indeterminate);
    let rule = Rule::from_name(&verdict.rule);
    let grade = Grade::judged(Some(state), rule.into_iter());
    let meaning = Coefficient::from_name(&verdict.coefficient).map_or("", |coefficient| t.meaning(coefficient));
    html! {
        li {
            (grade.badge(t)) " "
            span title=(meaning) { (symbol(&verdict.coefficient)) } " " strong { (rule.map_or("", |rule| t.rule(rule))) }
            @if verdict.confirmed { " (" (t.confirmed) ")" }
            br;
            (said.reason(viewer.language))
        }
    }
}
