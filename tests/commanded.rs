//! What is commanded is held against the Earth: simulated campaigns over latitudes and programmes, each mistake that
//! a station makes put into each of them.
//!
//! `cargo test --test all commanded:: -- --nocapture` prints how many of which kind are refused.

use std::collections::BTreeMap;

use gyrowatch::core::calibrate::outcome::{Outcome, evaluate};
use gyrowatch::core::campaign::commanded::{MistakeKind, findings};
use gyrowatch::core::campaign::{Campaign, CampaignNote, Dwell, Phase};
use gyrowatch::core::frames::{Body, Nav, Rotation};
use gyrowatch::core::record::Plausibility;
use gyrowatch::core::units::EARTH_RATE_DEG_H;
use gyrowatch::simulate::scenario::{EffectChoice, Scenario, StandardErrors, StatedE};
use gyrowatch::simulate::{programme::DwellOrder, programme::Positions, simulate};
use gyrowatch::wire::campaign::{parse_json, to_json};
use gyrowatch::wire::document::parse;
use nalgebra::{Matrix3, Rotation3, Vector3};

const CAMPAIGNS: u64 = 330;
const LATITUDES: [f64; 11] = [-78.0, -51.0, -34.25, -12.0, -2.0, 0.0, 2.0, 23.0, 34.25, 52.0, 70.0];

/// Campaigns without a mistake: every latitude with programmes, columns and gyros of its own.
fn clean(count: u64) -> Vec<Campaign> {
    let one = |i: u64| {
        let mut s = Scenario { seed: 40_000 + i, ..Scenario::default() };
        s.site.latitude_deg = LATITUDES[i as usize % LATITUDES.len()];
        s.site.height_m = [0.0, 400.0, 2000.0][i as usize % 3];
        s.columns.attitude = i.is_multiple_of(2);
        s.columns.standard_errors =
            [StandardErrors::Exact, StandardErrors::Noisy, StandardErrors::Absent][i as usize / 3 % 3];
        let p = &mut s.programme;
        p.positions = [Positions::TwentyFour, Positions::WithEdges, Positions::TwentyFour, Positions::WithTilts]
            [i as usize / 5 % 4];
        p.order = [DwellOrder::Random, DwellOrder::Fixed, DwellOrder::Mixed][i as usize / 2 % 3];
        if i % 4 == 3 {
            p.rates_arcsec_s = Vec::new();
            s.gyros.iter_mut().for_each(|gyro| gyro.states_e = StatedE::True);
        } else if i % 4 == 2 {
            p.rates_arcsec_s = vec![60.0, 360.0, 1000.0, 7200.0, 36000.0];
        }
        simulate(&s).unwrap().campaign
    };
    (0..count).map(one).collect()
}

/// The campaign as it comes in, read and fitted.
fn sent(campaign: &Campaign) -> Result<(), String> {
    let read = parse(to_json(campaign).as_bytes());
    let fitted = read.and_then(|campaign| evaluate(&campaign, &Plausibility::default()));
    fitted.map(|_| ()).map_err(|faults| faults.to_string())
}

fn each(campaign: &Campaign, change: impl Fn(&mut Dwell)) -> Campaign {
    let mut changed = campaign.clone();
    changed.dwells.iter_mut().for_each(change);
    changed
}

fn axes(matrix: Matrix3<f64>, force: bool, rate: bool) -> impl Fn(&mut Dwell) {
    move |d| {
        if force {
            d.specific_force_g0 = matrix * d.specific_force_g0;
        }
        if rate {
            d.rate_arcsec_s = matrix * d.rate_arcsec_s;
        }
    }
}

fn still(change: impl Fn(&mut Dwell)) -> impl Fn(&mut Dwell) {
    move |d| {
        if d.phase == Phase::Static {
            change(d);
        }
    }
}

fn up(d: &Dwell) -> Vector3<f64> {
    d.specific_force_g0.normalize()
}

