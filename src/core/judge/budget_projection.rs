//! How a gyro lies to its budget and where it goes, as far as the verdicts on its newest record say.

use crate::core::judge::{Coefficient, Finding, Load, Measured, Verdict};
use crate::core::time::UtcMicros;

/// How D_I, D_S and D_O lie to their budgets, and where D_I and D_S go.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct BudgetProjection {
    /// The loads, (value - baseline) / budget with its standard deviation: signed, 1 at the budget. None before the
    /// baseline is complete, and where the rule (`baseline`, of D_O `closure`) is off.
    pub load: [Option<Measured>; 3],
    /// The slopes of D_I and D_S that `trend` has established, in budgets a year.
    pub per_year: [Option<Measured>; 2],
    /// Where a trend reaches the budget: of D_I and D_S that which does so first.
    pub reach: Option<BudgetCrossing>,
}

/// When a trend reaches the budget.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BudgetCrossing {
    pub coefficient: Coefficient,
    /// By the line.
    pub at: UtcMicros,
    /// By the early edge of its 95 % band, and by the late one: none where that never does.
    pub between: [Option<UtcMicros>; 2],
    /// The course is young: these dates may be off by more than they say.
    pub provisional: bool,
}

impl BudgetProjection {
    /// By the verdicts on a gyro's newest record.
    pub fn of(verdicts: &[Verdict]) -> Self {
        let mut outlook = Self::default();
        for verdict in verdicts.iter().filter(|verdict| verdict.limit > 0.0) {
            let Some(column) = verdict.coefficient.column() else { continue };
            if let Some(load) = Load::of(verdict) {
                outlook.load[column] = Some(load.share());
            }
            if let Finding::Trend { per_year, reach: [from, at, until], provisional, .. } = verdict.finding {
                if let Some(slope) = outlook.per_year.get_mut(column) {
                    *slope = Some(per_year.in_units_of(verdict.limit));
                }
                let coefficient = verdict.coefficient;
                let reach = at.map(|at| BudgetCrossing { coefficient, at, between: [from, until], provisional });
                let earlier = |new: &BudgetCrossing| outlook.reach.is_none_or(|known| new.at < known.at);
                outlook.reach = reach.filter(earlier).or(outlook.reach);
            }
        }
        outlook
    }

    /// The larger load of D_I and D_S without its sign.
    pub fn extreme(&self) -> Option<f64> {
        self.load[..2].iter().flatten().map(|load| load.value.abs()).max_by(f64::total_cmp)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::judge::{Limit, LimitKey, Rule, State};

    fn verdict(coefficient: Coefficient, rule: Rule, finding: Finding) -> Verdict {
        let limit = Limit { value: 0.01, from: LimitKey::BUDGET };
        let undecided = Verdict::undecided(coefficient, rule, limit, finding);
        Verdict { state: State::Within, value: Some(0.025), sd: Some(0.0007), ..undecided }
    }

    fn trend(per_year: f64, reach: [Option<i64>; 3]) -> Finding {
        Finding::Trend {
            cells: 24,
            since: UtcMicros(0),
            until: UtcMicros(1),
            per_year: Measured { value: per_year, sd: Some(0.0003) },
            deviation: 0.0,
            horizon_days: 90.0,
            reach: reach.map(|at| at.map(UtcMicros)),
            provisional: true,
            of_fleet: false,
        }
    }

    fn near(measured: Option<Measured>, value: f64, sd: f64) -> bool {
        measured.is_some_and(|it| (it.value - value).abs() < 1e-9 && (it.sd.unwrap() - sd).abs() < 1e-9)
    }

    #[test]
    fn the_load_has_a_sign_and_the_slope_is_in_budgets() {
        let below = Finding::Baseline { level: -2.0, since: None, now: -2.025 };
        let closure = Finding::Closure { level: 0.0, since: None, moved: false, now: 0.005, d_s: None };
        let verdicts = [
            verdict(Coefficient::DI, Rule::Baseline, below),
            verdict(Coefficient::DI, Rule::Trend, trend(-0.013, [Some(5), Some(9), None])),
            verdict(Coefficient::DS, Rule::Trend, trend(0.002, [Some(4), Some(7), Some(8)])),
            verdict(Coefficient::DO, Rule::Closure, closure),
        ];
        let outlook = BudgetProjection::of(&verdicts);
        assert!(near(outlook.load[0], -2.5, 0.07) && near(outlook.load[2], 0.5, 0.07), "{outlook:?}");
        assert!(near(outlook.per_year[0], -1.3, 0.03) && near(outlook.per_year[1], 0.2, 0.03), "{outlook:?}");
        assert!((outlook.extreme().unwrap() - 2.5).abs() < 1e-9, "without its sign, and D_O has none");
        let first = outlook.reach.unwrap();
        assert_eq!((first.coefficient, first.at), (Coefficient::DS, UtcMicros(7)), "the first to reach it");
        assert_eq!(first.between, [Some(UtcMicros(4)), Some(UtcMicros(8))]);
    }

    #[test]
    fn without_a_baseline_there_is_no_load_and_without_a_slope_no_date() {
        let few = verdict(Coefficient::DI, Rule::Baseline, Finding::TooFew { have: 2, need: 4 });
        let flat = Finding::NoTrend { cells: 24, since: UtcMicros(0), step: None };
        let outlook = BudgetProjection::of(&[few, verdict(Coefficient::DI, Rule::Trend, flat)]);
        assert_eq!((outlook, outlook.extreme()), (BudgetProjection::default(), None));
    }
}
