//! What is said of what was commanded as the Earth does not allow it, and the faults of a campaign that must not be
//! believed for it.

use crate::core::calibrate::outcome::evaluate;
use crate::core::campaign::commanded::{AffectedDwells, CommandFinding, MistakeKind, Symptom, Vectors, findings};
use crate::core::campaign::gravity::{normal_gravity_g0, possible_gravity_g0};
use crate::core::campaign::{Campaign, Site, TestKind, constant, stuck};
use crate::core::effects::Refusal;
use crate::core::message::{Parameter, figure, list, signed, text};
use crate::core::mounting::Slot;
use crate::core::record::Plausibility;
use crate::core::units::degrees;
use crate::wire::prelude::*;

/// Fields of a dwell that a station commands.
const COMMANDED: [&str; 3] = ["attitude", "specific_force_g0", "rate_arcsec_s"];

/// Refuses a campaign whose commanded vectors have moved D_I and D_S, whose gravity is that of no place, or whose
/// outputs are those of gyros in other slots or of another sign. Every way in calls it; what is stored is not asked
/// again.
pub fn check(campaign: &Campaign) -> Result<(), Faults> {
    if let Some(fault) = campaign.site.as_ref().and_then(gravity_of_no_place) {
        return Err(fault.into());
    }
    let mut faults = Faults::default();
    for finding in findings(campaign).iter().filter(|finding| finding.matters) {
        faults.0.extend(faults_of(finding));
    }
    // A gyro without output is refused by its slot, not for an E of nothing.
    for j in constant(campaign) {
        faults.push(format!("/gyros/{j}"), Refusal::NoOutput(campaign.gyros[j].slot.name()).message());
    }
    let says_something = !(0..campaign.gyros.len()).any(|j| campaign.is_silent(j));
    if faults.is_empty() && campaign.test == TestKind::Imu && says_something {
        evaluate(campaign, &Plausibility::ever()).map_err(|faults| stuck_instead(campaign).unwrap_or(faults))?;
    }
    faults.or(())
}

/// Where a gyro was stuck for a part of the campaign, that is why its E cannot be.
fn stuck_instead(campaign: &Campaign) -> Option<Faults> {
    let mut faults = Faults::default();
    for stuck in stuck(campaign) {
        faults.push(format!("/dwells/{}/output_pulse_s", stuck.dwells[0]), stuck.message());
    }
    (!faults.is_empty()).then_some(faults)
}

fn gravity_of_no_place(site: &Site) -> Option<Fault> {
    let (least, most) = possible_gravity_g0(site);
    if (least..=most).contains(&site.gravity_g0) {
        return None;
    }
    let latitude = figure(degrees(site.latitude), 2);
    let [least, most, normal] = [least, most, normal_gravity_g0(site.latitude, 0.0)].map(|gravity| figure(gravity, 4));
    let message = message!("gravity_of_no_place", value = text(site.gravity_g0), latitude, normal, least, most);
    Some(Fault { pointer: "/site/gravity_g0".to_owned(), message })
}

/// Faults of a campaign that its checks found dwell by dwell, put together where one mistake explains them.
pub(super) fn explained(campaign: &Campaign, faults: Faults) -> Faults {
    let is_commanded = |fault: &Fault| COMMANDED.iter().any(|field| fault.pointer.ends_with(&format!("/{field}")));
    if !faults.0.iter().any(is_commanded) {
        return faults;
    }
    let found = findings(campaign);
    let known: Vec<&CommandFinding> = found.iter().filter(|f| f.matters && !f.single && !f.causes.is_empty()).collect();
    if known.is_empty() {
        return faults;
    }
    let mut together: Vec<Fault> = known.into_iter().flat_map(faults_of).collect();
    together.extend(faults.0.into_iter().filter(|fault| !is_commanded(fault)));
    Faults(together)
}

fn faults_of(finding: &CommandFinding) -> Vec<Fault> {
    let fault = |pointer, message| Fault { pointer, message };
    if finding.single {
        let one = |(k, value): &(usize, f64)| {
            let alone = CommandFinding { dwells: vec![(*k, *value)], ..finding.clone() };
            fault(pointer(finding, *k), message(&alone))
        };
        return finding.dwells.iter().map(one).collect();
    }
    vec![fault(pointer(finding, finding.dwells[0].0), message(finding))]
}

fn pointer(finding: &CommandFinding, dwell: usize) -> String {
    let field = match (finding.causes.first(), finding.symptom) {
        (Some(MistakeKind::LatitudeReversed), _) => return "/site/latitude_deg".to_owned(),
        (
            Some(
                MistakeKind::ForceReversed
                | MistakeKind::ForceUnit { .. }
                | MistakeKind::ForceNormalised
                | MistakeKind::ForceScale { .. }
                | MistakeKind::AxisReversed { of: Vectors::Force | Vectors::Both, .. }
                | MistakeKind::AxesExchanged { of: Vectors::Force | Vectors::Both, .. },
            ),
            _,
        ) => "specific_force_g0",
        (Some(MistakeKind::AttitudeInverted), _) | (_, Symptom::Attitude) => "attitude",
        (_, Symptom::Scale) => "output_pulse_s",
        (Some(MistakeKind::EarthRateLeftOut | MistakeKind::NedForEnu), _) => "rate_arcsec_s",
        (_, Symptom::Gravity | Symptom::Output) => "specific_force_g0",
        (
            _,
            Symptom::StaticRate | Symptom::VerticalRate | Symptom::TurningRate | Symptom::Heading | Symptom::Senses,
        ) => "rate_arcsec_s",
    };
    format!("/dwells/{dwell}/{field}")
}

