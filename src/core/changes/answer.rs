//! What is asked, one gyro's history, and what is answered.

use std::sync::Arc;

use super::noise::Process;
use super::unlike_window::Unlike;
use crate::core::judge::{Coefficient, Event, Mark, Measured};
use crate::core::message::{Message, Parameter, figure, list, signed, text};
use crate::core::mounting::Slot;
use crate::core::named::named;
use crate::core::time::UtcMicros;
use crate::message;

/// Days of a Julian year; ageing is stated per year.
pub(super) const YEAR_DAYS: f64 = 365.25;

/// One record of one gyro, with what else was recorded of the occasion.
#[derive(Debug, Clone, PartialEq)]
pub struct HistoryEntry {
    pub at: UtcMicros,
    pub station: Arc<str>,
    /// A change of IMU or slot is a re-mounting. Gyros of one IMU are calibrated together.
    pub imu: Arc<str>,
    pub slot: Slot,
    pub temperature_c: Option<f64>,
    /// D_I, D_S, D_O, deg/(h g0).
    pub d: [Measured; 3],
}

/// One gyro's records and events, oldest first.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct GyroHistory {
    pub entries: Vec<HistoryEntry>,
    pub marks: Vec<Mark>,
}

/// What a station did: to all gyros that it measured, or as far as one gyro's records can say.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StationForm {
    /// It reads differently from the station that offsets count from.
    Offset,
    /// Its reading changes steadily, deg/(h g0) a year.
    Drift,
    /// The same from this instant on.
    DriftSince(UtcMicros),
    /// Its reading changed at this instant and stayed: a re-levelling, a new reference.
    Step(UtcMicros),
    /// Its reading was off from the first instant on and before the second.
    Between(UtcMicros, UtcMicros),
}

impl StationForm {
    /// Whether its instants were searched for.
    pub(super) fn is_searched(self) -> bool {
        matches!(self, Self::DriftSince(_) | Self::Step(_) | Self::Between(..))
    }

    /// Whether its size is that of a year.
    pub(super) fn is_drift(self) -> bool {
        matches!(self, Self::Drift | Self::DriftSince(_))
    }

    /// Unit of its size.
    pub(super) fn unit(self) -> &'static str {
        if self.is_drift() { "deg/(h*g0)/year" } else { "deg/(h*g0)" }
    }

    /// What it adds at the station, at an instant that is so many years from the first.
    pub(super) fn at(self, at: UtcMicros, years: f64) -> f64 {
        match self {
            Self::Offset => 1.0,
            Self::Drift => years,
            Self::DriftSince(from) => (at.days_since(from) / YEAR_DAYS).max(0.0),
            Self::Step(from) => f64::from(at >= from),
            Self::Between(from, until) => f64::from(from <= at && at < until),
        }
    }
}

/// What a cause is tied to.
#[derive(Debug, Clone, PartialEq)]
pub enum Attribution {
    /// The time, throughout.
    Slope,
    /// A repair makes another gyro of it: a slope of its own before and after.
    SlopeUntil(UtcMicros),
    /// The time after a repair.
    SlopeAfter(UtcMicros),
    /// It began after this record.
    SlopeSince(UtcMicros),
    /// Every event between two records that follow one another: none of them is told from another.
    Events(Vec<(Event, UtcMicros)>),
    /// A step where the gyro comes to another IMU or slot.
    Moved { from: String, to: String, at: UtcMicros },
    /// The temperature about its mean; how many records state none.
    Temperature { mean_c: f64, missing: usize },
    /// What a station does; where that is an offset, against another.
    Station { name: Arc<str>, against: Arc<str>, form: StationForm },
    /// Many gyros of a station were off, each in its own direction, this one from the first instant on and before the
    /// second.
    Unlike { name: Arc<str>, seen: Unlike, from: UtcMicros, until: Option<UtcMicros> },
    /// D_S, in proportion to which D_O moves.
    Proportion,
    /// A step between two records, which no event explains.
    Instant { after: UtcMicros, before: UtcMicros },
}

