//! The table: what was reached against what is to be reached, and where it went wrong.

use std::collections::BTreeMap;

use serde::Serialize;

use super::draw::Case;
use super::score::{Closure, Score};
use super::tally::Tally;

/// Everything that a blind run says.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    /// SHA-256 of the key, printed before the first diagnosis.
    pub seal: String,
    pub campaigns: usize,
    pub rows: Vec<Rate>,
    pub by_effect: BTreeMap<String, Tally>,
    pub by_design: BTreeMap<String, Tally>,
    pub by_standard_errors: BTreeMap<String, Tally>,
    pub by_outside_family: BTreeMap<String, Tally>,
    /// Hidden effect, then what was named (`-` nothing), how often.
    pub confusion: BTreeMap<String, BTreeMap<String, usize>>,
    pub milliseconds: Milliseconds,
    pub errors: Vec<String>,
    pub scores: Vec<Score>,
}

/// One line of the table.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Rate {
    pub what: &'static str,
    pub tally: Tally,
    pub rate: Option<f64>,
    /// Wilson's interval at 95 %.
    pub interval: Option<[f64; 2]>,
    pub to_reach: Option<Goal>,
    /// None without trials or without a goal.
    pub reached: Option<bool>,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Goal {
    AtLeast(f64),
    AtMost(f64),
}

/// Time of one diagnosis.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Milliseconds {
    pub median: f64,
    pub p99: f64,
    pub most: f64,
}

impl Rate {
    fn new(what: &'static str, to_reach: Option<Goal>, hits: impl IntoIterator<Item = bool>) -> Self {
        let tally = Tally::of(hits);
        let reached = tally.rate().zip(to_reach).map(|(rate, goal)| match goal {
            Goal::AtLeast(share) => rate >= share,
            Goal::AtMost(share) => rate <= share,
        });
        Self { what, tally, rate: tally.rate(), interval: tally.interval(), to_reach, reached }
    }
}

impl Report {
    /// Counts hits by case, effect, design and standard errors. `seal` is the SHA-256 of the truth.
    pub fn of(seal: &str, scores: Vec<Score>) -> Self {
        Self {
            seal: seal.to_owned(),
            campaigns: scores.len(),
            rows: rows(&scores),
            by_effect: grouped(&scores, Case::One, |s| s.hidden[0].clone(), Score::all_found),
            by_design: grouped(&scores, Case::One, |s| s.design.clone(), Score::all_found),
            by_standard_errors: grouped(&scores, Case::One, |s| s.sem.clone(), Score::all_found),
            by_outside_family: grouped(&scores, Case::Outside, |s| s.hidden[0].clone(), Score::honest_about_outside),
            confusion: confusion(&scores),
            milliseconds: Milliseconds::of(&scores),
            errors: scores.iter().filter_map(|s| Some(format!("{}: {}", s.campaign, s.error.as_ref()?))).collect(),
            scores,
        }
    }

    /// Whether every row with a goal and with trials reached it.
    pub fn reached(&self) -> bool {
        self.errors.is_empty() && self.rows.iter().all(|row| row.reached != Some(false))
    }
}

