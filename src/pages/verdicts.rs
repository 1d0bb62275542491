//! Verdicts in words: what is broken first, what is kept folded away.

use maud::{Markup, html};

use super::layout::symbol;
use super::standing::Grade;
use super::viewer::Viewer;
use crate::core::judge::{Coefficient, Rule, State};
use crate::pipeline::Figures;
use crate::wire::answer::VerdictBody;

/// The worst that any rule that could judge says of the newest record.
pub(super) fn worst(newest: &Figures, verdicts: &[VerdictBody]) -> State {
    let judged = verdicts.iter().filter(|verdict| verdict.value.is_some());
    let states = judged.filter_map(|verdict| State::from_name(&verdict.state));
    states.chain(newest.states.worst()).max().unwrap_or(State::Indeterminate)
}

/// By shape and word as well as by colour.
pub(super) fn badge(viewer: &Viewer, state: State) -> Markup {
    html! { span class={ "badge " (state.name()) } { (viewer.text().state(state)) } }
}

/// What is broken and what is undecided in full, the rest folded.
pub(super) fn list(viewer: &Viewer, verdicts: &[VerdictBody]) -> Markup {
    let t = viewer.text();
    let of_state = |state: State| verdicts.iter().filter(move |verdict| verdict.state == state.name());
    // A rule that found too few records has decided nothing.
    let (undecided, waiting): (Vec<_>, Vec<_>) =
        of_state(State::Indeterminate).partition(|verdict| verdict.value.is_some());
    let kept = of_state(State::Within).count();
    html! {
        ul.verdicts {
            @for verdict in of_state(State::Exceeded).chain(undecided) { (one(viewer, verdict)) }
        }
        @if kept + waiting.len() > 0 {
            details {
                summary { (kept) " " (t.verdicts_within) }
                ul.verdicts { @for verdict in of_state(State::Within).chain(waiting) { (one(viewer, verdict)) } }
            }
        }
    }
}

fn one(viewer: &Viewer, verdict: &VerdictBody) -> Markup {
    let t = viewer.text();
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
            (verdict.reason)
        }
    }
}
