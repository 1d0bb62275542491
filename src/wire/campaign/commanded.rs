//! Words for what was commanded as the Earth does not allow it, and the faults of a campaign that must not be believed for it.

use serde_json::{Value, json};

use crate::core::campaign::Campaign;
use crate::core::campaign::commanded::{Cause, Finding, Part, Symptom, Vectors, findings};
use crate::core::fault::{Fault, Faults};

/// Fields of a dwell that a station commands.
const COMMANDED: [&str; 3] = ["attitude", "specific_force_g0", "rate_arcsec_s"];

/// Refuses a campaign whose commanded vectors have moved D_I and D_S. Every way in calls it; what is stored is not asked again.
///
/// # Errors
/// What it most likely is, and how to send it right.
pub fn check(campaign: &Campaign) -> Result<(), Faults> {
    let mut faults = Faults::default();
    for finding in findings(campaign).iter().filter(|finding| finding.matters) {
        faults.0.extend(faults_of(finding));
    }
    faults.or(())
}

/// Faults of a campaign that its checks found dwell by dwell, put together where one mistake explains them.
pub(super) fn explained(campaign: &Campaign, faults: Faults) -> Faults {
    let is_commanded = |fault: &Fault| COMMANDED.iter().any(|field| fault.pointer.ends_with(&format!("/{field}")));
    if !faults.0.iter().any(is_commanded) {
        return faults;
    }
    let found = findings(campaign);
    let known: Vec<&Finding> = found.iter().filter(|f| f.matters && !f.single && !f.causes.is_empty()).collect();
    if known.is_empty() {
        return faults;
    }
    let mut together: Vec<Fault> = known.into_iter().flat_map(faults_of).collect();
    together.extend(faults.0.into_iter().filter(|fault| !is_commanded(fault)));
    Faults(together)
}

fn faults_of(finding: &Finding) -> Vec<Fault> {
    let fault = |pointer, detail| Fault { pointer, detail };
    if finding.single {
        let one = |(k, value): &(usize, f64)| {
            let alone = Finding { dwells: vec![(*k, *value)], ..finding.clone() };
            fault(pointer(finding, *k), words(&alone))
        };
        return finding.dwells.iter().map(one).collect();
    }
    vec![fault(pointer(finding, finding.dwells[0].0), words(finding))]
}

fn pointer(finding: &Finding, dwell: usize) -> String {
    let field = match (finding.causes.first(), finding.symptom) {
        (Some(Cause::LatitudeReversed), _) => return "/site/latitude_deg".to_owned(),
        (
            Some(
                Cause::ForceReversed
                | Cause::ForceUnit { .. }
                | Cause::ForceNormalised
                | Cause::ForceScale { .. }
                | Cause::AxisReversed { of: Vectors::Force | Vectors::Both, .. }
                | Cause::AxesExchanged { of: Vectors::Force | Vectors::Both, .. },
            ),
            _,
        ) => "specific_force_g0",
        (Some(Cause::AttitudeInverted), _) | (_, Symptom::Attitude) => "attitude",
        (_, Symptom::Gravity | Symptom::Output) => "specific_force_g0",
        (_, Symptom::StaticRate | Symptom::VerticalRate | Symptom::TurningRate | Symptom::Heading) => "rate_arcsec_s",
    };
    format!("/dwells/{dwell}/{field}")
}

/// What it most likely is, then what was measured.
pub(crate) fn words(finding: &Finding) -> String {
    let causes: Vec<String> = finding.causes.iter().map(cause).collect();
    let likely = match causes.as_slice() {
        [] => "unit, sign or axes of specific_force_g0 or rate_arcsec_s are wrong".to_owned(),
        [one] => one.clone(),
        several => format!("either {}", several.join(", or ")),
    };
    let hidden = if finding.matters { "" } else { "; the noise of these gyros hides it" };
    format!("{likely}. Measured: {}{hidden}", measured(finding))
}

