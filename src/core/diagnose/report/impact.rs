//! What the adopted effects do to D_I and D_S: the coefficients of the plain and of the augmented model.

use crate::core::calibrate::Calibration;
use crate::core::diagnose::diagnosis::{BUDGET_DEG_PER_H_G0, Impact};
use crate::core::diagnose::report::calibrated::Calibrated;
use crate::core::model::Term;
use crate::core::mounting::Geometry;
use crate::core::record::Plausibility;
use crate::core::separate::Rigid;

/// Shift of D_I and D_S of every gyro that both models separate, where anything is named; before G was in the model,
/// they are counted as zero.
pub(crate) fn impact(fits: &Calibrated, geometry: &Geometry) -> Vec<Impact> {
    let Some(named) = &fits.named else { return Vec::new() };
    let g_in_model = fits.plain.terms.contains(Term::GLinear);
    let (plain, augmented) = (drift(&fits.plain, geometry), drift(named, geometry));
    let mut all = Vec::new();
    for ((gyro, plain), augmented) in named.gyros.iter().zip(plain).zip(augmented) {
        let before = if g_in_model { plain.map(|d| ([d.d_i, d.d_s], d.sd())) } else { Some(([0.0; 2], None)) };
        let after = augmented.and_then(|d| Some(([d.d_i, d.d_s], d.sd()?)));
        let (Some((before, before_sd)), Some((after, sd))) = (before, after) else { continue };
        all.extend(["D_I", "D_S"].into_iter().enumerate().map(|(i, coefficient)| Impact {
            slot: gyro.slot,
            coefficient,
            plain: before[i],
            plain_sd: before_sd.map(|sd| sd[i]),
            augmented: after[i],
            augmented_sd: sd[i],
            shift: after[i] - before[i],
            of_budget: (after[i] - before[i]).abs() / BUDGET_DEG_PER_H_G0,
        }));
    }
    all
}

fn drift(calibration: &Calibration, geometry: &Geometry) -> Vec<Option<Rigid>> {
    let separations = calibration.separate(geometry, &Plausibility::ever());
    separations.into_iter().map(|separation| separation.ok().map(|s| s.rigid)).collect()
}

#[cfg(test)]
mod tests {
    use nalgebra::{Rotation3, Unit, Vector3};

    use crate::core::augmented::{AugmentedModel, Options};
    use crate::core::calibrate::drift::NotSeparated;
    use crate::core::calibrate::outcome::{Outcome, evaluate_with};
    use crate::core::campaign::made_for_tests::{self, name};
    use crate::core::campaign::{Campaign, CampaignGyro, Dwell, Phase, Site};
    use crate::core::diagnose::{Diagnosis, diagnose};
    use crate::core::frames::Rotation;
    use crate::core::mounting::Slot;
    use crate::core::record::Plausibility;
    use crate::core::separate::Separation;

    const SCALE: f64 = 1.4;
    const NOISE: f64 = 1e-3;
    /// Of the field, from north towards east, degrees.
    const AZIMUTH: f64 = -21.0;
    /// D_I of every gyro, deg/(h g0).
    const D_I: f64 = 3.0;

