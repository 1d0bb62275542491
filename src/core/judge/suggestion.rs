//! What to do with a gyro, as its verdicts suggest it. A person decides.

use crate::core::judge::{Coefficient, Status};
use crate::core::named::named;

named! {
/// What the verdicts suggest.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Suggestion("suggestion_") {
    /// Everything that could be judged is in tolerance.
    Release = "release",
    /// Nothing could be judged yet, or not against a baseline.
    MoreRecords = "more_records",
    /// The figures may not be the gyro's.
    CheckRecord = "check_record",
    /// What changed is its station's doing.
    CheckStation = "check_station",
    /// Its interval is over.
    Calibrate = "calibrate",
    /// The standard deviations are too large to judge by.
    LowerUncertainty = "lower_uncertainty",
    /// What scatters is the gyro, whatever its records state.
    FindCause = "find_cause",
    /// One campaign is beyond a limit, or the uncertainty straddles one: another campaign decides.
    Retest = "retest",
    /// It drifts, and may be beyond its budget before its next calibration.
    ShortenInterval = "shorten_interval",
    /// By its course it may be beyond its budget already.
    CalibrateNow = "calibrate_now",
    /// It drifts, and stays in its budget beyond its next calibration.
    Watch = "watch",
    /// Nothing but D_O is out of tolerance: the mounting has moved, or something drifts along the output axis.
    CheckMounting = "check_mounting",
    /// Out of tolerance for certain, and at no level that could be accepted.
    Remove = "remove",
    /// Out of tolerance for certain: it goes, or somebody accepts its new level with a reason.
    RemoveOrAccept = "remove_or_accept",
    /// As before, where a recorded event explains it.
    AcceptOrRemove = "accept_or_remove",
}
}

impl Suggestion {
    /// Whether it is made of a drift within the budget.
    pub fn is_of_drift(self) -> bool {
        matches!(self, Self::Watch | Self::ShortenInterval)
    }
}

/// What a suggestion follows from.
#[derive(Debug, Clone, Default)]
pub struct SuggestionInput {
    /// The worst of all; none for a gyro that was never calibrated.
    pub status: Option<Status>,
    /// Whether the newest record may show another gyro's figures, or those in another unit.
    pub record_in_doubt: bool,
    /// Whether all that is wrong with it is put down to its station.
    pub is_stations: bool,
    /// Whether an alert says that it has moved together with others.
    pub moved_together: bool,
    /// What each rule that could judge says of which coefficient.
    pub verdicts: Vec<(Coefficient, Status)>,
    /// Whether it moves on or scatters, by more than one step does: it has no level that could be accepted.
    pub unsteady: bool,
    /// Whether one recorded event explains all that changed of what is out of tolerance: it has a new level.
    pub stepped_at_event: bool,
    /// Whether a coefficient still waits for its baseline: nothing says yet that it stays.
    pub awaits_baseline: bool,
    /// Whether its interval is over.
    pub overdue: bool,
    /// Whether all that is borderline changes by itself as time goes by: no other record decides that.
    pub ages: bool,
    /// Whether what is too uncertain or borderline is so by how the gyro scatters, and not by what its records state.
    pub scatters: bool,
    /// Days from its newest calibration until it may have reached its budget: the early edge of its band.
    pub reaches_in_days: Option<f64>,
    /// Whether they are over.
    pub may_have_reached: bool,
    /// Days from one calibration to the next.
    pub interval_days: Option<f64>,
}