/// The Earth's rate in a dwell, along and across the vertical.
fn earth(d: &Dwell, sin: f64) -> (Vector3<f64>, Vector3<f64>) {
    let along = EARTH_RATE_DEG_H * sin * up(d);
    if d.phase == Phase::Static { (along, d.rate_arcsec_s - along) } else { (along, Vector3::zeros()) }
}

/// The campaign with a change in its turning dwells; none where it has none.
fn turning(campaign: &Campaign, change: impl Fn(&mut Dwell)) -> Option<Campaign> {
    let turns = |d: &Dwell| d.phase == Phase::Rate;
    let changed = each(campaign, |d| {
        if turns(d) {
            change(d);
        }
    });
    campaign.dwells.iter().any(turns).then_some(changed)
}

/// The campaign with other attitudes; none where it states none.
fn attitudes(campaign: &Campaign, change: impl Fn(&Matrix3<f64>) -> Matrix3<f64>) -> Option<Campaign> {
    let changed = |stated: Rotation<Nav, Body>| Rotation3::from_matrix_unchecked(change(stated.matrix()));
    campaign.dwells[0]
        .attitude
        .is_some()
        .then(|| each(campaign, |d| d.attitude = Some(Rotation::<Nav, Body>::stated_as(changed(d.attitude.unwrap())))))
}

fn outputs(campaign: &Campaign, change: impl Fn(&mut Vec<f64>)) -> Campaign {
    each(campaign, |d| {
        change(&mut d.output_pulse_s);
        d.output_sem_pulse_s.iter_mut().for_each(&change);
        d.output_sem_pulse_s.iter_mut().flatten().for_each(|sem| *sem = sem.abs());
    })
}

fn scale_outputs(d: &mut Dwell, scale: impl Fn(usize) -> f64) {
    for of_gyros in [Some(&mut d.output_pulse_s), d.output_sem_pulse_s.as_mut()].into_iter().flatten() {
        of_gyros.iter_mut().enumerate().for_each(|(j, value)| *value *= scale(j));
    }
}

const REVERSED_X: Matrix3<f64> = Matrix3::new(-1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0);
const REVERSED_Z: Matrix3<f64> = Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, -1.0);
const EXCHANGED_XY: Matrix3<f64> = Matrix3::new(0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0);
const NED: Matrix3<f64> = Matrix3::new(0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -1.0);

/// One mistake, words of the cause that the refusal must hold, and the mistake put into a campaign at a latitude of
/// this sine; none where there is nothing to get wrong.
type Mutant = (&'static str, &'static str, fn(&Campaign, f64) -> Option<Campaign>);