    /// Six faces up at four headings and, where the table `turns`, turns about each either way, in a field that acts on
    /// three gyros along the axes.
    fn campaign(turns: bool) -> Campaign {
        let site = Site { latitude: 0.6, gravity_g0: 0.999, magnetic_field_nav: None };
        let azimuth = AZIMUTH.to_radians();
        let (earth, field) = (site.earth_rate().0, Vector3::new(azimuth.sin(), azimuth.cos(), 0.0));
        let up = |face: usize| Vector3::ith(face % 3, if face < 3 { 1.0 } else { -1.0 });
        let attitude = |face: usize, heading: f64| {
            let axis = Unit::new_normalize(Vector3::z().cross(&up(face)));
            let tip = match face {
                2 => Rotation3::identity(),
                5 => Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI),
                _ => Rotation3::from_axis_angle(&axis, std::f64::consts::FRAC_PI_2),
            };
            tip * Rotation3::from_axis_angle(&Vector3::z_axis(), heading)
        };
        let still = (0..24).map(|i| (Phase::Static, i % 6, 0.4 + std::f64::consts::FRAC_PI_2 * (i / 6) as f64, 0.0));
        let turning = (0..12).map(|i| (Phase::Rate, i % 6, 0.0, if i < 6 { 3600.0 } else { -7200.0 }));
        let all = still.chain(turning.filter(|_| turns)).enumerate();
        let dwell = |(k, (phase, face, heading, rate)): (usize, (Phase, usize, f64, f64))| {
            let c = attitude(face, heading);
            let force = site.gravity_g0 * up(face);
            let (rate, field) = match phase {
                Phase::Static => (c * earth, c * field),
                Phase::Rate => ((rate + earth.z) * up(face), Vector3::zeros()),
            };
            let output = |j: usize| {
                let seed = (3 * k + j + 5) as f64;
                let chance = (0..12).map(|i| (1.7 * seed * (i + 5) as f64 * (seed + i as f64)).sin()).sum::<f64>();
                let by_field = [0.08, -0.06, 0.05][j] * field[j] + 0.04 * field[(j + 1) % 3];
                let drift = 0.3 + D_I * force[j] - 1.5 * force[(j + 1) % 3] + by_field;
                SCALE * (rate[j] + drift + NOISE * chance / 6.0_f64.sqrt())
            };
            Dwell {
                phase,
                attitude: Some(Rotation::stated_as(c)),
                output_sem_pulse_s: Some(vec![SCALE * NOISE; 3]),
                ..made_for_tests::dwell(k, force, rate, (0..3).map(output).collect())
            }
        };
        let gyro = |slot: Slot| CampaignGyro { slot, serial: name(slot.name()), known_e: None };
        let campaign = made_for_tests::campaign(Slot::ALL.map(gyro).to_vec(), all.map(dwell).collect());
        Campaign { site: Some(site), ..campaign }
    }

    fn diagnosed(campaign: &Campaign) -> (Diagnosis, Vec<&'static str>) {
        let diagnosis = diagnose(campaign, &Options::default()).expect("it has dwells to spare");
        let [named] = diagnosis.effects.as_slice() else { panic!("{:?}", diagnosis.effects) };
        assert_eq!(named.effect.id(), "magnetic");
        let names = named.estimates.iter().map(|one| one.name).collect();
        (diagnosis, names)
    }

    /// `campaign` calibrated with what the diagnosis of `found_in` adopts.
    fn separated(
        campaign: &Campaign,
        (found_in, diagnosis): (&Campaign, &Diagnosis),
    ) -> Vec<Result<Separation, NotSeparated>> {
        let model = AugmentedModel::default().adopting(found_in, diagnosis);
        let outcome = evaluate_with(campaign, &model.options(campaign), &Plausibility::default());
        let Ok(Outcome::Imu { separations, .. }) = outcome else { panic!("{outcome:?}") };
        separations
    }

    #[test]
    fn a_field_whose_direction_is_not_told_moves_nothing() {
        let (still, turns) = (campaign(false), campaign(true));
        let (diagnosis, names) = diagnosed(&still);
        assert!(names.contains(&"east_x") && !names.contains(&"field_azimuth"), "{names:?}");
        assert!(diagnosis.notes.iter().any(|note| note.code == "field_direction_untold"), "{:?}", diagnosis.notes);
        assert_eq!(diagnosis.impact, []);
        let withheld = separated(&still, (&still, &diagnosis));
        assert!(withheld.iter().all(|one| *one == Err(NotSeparated::UntoldField)), "{withheld:?}");
        // Dwells that turn tell E, and so both parts of the field.
        for one in separated(&turns, (&still, &diagnosis)) {
            let rigid = one.expect("it is told").rigid;
            let sd = rigid.sd().expect("errors are stated")[0];
            assert!((rigid.d_i - D_I).abs() < 4.0 * sd, "{} +- {sd}", rigid.d_i);
        }
    }

    #[test]
    fn a_field_whose_direction_is_told_or_stated_moves_what_it_moves() {
        let turns = campaign(true);
        let (diagnosis, names) = diagnosed(&turns);
        assert!(names.contains(&"field_azimuth") && names.contains(&"k_x"), "{names:?}");
        let mut stated = campaign(false);
        let azimuth = AZIMUTH.to_radians();
        let site = stated.site.as_mut().expect("it has one");
        site.magnetic_field_nav = Some(Vector3::new(azimuth.sin(), azimuth.cos(), -1.0));
        for (campaign, diagnosis) in [(&turns, diagnosis), (&stated, diagnosed(&stated).0)] {
            assert_eq!(diagnosis.impact.len(), 6);
            for one in diagnosis.impact.iter().filter(|one| one.coefficient == "D_I") {
                assert!((one.augmented - D_I).abs() < 4.0 * one.augmented_sd, "{one:?}");
            }
            assert!(separated(campaign, (campaign, &diagnosis)).iter().all(Result::is_ok));
        }
    }
}