/// The most urgent deed; none for a gyro that was never calibrated.
///
/// A trend that may reach the budget within the interval shortens it; where no interval is asked for, a trend only
/// has to be watched until it may have passed the budget. Then nothing is left to be shortened.
pub fn suggest(of: &SuggestionInput) -> Option<Suggestion> {
    let certain = |status: Status| matches!(status, Status::OutOfTolerance | Status::Confirmed);
    let mut out = of.verdicts.iter().filter(|(_, status)| certain(*status)).map(|(coefficient, _)| *coefficient);
    let soon = of.reaches_in_days.is_some_and(|days| days <= of.interval_days.unwrap_or(0.0));
    // A coefficient that has moved to its budget and goes no further by itself.
    let is = |coefficient: Coefficient, status: Status| of.verdicts.contains(&(coefficient, status));
    let at_its_budget = |(coefficient, status): &(Coefficient, Status)| {
        *status == Status::Drifting && is(*coefficient, Status::Borderline)
    };
    let stands_at_budget = !of.ages && !of.scatters && of.verdicts.iter().any(at_its_budget);
    Some(match of.status? {
        _ if of.record_in_doubt => Suggestion::CheckRecord,
        _ if of.is_stations => Suggestion::CheckStation,
        status if certain(status) => {
            let any = out.clone().next().is_some();
            let closure_alone = any && out.all(|coefficient| coefficient == Coefficient::DO);
            match closure_alone {
                true => Suggestion::CheckMounting,
                false if of.unsteady => Suggestion::Remove,
                false if of.stepped_at_event => Suggestion::AcceptOrRemove,
                false => Suggestion::RemoveOrAccept,
            }
        }
        Status::Unconfirmed => Suggestion::Retest,
        _ if of.overdue => Suggestion::Calibrate,
        Status::Drifting if of.may_have_reached => Suggestion::CalibrateNow,
        Status::Drifting if soon => Suggestion::ShortenInterval,
        Status::Drifting if stands_at_budget => Suggestion::Retest,
        Status::Drifting => Suggestion::Watch,
        Status::Borderline if of.scatters => Suggestion::FindCause,
        Status::Borderline if of.ages && of.may_have_reached => Suggestion::CalibrateNow,
        Status::Borderline if of.ages && soon => Suggestion::ShortenInterval,
        Status::Borderline if of.ages => Suggestion::Watch,
        Status::Borderline => Suggestion::Retest,
        Status::TooUncertain if of.scatters => Suggestion::FindCause,
        Status::TooUncertain => Suggestion::LowerUncertainty,
        Status::NotEnoughData => Suggestion::MoreRecords,
        _ if of.may_have_reached => Suggestion::CalibrateNow,
        _ if soon => Suggestion::ShortenInterval,
        _ if of.awaits_baseline => Suggestion::MoreRecords,
        // The alert may be about to end: until it has, nothing is released beside it.
        _ if of.moved_together => return None,
        _ => Suggestion::Release,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(status: Status, verdicts: &[(Coefficient, Status)]) -> SuggestionInput {
        SuggestionInput { status: Some(status), verdicts: verdicts.to_vec(), ..SuggestionInput::default() }
    }

    #[test]
    fn what_is_certain_goes_and_what_is_not_is_measured_again() {
        use Coefficient::{DI, DO, DS, E};
        for (status, verdicts, expected) in [
            (Status::Confirmed, vec![(DI, Status::Confirmed), (DS, Status::InTolerance)], Suggestion::RemoveOrAccept),
            (Status::Confirmed, vec![(DO, Status::Confirmed), (DI, Status::InTolerance)], Suggestion::CheckMounting),
            (
                Status::Confirmed,
                vec![(DO, Status::Confirmed), (DI, Status::OutOfTolerance)],
                Suggestion::RemoveOrAccept,
            ),
            // An alert knows what no verdict on the newest record says.
            (Status::Confirmed, vec![], Suggestion::RemoveOrAccept),
            (Status::Confirmed, vec![(E, Status::Confirmed)], Suggestion::RemoveOrAccept),
            (Status::OutOfTolerance, vec![(DS, Status::OutOfTolerance)], Suggestion::RemoveOrAccept),
            (Status::Unconfirmed, vec![(DO, Status::Unconfirmed)], Suggestion::Retest),
            (Status::Borderline, vec![(DI, Status::Borderline)], Suggestion::Retest),
            (Status::TooUncertain, vec![(DI, Status::TooUncertain)], Suggestion::LowerUncertainty),
            (Status::NotEnoughData, vec![], Suggestion::MoreRecords),
            (Status::InTolerance, vec![(DI, Status::InTolerance)], Suggestion::Release),
        ] {
            assert_eq!(suggest(&of(status, &verdicts)), Some(expected), "{status:?} {verdicts:?}");
        }
        assert_eq!(suggest(&SuggestionInput::default()), None, "never calibrated");
        let moves_on = SuggestionInput { unsteady: true, ..of(Status::Confirmed, &[(DI, Status::Confirmed)]) };
        assert_eq!(suggest(&moves_on), Some(Suggestion::Remove), "no level to accept");
        let stepped = SuggestionInput { stepped_at_event: true, ..of(Status::Confirmed, &[(DI, Status::Confirmed)]) };
        assert_eq!(suggest(&stepped), Some(Suggestion::AcceptOrRemove));
        let scatters = SuggestionInput { scatters: true, ..of(Status::TooUncertain, &[(DI, Status::TooUncertain)]) };
        assert_eq!(suggest(&scatters), Some(Suggestion::FindCause), "no smaller uncertainty decides");
        let young = SuggestionInput { awaits_baseline: true, ..of(Status::InTolerance, &[(DI, Status::InTolerance)]) };
        assert_eq!(suggest(&young), Some(Suggestion::MoreRecords), "two records that agree are no release");
        let doubtful = SuggestionInput { record_in_doubt: true, ..stepped.clone() };
        assert_eq!(suggest(&doubtful), Some(Suggestion::CheckRecord), "whose figures are they?");
        let of_station = SuggestionInput { is_stations: true, ..stepped.clone() };
        assert_eq!(suggest(&of_station), Some(Suggestion::CheckStation), "no gyro goes for what its station did");
        for status in [Status::Borderline, Status::Overdue, Status::Drifting, Status::Unconfirmed] {
            let seen = SuggestionInput { is_stations: true, may_have_reached: true, ..of(status, &[(DI, status)]) };
            assert_eq!(suggest(&seen), Some(Suggestion::CheckStation), "{status:?}");
        }
        let moved = SuggestionInput { moved_together: true, ..of(Status::InTolerance, &[(DI, Status::InTolerance)]) };
        assert_eq!(suggest(&moved), None, "nothing is released while its IMU is said to have moved");
        let both = SuggestionInput { unsteady: true, ..stepped };
        assert_eq!(suggest(&both), Some(Suggestion::Remove), "what scatters about a new level has none");
    }

    #[test]
    fn a_drift_shortens_the_interval_where_it_may_reach_the_budget_within_it() {
        let drifting = |reaches: Option<f64>, interval: Option<f64>| {
            let seen = [(Coefficient::DI, Status::Drifting)];
            suggest(&SuggestionInput {
                reaches_in_days: reaches,
                interval_days: interval,
                ..of(Status::Drifting, &seen)
            })
        };
        assert_eq!(drifting(Some(60.0), Some(90.0)), Some(Suggestion::ShortenInterval));
        assert_eq!(drifting(Some(120.0), Some(90.0)), Some(Suggestion::Watch));
        assert_eq!(drifting(Some(60.0), None), Some(Suggestion::Watch));
        assert_eq!(drifting(None, Some(90.0)), Some(Suggestion::Watch));
        let at_budget = |of_borderline: Coefficient, input: SuggestionInput| {
            let verdicts = vec![(Coefficient::DI, Status::Drifting), (of_borderline, Status::Borderline)];
            suggest(&SuggestionInput { status: Some(Status::Drifting), verdicts, ..input })
        };
        let plain = SuggestionInput { interval_days: Some(90.0), ..SuggestionInput::default() };
        let expected = [
            (Coefficient::DI, plain.clone(), Suggestion::Retest),
            (Coefficient::DO, plain.clone(), Suggestion::Watch),
            (Coefficient::DI, SuggestionInput { ages: true, ..plain.clone() }, Suggestion::Watch),
            (Coefficient::DI, SuggestionInput { scatters: true, ..plain.clone() }, Suggestion::Watch),
            (
                Coefficient::DI,
                SuggestionInput { reaches_in_days: Some(60.0), ..plain.clone() },
                Suggestion::ShortenInterval,
            ),
            (Coefficient::DI, SuggestionInput { may_have_reached: true, ..plain }, Suggestion::CalibrateNow),
        ];
        for (of_borderline, input, expected) in expected {
            assert_eq!(at_budget(of_borderline, input.clone()), Some(expected), "{of_borderline:?} {input:?}");
        }
        // A trend that no rule speaks of yet.
        let quiet =
            SuggestionInput { reaches_in_days: Some(30.0), interval_days: Some(90.0), ..of(Status::InTolerance, &[]) };
        assert_eq!(suggest(&quiet), Some(Suggestion::ShortenInterval));
    }

    #[test]
    fn what_may_have_reached_its_budget_is_calibrated_now() {
        let reached = |status: Status, overdue: bool| {
            let seen = [(Coefficient::DI, status)];
            let reaches_in_days = Some(-24.0);
            suggest(&SuggestionInput { reaches_in_days, may_have_reached: true, overdue, ..of(status, &seen) })
        };
        assert_eq!(reached(Status::Drifting, false), Some(Suggestion::CalibrateNow));
        assert_eq!(reached(Status::InTolerance, false), Some(Suggestion::CalibrateNow));
        assert_eq!(reached(Status::Drifting, true), Some(Suggestion::Calibrate), "its interval is over besides");
        assert_eq!(
            reached(Status::Unconfirmed, false),
            Some(Suggestion::Retest),
            "the record says more than its course"
        );
        assert!(!Suggestion::CalibrateNow.is_of_drift(), "no day by which it should have been");
    }

    #[test]
    fn no_re_test_decides_a_slope_or_a_scatter() {
        let borderline = || of(Status::Borderline, &[(Coefficient::DS, Status::Borderline)]);
        let ages = |reaches: f64, may_have_reached: bool| {
            let (reaches_in_days, interval_days) = (Some(reaches), Some(30.0));
            suggest(&SuggestionInput { ages: true, reaches_in_days, may_have_reached, interval_days, ..borderline() })
        };
        assert_eq!(ages(60.0, false), Some(Suggestion::Watch));
        assert_eq!(ages(20.0, false), Some(Suggestion::ShortenInterval));
        assert_eq!(ages(-1.0, true), Some(Suggestion::CalibrateNow));
        assert_eq!(suggest(&SuggestionInput { scatters: true, ..borderline() }), Some(Suggestion::FindCause));
        assert_eq!(suggest(&borderline()), Some(Suggestion::Retest));
    }

    #[test]
    fn what_is_overdue_is_calibrated_before_anything_is_made_of_it() {
        for (status, expected) in [
            (Status::Overdue, Suggestion::Calibrate),
            (Status::Drifting, Suggestion::Calibrate),
            (Status::Borderline, Suggestion::Calibrate),
            (Status::Unconfirmed, Suggestion::Retest),
            (Status::Confirmed, Suggestion::RemoveOrAccept),
        ] {
            let seen = SuggestionInput { overdue: true, ..of(status, &[(Coefficient::DI, status)]) };
            assert_eq!(suggest(&seen), Some(expected), "{status:?}");
        }
    }
}
