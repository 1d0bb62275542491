//! What the stored verdicts on a record come to: for each coefficient, and for the gyro.

use crate::core::judge::{Coefficient, State, Status};
use crate::pipeline::prelude::*;
use crate::store::StoredVerdict;

const COLUMNS: [Coefficient; 3] = [Coefficient::DI, Coefficient::DS, Coefficient::DO];

/// The worst of the rules that could judge. None may have judged the drift, however well E and G keep to their
/// requirements.
pub(crate) fn of_gyro(verdicts: &[StoredVerdict]) -> Status {
    let of_drift = COLUMNS.into_iter().filter_map(|coefficient| worst(verdicts, coefficient)).max();
    let judged = verdicts.iter().filter(|verdict| verdict.value.is_some()).map(StoredVerdict::status);
    judged.fold(of_drift.unwrap_or(Status::NotEnoughData), Status::max)
}

/// Of D_I, D_S and the closure, each.
pub(crate) fn of_drift(verdicts: &[StoredVerdict]) -> [Status; 3] {
    COLUMNS.map(|coefficient| worst(verdicts, coefficient).unwrap_or(Status::NotEnoughData))
}

fn worst(verdicts: &[StoredVerdict], coefficient: Coefficient) -> Option<Status> {
    let judged = verdicts.iter().filter(|verdict| verdict.coefficient == coefficient && verdict.value.is_some());
    judged.map(StoredVerdict::status).max()
}

/// What the rules say of a gyro's records. Its history keeps a state for each coefficient; where that may mean
/// several things, the verdicts themselves tell.
#[derive(Debug, Clone, Default)]
pub struct Statuses(HashMap<Id, [CoefficientStatus; 3]>);

/// What the verdicts on one coefficient of a record come to.
#[derive(Debug, Clone, Default)]
struct CoefficientStatus {
    status: Option<Status>,
    /// The rules that say that a limit is passed.
    rules: Vec<Rule>,
}

impl CoefficientStatus {
    fn of(verdicts: &[StoredVerdict], coefficient: Coefficient) -> Self {
        let beyond = |verdict: &&StoredVerdict| (verdict.coefficient, verdict.state) == (coefficient, State::Exceeded);
        let rules = verdicts.iter().filter(beyond).map(|verdict| verdict.rule).collect();
        Self { status: worst(verdicts, coefficient), rules }
    }
}

impl Statuses {
    /// Of these rows of one gyro, for these columns of D_I, D_S and D_O.
    pub async fn of(
        store: &Store,
        gyro: u32,
        rows: impl Iterator<Item = &Figures>,
        columns: &[usize],
    ) -> Result<Self, StoreError> {
        let several = |state: Option<State>| matches!(state, Some(State::Indeterminate | State::Exceeded));
        let asked = rows.filter(|row| columns.iter().any(|&column| several(row.states.0[column])));
        let sheets = store::record::record_verdicts(store, asked.map(|row| row.record)).await?;
        let of_gyro = sheets.iter().map(|(record, sheet)| {
            (*record, COLUMNS.map(|coefficient| CoefficientStatus::of(sheet.of(gyro), coefficient)))
        });
        Ok(Self(of_gyro.collect()))
    }

    pub fn get(&self, row: &Figures, column: usize) -> Status {
        let state = row.states.0[column];
        let told = || self.0.get(&row.record).and_then(|of_record| of_record[column].status);
        match state {
            None | Some(State::Within) => Status::of_state(state),
            Some(_) => told().unwrap_or_else(|| Status::of_state(state)),
        }
    }

    /// The rules that say of it that a limit is passed.
    pub fn rules(&self, row: &Figures, column: usize) -> Vec<Rule> {
        self.0.get(&row.record).map_or_else(Vec::new, |of_record| of_record[column].rules.clone())
    }

    /// The worst of D_I, D_S and D_O, of those that could be judged.
    pub fn worst(&self, row: &Figures) -> Status {
        let judged = (0..3).filter(|&column| row.states.0[column].is_some());
        judged.map(|column| self.get(row, column)).max().unwrap_or(Status::NotEnoughData)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::judge::Rule;

    fn verdict(
        coefficient: Coefficient,
        rule: Rule,
        state: State,
        value: Option<f64>,
        confirmed: bool,
    ) -> StoredVerdict {
        StoredVerdict { coefficient, rule, state, value, limit: 0.01, sd: None, probability: None, confirmed }
    }

    #[test]
    fn the_worst_that_could_be_judged_counts_and_what_waits_for_records_does_not() {
        let within = verdict(Coefficient::DI, Rule::Step, State::Within, Some(0.0), false);
        let waits = verdict(Coefficient::DS, Rule::Trend, State::Indeterminate, None, false);
        let drifts = verdict(Coefficient::DS, Rule::Shift, State::Exceeded, Some(0.004), false);
        let once = verdict(Coefficient::DI, Rule::Baseline, State::Exceeded, Some(0.02), false);
        let twice = StoredVerdict { confirmed: true, ..once };
        let required = verdict(Coefficient::E, Rule::Requirement, State::Within, Some(1.0), false);
        for (verdicts, status) in [
            (vec![], Status::NotEnoughData),
            (vec![waits, required], Status::NotEnoughData),
            (vec![within, waits, required], Status::InTolerance),
            (vec![within, drifts], Status::Drifting),
            (vec![drifts, once], Status::Unconfirmed),
            (vec![once, drifts, twice], Status::Confirmed),
            (vec![waits, StoredVerdict { state: State::Exceeded, ..required }], Status::Unconfirmed),
        ] {
            assert_eq!(of_gyro(&verdicts), status, "{verdicts:?}");
        }
        assert_eq!(worst(&[within, drifts, waits], Coefficient::DS), Some(Status::Drifting));
        assert_eq!(worst(&[within, waits], Coefficient::DS), None);
    }
}
