use super::*;
use crate::core::judge::{Coefficient, Finding, LimitKey, Rule};

const POLICY: Policy = Policy { repeat_days: 7.0, resolve_below: 0.8, resolve_after: 2 };

fn day(n: f64) -> UtcMicros {
    UtcMicros(1_767_225_600_000_000).plus_days(n)
}

fn verdict(rule: Rule, state: State, value: f64, confirmed: bool) -> Verdict {
    Verdict {
        coefficient: Coefficient::DI,
        rule,
        state,
        value: Some(value),
        limit: 0.01,
        limit_from: LimitKey::BUDGET,
        sd: None,
        probability: None,
        confirmed,
        finding: Finding::Baseline { level: 3.0, since: None, now: 3.0 + value },
    }
}

fn exceeded() -> Verdict {
    verdict(Rule::Baseline, State::Exceeded, 0.012, false)
}

fn confirmed() -> Verdict {
    verdict(Rule::Baseline, State::Exceeded, 0.012, true)
}

fn within(value: f64) -> Verdict {
    verdict(Rule::Baseline, State::Within, value, false)
}

fn straddling() -> Verdict {
    verdict(Rule::Baseline, State::Indeterminate, 0.0102, false)
}

fn too_few() -> Verdict {
    Verdict { value: None, finding: Finding::TooFew { have: 1, need: 3 }, ..straddling() }
}

/// One alert followed through verdicts and ticks; a record is calibrated when it arrives.
#[derive(Default)]
struct Story {
    alert: Option<Alert>,
}

impl Story {
    fn record(&mut self, at: f64, verdict: &Verdict) -> Action {
        let decision = follow(self.alert.as_ref(), verdict, day(at), day(at), &POLICY);
        self.alert = decision.alert;
        decision.action
    }

    fn tick(&mut self, at: f64) -> Action {
        let decision = tick(&self.alert.expect("an alert"), day(at), &POLICY);
        self.alert = decision.alert;
        decision.action
    }

    fn silence(&mut self, until: f64) {
        self.alert = self.alert.map(|alert| silence(&alert, Some(day(until))));
    }

    fn status(&self) -> Option<Status> {
        self.alert.map(|alert| alert.status)
    }
}

#[test]
fn an_exceeded_limit_fires_once_and_resolves_once() {
    let mut story = Story::default();
    assert_eq!(story.record(0.0, &within(0.001)), Action::Silent);
    assert_eq!(story.status(), None);
    assert_eq!(story.record(14.0, &exceeded()), Action::Fire);
    assert_eq!(story.record(28.0, &exceeded()), Action::Silent);
    assert_eq!(story.record(42.0, &within(0.002)), Action::Resolve);
    assert_eq!(story.record(56.0, &within(0.002)), Action::Silent);
    assert_eq!(story.record(70.0, &exceeded()), Action::Fire);
}

#[test]
fn a_second_campaign_escalates_even_what_was_acknowledged() {
    let mut story = Story::default();
    story.record(0.0, &exceeded());
    story.alert = story.alert.map(|alert| acknowledge(&alert));
    assert_eq!(story.tick(10.0), Action::Silent, "acknowledged: no repeats");
    assert_eq!(story.record(14.0, &confirmed()), Action::Escalate);
    assert_eq!(story.alert.unwrap().severity, Severity::Critical);
    assert!(!story.alert.unwrap().acknowledged);
    assert_eq!(story.record(28.0, &confirmed()), Action::Silent);
    assert_eq!(story.record(42.0, &exceeded()), Action::Silent, "an episode's severity never falls");
}

#[test]
fn a_step_that_the_next_campaign_confirms_goes_on_firing_and_escalates() {
    let step = |state, value, confirmed| verdict(Rule::Step, state, value, confirmed);
    let mut story = Story::default();
    assert_eq!(story.record(0.0, &step(State::Exceeded, 0.02, false)), Action::Fire);
    assert_eq!(story.record(14.0, &step(State::Exceeded, 0.021, true)), Action::Escalate);
    assert_eq!(story.status(), Some(Status::Firing));
    assert_eq!(story.record(28.0, &step(State::Within, 0.001, false)), Action::Resolve);
}