impl Attribution {
    /// The regressor of the cause at a record; years count from `origin`, and constants do not matter.
    pub fn regressor(&self, entry: &HistoryEntry, origin: UtcMicros) -> f64 {
        let years = entry.at.days_since(origin) / YEAR_DAYS;
        let since = |at: UtcMicros| f64::from(u8::from(entry.at >= at));
        let years_after = |at: UtcMicros| entry.at.days_since(at) / YEAR_DAYS;
        match self {
            Self::Slope => years,
            Self::SlopeUntil(repair) => years_after(*repair).min(0.0),
            Self::SlopeAfter(began) | Self::SlopeSince(began) => years_after(*began).max(0.0),
            Self::Events(events) => events.last().map_or(0.0, |(_, at)| since(*at)),
            Self::Moved { at, .. } | Self::Instant { before: at, .. } => since(*at),
            Self::Temperature { mean_c, .. } => entry.temperature_c.map_or(0.0, |t| t - mean_c),
            Self::Station { name, .. } | Self::Unlike { name, .. } if *name != entry.station => 0.0,
            Self::Station { form, .. } => form.at(entry.at, years),
            Self::Unlike { from, until, .. } => since(*from) - until.map_or(0.0, since),
            Self::Proportion => entry.d[1].value,
        }
    }

    /// What it is tied to, as a code with parameters.
    pub fn message(&self) -> Message {
        match self {
            Self::Slope => message!("change_slope"),
            Self::SlopeUntil(repair) => message!("change_slope_until", day = text(repair.date())),
            Self::SlopeAfter(repair) => message!("change_slope_after", day = text(repair.date())),
            Self::SlopeSince(began) => message!("change_slope_since", day = text(began.date())),
            Self::Events(events) => {
                let event = |(event, at): &(Event, UtcMicros)| {
                    message!("change_event", event = event.word(), day = text(at.date()))
                };
                match &events[..] {
                    [one] => event(one),
                    all => message!("change_events", events = list(all.iter().map(event))),
                }
            }
            Self::Moved { from, to, .. } => message!("change_moved", from = text(from), to = text(to)),
            Self::Temperature { mean_c, missing: 0 } => message!("change_temperature", mean = figure(*mean_c, 2)),
            Self::Temperature { mean_c, missing } => {
                message!("change_temperature_gaps", mean = figure(*mean_c, 2), missing = *missing)
            }
            Self::Station { name, against, form: StationForm::Offset } => {
                message!("change_station_offset", station = text(name), against = text(against))
            }
            Self::Station { name, form: StationForm::Drift, .. } => {
                message!("change_station_drift", station = text(name))
            }
            Self::Station { name, form: StationForm::DriftSince(at), .. } => {
                message!("change_station_drift_since", station = text(name), day = text(at.date()))
            }
            Self::Station { name, form: StationForm::Step(at), .. } => {
                message!("change_station_step", station = text(name), day = text(at.date()))
            }
            Self::Station { name, form: StationForm::Between(from, until), .. } => {
                let [from, until] = [from, until].map(|at| text(at.date()));
                message!("change_station_between", station = text(name), from, until)
            }
            Self::Unlike { name, seen, .. } => seen.as_cause(name),
            Self::Proportion => message!("change_proportion"),
            Self::Instant { after, before } => {
                message!("change_instant", after = text(after.date()), before = text(before.date()))
            }
        }
    }
}

/// An estimated parameter and its standard deviation.
#[derive(Debug, Clone, PartialEq)]
pub struct CauseEstimate {
    pub name: &'static str,
    pub value: f64,
    pub sd: f64,
    pub unit: &'static str,
}

impl CauseEstimate {
    /// Its unit as the reader's language writes it.
    fn unit_said(&self) -> Parameter {
        match self.unit {
            "deg/(h*g0)" => message!("unit_drift").into(),
            "deg/(h*g0)/year" => message!("unit_drift_a_year").into(),
            "deg/(h*g0)/K" => message!("unit_drift_a_kelvin").into(),
            other => other.into(),
        }
    }
}

/// Errors of predicting blocks of time that were left out, rms in deg/(h g0), and what share of the change is closed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HistoryHeldOut {
    pub before: f64,
    pub after: f64,
    pub closure: f64,
    /// 95 %.
    pub interval: [f64; 2],
}

