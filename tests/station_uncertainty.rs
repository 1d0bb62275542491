//! D_I, D_S, E and G of stations that are not quite level, north or seated: rms(error/sd) with and without the
//! station's part. The tables and gyros are drawn here; nothing but the mounting is the fit's own.

use gyrowatch::core::calibrate::outcome::{Outcome, evaluate};
use gyrowatch::core::campaign::{Campaign, CampaignGyro, Dwell, Phase, StationUncertainty, TestKind};
use gyrowatch::core::frames::Rotation;
use gyrowatch::core::mounting::{Geometry, Slot};
use gyrowatch::core::record::{Name, Plausibility};
use gyrowatch::core::time::UtcMicros;
use nalgebra::{Rotation3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, PI};

const ARCSEC: f64 = PI / 180.0 / 3600.0;
/// Of one dwell, pulse/s.
const SIGMA: f64 = 0.0015;

/// What is measured where, and what is known of it.
#[derive(Clone, Copy)]
struct Design {
    name: &'static str,
    geometry: fn() -> Geometry,
    headings: usize,
    /// Of each face, arcsec/s; none where E is held.
    rates: &'static [f64],
    repeats: usize,
    states_errors: bool,
    latitude_deg: f64,
    stated: [Option<f64>; 3],
}

const RATES: &[f64] = &[3600.0, -3600.0, 36_000.0, -36_000.0];

const DESIGNS: [Design; 5] = [
    Design {
        name: "24 positions, twelve again, 24 rates; levelling 20",
        geometry: || Geometry::Skewed,
        headings: 4,
        rates: RATES,
        repeats: 12,
        states_errors: true,
        latitude_deg: 34.25,
        stated: [Some(20.0), None, None],
    },
    Design {
        name: "the same without standard errors; 20, 30 and 10",
        geometry: || Geometry::Skewed,
        headings: 4,
        rates: RATES,
        repeats: 12,
        states_errors: false,
        latitude_deg: 34.25,
        stated: [Some(20.0), Some(30.0), Some(10.0)],
    },
    Design {
        name: "12 positions, orthogonal, no repeats; 20, 30 and 10",
        geometry: || Geometry::Orthogonal,
        headings: 2,
        rates: RATES,
        repeats: 0,
        states_errors: true,
        latitude_deg: 60.0,
        stated: [Some(20.0), Some(30.0), Some(10.0)],
    },
    Design {
        name: "24 positions, E held; 20, 30 and 10",
        geometry: || Geometry::Skewed,
        headings: 4,
        rates: &[],
        repeats: 12,
        states_errors: true,
        latitude_deg: 34.25,
        stated: [Some(20.0), Some(30.0), Some(10.0)],
    },
    Design {
        name: "six faces, one heading each; azimuth 60",
        geometry: || Geometry::Skewed,
        headings: 1,
        rates: RATES,
        repeats: 6,
        states_errors: true,
        latitude_deg: 10.0,
        stated: [None, Some(60.0), None],
    },
];

/// Attitudes (nav to body) of the positions, with the rate about the vertical.
fn programme(design: &Design) -> Vec<(Rotation3<f64>, Option<f64>)> {
    let faces = [(0.0, 0.0), (FRAC_PI_2, 0.0), (-FRAC_PI_2, 0.0), (PI, 0.0), (0.0, FRAC_PI_2), (0.0, -FRAC_PI_2)];
    let attitude = |face: usize, heading: usize| {
        let (x, y) = faces[face];
        let tilted =
            Rotation3::from_axis_angle(&Vector3::x_axis(), x) * Rotation3::from_axis_angle(&Vector3::y_axis(), y);
        let turn = 2.0 * PI / design.headings as f64 * heading as f64 + 0.3;
        tilted * Rotation3::from_axis_angle(&Vector3::z_axis(), turn)
    };
    let still = (0..6 * design.headings).map(|k| (attitude(k % 6, k / 6), None));
    let again = (0..design.repeats).map(|k| (attitude(k % 6, k / 6), None));
    let turning = design.rates.iter().flat_map(|rate| (0..6).map(move |face| (face, *rate)));
    still.chain(again).chain(turning.map(|(face, rate)| (attitude(face, 0), Some(rate)))).collect()
}

