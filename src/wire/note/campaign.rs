//! Words and parameters of what is noted of a campaign.

use serde_json::Map;

use crate::core::bench::Alias;
use crate::core::campaign::{
    CampaignNote, CoarseStep, DriftOfGyro, DwellColumn, EffectNotFitted, StationUndetermined, Stepped, StuckOutput,
};
use crate::core::message::{Parameter, figure, list, signed, significant, text};
use crate::wire::campaign::commanded;
use crate::wire::prelude::*;

/// Dwells that a sentence names before it counts.
const NAMED: usize = 5;

pub(super) fn message(note: &CampaignNote) -> Message {
    said(note).0
}

pub(super) fn parameters(note: &CampaignNote) -> Map<String, Value> {
    match said(note).1 {
        Value::Object(members) => members,
        _ => Map::new(),
    }
}

/// The words of a note, and what they name for programs.
fn said(note: &CampaignNote) -> (Message, Value) {
    let pointers = |dwells: &[usize], field: &str| -> Vec<String> {
        dwells.iter().map(|k| format!("/dwells/{k}/{field}")).collect()
    };
    let names = |slots: &[Slot]| -> Vec<&str> { slots.iter().map(|slot| slot.name()).collect() };
    match note {
        CampaignNote::Missing { column, dwells, of } => {
            (missing(*column, dwells, *of), json!({"pointers": pointers(dwells, column.name()), "of": of}))
        }
        CampaignNote::TemperatureOutlier { dwell, celsius, median } => (
            message!("temperature_outlier", dwell = text(dwell), celsius = text(celsius), median = figure(*median, 2)),
            json!({"pointer": format!("/dwells/{dwell}/temperature_c"), "value": celsius, "median": median}),
        ),
        CampaignNote::TemperatureUnit { median } => {
            (message!("temperature_unit", median = figure(*median, 1)), json!({"median": median}))
        }
        CampaignNote::TimeUnit { median_s, turn_deg: None } => {
            (message!("time_unit", median = significant(*median_s, 2)), json!({"median_s": median_s}))
        }
        CampaignNote::TimeUnit { median_s, turn_deg: Some(turn) } => (
            message!("time_unit_of_turns", median = significant(*median_s, 2), turn = significant(*turn, 2)),
            json!({"median_s": median_s, "turn_deg": turn}),
        ),
        CampaignNote::Commanded(finding) => (commanded::message(finding), commanded::parameters(finding)),
        CampaignNote::RateNotOfAttitude { off, of, dwell, most_arcsec_s: arcsec_s } => {
            let (most, pointer) = (figure(*arcsec_s, 2), format!("/dwells/{dwell}/rate_arcsec_s"));
            (
                message!("rate_not_of_attitude", off = *off, of = *of, most, dwell = text(dwell)),
                json!({"pointer": pointer, "dwells": off, "of": of, "arcsec_s": arcsec_s}),
            )
        }
        CampaignNote::OutputsContradict { dwells, most_arcsec_s: arcsec_s } => (
            message!("dwells_contradict", dwells = places(dwells), most = significant(*arcsec_s, 3)),
            json!({"pointers": pointers(dwells, "output_pulse_s"), "arcsec_s": arcsec_s}),
        ),
        CampaignNote::OutputStuck(stuck @ StuckOutput { slot, dwells, pulse_s }) => (
            stuck.message(),
            json!({"slot": slot.name(), "pointers": pointers(dwells, "output_pulse_s"), "pulse_s": pulse_s}),
        ),
        CampaignNote::Coarse(coarse @ CoarseStep { of, step, slot, times }) => {
            let of = match of {
                Stepped::Force => "specific_force_g0",
                Stepped::Rate | Stepped::SentRate => "rate_arcsec_s",
                Stepped::Output => "output_pulse_s",
            };
            (coarse.message(), json!({"of": of, "step": step, "slot": slot.name(), "times": times}))
        }
        CampaignNote::NoStandardErrors => (message!("no_standard_errors"), json!({})),
        CampaignNote::NoRepeats => (message!("no_repeats"), json!({})),
        CampaignNote::NoiseGrows { times } => {
            (message!("noise_grows_with_rate", times = figure(*times, 1)), json!({"times": times}))
        }
        CampaignNote::NoiseShared { correlation } => {
            (message!("residuals_shared", correlation = signed(*correlation, 2)), json!({"correlation": correlation}))
        }
        CampaignNote::NoiseRemembers { probability: p, deg_per_h } => (
            message!("residuals_remember", probability = figure(p.min(0.999), 3), size = significant(*deg_per_h, 2)),
            json!({"probability": p, "deg_per_h": deg_per_h}),
        ),
        CampaignNote::ErrorsOverstated { gyros } => {
            let one = |(slot, times): &(Slot, f64)| match *times < 1e3 {
                true => message!("overstated_times", slot = slot.name(), times = figure(*times, 1)),
                false => message!("overstated_by_far", slot = slot.name()),
            };
            let times: Map<String, Value> =
                gyros.iter().map(|(slot, times)| (slot.name().to_owned(), json!(times))).collect();
            let gyros = list(gyros.iter().map(one));
            (message!("standard_errors_overstated", gyros), json!({"times": times}))
        }
        CampaignNote::ErrorsScatter { scatter } => {
            (message!("standard_errors_scatter", percent = figure(100.0 * scatter, 0)), json!({"scatter": scatter}))
        }
        CampaignNote::ErrorsUnderstated { gyros, times } => (
            message!("standard_errors_understated", slots = list(names(gyros)), times = figure(*times, 1)),
            json!({"slots": names(gyros), "times": times}),
        ),
        CampaignNote::ResidualsExceedNoise { gyros, law } => {
            let slots = list(names(gyros));
            let message = match law {
                None => message!("residuals_exceed_noise", slots),
                Some(law) => message!("residuals_exceed_noise_or_law", slots, law = law.message()),
            };
            (message, json!({"slots": names(gyros)}))
        }
        CampaignNote::EffectLeftOut { slot: None, effect, why } => {
            (message!("effect_left_out", effect = effect.id(), why = left_out(why)), json!({"effect": effect.id()}))
        }
        CampaignNote::EffectLeftOut { slot: Some(slot), effect, why } => (
            message!("effect_left_out_of_gyro", slot = slot.name(), effect = effect.id(), why = left_out(why)),
            json!({"slot": slot.name(), "effect": effect.id()}),
        ),
        CampaignNote::EffectContradicted { slot, effect } => (
            message!("effect_contradicted", slot = slot.name(), effect = effect.id()),
            json!({"slot": slot.name(), "effect": effect.id()}),
        ),
        CampaignNote::EffectAtReference { effect } => {
            (message!("effect_at_reference", effect = effect.word()), json!({"effect": effect.id()}))
        }
        CampaignNote::EffectsLeftOut { why } => (message!("effects_left_out", why = why.message()), json!({})),
        CampaignNote::StationLeftOut { parts, why } => {
            let why = match why {
                StationUndetermined::Attitude => message!("dwells_without_attitude"),
                StationUndetermined::Scale(slot) => message!("station_needs_scale", slot = slot.name()),
            };
            let parts: Vec<&str> = parts.iter().map(|part| part.name()).collect();
            (message!("station_left_out", parts = list(parts.iter().copied()), why), json!({"parts": parts}))
        }
        CampaignNote::StationContradicted { part, times, arcsec } => {
            let (part, stated) = (part.name(), significant(*arcsec, 3));
            (
                message!("station_contradicted", part, times = figure(*times, 1), stated),
                json!({"part": part, "times": times, "stated_arcsec": arcsec}),
            )
        }
        CampaignNote::ProductAliased(Alias { product, coefficient, moves }) => {
            let (product, coefficient) = (*product, *coefficient);
            (
                message!("product_aliased", product, coefficient, moves = figure(0.01 * moves.abs(), 4)),
                json!({"product": product, "coefficient": coefficient, "moves": moves}),
            )
        }
        CampaignNote::CubicAliased { size, aliases } => {
            let one = |alias: &Alias| {
                let moves = significant(size * alias.moves.abs(), 2);
                message!("cubic_moves", cubic = alias.product, coefficient = alias.coefficient, moves)
            };
            let body = |alias: &Alias| json!({"product": alias.product, "coefficient": alias.coefficient, "moves": alias.moves});
            let bodies: Vec<Value> = aliases.iter().map(body).collect();
            (
                message!("cubic_aliased", size = text(size), moved = list(aliases.iter().map(one))),
                json!({"size_deg_per_h_g03": size, "aliases": bodies}),
            )
        }
        CampaignNote::DriftAliased { of: None, drift, d_i, d_s } => (
            message!("drift_aliased", drift = text(drift), d_i = significant(*d_i, 2), d_s = significant(*d_s, 2)),
            json!({"drift_deg_per_h_h": drift, "d_i_deg_per_h_g0": d_i, "d_s_deg_per_h_g0": d_s}),
        ),
        CampaignNote::DriftAliased { of: Some(DriftOfGyro { slot, whole }), drift, d_i, d_s } => {
            let said = significant(*whole, 2);
            let moved = (significant(*d_i, 2), significant(*d_s, 2));
            (
                message!("drift_aliased_of_gyro", slot = slot.name(), drift = said, d_i = moved.0, d_s = moved.1),
                json!({
                    "drift_deg_per_h_h": drift, "d_i_deg_per_h_g0": d_i, "d_s_deg_per_h_g0": d_s,
                    "slot": slot.name(), "drift_deg_per_h": whole,
                }),
            )
        }
        CampaignNote::OffsetInGauge { moves } => {
            (message!("d_f_in_gauge", moves = figure(0.01 * moves, 4)), json!({"moves": moves}))
        }
        CampaignNote::LatitudeSign { shift } => {
            (message!("latitude_sign", shift = signed(*shift, 1)), json!({"shift_deg_per_h_g0": shift}))
        }
        CampaignNote::GravityOff { share, slot, moves } => {
            let (percent, slot) = (significant(100.0 * share, 2), slot.name());
            (
                message!("gravity_off", percent, moves = significant(*moves, 2), slot),
                json!({"share": share, "slot": slot, "moves_deg_per_h_g0": moves}),
            )
        }
        CampaignNote::LatitudeOff { degrees, moves } => (
            message!("latitude_off", degrees = figure(*degrees, 4), moves = significant(*moves, 2)),
            json!({"latitude_deg": degrees, "moves_deg_per_h_g0": moves}),
        ),
        CampaignNote::HeldScale { slot, arcsec, moves } => (
            message!("held_scale", slot = slot.name(), arcsec = text(arcsec), moves = significant(*moves, 2)),
            json!({"slot": slot.name(), "arcsec": arcsec, "moves_deg_per_h_g0": moves}),
        ),
        CampaignNote::HeldSize { slot, share, moves } => {
            let (slot, percent) = (slot.name(), text(100.0 * share));
            (
                message!("held_scale_size", slot, percent, moves = significant(*moves, 2)),
                json!({"slot": slot, "share": share, "moves_deg_per_h_g0": moves}),
            )
        }
        CampaignNote::NominalAxis { slot, scale } => (
            message!("nominal_axis", slot = slot.name(), scale = figure(*scale, 4)),
            json!({"slot": slot.name(), "pulse_per_arcsec": scale}),
        ),
    }
}