const MUTANTS: [Mutant; 28] = [
    ("force reversed", "force_reversed", |c, _| Some(each(c, |d| d.specific_force_g0 *= -1.0))),
    ("Earth rate left out", "earth_rate_left_out", |c, sin| {
        Some(each(c, |d| {
            let (along, across) = earth(d, sin);
            d.rate_arcsec_s -= along + across;
        }))
    }),
    ("Earth rate left out at rest", "earth_rate_left_out", |c, _| {
        Some(each(c, still(|d| d.rate_arcsec_s = Vector3::zeros())))
    }),
    ("deg/s", "unit: deg/s", |c, _| Some(each(c, |d| d.rate_arcsec_s /= 3600.0))),
    ("deg/s at rest", "unit: deg/s", |c, _| Some(each(c, still(|d| d.rate_arcsec_s /= 3600.0)))),
    ("deg/s while turning", "rate_unit (dwells: rate_dwells, unit: deg/s)", |c, _| {
        turning(c, |d| d.rate_arcsec_s /= 3600.0)
    }),
    ("rad/s", "unit: rad/s", |c, _| Some(each(c, |d| d.rate_arcsec_s /= 206_264.806_247_096_36))),
    ("NED rates at rest", "ned_for_enu", |c, sin| {
        (sin != 0.0).then(|| {
            each(c, |d| {
                let (along, across) = earth(d, sin);
                d.rate_arcsec_s += match d.phase {
                    // (E, N, U) = (0, c, s) written as (N, E, D) = (c, 0, -s): north is a quarter turn back from
                    // where it was.
                    Phase::Static => across.cross(&up(d)) - across - 2.0 * along,
                    Phase::Rate => -2.0 * along,
                };
            })
        })
    }),
    ("NED attitudes", "ned_for_enu", |c, _| attitudes(c, |stated| stated * NED)),
    ("attitudes inverted", "attitude_inverted", |c, _| attitudes(c, Matrix3::transpose)),
    ("latitude of the site flipped", "latitude_reversed", |c, sin| {
        let mut c = c.clone();
        c.site.as_mut().unwrap().latitude *= -1.0;
        (sin != 0.0).then_some(c)
    }),
    ("rates with the latitude flipped", "latitude_reversed", |c, sin| {
        (sin != 0.0).then(|| each(c, |d| d.rate_arcsec_s -= 2.0 * earth(d, sin).0))
    }),
    ("rates of another latitude", "other_latitude", |c, sin| {
        let cos = (1.0 - sin * sin).sqrt();
        let other = sin.asin() + 0.01;
        (sin.abs() < 0.9).then(|| {
            each(c, |d| {
                let (along, across) = earth(d, sin);
                let now = EARTH_RATE_DEG_H * other.sin() * up(d) + across * (other.cos() / cos);
                d.rate_arcsec_s += now - along - across;
            })
        })
    }),
    ("solar day", "other_earth_rate (rate: 15.000)", |c, sin| {
        (sin.abs() > 0.1).then(|| {
            each(c, |d| {
                let (along, across) = earth(d, sin);
                d.rate_arcsec_s -= (along + across) * (1.0 - 15.0 / EARTH_RATE_DEG_H);
            })
        })
    }),
    ("force normalised", "force_normalised", |c, _| {
        let off = (c.site.unwrap().gravity_g0 - 1.0).abs();
        (off > 5e-4).then(|| each(c, |d| d.specific_force_g0 = up(d)))
    }),
    ("force in m/s^2", "force_unit (unit: m/s^2)", |c, _| Some(each(c, |d| d.specific_force_g0 *= 9.80665))),
    ("x of the force reversed", "axis_reversed (axis: x, vectors: specific_force_g0)", |c, _| {
        Some(each(c, axes(REVERSED_X, true, false)))
    }),
    ("z of the rate reversed", "axis_reversed (axis: z, vectors: rate_arcsec_s)", |c, _| {
        Some(each(c, axes(REVERSED_Z, false, true)))
    }),
    ("x and y of the force exchanged", "axes_exchanged (first: x, second: y, vectors: specific_force_g0)", |c, _| {
        Some(each(c, axes(EXCHANGED_XY, true, false)))
    }),
    ("z of the rate reversed while turning", "axis_reversed (axis: z, vectors: rate_arcsec_s)", |c, _| {
        turning(c, axes(REVERSED_Z, false, true))
    }),
    ("rates reversed while turning", "rates_reversed", |c, _| turning(c, |d| d.rate_arcsec_s *= -1.0)),
    ("outputs of two gyros exchanged", "direction_of_another", |c, _| {
        turning(c, |_| ()).map(|c| outputs(&c, |o| o.swap(0, 1)))
    }),
    ("output of one gyro reversed", "direction_off_axis", |c, _| {
        turning(c, |_| ()).map(|c| outputs(&c, |o| o[1] *= -1.0))
    }),
    ("all outputs tenfold while turning", "output_scale (gyros: G1, G2, G3)", |c, _| {
        turning(c, |d| scale_outputs(d, |_| 10.0))
    }),
    ("output of one gyro halved while turning", "output_scale (gyros: G2)", |c, _| {
        turning(c, |d| scale_outputs(d, |j| if j == 1 { 0.5 } else { 1.0 }))
    }),
    ("x and y of the rate exchanged", "axes_exchanged (first: x, second: y, vectors: rate_arcsec_s)", |c, _| {
        Some(each(c, axes(EXCHANGED_XY, false, true)))
    }),
    (
        "x and y of the rate exchanged while turning",
        "axes_exchanged (first: x, second: y, vectors: rate_arcsec_s)",
        |c, _| turning(c, axes(EXCHANGED_XY, false, true)),
    ),
    ("x and y of both exchanged", "axes_exchanged (first: x, second: y", |c, _| {
        Some(each(c, axes(EXCHANGED_XY, true, true)))
    }),
];