#[test]
fn a_requirement_missed_by_a_second_campaign_escalates_and_two_that_keep_it_resolve() {
    let requirement = |state| verdict(Rule::Requirement, state, -0.6, false);
    let mut story = Story::default();
    assert_eq!(story.record(0.0, &requirement(State::Exceeded)), Action::Fire);
    assert_eq!(story.record(0.0, &requirement(State::Exceeded)), Action::Silent, "the same campaign again");
    assert_eq!(story.record(14.0, &requirement(State::Exceeded)), Action::Escalate);
    assert_eq!(story.record(28.0, &requirement(State::Within)), Action::Silent);
    assert_eq!(story.record(42.0, &requirement(State::Within)), Action::Resolve);
}

#[test]
fn how_an_alert_stands_is_told_by_what_people_said_and_by_the_time() {
    let mut story = Story::default();
    story.record(0.0, &exceeded());
    let alert = story.alert.unwrap();
    let known = acknowledge(&alert);
    assert_eq!(alert.standing(day(1.0)), Standing::Firing);
    assert_eq!(known.standing(day(1.0)), Standing::Acknowledged);
    let silenced = silence(&known, Some(day(5.0)));
    assert_eq!(silenced.standing(day(4.9)), Standing::Silenced);
    assert_eq!(silenced.standing(day(5.0)), Standing::Acknowledged);
    assert_eq!(reset(&silenced, day(2.0)).alert.unwrap().standing(day(2.0)), Standing::Resolved);
}

#[test]
fn near_the_limit_it_takes_two_campaigns_to_resolve() {
    let mut story = Story::default();
    story.record(0.0, &exceeded());
    assert_eq!(story.record(14.0, &within(0.0095)), Action::Silent);
    assert_eq!(
        story.record(14.0, &within(0.0095)),
        Action::Silent,
        "the same record judged again is no second campaign"
    );
    assert_eq!(story.record(28.0, &exceeded()), Action::Silent, "no flapping: it never stopped firing");
    assert_eq!(story.record(42.0, &within(0.0095)), Action::Silent);
    assert_eq!(story.record(56.0, &within(0.0095)), Action::Resolve);
}

#[test]
fn what_is_uncertain_or_sparse_neither_fires_nor_takes_back() {
    let mut story = Story::default();
    assert_eq!(story.record(0.0, &too_few()), Action::Silent);
    assert_eq!(story.record(14.0, &straddling()), Action::Silent);
    assert_eq!(story.status(), None);
    story.record(28.0, &exceeded());
    assert_eq!(story.record(42.0, &straddling()), Action::Silent);
    assert_eq!(story.status(), Some(Status::Firing));
    assert_eq!(story.record(56.0, &too_few()), Action::Resolve, "the history was restarted");
}

#[test]
fn a_firing_alert_repeats_until_it_is_acknowledged() {
    let mut story = Story::default();
    story.record(0.0, &exceeded());
    assert_eq!(story.tick(6.9), Action::Silent);
    assert_eq!(story.tick(7.0), Action::Repeat);
    assert_eq!(story.tick(7.1), Action::Silent);
    assert_eq!(story.tick(14.0), Action::Repeat);
    story.alert = story.alert.map(|alert| acknowledge(&alert));
    assert_eq!(story.tick(40.0), Action::Silent);
}

#[test]
fn a_silence_holds_back_and_loses_nothing() {
    let mut story = Story::default();
    story.record(0.0, &exceeded());
    story.silence(20.0);
    assert_eq!(story.record(5.0, &confirmed()), Action::Silent);
    assert_eq!(story.tick(19.9), Action::Silent);
    assert_eq!(story.tick(20.0), Action::Escalate, "what was escalated under the silence is told at its end");

    let mut story = Story::default();
    story.record(0.0, &exceeded());
    story.silence(20.0);
    assert_eq!(story.record(5.0, &within(0.001)), Action::Silent);
    assert_eq!(story.tick(20.0), Action::Resolve, "nobody is left believing that it fires");
    assert_eq!(story.tick(21.0), Action::Silent);

    let mut story = Story::default();
    story.record(0.0, &exceeded());
    story.record(1.0, &within(0.001));
    story.silence(20.0);
    assert_eq!(story.record(5.0, &exceeded()), Action::Silent);
    assert_eq!(story.record(6.0, &within(0.001)), Action::Silent);
    assert_eq!(story.tick(20.0), Action::Silent, "what came and went in silence is not told");
    assert_eq!(story.record(30.0, &exceeded()), Action::Fire);
}

