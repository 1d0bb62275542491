//! An answer with the verdicts that were just decided: what serde writes of [`VerdictBody`](super::VerdictBody), byte
//! for byte, in a fraction of the time. A record has 45 of them, and serde looks through every word of each for what
//! has to be escaped.

use std::fmt::{self, Write as _};
use std::io;

use serde::Serialize;

use crate::core::judge::Verdict;
use crate::wire::reason::Reason;
use crate::words::asked;

/// Three gyros with all their verdicts take about 17 kB; growing would copy them again and again.
pub const CAPACITY: usize = 20 * 1024;

/// The JSON of `answer`, whose last member is `verdicts` and empty, with those of every gyro in it.
///
/// # Errors
/// Where `answer` cannot be put into JSON, or ends otherwise.
pub fn with_verdicts<'v>(
    answer: &impl Serialize,
    gyros: impl Iterator<Item = (&'v str, &'v [Verdict])>,
) -> io::Result<Vec<u8>> {
    let mut text = Vec::with_capacity(CAPACITY);
    serde_json::to_writer(&mut text, answer)?;
    if !text.ends_with(b",\"verdicts\":[]}") {
        return Err(io::Error::other("the answer does not end with the place of its verdicts"));
    }
    text.truncate(text.len() - 2);
    let mut between: &[u8] = b"";
    for (serial, verdicts) in gyros {
        let mut head = b"{\"serial\":".to_vec();
        serde_json::to_writer(&mut head, serial)?;
        for verdict in verdicts {
            text.extend_from_slice(between);
            text.extend_from_slice(&head);
            write_rest(verdict, &mut text)?;
            between = b",";
        }
    }
    text.extend_from_slice(b"]}");
    Ok(text)
}

/// All but the serial. Names and fixed phrases are the program's own words, in which nothing has to be escaped.
fn write_rest(verdict: &Verdict, text: &mut Vec<u8>) -> io::Result<()> {
    let words: [(&[u8], &str); 4] = [
        (b",\"coefficient\":\"", verdict.coefficient.name()),
        (b"\",\"rule\":\"", verdict.rule.name()),
        (b"\",\"state\":\"", verdict.state.name()),
        (b"\",\"status\":\"", verdict.status().name()),
    ];
    for (before, word) in words {
        text.extend_from_slice(before);
        text.extend_from_slice(word.as_bytes());
    }
    write_figure(b"\",\"value\":", verdict.value, text)?;
    write_figure(b",\"limit\":", Some(verdict.limit), text)?;
    write!(Words(text), ",\"limit_from\":\"{}\"", verdict.limit_from).map_err(io::Error::other)?;
    write_figure(b",\"sd\":", verdict.sd, text)?;
    write_figure(b",\"probability\":", verdict.probability, text)?;
    text.extend_from_slice(b",\"confirmed\":");
    text.extend_from_slice(if verdict.confirmed { b"true" } else { b"false" });
    match verdict.phrase() {
        Some(phrase) => {
            let words = asked().word(&phrase.code);
            write!(Words(text), ",\"code\":\"{}\",\"reason\":\"{words}\"}}", phrase.code).map_err(io::Error::other)
        }
        None => {
            let reason = serde_json::to_vec(&Reason::of(verdict))?;
            text.push(b',');
            text.extend_from_slice(&reason[1..]);
            Ok(())
        }
    }
}

fn write_figure(before: &[u8], figure: Option<f64>, text: &mut Vec<u8>) -> io::Result<()> {
    text.extend_from_slice(before);
    Ok(serde_json::to_writer(text, &figure)?)
}

/// Takes words as they come: `io::Write` would look at each piece for an error that a vector never has.
struct Words<'a>(&'a mut Vec<u8>);