/// Campaigns, and those of them that were refused, and refused with the right cause.
#[derive(Debug, Default, Clone, Copy)]
struct Count {
    all: usize,
    refused: usize,
    named: usize,
}

#[test]
fn no_clean_campaign_is_refused_or_noted() {
    let campaigns = clean(CAMPAIGNS);
    let odd = |c: &Campaign| findings(&parse_json(to_json(c).as_bytes()).unwrap());
    for (i, campaign) in campaigns.iter().enumerate() {
        sent(campaign).unwrap_or_else(|why| panic!("{i}: {why}"));
        assert_eq!(odd(campaign), [], "{i}");
        assert!(!notes_latitude(campaign), "{i}");
    }
    println!("clean: 0 of {} refused", campaigns.len());
}

/// Where rates and site have the same wrong sign of the latitude, specific force and rate are at peace: only D_I moves,
/// and of all gyros alike.
#[test]
fn a_wrong_sign_of_the_latitude_is_noted_where_all_gyros_show_it() {
    let (mut noted, mut all) = (0, 0);
    for campaign in clean(CAMPAIGNS) {
        let sin = campaign.site.unwrap().latitude.sin();
        if sin.abs() < 0.5 {
            continue;
        }
        let mut wrong = each(&campaign, |d| d.rate_arcsec_s -= 2.0 * earth(d, sin).0);
        wrong.site.as_mut().unwrap().latitude *= -1.0;
        assert_eq!(sent(&wrong), Ok(()));
        all += 1;
        noted += usize::from(notes_latitude(&wrong));
    }
    println!("wrong sign of the latitude in site and rates: noted in {noted} of {all}");
    assert!(all > 100 && 2 * noted > all, "{noted} of {all}");
}

fn notes_latitude(campaign: &Campaign) -> bool {
    let Ok(Outcome::Imu { calibration, .. }) = evaluate(campaign, &Plausibility::ever()) else { return false };
    calibration.notes.iter().any(|note| matches!(note, CampaignNote::LatitudeSign { .. }))
}

/// What gyros do, however much of it, is no mistake of the station.
#[test]
fn no_campaign_with_a_large_effect_or_another_seat_is_refused() {
    let ids =
        ["magnetic", "azimuth", "levelling", "temperature_scale", "scale_asymmetry", "g_rate_coupling", "periodic"];
    let mut tried = 0;
    for i in 0..56 {
        let mut s = Scenario { seed: 50_000 + i, ..Scenario::default() };
        s.site.latitude_deg = LATITUDES[i as usize % LATITUDES.len()];
        s.programme.order = [DwellOrder::Random, DwellOrder::Fixed, DwellOrder::Mixed][i as usize % 3];
        s.effects.push(match i % 8 {
            7 => EffectChoice::sized("reseating", 300.0 / 3600.0_f64 * 0.017_453_292_519_943_295),
            kind => EffectChoice::detectable(ids[kind as usize], [100.0, 1e3, 1e4][i as usize / 8 % 3]),
        });
        let Ok(simulated) = simulate(&s) else { continue };
        tried += 1;
        let refused = sent(&simulated.campaign);
        assert_eq!(refused, Ok(()), "{i}: {:?}", s.effects[0].effect);
    }
    assert!(tried > 50, "{tried}");
}