named! {
/// What a change of a coefficient is put down to, in the order of names, in which a class lists it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum ChangeCause("cause_") {
    Ageing = "ageing",
    Clocking = "clocking",
    ReMounting = "re_mounting",
    Station = "station",
    Step = "step",
    StepAtEvent = "step_at_event",
    Temperature = "temperature",
    /// Stands in a class where the coefficient may as well wander without a cause.
    Wandering = "wandering",
}
}

impl ChangeCause {
    /// Whether it is the gyro's own, from one record to the next.
    pub(super) fn is_step(self) -> bool {
        matches!(self, Self::Step | Self::StepAtEvent | Self::ReMounting)
    }
}

/// One record as it is drawn, deg/(h g0).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DrawnRecord {
    pub at: UtcMicros,
    pub measured: Measured,
    /// What the stations did to it, about their mean.
    pub station: f64,
    /// What all that is named makes of it.
    pub explained: f64,
}

/// A cause that was named, and the evidence.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedCause {
    pub cause: ChangeCause,
    /// Every cause that explains this change equally well, itself included.
    pub class: Vec<ChangeCause>,
    pub tie: Attribution,
    pub estimate: CauseEstimate,
    /// None where no block can be predicted from the others, or where they say nothing of it.
    pub held_out: Option<HistoryHeldOut>,
    pub p_value_adjusted: f64,
}

/// Why a candidate was not taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum WhyRejected {
    /// These records do not tell it from what is named.
    NotSeparable,
    /// As large by chance too often.
    NotSignificant { p: f64 },
    /// A wandering coefficient does as much.
    NoBetterThanWandering { p: f64 },
    /// The other gyros that the station measured say otherwise.
    OthersDeny { own: f64, others: f64, sd: f64, gyros: usize },
}

impl WhyRejected {
    /// The reason as a code with parameters.
    pub fn message(&self) -> Message {
        match *self {
            Self::NotSeparable => message!("change_not_separable"),
            Self::NotSignificant { p } => message!("change_not_significant", p = figure(p, 2)),
            Self::NoBetterThanWandering { p } => message!("change_no_better_than_wandering", p = figure(p, 2)),
            Self::OthersDeny { own, others, sd, gyros } => message!(
                "change_others_deny",
                own = signed(own, decimals(sd)),
                others = signed(others, decimals(sd)),
                sd = figure(sd, decimals(sd)),
                gyros
            ),
        }
    }
}

/// A candidate that was not taken, and why.
#[derive(Debug, Clone, PartialEq)]
pub struct Rejected {
    pub cause: ChangeCause,
    pub tie: Attribution,
    pub why: WhyRejected,
}

/// A record that stands apart from those before and after it, and was left out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outlier {
    pub at: UtcMicros,
    /// Distance from its neighbours, deg/(h g0).
    pub deviation: f64,
    pub sd: f64,
}

impl Outlier {
    /// `is_newest`: whether no record has come since.
    fn message(&self, is_newest: bool) -> Message {
        let (day, deviation) = (text(self.at.date()), signed(self.deviation, 4));
        match is_newest {
            true => message!("history_outlier_newest", day, deviation),
            false => message!("history_outlier", day, deviation),
        }
    }
}

/// A coefficient that changes without a cause that records can name.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RandomVariation {
    pub process: Process,
    /// Standard deviation: of a year, of one record to the next, and altogether.
    pub size: f64,
    pub p_value: f64,
}

/// What is left varies far more than calibrations of such gyros scatter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExcessScatter {
    /// Standard deviation of what is left, and that expected of calibrations, deg/(h g0).
    pub sd: f64,
    pub expected: f64,
    pub p_value: f64,
}

/// When a coefficient that ages is out of tolerance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Due {
    /// Days from the newest record; negative where it is over.
    pub days: f64,
    /// Intervals, ends in days from the newest record; none where that end may never come.
    pub p80: [Option<f64>; 2],
    pub p95: [Option<f64>; 2],
    /// Until when it is within its budget with 95 %: the last day on which a calibration still finds it there.
    pub calibrate_by: Option<f64>,
}