/// What it most likely is, then what was measured.
pub(crate) fn message(finding: &CommandFinding) -> Message {
    let mut causes = finding.causes.iter().map(cause);
    let likely = match (causes.next(), causes.next(), causes.next()) {
        (None, ..) => message!("commanded_wrong"),
        (Some(one), None, _) => one,
        (Some(first), Some(second), None) => message!("either_of_two", first, second),
        (Some(first), Some(second), Some(third)) => {
            message!("either_of_three", first, second, third)
        }
    };
    let measured = measured(finding);
    match finding.matters {
        true => message!("commanded", likely, measured),
        false => message!("commanded_hidden", likely, measured),
    }
}

fn measured(finding: &CommandFinding) -> Message {
    let (n, of, value) = (finding.dwells.len(), finding.of, finding.measured());
    let share = match finding.single && n == 1 {
        true => message!("this_dwell"),
        false => message!("share_of_dwells", count = n, of),
    };
    match (finding.symptom, finding.expected) {
        (Symptom::StaticRate, _) => message!("measured_static_rate", value = figure(value, 3), share),
        (Symptom::VerticalRate, expected) => {
            let expected = signed(expected.unwrap_or(0.0), 3);
            message!("measured_vertical_rate", value = signed(value, 3), share, expected)
        }
        (Symptom::TurningRate, _) => message!("measured_turning_rate", value = figure(value, 3), share),
        (Symptom::Heading, _) => message!("measured_heading", value = figure(value, 2), share),
        (Symptom::Output, _) => message!("measured_output", value = figure(value, 2)),
        (Symptom::Senses, _) => message!("measured_senses", value = figure(value, 1), share),
        (Symptom::Scale, _) => message!("measured_scale", value = figure(value, 4), share),
        (Symptom::Gravity, expected) => {
            let expected = figure(expected.unwrap_or(1.0), 5);
            message!("measured_gravity", value = figure(value, 5), share, expected)
        }
        (Symptom::Attitude, _) => message!("measured_attitude", value = figure(value, 3), share),
    }
}

fn cause(cause: &MistakeKind) -> Message {
    let axis = |k: usize| ["x", "y", "z"][k];
    let vectors = |of: Vectors| match of {
        Vectors::Force => Parameter::from("specific_force_g0"),
        Vectors::Rate => "rate_arcsec_s".into(),
        Vectors::Both => message!("force_and_rate").into(),
    };
    match *cause {
        MistakeKind::ForceReversed => message!("force_reversed"),
        MistakeKind::RateReversed => message!("rates_reversed"),
        MistakeKind::LatitudeReversed => message!("latitude_reversed"),
        MistakeKind::NedForEnu => message!("ned_for_enu"),
        MistakeKind::AttitudeInverted => message!("attitude_inverted"),
        MistakeKind::EarthRateLeftOut => message!("earth_rate_left_out"),
        MistakeKind::RateUnit { unit, part } => {
            let dwells = match part {
                AffectedDwells::All => message!("all_dwells"),
                AffectedDwells::Static => message!("static_dwells"),
                AffectedDwells::Turning => message!("rate_dwells"),
            };
            message!("rate_unit", dwells, unit)
        }
        MistakeKind::AxisReversed { axis: k, of } => {
            message!("axis_reversed", axis = axis(k), vectors = vectors(of))
        }
        MistakeKind::AxesExchanged { axes: (a, b), of } => {
            message!("axes_exchanged", first = axis(a), second = axis(b), vectors = vectors(of))
        }
        MistakeKind::OtherLatitude { degrees } => message!("other_latitude", degrees = figure(degrees, 3)),
        MistakeKind::OtherEarthRate { arcsec_s } => message!("other_earth_rate", rate = figure(arcsec_s, 3)),
        MistakeKind::OtherHeadings => message!("other_headings"),
        MistakeKind::ForceUnit { unit } => message!("force_unit", unit),
        MistakeKind::ForceNormalised => message!("force_normalised"),
        MistakeKind::ForceScale { ratio } => message!("force_scale", ratio = figure(ratio, 5)),
        MistakeKind::OutputScale { of } => {
            let slots = Slot::ALL.into_iter().filter(|slot| of[slot.index()]).map(Slot::name);
            message!("output_scale", gyros = list(slots))
        }
    }
}

/// Parameters of a note, for programs.
pub(crate) fn parameters(finding: &CommandFinding) -> Value {
    json!({
        "causes": finding.causes.iter().map(MistakeKind::code).collect::<Vec<_>>(),
        "pointer": pointer(finding, finding.dwells[0].0),
        "dwells": finding.dwells.len(),
        "of": finding.of,
        "measured": finding.measured(),
        "expected": finding.expected,
    })
}
