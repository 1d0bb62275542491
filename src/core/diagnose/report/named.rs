//! The names: contract entries among the choices of the search, and what speaks against them.

use crate::core::diagnose::diagnosis::Sign;
use crate::core::diagnose::report::indistinguishable;
use crate::core::diagnose::residuals::augmented_fit::Part;
use crate::core::diagnose::residuals::whitened::Frame;
use crate::core::diagnose::search::choice::Choice;
use crate::core::diagnose::search::stepwise::Search;
use crate::core::effects::{Effect, Shape};
use crate::core::mounting::Slot;

/// ln of evidence by which two named courses in time must beat a single wandering one to stand without a doubt.
const LEAD_OVER_WANDERING: f64 = 10.0;

/// The same for one course.
const LEAD_OF_ONE: f64 = 2.0;

/// ln of odds by which noise with a memory is likelier, where a course in time is to stand without a doubt, than where
/// it is to be named: some 10 % of stations instead of 0.5 %.
const ODDS_OF_MEMORY: f64 = 3.0;

/// A gap that needs more names than this has been approximated, not explained.
const MOST_NAMED: usize = 3;

/// One adopted contract entry with all that belongs to it.
pub(crate) struct Named {
    pub part: Part,
    pub class: Vec<Effect>,
    pub wider_in: Vec<(usize, Vec<Effect>)>,
    pub evidence: f64,
    pub rival: Option<Effect>,
}

impl Named {
    /// What stands in for it in all gyros or in one.
    pub fn anywhere(&self) -> Vec<Effect> {
        let mut all = self.class.clone();
        for effect in self.wider_in.iter().flat_map(|(_, class)| class) {
            if !all.contains(effect) {
                all.push(*effect);
            }
        }
        all
    }
}

/// Contract entries among the choices; one that needs several dwells or shapes at once in a gyro is not that entry.
pub(crate) fn named(search: &Search, found: &[Choice]) -> (Vec<Named>, Vec<Sign>) {
    let mut named: Vec<Named> = Vec::new();
    let mut crowded = Vec::new();
    let outliers = found.iter().filter(|c| c.kind.entry().is_one_dwell()).count();
    // Beside structure of another kind, a dwell apart is a part of that.
    let alone = outliers == 1 && !found.iter().any(Choice::is_competitor);
    let apart = if outliers == 1 { "dwell_beside_structure" } else { "several_bad_dwells" };
    for (i, choice) in found.iter().enumerate() {
        let effect = choice.kind;
        if !effect.is_nameable() {
            continue;
        }
        let members = indistinguishable::members(search, found, i);
        let shape = search.bank.hypotheses[choice.hypothesis].shape;
        if let Shape::Dwell(dwell) = shape
            && !alone
        {
            let of_dwell = sign(search, apart, &members, choice.evidence);
            add_dwells(&mut crowded, Sign { dwells: vec![dwell], ..of_dwell });
            continue;
        }
        let again = |n: &Named| n.part.effect == effect && (n.part.shape != shape || shared(&n.part.members, &members));
        if named.iter().any(again) {
            // Two steps, or two periods: the cause is neither.
            named.retain(|n| !(again(n) && effect.entry().course_in_time));
            crowded.push(sign(search, "one_shape_is_not_enough", &members, choice.evidence));
            continue;
        }
        let class = indistinguishable::class(search, found, i);
        let wider_in = indistinguishable::wider_in_gyros(search, found, i, &members, &class);
        named.push(Named {
            part: Part { effect, shape, members },
            class,
            wider_in,
            evidence: choice.evidence,
            rival: choice.rival.or_else(|| indistinguishable::in_part(search, found, i)),
        });
    }
    crowded.extend(wandering(search, found));
    if named.len() > MOST_NAMED {
        let p_value = search.p_value(named.iter().map(|n| n.evidence).fold(f64::INFINITY, f64::min));
        crowded.push(Sign::of_no_dwell("many_causes_at_once", all_slots(search.frame), p_value));
    }
    (named, crowded)
}

/// A course in time that one which wanders would replace without much loss, and two such in one gyro: each may be
/// there, or neither.
fn wandering(search: &Search, found: &[Choice]) -> Vec<Sign> {
    let course = |choice: &Choice| choice.kind.entry().course_in_time;
    let mut signs = Vec::new();
    let slow = |c: &Choice| c.kind.is_nameable() && (course(c) || c.kind.entry().follows_time);
    for (i, choice) in found.iter().enumerate().filter(|(_, choice)| slow(choice)) {
        if search.lead_of_one(found, i) < LEAD_OF_ONE || search.lead_over_memory(found, i, ODDS_OF_MEMORY) < 0.0 {
            signs.push(sign(search, "wandering_in_time", &choice.members, choice.evidence));
        }
    }
    for (i, first) in found.iter().enumerate().filter(|(_, choice)| course(choice)) {
        for (j, second) in found.iter().enumerate().skip(i + 1).filter(|(_, choice)| course(choice)) {
            let both: Vec<bool> = first.members.iter().zip(&second.members).map(|(a, b)| *a && *b).collect();
            if both.contains(&true) && search.lead_over_wandering(found, i, j) < LEAD_OVER_WANDERING {
                signs.push(sign(search, "wandering_in_time", &both, first.evidence.min(second.evidence)));
            }
        }
    }
    signs
}

/// What evidence like this says of the gyros `members`.
pub(crate) fn sign(search: &Search, kind: &'static str, members: &[bool], evidence: f64) -> Sign {
    Sign::of_no_dwell(kind, slots(search.frame, members), search.p_value(evidence))
}

/// Single dwells that stand out are one sign, whatever their number.
fn add_dwells(signs: &mut Vec<Sign>, of_one: Sign) {
    let Some(sign) = signs.iter_mut().find(|sign| sign.kind == of_one.kind) else { return signs.push(of_one) };
    sign.slots.extend(of_one.slots);
    sign.slots.sort_unstable();
    sign.slots.dedup();
    sign.dwells.extend(of_one.dwells);
    sign.dwells.sort_unstable();
    sign.dwells.dedup();
    sign.p_value = sign.p_value.min(of_one.p_value);
}

fn shared(a: &[bool], b: &[bool]) -> bool {
    a.iter().zip(b).any(|(a, b)| *a && *b)
}

pub(crate) fn slots(frame: &Frame, members: &[bool]) -> Vec<Slot> {
    (0..members.len()).filter(|&j| members[j]).map(|j| frame.setting.gyros[j].slot).collect()
}

pub(crate) fn all_slots(frame: &Frame) -> Vec<Slot> {
    frame.setting.gyros.iter().map(|gyro| gyro.slot).collect()
}