fn name(text: &str) -> Name {
    Name::parse(text).expect("a name")
}

/// A campaign and [E, G] of its gyros; the station states `stated` of itself.
fn draw(design: &Design, stated: [Option<f64>; 3], seed: u64) -> (Campaign, Vec<[Vector3<f64>; 2]>) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = || rng.sample::<f64, _>(StandardNormal);
    let mut drawn = |sd: Option<f64>| sd.unwrap_or(0.0) * ARCSEC * normal();
    let [levelling, azimuth, fixture] = design.stated;
    let table = Rotation3::new(Vector3::new(drawn(levelling), drawn(levelling), drawn(azimuth)));
    let seat = Rotation3::new(Vector3::new(drawn(fixture), drawn(fixture), drawn(fixture)));
    let geometry = (design.geometry)();
    let latitude = design.latitude_deg.to_radians();
    let earth = 15.041_067 * Vector3::new(0.0, latitude.cos(), latitude.sin());
    let plumb = Vector3::new(0.0, 0.0, 0.9987);
    let slots = [Slot::G1, Slot::G2, Slot::G3];
    let truth: Vec<[Vector3<f64>; 2]> = slots
        .iter()
        .map(|slot| {
            let triad = geometry.triad(*slot).expect("a mounting");
            let small = Rotation3::new(Vector3::new(normal(), normal(), normal()) * 3e-4);
            let scale = 1.47 * (1.0 + 0.01 * normal());
            let drift = triad.input() * (4.0 * normal()) + triad.spin() * (6.0 * normal());
            [small * triad.input() * scale, small * drift * scale]
        })
        .collect();
    let bias: Vec<f64> = slots.iter().map(|_| normal()).collect();
    let dwell = |(k, (attitude, rate)): (usize, (Rotation3<f64>, Option<f64>))| {
        let up = Vector3::z();
        let along = |v: Vector3<f64>| up * v.z;
        let (commanded, real) = match rate {
            None => ((plumb, earth), (table * plumb, table * earth)),
            // Over whole turns of the table only what lies along its own vertical stays.
            Some(rate) => ((plumb, along(earth) + up * rate), (along(table * plumb), along(table * earth) + up * rate)),
        };
        let (force, turning) = (seat * (attitude * real.0), seat * (attitude * real.1));
        let output = |j: usize| bias[j] + truth[j][0].dot(&turning) + truth[j][1].dot(&force);
        Dwell {
            phase: if rate.is_some() { Phase::Rate } else { Phase::Static },
            start_s: 240.0 * k as f64,
            duration_s: 180.0,
            attitude: Some(Rotation::stated_as(attitude)),
            specific_force_g0: attitude * commanded.0,
            rate_arcsec_s: attitude * commanded.1,
            temperature_c: None,
            output_pulse_s: (0..3).map(|j| output(j) + SIGMA * normal()).collect(),
            output_sem_pulse_s: design.states_errors.then(|| vec![SIGMA; 3]),
        }
    };
    let dwells = programme(design).into_iter().enumerate().map(dwell).collect();
    let known_e = |j: usize| design.rates.is_empty().then(|| truth[j][0]);
    let gyros = slots.iter().enumerate().map(|(j, slot)| CampaignGyro {
        slot: *slot,
        serial: name(slot.name()),
        known_e: known_e(j),
    });
    let radians = |part: usize| stated[part].map(|sd: f64| sd * ARCSEC);
    let campaign = Campaign {
        imu: name("IMU"),
        station: name("ST"),
        measured_at: UtcMicros(0),
        geometry,
        site: None,
        station_uncertainty: StationUncertainty { levelling: radians(0), azimuth: radians(1), fixture: radians(2) },
        gyros: gyros.collect(),
        dwells,
        rates_sent_in_steps: None,
        test: TestKind::Imu,
        model: None,
        temperature_c: None,
        operator: None,
        note: None,
    };
    (campaign, truth)
}