/// What an answer rests on, and when it is given.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AsOf {
    /// How many records count.
    pub records: usize,
    /// The newest of them, from which dates count.
    pub newest: Option<UtcMicros>,
    pub now: UtcMicros,
}

named! {
/// What the diagnosis of a gyro's history comes to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HistoryVerdict {
    /// Too few records, or too short a time, to tell a change from scatter.
    TooFew = "too_few",
    /// Nothing above the scatter of calibration.
    NoChange = "no_change",
    Explained = "explained",
    PartlyExplained = "partly_explained",
    Unexplained = "unexplained",
}
}

/// The answer for one coefficient.
#[derive(Debug, Clone, PartialEq)]
pub struct HistoryDiagnosis {
    pub coefficient: Coefficient,
    pub verdict: HistoryVerdict,
    pub records: usize,
    /// Scatter of calibration from successive differences, deg/(h g0).
    pub scatter: f64,
    /// Root mean square about the mean, deg/(h g0).
    pub spread: f64,
    pub causes: Vec<NamedCause>,
    pub rejected: Vec<Rejected>,
    pub outliers: Vec<Outlier>,
    /// Whether there are records enough, and all of one day: too few, for they tell nothing of time.
    pub is_of_a_day: bool,
    pub wander: Option<RandomVariation>,
    pub excess: Option<ExcessScatter>,
    /// Significance of what is left beyond the scatter.
    pub remaining_p_value: f64,
    /// Where it ages and its budget is known.
    pub due: Option<Due>,
    /// The records, where there are enough of them.
    pub course: Vec<DrawnRecord>,
}

/// Fewest records of which anything is said: a constant, a cause, and four left to judge the scatter by.
pub const FEWEST_RECORDS: usize = 6;

impl HistoryDiagnosis {
    /// What is said of the coefficient, sentence by sentence.
    pub fn sentences(&self, as_of: AsOf) -> Vec<Message> {
        let of_causes = self.causes.iter().flat_map(NamedCause::sentences);
        std::iter::once(self.opening())
            .chain(of_causes)
            .chain(self.besides(as_of))
            .chain(self.looked_at(as_of.records))
            .collect()
    }

    /// How much of the change is explained.
    pub fn opening(&self) -> Message {
        match self.verdict {
            HistoryVerdict::TooFew if self.is_of_a_day => message!("history_of_a_day", records = self.records),
            HistoryVerdict::TooFew => message!("history_too_few", records = self.records),
            HistoryVerdict::NoChange => message!("history_no_change"),
            HistoryVerdict::Explained if self.causes.iter().any(|one| one.cause == ChangeCause::Step) => {
                message!("history_explained_by_step")
            }
            HistoryVerdict::Explained => message!("history_explained"),
            HistoryVerdict::PartlyExplained => message!("history_partly_explained"),
            HistoryVerdict::Unexplained => message!("history_unexplained"),
        }
    }

    /// Whether one step explains all of its change that is no station's for certain, and nothing else does as well: the
    /// gyro's own, or its station's.
    pub fn is_one_step(&self) -> bool {
        let stepped = |cause: &NamedCause| {
            let may_be = |other: &ChangeCause| other.is_step() || *other == ChangeCause::Station;
            cause.cause.is_step() && cause.class.iter().all(may_be)
        };
        let mut own = self.causes.iter().filter(|cause| cause.class.iter().any(|one| *one != ChangeCause::Station));
        self.verdict == HistoryVerdict::Explained && own.next().is_some_and(stepped) && own.next().is_none()
    }

    /// Whether one recorded event explains all of its change.
    pub fn is_one_event(&self) -> bool {
        self.is_one_step() && self.causes.iter().all(|one| one.cause != ChangeCause::Step)
    }

    /// Of how many records it is said, where not all that count are looked at.
    pub fn looked_at(&self, records: usize) -> Option<Message> {
        (self.records < records).then(|| message!("history_looked_at", looked_at = self.records, records))
    }

