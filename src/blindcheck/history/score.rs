//! What a diagnosis of a drawn fleet got right.

use crate::core::changes::{ChangeCause, HistoryDiagnosis, HistoryVerdict};

use super::draw::{DrawnFleet, HiddenCause, YEAR_DAYS};

/// What is answered of D_I, D_S and D_O of each gyro of a fleet, in the fleet's order.
pub type Answers = Vec<Vec<HistoryDiagnosis>>;

/// What diagnoses a fleet, the service with its real ingest; or the reason why it could not.
pub type FleetDiagnoser<'a> = dyn Fn(&DrawnFleet) -> Result<Answers, String> + Sync + 'a;

/// One fleet, scored.
#[derive(Debug, Clone)]
pub struct FleetScore {
    pub kind: HiddenCause,
    /// The causes that are hidden, and no other.
    pub right: bool,
    /// Whether the class of what leads holds what has to be in it.
    pub class: Option<bool>,
    /// Coefficients of which nothing is true, and how many of them have a name.
    pub false_names: (usize, usize),
    /// Where a station did it: whether the gyro is blamed.
    pub gyro_blamed: Option<bool>,
    /// Where a coefficient wanders: whether a name explains it.
    pub explained: Option<bool>,
    pub closure_covered: Option<bool>,
    /// Whether the date at which the budget is left lies within the 80 % and the 95 % interval.
    pub date_covered: Option<[bool; 2]>,
    /// Whether a calibration on the day that is asked for would have found it within its budget.
    pub in_time: Option<bool>,
    pub named: Vec<ChangeCause>,
}

impl DrawnFleet {
    /// Holds what was answered of every gyro and coefficient against what is hidden.
    pub fn score(&self, answers: Answers) -> FleetScore {
        let mut false_names = (0, 0);
        let mut own = None;
        for (g, answers) in answers.into_iter().enumerate() {
            for (column, answer) in answers.into_iter().enumerate() {
                let asked = g == self.asked && column == self.column;
                let moved = self.kind == HiddenCause::Clocking && g == self.asked && column == 1;
                if asked {
                    own = Some(answer);
                } else if !(moved || self.shared && column == self.column) {
                    false_names.0 += usize::from(!answer.causes.is_empty());
                    false_names.1 += 1;
                }
            }
        }
        let left = self.budget().map(|budget| budget.years_from_first - self.years(self.signal.len() - 1));
        let own = own.expect("the asked gyro is one of the fleet");
        let mut named: Vec<ChangeCause> = own.causes.iter().map(|cause| cause.cause).collect();
        named.dedup();
        let mut truth = self.truth.clone();
        truth.sort_unstable();
        let mut sorted = named.clone();
        sorted.sort_unstable();
        sorted.dedup();
        let lone = self.kind == HiddenCause::LoneImuMoved;
        let in_class = |cause: &ChangeCause| own.causes.iter().any(|named| named.class.contains(cause));
        let class = (!self.class.is_empty()).then(|| self.class.iter().all(in_class));
        let right = if lone { class == Some(true) && own.causes.len() == 1 } else { sorted == truth };
        let station = self.truth == [ChangeCause::Station] && !lone;
        FleetScore {
            kind: self.kind,
            right,
            class,
            false_names,
            gyro_blamed: station.then(|| named.iter().any(|cause| *cause != ChangeCause::Station)),
            explained: (self.kind == HiddenCause::Wanders).then_some(own.verdict == HistoryVerdict::Explained),
            closure_covered: self.closure_covered(&own),
            in_time: left
                .zip(own.due.as_ref().and_then(|due| due.calibrate_by))
                .map(|(years, by)| by <= years * YEAR_DAYS),
            date_covered: left.zip(own.due.as_ref()).map(|(years, due)| {
                let days = years * YEAR_DAYS;
                [due.p80, due.p95].map(|[early, late]| {
                    early.is_none_or(|early| early <= days) && late.is_none_or(|late| days <= late)
                })
            }),
            named,
        }
    }

    /// Whether the interval of the closure holds the share of the true change that is explained, where one cause is
    /// named.
    fn closure_covered(&self, answer: &HistoryDiagnosis) -> Option<bool> {
        let [cause] = &answer.causes[..] else { return None };
        let held_out = cause.held_out?;
        if self.truth.len() != 1 {
            return None;
        }
        let origin = self.entries()[0].at;
        let explained: Vec<f64> =
            self.entries().iter().map(|e| cause.estimate.value * cause.tie.regressor(e, origin)).collect();
        let error: Vec<f64> = self.signal.iter().zip(&explained).map(|(s, e)| s - e).collect();
        let power = |values: &[f64]| {
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            values.iter().map(|v| (v - mean).powi(2)).sum::<f64>()
        };
        let truth = 1.0 - power(&error) / power(&self.signal);
        Some((held_out.interval[0]..=held_out.interval[1] + 1e-9).contains(&truth))
    }
}
