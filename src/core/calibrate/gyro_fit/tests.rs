//! Three gyros against one least squares of all of them together, made of full matrices.

use super::*;
use crate::core::calibrate::noise::NoiseSource;
use crate::core::calibrate::shared_coefficients::SharedRegressors;
use crate::core::calibrate::{calibrate, calibrate_in_white_noise, fit_common, noise, weights_sd};
use crate::core::campaign::made_for_tests::{self, dwell, name};
use crate::core::campaign::repeats;
use crate::core::effects::Coefficient;
use crate::core::mounting::Slot;
use crate::core::numerics::tails::f_tail;

/// A fixed sequence without any pattern that the columns have.
fn number(i: usize) -> f64 {
    (7.3 * i as f64).sin() + 0.4 * (3.1 * (i * i % 977) as f64).cos()
}

fn regressor(effect: Effect, column: DVector<f64>) -> Regressor {
    Regressor { effect, coefficient: Coefficient { name: "k", unit: "deg/h" }, column }
}

fn numbers(n: usize, from: usize) -> DVector<f64> {
    DVector::from_fn(n, |k, _| number(from + k))
}

fn campaign(dwells: Vec<Dwell>, known_e: &[Option<Vector3<f64>>]) -> Campaign {
    let gyro = |(slot, known_e): (Slot, &Option<Vector3<f64>>)| CampaignGyro {
        slot,
        serial: name(slot.name()),
        known_e: *known_e,
    };
    made_for_tests::campaign([Slot::G1, Slot::G2, Slot::G3].into_iter().zip(known_e).map(gyro).collect(), dwells)
}

const N: usize = 36;
const HELD: [f64; 3] = [0.02, -0.01, 1.6];

/// Eighteen positions at 1 g under the Earth's rate, each taken twice. G1 and G3 have the same standard errors; G3's
/// E is held.
fn three_gyros(has_sem: bool) -> Campaign {
    let dwells = (0..N)
        .map(|k| {
            let at = k % 18;
            let force = Vector3::new(number(at), number(40 + at), number(80 + at)).normalize();
            let rate = 15.0 * Vector3::new(number(120 + at), number(160 + at), number(200 + at)).normalize();
            let errors = [0.1 + 0.002 * k as f64, 0.2 - 0.003 * k as f64, 0.1 + 0.002 * k as f64];
            let outputs =
                (0..3).map(|j| 3.0 * number(300 + 50 * j + at) + errors[j] * number(500 + 50 * j + k)).collect();
            Dwell { output_sem_pulse_s: has_sem.then(|| errors.to_vec()), ..dwell(k, force, rate, outputs) }
        })
        .collect();
    campaign(dwells, &[None, None, Some(HELD.into())])
}

/// Model (6) with P_x = -P_y - P_z, without E where that is held.
fn columns_of_model_6(campaign: &Campaign, held: bool) -> Vec<DVector<f64>> {
    let of = |f: &dyn Fn(&Dwell) -> f64| DVector::from_iterator(N, campaign.dwells.iter().map(f));
    let mut columns = vec![of(&|_| 1.0)];
    columns.extend((0..3).map(|i| of(&|d| d.specific_force_g0[i])));
    columns.extend((1..3).map(|i| of(&|d| d.specific_force_g0[i].powi(2) - d.specific_force_g0[0].powi(2))));
    columns.extend((0..if held { 0 } else { 3 }).map(|i| of(&|d| d.rate_arcsec_s[i])));
    columns
}

fn close(a: f64, b: f64, what: impl std::fmt::Display) {
    assert!((a - b).abs() <= 1e-8 * b.abs().max(1.0), "{what}: {a} is not {b}");
}

