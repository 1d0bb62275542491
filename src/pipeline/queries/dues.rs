//! When gyros that drift, or that the rule `trend` carries there, reach their budgets by the diagnosis of their
//! histories, which knows of ageing before the rule has established it.

use std::sync::{Mutex, MutexGuard, PoisonError};

use tokio::time::Instant;

use super::gyro_history::Histories;
use crate::core::changes::HistoryDiagnosis;
use crate::core::judge::{BudgetCrossing, Coefficient, Status};
use crate::pipeline::GyroStatus;
use crate::pipeline::cached_answer::found_until;
use crate::pipeline::prelude::*;

/// Gyros whose dates are kept; more of them, and all are found anew.
const MOST_KEPT: usize = 1000;

/// When a coefficient reaches its budget: by the diagnosis of its history, which is on the gyro's page; else by the
/// rule `trend`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DueDate {
    pub coefficient: Coefficient,
    pub at: UtcMicros,
    /// 95 %; none where an end is open.
    pub between: [Option<UtcMicros>; 2],
    /// Until then it is within its budget with 95 %.
    pub calibrate_by: Option<UtcMicros>,
    /// By the straight line of the rule `trend`: a diagnosis may find another.
    pub provisional: bool,
}

impl DueDate {
    /// By the rule `trend`.
    pub fn by_trend(gyro: &GyroStatus) -> Option<Self> {
        let BudgetCrossing { coefficient, at, between, .. } = gyro.projection.reach?;
        Some(Self { coefficient, at, between, calibrate_by: None, provisional: true })
    }
}

/// Dates of gyros that drift, kept for who asks next. Cheap to clone.
#[derive(Debug, Clone)]
pub struct Dues {
    histories: Histories,
    /// And how these gyros stood when they were found.
    kept: Arc<Mutex<HashMap<u32, (GyroStatus, Option<DueDate>)>>>,
}

impl Dues {
    pub(super) fn new(histories: Histories) -> Self {
        Self { histories, kept: Arc::default() }
    }

    /// Of those of these gyros that drift, or have a date by the rule `trend` and are not out of tolerance, what reaches
    /// its budget first by its history, or has reached it, by gyro number; and how many that drift could not be
    /// diagnosed within `patience`: a gyro's own page has its date then. A gyro is diagnosed again once it stands
    /// otherwise.
    pub async fn of(
        &self,
        gyros: &[GyroStatus],
        patience: Duration,
    ) -> Result<(HashMap<u32, DueDate>, usize), StoreError> {
        let drifts = |gyro: &GyroStatus| gyro.status == Some(Status::Drifting);
        let is_carried = |gyro: &GyroStatus| gyro.projection.reach.is_some() && gyro.status < Some(Status::Drifting);
        let dated = gyros.iter().filter(|gyro| drifts(gyro) || is_carried(gyro));
        let (mut found, mut missing) = (HashMap::new(), 0);
        let until = Instant::now() + patience;
        for gyro in dated {
            let (gyro, is_drifting) = (of_any_day(gyro), drifts(gyro));
            let kept = self.kept().get(&gyro.number).filter(|(of, _)| *of == gyro).map(|(_, due)| *due);
            let number = gyro.number;
            let due = match kept {
                Some(due) => Some(due),
                None if Instant::now() >= until => None,
                None => {
                    let dues = self.clone();
                    found_until(until, async move { dues.due(&gyro).await }).await.transpose()?
                }
            };
            missing += usize::from(due.is_none() && is_drifting);
            found.extend(due.flatten().map(|due| (number, due)));
        }
        Ok((found, missing))
    }

    async fn due(&self, gyro: &GyroStatus) -> Result<Option<DueDate>, StoreError> {
        let explained = self.histories.explain(gyro.number, &gyro.serial).await?;
        let carried = gyro.projection.reach.map(|reach| reach.coefficient);
        let is_asked = |(answer, drift): &(&HistoryDiagnosis, Status)| {
            *drift >= Status::Drifting || carried == Some(answer.coefficient)
        };
        let asked = explained.coefficients.iter().zip(gyro.drift).filter(is_asked);
        let dates = asked.filter_map(|(answer, _)| {
            let (newest, due) = (explained.as_of.newest?, answer.due?);
            let at = |days: f64| newest.plus_days(days);
            Some(DueDate {
                coefficient: answer.coefficient,
                at: at(due.days),
                between: due.p95.map(|days| days.map(at)),
                calibrate_by: due.calibrate_by.map(at),
                provisional: false,
            })
        });
        let first = dates.min_by_key(|due| due.at);
        let mut kept = self.kept();
        if kept.len() >= MOST_KEPT {
            kept.clear();
        }
        kept.insert(gyro.number, (gyro.clone(), first));
        Ok(first)
    }

    fn kept(&self) -> MutexGuard<'_, HashMap<u32, (GyroStatus, Option<DueDate>)>> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// How it stands, but for what changes from day to day by itself.
fn of_any_day(gyro: &GyroStatus) -> GyroStatus {
    GyroStatus { overdue_days: None, ..gyro.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::core::judge::BudgetProjection;

    #[test]
    fn a_date_of_the_straight_line_is_provisional_however_long_the_course_is() {
        let reach =
            BudgetCrossing { coefficient: Coefficient::DI, at: UtcMicros(0), between: [None; 2], provisional: false };
        let standing =
            GyroStatus::made_for_tests(1, BudgetProjection { reach: Some(reach), ..BudgetProjection::default() });
        assert!(DueDate::by_trend(&standing).unwrap().provisional);
    }
}