    /// Whether there is a change to be put down to something, or the newest record stands apart from all that is said.
    pub fn is_changed(&self, as_of: AsOf) -> bool {
        !matches!(self.verdict, HistoryVerdict::TooFew | HistoryVerdict::NoChange)
            || self.newest_left_out(as_of).is_some()
    }

    /// The newest record, where it was left out: what is said is of those before it.
    pub fn newest_left_out(&self, as_of: AsOf) -> Option<&Outlier> {
        self.outliers.iter().find(|outlier| Some(outlier.at) == as_of.newest)
    }

    fn random_variation_message(&self) -> Option<Message> {
        self.wander.as_ref().map(|wander| {
            let size = figure(wander.size, 5);
            match wander.process {
                Process::RandomWalk => message!("history_wander_random_walk", size),
                Process::WalkByRecord => message!("history_wander_walk_by_record", size),
                Process::White | Process::Flicker => message!("history_wander_flicker", size),
            }
        })
    }

    /// What stands beside the causes where there is room for little: how much is explained, how it wanders, whether that
    /// is said of the newest record, and what lies ahead.
    pub fn in_brief(&self, as_of: AsOf) -> Vec<Message> {
        let left_out = self.newest_left_out(as_of).map(|outlier| outlier.message(true));
        std::iter::once(self.opening())
            .chain(self.random_variation_message())
            .chain(left_out)
            .chain(self.ahead(as_of))
            .collect()
    }

    /// What is said besides the causes: how it wanders, what is left, what lies off, when it reaches its budget.
    pub fn besides(&self, as_of: AsOf) -> Vec<Message> {
        let mut all = Vec::new();
        all.extend(self.random_variation_message());
        all.extend(self.excess.iter().map(|excess| {
            message!("history_excess", sd = figure(excess.sd, 5), expected = figure(excess.expected, 5))
        }));
        all.extend(self.outliers.iter().map(|outlier| outlier.message(Some(outlier.at) == as_of.newest)));
        all.extend(self.ahead(as_of));
        all
    }

    /// When it reaches its budget, and until when it has to be calibrated.
    pub fn ahead(&self, AsOf { newest, now, .. }: AsOf) -> Vec<Message> {
        let Some((newest, due)) = newest.zip(self.due.as_ref()) else { return Vec::new() };
        let day = |days: f64| text(newest.plus_days(days).date());
        let is_past = |days: f64| newest.plus_days(days) < now;
        let reaches = match due.p80 {
            _ if is_past(due.days) => message!("history_due_past", day = day(due.days)),
            [Some(early), Some(late)] => {
                message!("history_due", day = day(due.days), early = day(early), late = day(late))
            }
            [early, _] => message!("history_due_open", day = day(due.days), early = day(early.unwrap_or(0.0))),
        };
        // What the newest record has shown to be beyond needs no calibration to be found so.
        let calibrate = due.calibrate_by.filter(|_| due.days > 0.0).map(|days| match is_past(days) {
            true => message!("history_calibrate_now", day = day(days)),
            false => message!("history_calibrate_by", day = day(days)),
        });
        std::iter::once(reaches).chain(calibrate).collect()
    }
}

/// Decimals of a figure beside its standard deviation: two digits of that, and four at the least.
fn decimals(sd: f64) -> usize {
    (1.0 - sd.max(1e-9).log10().floor()).max(4.0) as usize
}

impl NamedCause {
    /// What it is and what it explains, sentence by sentence.
    fn sentences(&self) -> Vec<Message> {
        let mut all = vec![message!(
            "history_cause",
            cause = self.cause.word(),
            detail = self.tie.message(),
            value = signed(self.estimate.value, decimals(self.estimate.sd)),
            sd = figure(self.estimate.sd, decimals(self.estimate.sd)),
            unit = self.estimate.unit_said()
        )];
        all.extend(self.others());
        if let Some(held_out) = self.held_out {
            let [closure, low, high] = [held_out.closure, held_out.interval[0], held_out.interval[1]]
                .map(|share| text(format_args!("{:.0} %", 100.0 * share)));
            all.push(message!("history_closure", closure, low, high));
        }
        all
    }