#[expect(clippy::disallowed_methods, reason = "the other route, by the textbook: the normal equations")]
#[test]
fn gyros_with_effects_of_their_own_and_shared_ones_are_those_of_one_fit() {
    for has_sem in [true, false] {
        let campaign = three_gyros(has_sem);
        let groups = repeats::repeats(&campaign.dwells);
        assert_eq!(groups.len(), 18);
        let mut factors = SharedDesigns::default();
        // G1 alone has an effect of its own, and another one that model (6) absorbs.
        let absorbed = DVector::from_fn(N, |k, _| 2.0 - 0.5 * campaign.dwells[k].specific_force_g0.y);
        let ramp = regressor(Effect::TimeRamp, numbers(N, 700));
        let own = [vec![regressor(Effect::CubicG, absorbed.clone()), ramp.clone()], vec![], vec![]];
        let mut fits: Vec<GyroFit> = own
            .into_iter()
            .enumerate()
            .map(|(j, own)| {
                fit_gyro(&campaign, j, Terms::MODEL_6, (own, &[]), (weights_sd(&campaign, j), &groups), &mut factors)
            })
            .collect();
        assert_eq!(fits[0].hidden, [Effect::CubicG]);
        assert!(fits[1].hidden.is_empty() && fits[2].hidden.is_empty());
        let before: Vec<usize> = fits.iter().map(|fit| fit.fit.dof).collect();
        assert_eq!(before, [N - 10, N - 9, N - 6]);
        // Without standard errors each gyro weighs as its own fit scatters.
        let scatter = |fit: &GyroFit| if has_sem { 1.0 } else { fit.fit.residuals.norm_squared() / fit.fit.dof as f64 };
        let variances: Vec<f64> = fits.iter().map(scatter).collect();

        // One coefficient of all, one that G1 is not part of, and one that nothing tells from model (6).
        let level = |j: usize| regressor(Effect::Levelling, numbers(N, 800 + 50 * j));
        let north = |j: usize| regressor(Effect::Azimuth, numbers(N, 1000 + 50 * j));
        let shared: Vec<SharedRegressors> = vec![
            (0..3).map(|j| Some(level(j))).collect(),
            (0..3).map(|_| Some(regressor(Effect::Magnetic, absorbed.clone()))).collect(),
            vec![None, Some(north(1)), Some(north(2))],
        ];
        let common = fit_common(shared, &mut fits, has_sem, &groups);
        assert_eq!(common.hidden, [Effect::Magnetic]);

        // All at once: rows over their standard deviations, the columns of each gyro, then the two shared ones.
        let mut columns: Vec<(usize, DVector<f64>)> = Vec::new();
        let mut first = Vec::new();
        for j in 0..3 {
            first.push(columns.len());
            columns.extend(columns_of_model_6(&campaign, j == 2).into_iter().map(|c| (j, c)));
            columns.extend((j == 0).then(|| (0, ramp.column.clone())));
        }
        let total = columns.len() + 2;
        let mut all = DMatrix::zeros(3 * N, total);
        let (mut side, mut deviations) = (DVector::zeros(3 * N), DVector::zeros(3 * N));
        for j in 0..3 {
            for (k, d) in campaign.dwells.iter().enumerate() {
                let row = j * N + k;
                deviations[row] = d.output_sem_pulse_s.as_ref().map_or(1.0, |s| s[j]);
                let over = 1.0 / (deviations[row] * variances[j].sqrt());
                let held = if j == 2 { Vector3::from(HELD).dot(&d.rate_arcsec_s) } else { 0.0 };
                side[row] = over * (d.output_pulse_s[j] - held);
                for (c, (of, column)) in columns.iter().enumerate() {
                    all[(row, c)] = if *of == j { over * column[k] } else { 0.0 };
                }
                all[(row, total - 2)] = over * level(j).column[k];
                all[(row, total - 1)] = if j > 0 { over * north(j).column[k] } else { 0.0 };
            }
        }
        let normal = (all.transpose() * &all).try_inverse().expect("it is determined");
        let together = &normal * all.transpose() * &side;
        let hat = &all * &normal * all.transpose();
        let left = &side - &all * &together;

        let evidence: Vec<Evidence> = fits.iter().map(|fit| fit.evidence).collect();
        let dofs: Vec<usize> = fits.iter().map(|fit| fit.fit.dof).collect();
        assert_eq!(dofs.iter().sum::<usize>(), 3 * N - total);
        let noises = noise::noise(&evidence, has_sem);
        // What the model leaves out is not asked here.
        for (j, (fit, noise)) in fits.into_iter().zip(noises).enumerate() {
            let coordinates = fit.coordinates(&noise);
            let found = fit.finish((&campaign.gyros[j], 0.0), noise, (coordinates, 1.0), true);
            let exact = N as f64 - (0..N).map(|k| hat[(j * N + k, j * N + k)]).sum::<f64>();
            assert!((found.dof as f64 - exact).abs() < 1.0, "{} of {exact}", found.dof);
            // The covariance of all at once, in units of the gyro's own noise.
            let scale = noise.covariance_scale().expect("enough is left over") / variances[j];
            let f = noise.factor.expect("there is a scale");
            let last = first[j] + if j == 2 { 6 } else { 9 };
            let at = |i: usize| DVector::from_fn(total, |c, _| f64::from(u8::from(c == i)));
            let mut places: Vec<DVector<f64>> = (first[j]..last).map(at).collect();
            places.insert(4, -at(first[j] + 4) - at(first[j] + 5));
            assert_eq!(found.parameters.len(), places.len());
            let covariance = found.covariance.as_ref().expect("there is a scale");
            for (a, place) in places.iter().enumerate() {
                let parameter = &found.parameters[a];
                close(parameter.value, place.dot(&together), parameter.name);
                let variance = scale * place.dot(&(&normal * place));
                close(parameter.sd.expect("determined"), variance.sqrt(), parameter.name);
                for (b, other) in places.iter().enumerate() {
                    close(covariance[(a, b)], scale * place.dot(&(&normal * other)), parameter.name);
                }
            }
            let mut effects: Vec<(Effect, usize)> = Vec::new();
            effects.extend((j == 0).then_some((Effect::TimeRamp, last)));
            effects.push((Effect::Levelling, total - 2));
            effects.extend((j > 0).then_some((Effect::Azimuth, total - 1)));
            assert_eq!(
                found.effects.iter().map(|e| e.effect).collect::<Vec<_>>(),
                effects.iter().map(|e| e.0).collect::<Vec<_>>()
            );
            for (effect, (_, place)) in found.effects.iter().zip(&effects) {
                close(effect.value, together[*place], "an effect");
                close(effect.sd.expect("there is a scale"), (scale * normal[(*place, *place)]).sqrt(), "its deviation");
            }
            let rows = |k: usize| j * N + k;
            let sum: f64 = (0..N).map(|k| left[rows(k)].powi(2) * variances[j]).sum();
            close(found.chi2, sum, "chi2");
            let (sigma, standardised) = (found.sigma.as_ref().expect("f"), found.standardised.as_ref().expect("f"));
            for k in 0..N {
                let (h, deviation) = (hat[(rows(k), rows(k))], deviations[rows(k)]);
                let residual = left[rows(k)] * deviation * variances[j].sqrt();
                close(found.leverage[k], h, "leverage");
                close(found.residuals[k], residual, "residual");
                close(sigma[k], f * deviation, "sigma");
                close(standardised[k], residual / (f * deviation * (1.0 - h).sqrt()), "standardised");
            }
            // Repeats differ by noise and by what the effects add; a pair about its weighted mean holds (y -
            // y')^2/(s^2 + s'^2).
            let pairs: f64 = (0..18)
                .map(|k| {
                    let bare = |k: usize| {
                        let mut y = campaign.dwells[k].output_pulse_s[j] - together[total - 2] * level(j).column[k];
                        y -= if j > 0 { together[total - 1] * north(j).column[k] } else { 0.0 };
                        y - if j == 0 { together[last] * ramp.column[k] } else { 0.0 }
                    };
                    let spread = deviations[rows(k)].powi(2) + deviations[rows(k + 18)].powi(2);
                    (bare(k) - bare(k + 18)).powi(2) / spread
                })
                .sum();
            close(found.noise.pure_error.chi2, pairs, "repeats");
            assert_eq!(found.noise.pure_error.dof, 18);
        }
    }
}