#[test]
fn a_clock_that_jumps_neither_doubles_nor_loses_an_alert() {
    let mut story = Story::default();
    story.record(0.0, &exceeded());
    assert_eq!(story.tick(3650.0), Action::Repeat);
    assert_eq!(story.tick(3650.1), Action::Silent);
    assert_eq!(story.tick(1.0), Action::Silent, "set back ten years");
    assert_eq!(story.tick(7.9), Action::Silent);
    assert_eq!(story.tick(8.0), Action::Repeat, "it repeats on the new clock");
}

#[test]
fn an_event_that_resets_the_rule_resolves_the_alert() {
    let mut story = Story::default();
    story.record(0.0, &exceeded());
    let decision = reset(&story.alert.unwrap(), day(1.0));
    assert_eq!(decision.action, Action::Resolve);
    assert_eq!(decision.alert.unwrap().resolved_at, Some(day(1.0)));
    assert_eq!(reset(&decision.alert.unwrap(), day(2.0)).action, Action::Silent);
}

mod properties {
    use super::*;
    use proptest::prelude::*;

    #[derive(Debug, Clone)]
    enum Happening {
        Verdict(Verdict),
        Tick,
        Acknowledge,
        Silence(f64),
        Reset,
    }

    fn happening() -> impl Strategy<Value = Happening> {
        prop_oneof![
            4 => prop::sample::select(vec![
                exceeded(), confirmed(), within(0.001), within(0.0095), straddling(), too_few(),
                verdict(Rule::Step, State::Within, 0.001, true),
            ])
            .prop_map(Happening::Verdict),
            3 => Just(Happening::Tick),
            1 => Just(Happening::Acknowledge),
            1 => (0.0..40.0).prop_map(Happening::Silence),
            1 => Just(Happening::Reset),
        ]
    }

    proptest! {
        /// Whoever hears only the actions knows the truth whenever no silence is on.
        #[test]
        fn a_listener_is_never_wrong_outside_a_silence(
            happenings in prop::collection::vec((happening(), 0.1..10.0), 1..80)
        ) {
            let (mut alert, mut now): (Option<Alert>, f64) = (None, 0.0);
            let mut believes_firing = false;
            for (happening, days) in happenings {
                now += days;
                let decision = match (&happening, alert) {
                    (Happening::Verdict(verdict), _) => follow(alert.as_ref(), verdict, day(now), day(now), &POLICY),
                    (_, None) => continue,
                    (Happening::Tick, Some(alert)) => tick(&alert, day(now), &POLICY),
                    (Happening::Acknowledge, Some(alert)) => {
                        Decision { alert: Some(acknowledge(&alert)), action: Action::Silent }
                    }
                    (Happening::Silence(d), Some(alert)) => {
                        Decision { alert: Some(silence(&alert, Some(day(now + d)))), action: Action::Silent }
                    }
                    (Happening::Reset, Some(alert)) => reset(&alert, day(now)),
                };
                alert = decision.alert;
                match decision.action {
                    Action::Fire => { prop_assert!(!believes_firing, "fired twice"); believes_firing = true; }
                    Action::Resolve => { prop_assert!(believes_firing, "resolved what was never told"); believes_firing = false; }
                    Action::Escalate | Action::Repeat => prop_assert!(believes_firing),
                    Action::Silent => {}
                }
                let Some(alert) = alert else { continue };
                let heard = tick(&alert, day(now), &POLICY).action;
                if alert.silenced_until.is_none_or(|until| until <= day(now)) && matches!(heard, Action::Silent) {
                    prop_assert_eq!(believes_firing, alert.status == Status::Firing);
                }
            }
        }
    }
}