fn missing(column: DwellColumn, dwells: &[usize], of: usize) -> Message {
    let (count, dwells) = (dwells.len(), places(dwells));
    match column {
        DwellColumn::Attitude => message!("some_attitudes_missing", count, of, dwells),
        DwellColumn::Temperature if 2 * count > of => message!("temperatures_mostly_missing", count, of, dwells),
        DwellColumn::Temperature => message!("temperatures_missing", count, of, dwells),
        DwellColumn::StandardErrors => message!("standard_errors_missing", count, of, dwells),
    }
}

fn left_out(why: &EffectNotFitted) -> Message {
    match why {
        EffectNotFitted::Lacks(what) => what.message(),
        EffectNotFitted::NotDistinguished => message!("not_told_apart"),
        EffectNotFitted::NorthPart => message!("north_part_not_told"),
        EffectNotFitted::Held => message!("held_as_in_model"),
        EffectNotFitted::AnyTemperature => message!("any_temperature"),
    }
}

/// `/dwells/3, /dwells/7 and 12 more`.
fn places(dwells: &[usize]) -> Parameter {
    let named = list(dwells.iter().take(NAMED).map(|k| format!("/dwells/{k}")));
    match dwells.len().saturating_sub(NAMED) {
        0 => named,
        more => message!("and_more", named, more).into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::words::Language;

    #[test]
    fn how_much_too_large_errors_are_is_said_up_to_a_thousand_times() {
        let gyros = vec![(Slot::G1, 2.04), (Slot::G2, 999.9), (Slot::G3, 1e3)];
        let note = Language::English.words(&message(&CampaignNote::ErrorsOverstated { gyros }));
        assert!(note.contains("(G1 2.0 times, G2 999.9 times, G3 by far)"), "{note}");
    }
}