#[test]
fn one_factorisation_serves_gyros_of_the_same_terms_and_errors() {
    let mut campaign = three_gyros(true);
    let held = Some(HELD.into());
    campaign.gyros.iter_mut().for_each(|gyro| gyro.known_e = held);
    let mut factors = SharedDesigns::default();
    let own = [vec![regressor(Effect::TimeRamp, numbers(N, 700))], vec![], vec![]];
    let used: Vec<Option<usize>> = own
        .into_iter()
        .enumerate()
        .map(|(j, own)| {
            let fit = fit_gyro(&campaign, j, Terms::MODEL_6, (own, &[]), (weights_sd(&campaign, j), &[]), &mut factors);
            factors.0.iter().position(|known| Rc::ptr_eq(known, &fit.weighted))
        })
        .collect();
    // Plain with G1's errors and extended for G1, plain with G2's; G3 has G1's errors and finds the first.
    assert_eq!((used, factors.0.len()), (vec![None, Some(1), Some(0)], 2));
    // E alone is never taken off: there would be nothing left to fit.
    let alone =
        fit_gyro(&campaign, 0, Terms::of(&[Term::Scale]), (vec![], &[]), (weights_sd(&campaign, 0), &[]), &mut factors);
    assert_eq!((alone.fit.estimate.len(), factors.0.len()), (3, 3));
}