    /// What explains the change equally well.
    pub fn others(&self) -> Option<Message> {
        let others = self.class.iter().filter(|one| **one != self.cause).map(|one| one.word());
        let others: Vec<Message> = others.collect();
        (!others.is_empty()).then(|| message!("history_class", others = list(others)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::words::Language;

    #[test]
    fn a_cause_is_said_in_the_units_of_the_language() {
        for (unit, english, chinese) in [
            ("deg/(h*g0)", "deg/(h g0)", "(°)/(h·g0)"),
            ("deg/(h*g0)/year", "deg/(h g0) a year", "(°)/(h·g0)/年"),
            ("deg/(h*g0)/K", "deg/(h g0)/K", "(°)/(h·g0)/K"),
        ] {
            let estimate = CauseEstimate { name: "k", value: 0.01, sd: 0.002, unit };
            let said = message!(
                "history_cause",
                cause = "a",
                detail = "b",
                value = "1",
                sd = "2",
                unit = estimate.unit_said()
            );
            assert_eq!(Language::English.words(&said), format!("a: b, 1 +- 2 {english}"));
            assert_eq!(Language::Chinese.words(&said), format!("a：b，1 ± 2 {chinese}"));
        }
    }

    fn named(cause: ChangeCause, class: &[ChangeCause]) -> NamedCause {
        let estimate = CauseEstimate { name: "k", value: 0.018, sd: 7e-4, unit: "deg/(h*g0)" };
        NamedCause {
            cause,
            class: class.to_vec(),
            tie: Attribution::Slope,
            estimate,
            held_out: None,
            p_value_adjusted: 1e-6,
        }
    }

    fn explained_by(causes: Vec<NamedCause>) -> HistoryDiagnosis {
        HistoryDiagnosis {
            coefficient: Coefficient::DS,
            verdict: HistoryVerdict::Explained,
            records: 30,
            scatter: 7e-4,
            spread: 5e-3,
            causes,
            rejected: Vec::new(),
            outliers: Vec::new(),
            is_of_a_day: false,
            wander: None,
            excess: None,
            remaining_p_value: 1.0,
            due: None,
            course: Vec::new(),
        }
    }

    #[test]
    fn one_step_is_one_beside_what_the_station_did_and_the_newest_record_says_that_it_was_left_out() {
        use ChangeCause::{Ageing, ReMounting, Station, Step};
        let step = || named(Step, &[Step]);
        for (causes, expected) in [
            (vec![step()], true),
            (vec![named(Step, &[Station, Step])], true),
            (vec![step(), named(Station, &[Station])], true),
            (vec![named(Station, &[Station])], false),
            (vec![step(), named(Station, &[Ageing, Station])], false),
            (vec![step(), named(ReMounting, &[ReMounting])], false),
            (vec![named(Step, &[Ageing, Step])], false),
        ] {
            let answer = explained_by(causes);
            assert_eq!(answer.is_one_step(), expected, "{:?}", answer.causes);
        }
        let wanders = HistoryDiagnosis { verdict: HistoryVerdict::PartlyExplained, ..explained_by(vec![step()]) };
        assert!(!wanders.is_one_step());
        let day = |day: i64| UtcMicros(day * UtcMicros::DAY);
        let apart = Outlier { at: day(40), deviation: 0.016, sd: 7e-4 };
        let steady = HistoryDiagnosis {
            verdict: HistoryVerdict::NoChange,
            outliers: vec![Outlier { at: day(10), ..apart }, apart],
            ..explained_by(Vec::new())
        };
        for (newest, of_it) in [(40, vec![apart.message(true)]), (50, Vec::new())] {
            let as_of = AsOf { records: 30, newest: Some(day(newest)), now: day(60) };
            let said = std::iter::once(message!("history_no_change")).chain(of_it.clone()).collect::<Vec<_>>();
            assert_eq!((steady.in_brief(as_of), steady.is_changed(as_of)), (said, !of_it.is_empty()), "{newest}");
        }
        assert!(explained_by(vec![named(ReMounting, &[ReMounting]), named(Station, &[Station])]).is_one_event());
    }
}
