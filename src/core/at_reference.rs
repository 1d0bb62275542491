//! A finished calibration at the temperature at which its IMU's model states D_I and D_S: what
//! [`crate::core::calibrate`] does for campaigns, where there are no dwells.

use nalgebra::{Matrix3, Vector3};

use super::adopted::Adopted;
use super::augmented::AugmentedModel;
use super::campaign::{Phase, any_kelvin};
use super::effects::{Effect, GyroAxes, Setting};
use super::record::{GyroParameters, Record};
use super::separate::{CovarianceEg, diagonal_covariance};

/// What a model makes of one gyro of a record.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AtReference {
    /// Its parameters at the model's temperature, and the covariance of its E and G; none where nothing is known that
    /// moves G.
    pub restated: Option<(GyroParameters, Option<CovarianceEg>)>,
    /// Effects that move G, known of another gyro than this one (it was exchanged) or of all gyros in common.
    pub unknown: Vec<Effect>,
}

/// An effect's drift at the record's temperature goes with specific force as G does. So G at the reference is
/// G - |E| sum_m k_m u_m, with u_m half the difference of its regressor at +1 and -1 g0 on each axis, and the variances
/// of the k_m join G's. Of a record that states no temperature G stays as it is, and its covariance holds the mean
/// square of what any temperature would do.
pub fn at_reference(
    model: &AugmentedModel,
    record: &Record,
    gyro: &GyroParameters,
    covariance: Option<&CovarianceEg>,
) -> AtReference {
    let (Some(reference_c), Some(triad)) = (model.restates_at(), record.geometry.triad(gyro.slot)) else {
        return AtReference::default();
    };
    let stated = record.temperature_c.map(|celsius| celsius - reference_c);
    let temperatures = stated.map_or_else(|| any_kelvin(reference_c).collect(), |kelvin| vec![(kelvin, 1.0)]);
    let known = model.known(&record.imu, &[(gyro.slot, &gyro.serial)]);
    let axes = GyroAxes::carried(gyro.slot, triad.mat_gyro_body(), gyro.e, gyro.g);
    let (mut moved, mut spread, mut unknown) = (Vector3::zeros(), Matrix3::zeros(), Vec::new());
    for (kelvin, weight) in temperatures {
        let at_rest = at_rest(&axes, kelvin);
        let mut by_all = Vector3::zeros();
        for adopted in model.effects.iter().map(|known| &known.adopted) {
            for (name, by_axis) in along_axes(adopted, &at_rest) {
                let one = known.iter().find(|one| one.effect == adopted.effect && one.name == name);
                match one {
                    Some(one) => {
                        by_all += by_axis * one.value;
                        spread += by_axis * by_axis.transpose() * (weight * one.sd * one.sd);
                    }
                    None if by_axis == Vector3::zeros() || unknown.contains(&adopted.effect) => {}
                    None => unknown.push(adopted.effect),
                }
            }
        }
        match stated {
            Some(_) => moved = by_all,
            None => spread += by_all * by_all.transpose() * weight,
        }
    }
    if spread == Matrix3::zeros() && moved == Vector3::zeros() {
        return AtReference { restated: None, unknown };
    }
    let wider = |stated: Vector3<f64>| stated.zip_map(&spread.diagonal(), |sd, variance| sd.hypot(variance.sqrt()));
    // Without standard deviations a record is taken at its word, but not at any temperature.
    let at_its_word = |sd: Option<Vector3<f64>>| sd.or_else(|| stated.is_none().then(Vector3::zeros));
    let (e_sd, g_sd) = (at_its_word(gyro.e_sd), at_its_word(gyro.g_sd));
    let covariance = covariance.copied().or_else(|| diagonal_covariance(e_sd.as_ref(), g_sd.as_ref()));
    let covariance = covariance.map(|mut covariance| {
        let mut of_g = covariance.fixed_view_mut::<3, 3>(3, 3);
        of_g += spread;
        covariance
    });
    let gyro = GyroParameters { g: gyro.g - moved, g_sd: g_sd.map(wider), ..gyro.clone() };
    AtReference { restated: Some((gyro, covariance)), unknown }
}

/// What each coefficient of an effect does to G, pulse/(s g0), by its name; nothing where that asks for more than a
/// temperature, or has no value.
fn along_axes(adopted: &Adopted, at_rest: &Setting) -> Vec<(&'static str, Vector3<f64>)> {
    let (entry, gyro) = (adopted.effect.entry(), &at_rest.gyros[0]);
    let is_of_record = entry.of_temperature && !entry.of_order && adopted.slots.contains(&gyro.slot);
    if !is_of_record || (entry.missing)(at_rest).is_some() {
        return Vec::new();
    }
    // What lies beyond a regressor is of the scale factor: it is in E as it is in G.
    let columns = (entry.columns)(at_rest, 0, adopted.shape);
    let half = |column: &Vec<f64>, i: usize| gyro.scale * (column[2 * i] - column[2 * i + 1]) / 2.0;
    let by_axis = columns.iter().map(|column| Vector3::from_fn(|i, _| half(column, i)));
    entry.coefficients(adopted.shape).iter().map(|coefficient| coefficient.name).zip(by_axis).collect()
}

/// +1 and -1 g0 along each body axis, at a temperature `kelvin` above the reference.
fn at_rest(axes: &GyroAxes, kelvin: f64) -> Setting {
    let force: Vec<Vector3<f64>> = (0..3).flat_map(|i| [1.0, -1.0].map(|g| Vector3::ith(i, g))).collect();
    let n = force.len();
    Setting {
        force,
        rate: vec![Vector3::zeros(); n],
        phase: vec![Phase::Static; n],
        time: (0..n).map(|k| 100.0 * k as f64).collect(),
        duration: vec![100.0; n],
        temperature: Some(vec![kelvin; n]),
        nav_to_body: None,
        earth_nav: Vector3::zeros(),
        gravity: 1.0,
        field_nav: None,
        gyros: vec![axes.clone()],
    }
}

#[cfg(test)]
mod tests;