fn rows(scores: &[Score]) -> Vec<Rate> {
    let (at_least, at_most) = (|share| Some(Goal::AtLeast(share)), |share| Some(Goal::AtMost(share)));
    let of = |case: Case| scores.iter().filter(move |s| s.case == case);
    let found = |case: Case| of(case).map(Score::all_found);
    let stated = || of(Case::One).filter(|s| s.sem != "absent");
    let unstated = of(Case::One).filter(|s| s.sem == "absent");
    let stated_and_found = stated().filter(|s| s.all_found());
    let alone = |s: &Score| s.wrong == 0 && s.error.is_none();
    let gyros = |s: &Score| s.all_found() && s.gyros.iter().all(|right| *right);
    let nameable = [Case::One, Case::Faint, Case::Pair];
    let structured = || scores.iter().filter(|s| nameable.contains(&s.case) && s.all_found() && s.wrong == 0);
    let closures = structured().flat_map(|s| s.closures.iter().map(Closure::covered));
    let moved = structured().flat_map(|s| s.moved.clone());
    let shifts = || structured().filter_map(|s| s.shift);
    let material = shifts().filter(|s| s.material);
    let listed = |s: &Score| s.listed_as_unseen == Some(true);
    let honest = of(Case::Outside).map(Score::honest_about_outside);
    vec![
        Rate::new("one effect, d >= 8: named", at_least(0.99), stated().map(Score::all_found)),
        Rate::new("  and its gyros right", at_least(0.95), stated().map(gyros)),
        Rate::new("  and nothing else named", None, stated().map(alone)),
        Rate::new("  and nothing said to remain", None, stated_and_found.map(|s| s.verdict == "explained")),
        Rate::new("  its class no wider than the design forces", None, stated().flat_map(|s| s.classes.clone())),
        Rate::new("one effect, d >= 8, no standard errors: named", None, unstated.map(Score::all_found)),
        Rate::new("one effect, d = 5: named", at_least(0.70), found(Case::Faint)),
        Rate::new("clean: an effect named", at_most(0.01), of(Case::Clean).map(Score::false_alarm)),
        Rate::new("  said to have a gap", at_most(0.05), of(Case::Clean).map(|s| s.verdict != "no_gap")),
        Rate::new("two effects, d = 12 each: both named", at_least(0.95), found(Case::Pair)),
        Rate::new("  and nothing else named", at_least(0.95), of(Case::Pair).map(alone)),
        Rate::new("outside the catalogue, d >= 15: partly or not explained", at_least(0.95), honest),
        Rate::new("unseen by the design: listed as such", at_least(1.0), of(Case::Unseen).map(listed)),
        Rate::new("  an effect named", at_most(0.01), of(Case::Unseen).map(Score::false_alarm)),
        Rate::new("closure of the truth within its interval", at_least(0.90), closures),
        Rate::new("D_I, D_S reported as moved: nearer to the truth", at_least(0.95), moved),
        Rate::new("  all of a campaign's together, where any is", at_least(0.95), material.map(|s| s.nearer())),
        Rate::new("  in every campaign, moved or not", None, shifts().map(|s| s.nearer())),
        Rate::new("a term withheld from the model: named", at_least(0.99), found(Case::Withheld)),
    ]
}

fn grouped(
    scores: &[Score],
    case: Case,
    group: impl Fn(&Score) -> String,
    hit: impl Fn(&Score) -> bool,
) -> BTreeMap<String, Tally> {
    let mut tallies: BTreeMap<String, Tally> = BTreeMap::new();
    for score in scores.iter().filter(|s| s.case == case && !s.hidden.is_empty()) {
        tallies.entry(group(score)).or_default().add(hit(score));
    }
    tallies
}

fn confusion(scores: &[Score]) -> BTreeMap<String, BTreeMap<String, usize>> {
    let mut matrix: BTreeMap<String, BTreeMap<String, usize>> = BTreeMap::new();
    for score in scores.iter().filter(|s| s.case != Case::Pair) {
        let hidden = score.hidden.first().map_or("-", String::as_str);
        let named = if score.named.is_empty() { "-".to_owned() } else { score.named.join("+") };
        *matrix.entry(hidden.to_owned()).or_default().entry(named).or_default() += 1;
    }
    matrix
}

impl Milliseconds {
    fn of(scores: &[Score]) -> Self {
        let mut times: Vec<f64> = scores.iter().map(|s| s.milliseconds).collect();
        times.sort_by(f64::total_cmp);
        let at = |share: f64| times.get((share * (times.len().max(1) - 1) as f64).round() as usize).copied();
        let at = |share: f64| at(share).unwrap_or(0.0);
        Self { median: at(0.5), p99: at(0.99), most: at(1.0) }
    }
}
