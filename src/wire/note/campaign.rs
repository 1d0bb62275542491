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
    match note {
        CampaignNote::Missing { column, dwells, of } => missing(*column, dwells, *of),
        CampaignNote::TemperatureOutlier { dwell, celsius, median } => {
            message!("temperature_outlier", dwell = text(dwell), celsius = text(celsius), median = figure(*median, 2),)
        }
        CampaignNote::TemperatureUnit { median } => message!("temperature_unit", median = figure(*median, 1)),
        CampaignNote::TimeUnit { median_s, turn_deg: None } => {
            message!("time_unit", median = significant(*median_s, 2))
        }
        CampaignNote::TimeUnit { median_s, turn_deg: Some(turn) } => {
            message!("time_unit_of_turns", median = significant(*median_s, 2), turn = significant(*turn, 2))
        }
        CampaignNote::Commanded(finding) => commanded::message(finding),
        CampaignNote::RateNotOfAttitude { off, of, dwell, most_arcsec_s } => message!(
            "rate_not_of_attitude",
            off = *off,
            of = *of,
            most = figure(*most_arcsec_s, 2),
            dwell = text(dwell),
        ),
        CampaignNote::OutputsContradict { dwells, most_arcsec_s } => {
            message!("dwells_contradict", dwells = places(dwells), most = significant(*most_arcsec_s, 3),)
        }
        CampaignNote::OutputStuck(stuck) => stuck.message(),
        CampaignNote::Coarse(step) => step.message(),
        CampaignNote::NoStandardErrors => message!("no_standard_errors"),
        CampaignNote::NoRepeats => message!("no_repeats"),
        CampaignNote::NoiseGrows { times } => message!("noise_grows_with_rate", times = figure(*times, 1)),
        CampaignNote::NoiseShared { correlation } => {
            message!("residuals_shared", correlation = signed(*correlation, 2))
        }
        CampaignNote::NoiseRemembers { probability, deg_per_h } => {
            message!(
                "residuals_remember",
                probability = figure(probability.min(0.999), 3),
                size = significant(*deg_per_h, 2)
            )
        }
        CampaignNote::ErrorsOverstated { gyros } => {
            let one = |(slot, times): &(Slot, f64)| match *times < 1e3 {
                true => message!("overstated_times", slot = slot.name(), times = figure(*times, 1)),
                false => message!("overstated_by_far", slot = slot.name()),
            };
            message!("standard_errors_overstated", gyros = list(gyros.iter().map(one)))
        }
        CampaignNote::ErrorsScatter { scatter } => {
            message!("standard_errors_scatter", percent = figure(100.0 * scatter, 0))
        }
        CampaignNote::ErrorsUnderstated { gyros, times } => {
            let slots = list(gyros.iter().map(|slot| slot.name()));
            message!("standard_errors_understated", slots, times = figure(*times, 1))
        }
        CampaignNote::ResidualsExceedNoise { gyros, law } => {
            let slots = list(gyros.iter().map(|slot| slot.name()));
            match law {
                None => message!("residuals_exceed_noise", slots),
                Some(law) => message!("residuals_exceed_noise_or_law", slots, law = law.message()),
            }
        }
        CampaignNote::EffectLeftOut { slot: None, effect, why } => {
            message!("effect_left_out", effect = effect.id(), why = left_out(why))
        }
        CampaignNote::EffectLeftOut { slot: Some(slot), effect, why } => {
            message!("effect_left_out_of_gyro", slot = slot.name(), effect = effect.id(), why = left_out(why))
        }
        CampaignNote::EffectContradicted { slot, effect } => {
            message!("effect_contradicted", slot = slot.name(), effect = effect.id())
        }
        CampaignNote::EffectAtReference { effect } => message!("effect_at_reference", effect = effect.word()),
        CampaignNote::EffectsLeftOut { why } => message!("effects_left_out", why = why.message()),
        CampaignNote::StationLeftOut { parts, why } => {
            let why = match why {
                StationUndetermined::Attitude => message!("dwells_without_attitude"),
                StationUndetermined::Scale(slot) => message!("station_needs_scale", slot = slot.name()),
            };
            message!("station_left_out", parts = list(parts.iter().map(|part| part.name())), why)
        }
        CampaignNote::StationContradicted { part, times, arcsec } => {
            let (times, stated) = (figure(*times, 1), significant(*arcsec, 3));
            message!("station_contradicted", part = part.name(), times, stated)
        }
        CampaignNote::ProductAliased(Alias { product, coefficient, moves }) => message!(
            "product_aliased",
            product = *product,
            coefficient = *coefficient,
            moves = figure(0.01 * moves.abs(), 4),
        ),
        CampaignNote::CubicAliased { size, aliases } => {
            let one = |alias: &Alias| {
                let moves = significant(size * alias.moves.abs(), 2);
                message!("cubic_moves", cubic = alias.product, coefficient = alias.coefficient, moves)
            };
            message!("cubic_aliased", size = text(size), moved = list(aliases.iter().map(one)))
        }
        CampaignNote::DriftAliased { of, drift, d_i, d_s } => {
            let (d_i, d_s) = (significant(*d_i, 2), significant(*d_s, 2));
            match of {
                None => message!("drift_aliased", drift = text(drift), d_i, d_s),
                Some(DriftOfGyro { slot, whole }) => {
                    message!("drift_aliased_of_gyro", slot = slot.name(), drift = significant(*whole, 2), d_i, d_s)
                }
            }
        }
        CampaignNote::OffsetInGauge { moves } => message!("d_f_in_gauge", moves = figure(0.01 * moves, 4)),
        CampaignNote::LatitudeSign { shift } => message!("latitude_sign", shift = signed(*shift, 1)),
        CampaignNote::GravityOff { share, slot, moves } => {
            let percent = significant(100.0 * share, 2);
            message!("gravity_off", percent, moves = significant(*moves, 2), slot = slot.name())
        }
        CampaignNote::LatitudeOff { degrees, moves } => {
            message!("latitude_off", degrees = figure(*degrees, 4), moves = significant(*moves, 2))
        }
        CampaignNote::HeldScale { slot, arcsec, moves } => {
            message!("held_scale", slot = slot.name(), arcsec = text(arcsec), moves = significant(*moves, 2))
        }
        CampaignNote::HeldSize { slot, share, moves } => {
            let percent = text(100.0 * share);
            message!("held_scale_size", slot = slot.name(), percent, moves = significant(*moves, 2))
        }
        CampaignNote::NominalAxis { slot, scale } => {
            message!("nominal_axis", slot = slot.name(), scale = figure(*scale, 4))
        }
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
        EffectNotFitted::Held => message!("held_as_in_model"),
        EffectNotFitted::AnyTemperature => message!("any_temperature"),
    }
}