/// With attitudes every mistake shows. Without them some cannot: on the equator the Earth's rate has no vertical
/// part, and a force reversed as a whole or in one axis is that of other gyros.
#[test]
fn every_mistake_that_shows_is_refused_by_its_name() {
    let campaigns = clean(CAMPAIGNS);
    for (name, cause, mutate) in MUTANTS {
        for with in [true, false] {
            let mut count = [Count::default(); 2];
            let mut missed: BTreeMap<String, usize> = BTreeMap::new();
            for (i, campaign) in campaigns.iter().enumerate() {
                let latitude = LATITUDES[i % LATITUDES.len()];
                let Some(mutant) = mutate(campaign, campaign.site.unwrap().latitude.sin()) else { continue };
                if campaign.dwells[0].attitude.is_some() != with {
                    continue;
                }
                let count = &mut count[usize::from(latitude == 0.0)];
                let answer = sent(&mutant);
                count.all += 1;
                count.refused += usize::from(answer.is_err());
                match answer {
                    Err(why) if why.contains(cause) => count.named += 1,
                    Err(why) => *missed.entry(why.chars().take(200).collect()).or_default() += 1,
                    Ok(()) => *missed.entry(format!("accepted at latitude {latitude}")).or_default() += 1,
                }
            }
            let [elsewhere, equator] = count;
            println!(
                "{name}, attitudes {with}: refused {} of {} (on the equator {} of {}), cause named {} ({})",
                elsewhere.refused, elsewhere.all, equator.refused, equator.all, elsewhere.named, equator.named
            );
            let missed: Vec<_> = missed.iter().take(4).collect();
            assert_eq!(elsewhere.refused, elsewhere.all, "{name}, attitudes {with}: {missed:?}");
            // A body mirrored as a whole is refused by the direction of its E; only where E is held do the outputs
            // have to tell.
            let by_its_e = name.contains("of both") && !with;
            assert!(elsewhere.named == elsewhere.all || by_its_e, "{name}, attitudes {with}: {missed:?}");
            if with {
                assert_eq!(equator.refused, equator.all, "{name} on the equator: {missed:?}");
            }
        }
    }
}

#[test]
fn a_few_bad_dwells_are_named_by_place() {
    for (i, campaign) in clean(22).iter().enumerate().filter(|(i, _)| LATITUDES[i % LATITUDES.len()] != 0.0) {
        let still: Vec<usize> =
            (0..campaign.dwells.len()).filter(|&k| campaign.dwells[k].phase == Phase::Static).collect();
        let bad = [still[3], still[11], still[17]];
        let mut spoiled = campaign.clone();
        for k in bad {
            spoiled.dwells[k].specific_force_g0 *= -1.0;
        }
        let why = sent(&spoiled).unwrap_err();
        for k in bad {
            assert!(why.contains(&format!("/dwells/{k}/")), "{i}: {why}");
        }
        assert_eq!(why.matches("/dwells/").count(), 3, "{i}: {why}");
    }
}

/// The table's own rates, as its controller has them, come to what was commanded.
#[test]
fn the_earths_rate_that_the_service_adds_is_that_of_the_simulator() {
    for campaign in clean(40).iter().filter(|c| c.dwells[0].attitude.is_some()) {
        let sin = campaign.site.unwrap().latitude.sin();
        let table = each(campaign, |d| {
            let (along, across) = earth(d, sin);
            d.rate_arcsec_s -= along + across;
        });
        let mut document: serde_json::Value = serde_json::from_str(&to_json(&table)).unwrap();
        document["rates"] = "table".into();
        let read = parse(document.to_string().as_bytes()).unwrap();
        for (read, commanded) in read.dwells.iter().zip(&campaign.dwells) {
            assert!((read.rate_arcsec_s - commanded.rate_arcsec_s).norm() < 1e-8, "{read:?} {commanded:?}");
        }
    }
}

#[test]
fn measured_mems_sets_that_state_no_rates_get_a_note() {
    for name in ["xsens-mti", "mimu-imu1-run4"] {
        let path = format!("{}/tests/data/measured/{name}.json", env!("CARGO_MANIFEST_DIR"));
        let campaign = parse(&std::fs::read(path).unwrap()).unwrap();
        let found = findings(&campaign);
        assert!(
            matches!(&found[..], [one] if one.causes == [MistakeKind::EarthRateLeftOut] && !one.matters),
            "{found:?}"
        );
    }
}