/// rms(error/sd) of each quantity, the sd as stated and its noise alone.
fn pulls(design: &Design, stated: [Option<f64>; 3], seeds: std::ops::Range<u64>) -> BTreeMap<&'static str, [f64; 2]> {
    let mut squares: BTreeMap<&'static str, (f64, [f64; 2])> = BTreeMap::new();
    for seed in seeds {
        let (campaign, truth) = draw(design, stated, seed);
        let outcome = evaluate(&campaign, &Plausibility::default()).expect("it can be fitted");
        let Outcome::Imu { calibration, separations, .. } = outcome else { panic!("an IMU") };
        for (j, (gyro, separation)) in calibration.gyros.iter().zip(&separations).enumerate() {
            let rigid = separation.as_ref().expect("separable").rigid;
            let budgets = gyro.budgets(&campaign.geometry, false).expect("a noise scale");
            let mut add = |name, error: f64, sds: [f64; 2]| {
                let (count, sums) = squares.entry(name).or_default();
                *count += 1.0;
                for (sum, sd) in sums.iter_mut().zip(sds) {
                    *sum += (error / sd).powi(2);
                }
            };
            let [e, g] = truth[j];
            let triad = campaign.geometry.triad(gyro.slot).expect("a mounting");
            let spin = Rotation3::rotation_between(&triad.input(), &e).expect("near") * triad.spin();
            let sd = rigid.sd().expect("a noise scale");
            add("D_I", rigid.d_i - g.dot(&e.normalize()) / e.norm(), [sd[0], budgets[0].statistical]);
            add("D_S", rigid.d_s - g.dot(&spin) / e.norm(), [sd[1], budgets[1].statistical]);
            let parts = gyro.uncertainty.as_ref().expect("a noise scale");
            for (i, p) in gyro.parameters.iter().enumerate() {
                let Some(axis) = ["_x", "_y", "_z"].iter().position(|axis| p.name.ends_with(axis)) else { continue };
                let (name, truth) = match &p.name[..1] {
                    "E" => ("E", e[axis]),
                    "G" => ("G", g[axis]),
                    _ => continue,
                };
                let [budget] = parts.budgets(|c| Some([c[(i, i)]])).expect("one number");
                add(name, p.value - truth, [p.sd.expect("determined"), budget.statistical]);
            }
        }
    }
    squares.into_iter().map(|(name, (n, sums))| (name, sums.map(|sum| (sum / n).sqrt()))).collect()
}

#[test]
fn what_a_station_states_of_itself_makes_its_sigmas_honest() {
    let mut dishonest = Vec::new();
    for design in DESIGNS {
        let found = pulls(&design, design.stated, 40_000..40_300);
        let shown = |which: usize| {
            let figures: Vec<String> = found.iter().map(|(name, rms)| format!("{name} {:.2}", rms[which])).collect();
            figures.join(", ")
        };
        println!("| {} | {} | {} |", design.name, shown(0), shown(1));
        for (name, [rms, _]) in &found {
            if !(0.9..1.1).contains(rms) {
                dishonest.push(format!("{}: rms(error/sd) of {name} is {rms:.3}", design.name));
            }
        }
        // The noise alone is far from the truth, so that the part that is added is what makes it honest.
        assert!(found["D_I"][1] > 1.5, "{}: {:?}", design.name, found["D_I"]);
    }
    assert!(dishonest.is_empty(), "{dishonest:#?}");
}

#[test]
fn a_levelling_that_the_residuals_contradict_is_told_and_in_the_sigmas() {
    let truth = Design { stated: [Some(60.0), None, None], ..DESIGNS[0] };
    let told = |design: &Design, stated: f64, seed: u64| {
        let outcome = evaluate(&draw(design, [Some(stated), None, None], seed).0, &Plausibility::default());
        let Ok(Outcome::Imu { calibration, .. }) = outcome else { panic!("an IMU") };
        calibration.all_notes().iter().any(|note| note.code() == "station_contradicted")
    };
    let count = |design: &Design, stated: f64| (41_000..41_200).filter(|seed| told(design, stated, *seed)).count();
    let (of_five, of_sixty, of_twenty) = (count(&truth, 5.0), count(&truth, 60.0), count(&DESIGNS[0], 20.0));
    let rms = pulls(&truth, [Some(5.0), None, None], 41_000..41_200)["D_I"][0];
    println!("said {of_five} of 200, falsely {of_sixty} and {of_twenty}; rms(error/sd) of D_I {rms:.2}");
    assert!(of_five >= 180 && of_sixty <= 2 && of_twenty <= 2);
    assert!((0.6..1.4).contains(&rms), "{rms}");
}