/// D0 and E along x, without standard errors, with rates up to 400 arcsec/s whose noise grows with the rate along E;
/// one position twice.
fn turned(fastest: f64, held: Option<[f64; 3]>) -> (Campaign, Vec<f64>) {
    let n = 40;
    let along: Vec<f64> = (0..n).map(|k| if k < 2 { 0.0 } else { fastest * (k as f64 / (n - 1) as f64) }).collect();
    let dwells = (0..n).map(|k| {
        let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
        // Every fourth dwell turns across the input axis, which the gyro does not feel.
        let across = k % 4 == 3;
        let rate = if across { Vector3::y() } else { Vector3::x() } * sign * along[k];
        let felt = if across { 0.0 } else { (along[k] / fastest).powi(2) };
        let noise = 0.02 * (1.0 + 60.0 * felt).sqrt() * number(1500 + k);
        dwell(k, Vector3::z(), rate, vec![3.0 + 2.0 * rate.x + noise])
    });
    let campaign = campaign(dwells.collect(), &[held.map(Vector3::from)]);
    let felt = campaign.dwells.iter().map(|d| (d.rate_arcsec_s.x / fastest).powi(2)).collect();
    (campaign, felt)
}

#[test]
fn noise_that_grows_with_the_rate_is_in_the_covariance_and_in_every_sigma() {
    let (campaign, felt) = turned(400.0, Some([2.0, 0.0, 0.0]));
    let calibration = calibrate_in_white_noise(&campaign, Terms::of(&[Term::Bias, Term::GLinear, Term::Scale]));
    let (found, rho) = (&calibration.gyros[0], calibration.growth);
    assert!((3.0..300.0).contains(&rho), "{rho}");
    // E is held and the force is one, so D0 + G_z is a mean: its variance is that of the mean of unequal ones.
    let n = felt.len() as f64;
    let v: Vec<f64> = felt.iter().map(|x| 1.0 + rho * x).collect();
    let sum: f64 = v.iter().sum();
    let s2 = found.residuals.norm_squared() / (sum * (1.0 - 1.0 / n));
    close(found.noise.factor.expect("residuals"), s2.sqrt(), "s");
    for (k, v) in v.iter().enumerate() {
        close(found.sigma.as_ref().expect("s")[k], (s2 * v).sqrt(), "sigma");
    }
    let dof = sum * sum * (1.0 - 1.0 / n) / v.iter().map(|v| v * v).sum::<f64>();
    close(found.noise.dof, dof, "degrees of freedom");
    let one = DVector::from_vec(vec![1.0, 0.0, 0.0, 1.0]);
    let variance = one.dot(&(found.covariance.as_ref().expect("s") * &one));
    close(variance / (s2 * dof / (dof - 2.0) * sum / (n * n)), 1.0, "variance of the mean");
    assert_eq!(found.noise.source, NoiseSource::Residuals);
    let pair = (campaign.dwells[0].output_pulse_s[0] - campaign.dwells[1].output_pulse_s[0]).powi(2) / 2.0;
    close(found.noise.pure_error.chi2, pair, "the pair at rest");

    // What is left over beyond that pair, over the variances, is held against it.
    let beyond: f64 = found.residuals.iter().zip(&v).map(|(r, v)| r * r / v).sum::<f64>() - pair;
    close(found.p_value.expect("a pair"), f_tail(beyond / (n - 2.0) / pair, n - 2.0, 1.0), "chance");

    // The input axis is found where it is fitted too, and rates like the Earth's show no growth.
    let scale = Terms::of(&[Term::Bias, Term::Scale]);
    let (campaign, _) = turned(400.0, None);
    let found = &calibrate(&campaign, scale).gyros[0];
    let sigma = found.sigma.as_ref().expect("s");
    close(sigma[39] / sigma[0], 1.0, "across the input axis");
    assert!(sigma[38] > 2.0 * sigma[0], "along it");
    let (campaign, _) = turned(20.0, Some([2.0, 0.0, 0.0]));
    assert_eq!(calibrate(&campaign, scale).growth, 0.0);
}