fn measured(finding: &Finding) -> String {
    let (n, of, value) = (finding.dwells.len(), finding.of, finding.measured());
    let share = if finding.single && n == 1 { "this dwell".to_owned() } else { format!("{n} of {of} dwells") };
    match (finding.symptom, finding.expected) {
        (Symptom::StaticRate, _) => {
            format!("|rate_arcsec_s| is {value:.3} arcsec/s at rest in {share}; the Earth turns at 15.041")
        }
        (Symptom::VerticalRate, expected) => format!(
            "w.f/|f| is {value:+.3} arcsec/s at rest in {share}; Omega sin(latitude) is {:+.3}",
            expected.unwrap_or(0.0)
        ),
        (Symptom::TurningRate, _) => format!(
            "in {share} the table turns, but rate_arcsec_s is not along specific_force_g0 or is slower than any table ({value:.3} arcsec/s)"
        ),
        (Symptom::Heading, _) => {
            format!("rate_arcsec_s is {value:.2} arcsec/s from the Earth's rate at the attitude in {share}")
        }
        (Symptom::Output, _) => format!("the outputs are {value:.2} arcsec/s from the model in the root mean square"),
        (Symptom::Gravity, expected) => {
            format!("|specific_force_g0| is {value:.5} g0 in {share}; gravity is {:.5} g0", expected.unwrap_or(1.0))
        }
        (Symptom::Attitude, _) => {
            format!("the vertical of the attitude is {value:.3} deg from specific_force_g0 in {share}")
        }
    }
}

fn cause(cause: &Cause) -> String {
    let axis = |k: usize| ["x", "y", "z"][k];
    let vectors = |of: Vectors| match of {
        Vectors::Force => "specific_force_g0",
        Vectors::Rate => "rate_arcsec_s",
        Vectors::Both => "specific_force_g0 and rate_arcsec_s",
    };
    match *cause {
        Cause::ForceReversed => {
            "the specific force is reversed: it must point up, away from the Earth, in a static dwell".to_owned()
        }
        Cause::RateReversed => {
            "the rates are reversed: send them positive for a turn about the positive axis by the right-hand rule".to_owned()
        }
        Cause::LatitudeReversed => {
            "the latitude has the wrong sign, in site.latitude_deg or where the rates were made: north is positive".to_owned()
        }
        Cause::NedForEnu => "North-East-Down is mixed with East-North-Up: attitude, specific force and rate must all be made with \
                             nav = East-North-Up"
            .to_owned(),
        Cause::AttitudeInverted => {
            "the attitude is inverted: send the quaternion with v_body = C(q) v_nav".to_owned()
        }
        Cause::EarthRateLeftOut => "the Earth's rate is left out of the rates: send inertial rates; with attitudes and a site \
                                    \"rates\": \"table\" lets the service add it"
            .to_owned(),
        Cause::RateUnit { unit, part } => {
            let dwells = match part {
                Part::All => "all dwells",
                Part::Static => "static dwells",
                Part::Turning => "rate dwells",
            };
            format!("the rates of {dwells} are in {unit}: send them in arcsec/s")
        }
        Cause::AxisReversed { axis: k, of } => format!("the {} axis of {} is reversed", axis(k), vectors(of)),
        Cause::AxesExchanged { axes: (a, b), of } => {
            format!("the {} and {} axes of {} are exchanged", axis(a), axis(b), vectors(of))
        }
        Cause::OtherLatitude { degrees } => {
            format!("the rates are those of latitude {degrees:.3} deg: correct site.latitude_deg or the rates")
        }
        Cause::OtherEarthRate { arcsec_s } => format!(
            "the rates are made with an Earth that turns at {arcsec_s:.3} arcsec/s: use 15.041, that of a sidereal day"
        ),
        Cause::OtherHeadings => {
            "the rates of static dwells are made with other headings than the attitudes: send the Earth's rate at each attitude"
                .to_owned()
        }
        Cause::ForceUnit { unit } => format!("the specific force is in {unit}: send it in g0 = 9.80665 m/s^2"),
        Cause::ForceNormalised => {
            "the specific force is normalised to 1: multiply it by the site's gravity in g0".to_owned()
        }
        Cause::ForceScale { ratio } => {
            format!("the specific force is {ratio:.5} times gravity: correct it, or state the gravity of the site in site.gravity_g0")
        }
    }
}

/// Parameters of a note, for programs.
pub(crate) fn parameters(finding: &Finding) -> Value {
    json!({
        "causes": finding.causes.iter().map(Cause::code).collect::<Vec<_>>(),
        "pointer": pointer(finding, finding.dwells[0].0),
        "dwells": finding.dwells.len(),
        "of": finding.of,
        "measured": finding.measured(),
        "expected": finding.expected,
    })
}
