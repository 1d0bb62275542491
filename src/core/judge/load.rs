//! How much of its budget a coefficient takes up.

use crate::core::judge::{Finding, Measured, Verdict};

/// The deviation of a record from the level of its own epoch, held against the budget:
/// `load = (value - level) / budget`, signed, without a unit; 1 is the whole budget.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Load {
    /// value - level, deg/(h g0); its standard deviation counts the level's own.
    pub deviation: Measured,
    /// deg/(h g0).
    pub level: f64,
    /// deg/(h g0), more than zero.
    pub budget: f64,
}

impl Load {
    /// deviation / budget; without a standard deviation where the station states none.
    pub fn share(&self) -> Measured {
        self.deviation.in_units_of(self.budget)
    }

    /// Of the rules that hold a record against its level (`baseline`, `closure`); none while the level is being made.
    pub fn of(verdict: &Verdict) -> Option<Self> {
        let (Finding::Baseline { level, now, .. } | Finding::Closure { level, now, .. }) = verdict.finding else {
            return None;
        };
        let deviation = Measured { value: now - level, sd: verdict.sd };
        (verdict.value.is_some() && verdict.limit > 0.0).then_some(Self { deviation, level, budget: verdict.limit })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::judge::{Coefficient, Limit, LimitKey, Rule, State};

    #[test]
    fn a_load_has_the_sign_of_the_deviation_and_the_budget_as_its_unit() {
        let finding = Finding::Baseline { level: -2.0628, since: None, now: -2.0377 };
        let limit = Limit { value: 0.01, from: LimitKey::BUDGET };
        let undecided = Verdict::undecided(Coefficient::DI, Rule::Baseline, limit, finding);
        let verdict = Verdict { state: State::Exceeded, value: Some(0.0251), sd: Some(0.0007), ..undecided };
        let load = Load::of(&verdict).unwrap();
        assert!(
            (load.share().value - 2.51).abs() < 1e-9 && (load.share().sd.unwrap() - 0.07).abs() < 1e-12,
            "{load:?}"
        );
        let below = Finding::Closure { level: 0.5, since: None, moved: false, now: 0.495, d_s: None };
        let load = Load::of(&Verdict { finding: below, sd: None, ..verdict }).unwrap();
        assert!((load.share().value + 0.5).abs() < 1e-9 && load.share().sd.is_none(), "{load:?}");
        assert_eq!(Load::of(&Verdict { value: None, ..verdict }), None, "the level is being made");
        assert_eq!(Load::of(&Verdict { limit: 0.0, ..verdict }), None, "nothing is a share of no budget");
        let step = Finding::Step { level: 1.0, now: 2.0 };
        assert_eq!(Load::of(&Verdict { finding: step, ..verdict }), None, "a step is no deviation from the level");
    }
}