impl fmt::Write for Words<'_> {
    fn write_str(&mut self, word: &str) -> fmt::Result {
        self.0.extend_from_slice(word.as_bytes());
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::{RecordAnswer, VerdictBody};
    use super::*;
    use crate::core::judge::{
        Coefficient, Finding, History, LimitKey, Limits, Measured, Rule, Sample, Seat, Series, State, judge,
    };
    use crate::core::note::Note;
    use crate::core::time::UtcMicros;
    use crate::wire::calibration::{CalibrationBody, CampaignAnswer, StationStatedBody};
    use crate::wire::note::NoteBody;

    /// Of histories that lie still, drift and step, without and with standard deviations, from one record on.
    fn judged() -> Vec<Verdict> {
        let mut verdicts = Vec::new();
        for (drift, step, sd) in
            [(0.0, 0.0, None), (1e-3, 0.0, Some(2e-4)), (1e-5, 0.02, Some(1e-3)), (-2e-3, -0.05, None)]
        {
            let samples: Vec<Sample> = (0..14)
                .map(|k| {
                    let value = drift * f64::from(k) + if k > 8 { step } else { 0.0 } + 1e-4 * f64::from(k * 7 % 5);
                    let at = UtcMicros(i64::from(k) * 9 * UtcMicros::DAY);
                    Sample {
                        at,
                        seat: Seat::default(),
                        station: 0,
                        d: [3.0, -5.0, 0.0].map(|level| Measured { value: level + value, sd }),
                    }
                })
                .collect();
            let samples = Series::from(samples);
            for k in 0..samples.len() {
                judge(&History::whole(&samples, k), k, &Limits::default(), &mut verdicts);
            }
        }
        let others = [Some("E_y"), Some("|E|"), None];
        let requirement = Finding::Requirement { figure: "E_x", low: 0.1, high: 2.5, others };
        let beside = [(Rule::Overdue, Finding::Overdue { last: UtcMicros(5) }), (Rule::Requirement, requirement)];
        verdicts.extend(beside.map(|(rule, finding)| Verdict {
            coefficient: Coefficient::E,
            rule,
            state: State::Exceeded,
            value: Some(-0.0),
            limit: 1e-300,
            limit_from: LimitKey { place: Some(12), key: "rules.step" },
            sd: Some(f64::NAN),
            probability: Some(1.0),
            between: None,
            confirmed: true,
            finding,
        }));
        verdicts
    }

    #[test]
    fn it_is_byte_for_byte_what_serde_writes() {
        let verdicts = judged();
        for rule in
            [Rule::Step, Rule::Range, Rule::Baseline, Rule::Trend, Rule::Shift, Rule::RmsSuccessive, Rule::Closure]
        {
            let of_rule = || verdicts.iter().filter(|verdict| verdict.rule == rule);
            assert!(
                of_rule().any(|verdict| verdict.value.is_some()) && of_rule().any(|verdict| verdict.value.is_none())
            );
        }
        let gyros = [("LFG-\"1\"\\", verdicts.as_slice()), ("陀螺", &[]), ("G", &verdicts[..1])];
        for count in 0..=gyros.len() {
            let gyros = &gyros[..count];
            let of = |&(serial, verdicts): &(&str, &[Verdict])| -> Vec<VerdictBody> {
                verdicts.iter().map(|verdict| VerdictBody::of(serial, verdict)).collect()
            };
            let said: Vec<VerdictBody> = gyros.iter().flat_map(of).collect();
            let record = |verdicts| RecordAnswer { id: Some("7".into()), separations: vec![], notes: vec![], verdicts };
            let campaign = |verdicts| CampaignAnswer { verdicts, ..campaign() };
            let written = [
                with_verdicts(&record(vec![]), gyros.iter().copied()),
                with_verdicts(&campaign(vec![]), gyros.iter().copied()),
            ];
            let whole = [serde_json::to_string(&record(said.clone())), serde_json::to_string(&campaign(said))];
            for (written, whole) in written.into_iter().zip(whole) {
                assert_eq!(String::from_utf8(written.unwrap()).unwrap(), whole.unwrap());
            }
        }
    }

    fn campaign() -> CampaignAnswer {
        let calibration = CalibrationBody {
            model: vec!["bias".into()],
            effects: vec![],
            dwells: 24,
            repeats: vec![],
            noise: None,
            station_uncertainty: StationStatedBody::default(),
            gyros: vec![],
        };
        CampaignAnswer {
            id: Some("7".into()),
            imu: "IMU-07".into(),
            imu_model: None,
            station: "ST-2".into(),
            measured_at: "2026-03-01T08:00:00Z".into(),
            test: "imu".into(),
            calibration,
            separations: vec![],
            not_separated: vec![],
            bench_result: None,
            notes: vec![NoteBody::of(&Note::NoSite)],
            verdicts: vec![],
        }
    }

    #[test]
    fn an_answer_that_has_verdicts_already_is_refused() {
        let verdicts = judged();
        let whole = RecordAnswer {
            id: None,
            separations: vec![],
            notes: vec![],
            verdicts: vec![VerdictBody::of("G", &verdicts[0])],
        };
        assert!(with_verdicts(&whole, [].into_iter()).is_err());
    }
}