pub(super) fn parameters(note: &CampaignNote) -> Map<String, Value> {
    let pointers = |dwells: &[usize], field: &str| -> Vec<String> {
        dwells.iter().map(|k| format!("/dwells/{k}/{field}")).collect()
    };
    let value = match note {
        CampaignNote::NoStandardErrors | CampaignNote::NoRepeats | CampaignNote::EffectsLeftOut { .. } => json!({}),
        CampaignNote::Missing { column, dwells, of } => {
            json!({"pointers": pointers(dwells, column.name()), "of": of})
        }
        CampaignNote::TemperatureOutlier { dwell, celsius, median } => json!({
            "pointer": format!("/dwells/{dwell}/temperature_c"), "value": celsius, "median": median
        }),
        CampaignNote::TemperatureUnit { median } => json!({"median": median}),
        CampaignNote::TimeUnit { median_s, turn_deg } => match turn_deg {
            Some(turn_deg) => json!({"median_s": median_s, "turn_deg": turn_deg}),
            None => json!({"median_s": median_s}),
        },
        CampaignNote::Commanded(finding) => commanded::parameters(finding),
        CampaignNote::RateNotOfAttitude { off, of, dwell, most_arcsec_s } => json!({
            "pointer": format!("/dwells/{dwell}/rate_arcsec_s"), "dwells": off, "of": of, "arcsec_s": most_arcsec_s
        }),
        CampaignNote::OutputsContradict { dwells, most_arcsec_s } => {
            json!({"pointers": pointers(dwells, "output_pulse_s"), "arcsec_s": most_arcsec_s})
        }
        CampaignNote::OutputStuck(StuckOutput { slot, dwells, pulse_s }) => json!({
            "slot": Slot::name(*slot), "pointers": pointers(dwells, "output_pulse_s"), "pulse_s": pulse_s
        }),
        CampaignNote::Coarse(CoarseStep { of, step, slot, times }) => {
            let step_of = match of {
                Stepped::Force => "specific_force_g0",
                Stepped::Rate => "rate_arcsec_s",
                Stepped::Output => "output_pulse_s",
            };
            json!({"of": step_of, "step": step, "slot": Slot::name(*slot), "times": times})
        }
        CampaignNote::NoiseGrows { times } => json!({"times": times}),
        CampaignNote::NoiseShared { correlation } => json!({"correlation": correlation}),
        CampaignNote::NoiseRemembers { probability, deg_per_h } => {
            json!({"probability": probability, "deg_per_h": deg_per_h})
        }
        CampaignNote::ErrorsOverstated { gyros } => {
            let times: Map<String, Value> =
                gyros.iter().map(|(s, times)| (s.name().to_owned(), json!(times))).collect();
            json!({"times": times})
        }
        CampaignNote::ErrorsScatter { scatter } => json!({"scatter": scatter}),
        CampaignNote::ErrorsUnderstated { gyros, times } => {
            json!({"slots": gyros.iter().map(|slot| slot.name()).collect::<Vec<_>>(), "times": times})
        }
        CampaignNote::ResidualsExceedNoise { gyros, .. } => {
            json!({"slots": gyros.iter().map(|slot| slot.name()).collect::<Vec<_>>()})
        }
        CampaignNote::EffectLeftOut { slot, effect, .. } => match slot {
            Some(slot) => json!({"slot": slot.name(), "effect": effect.id()}),
            None => json!({"effect": effect.id()}),
        },
        CampaignNote::EffectContradicted { slot, effect } => json!({"slot": slot.name(), "effect": effect.id()}),
        CampaignNote::EffectAtReference { effect } => json!({"effect": effect.id()}),
        CampaignNote::StationLeftOut { parts, .. } => {
            json!({"parts": parts.iter().map(|part| part.name()).collect::<Vec<_>>()})
        }
        CampaignNote::StationContradicted { part, times, arcsec } => {
            json!({"part": part.name(), "times": times, "stated_arcsec": arcsec})
        }
        CampaignNote::ProductAliased(Alias { product, coefficient, moves }) => {
            json!({"product": product, "coefficient": coefficient, "moves": moves})
        }
        CampaignNote::CubicAliased { size, aliases } => {
            let one = |alias: &Alias| {
                let Alias { product, coefficient, moves } = alias;
                json!({"product": product, "coefficient": coefficient, "moves": moves})
            };
            json!({"size_deg_per_h_g03": size, "aliases": aliases.iter().map(one).collect::<Vec<Value>>()})
        }
        CampaignNote::DriftAliased { of, drift, d_i, d_s } => {
            let moves = json!({"drift_deg_per_h_h": drift, "d_i_deg_per_h_g0": d_i, "d_s_deg_per_h_g0": d_s});
            let Value::Object(mut members) = moves else { return Map::new() };
            if let Some(DriftOfGyro { slot, whole }) = of {
                members.insert("slot".to_owned(), json!(slot.name()));
                members.insert("drift_deg_per_h".to_owned(), json!(whole));
            }
            Value::Object(members)
        }
        CampaignNote::OffsetInGauge { moves } => json!({"moves": moves}),
        CampaignNote::LatitudeSign { shift } => json!({"shift_deg_per_h_g0": shift}),
        CampaignNote::GravityOff { share, slot, moves } => {
            json!({"share": share, "slot": Slot::name(*slot), "moves_deg_per_h_g0": moves})
        }
        CampaignNote::LatitudeOff { degrees, moves } => {
            json!({"latitude_deg": degrees, "moves_deg_per_h_g0": moves})
        }
        CampaignNote::HeldScale { slot, arcsec, moves } => {
            json!({"slot": Slot::name(*slot), "arcsec": arcsec, "moves_deg_per_h_g0": moves})
        }
        CampaignNote::HeldSize { slot, share, moves } => {
            json!({"slot": Slot::name(*slot), "share": share, "moves_deg_per_h_g0": moves})
        }
        CampaignNote::NominalAxis { slot, scale } => json!({"slot": Slot::name(*slot), "pulse_per_arcsec": scale}),
    };
    match value {
        Value::Object(members) => members,
        _ => Map::new(),
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
