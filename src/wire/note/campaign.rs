//! Words and parameters of what is noted of a campaign.

use serde_json::{Map, Value, json};

use crate::core::calibrate::noise::overstated_note;
use crate::core::campaign::{CampaignNote, Column, LeftOut};
use crate::core::mounting::Slot;
use crate::wire::campaign::commanded;
use crate::words;

/// Dwells that a sentence names before it counts.
const NAMED: usize = 5;

pub(super) fn detail(note: &CampaignNote) -> String {
    match note {
        CampaignNote::Missing { column, dwells, of } => {
            let (n, which) = (dwells.len(), places(dwells));
            match column {
                Column::Attitude => {
                    format!(
                        "no attitude in {n} of {of} dwells ({which}): these were not checked against it, and effects of the station cannot be seen"
                    )
                }
                Column::Temperature if 2 * n > *of => format!(
                    "no temperature in {n} of {of} dwells ({which}): with so few, effects of temperature cannot be seen"
                ),
                Column::Temperature => {
                    format!("no temperature in {n} of {of} dwells ({which}): it is taken from the dwells beside them")
                }
                Column::StandardErrors => format!(
                    "no standard errors in {n} of {of} dwells ({which}): they get the median of the others, scaled to their duration"
                ),
            }
        }
        CampaignNote::TemperatureOutlier { dwell, celsius, median } => format!(
            "the temperature of /dwells/{dwell} is {celsius} deg C where the campaign's median is {median:.2} deg C: taken for a fault value of \
             the sensor and left out of temperature effects"
        ),
        CampaignNote::Commanded(finding) => words::asked().words(&commanded::message(finding)),
        CampaignNote::RateNotOfAttitude { off, of, dwell, most_arcsec_s } => format!(
            "rate_arcsec_s of {off} of {of} static dwells is not the Earth's at their attitude and the site's latitude: by \
             {most_arcsec_s:.2} arcsec/s in /dwells/{dwell}"
        ),
        CampaignNote::NoStandardErrors => {
            "no standard errors: all dwells have equal weight and the residuals give the noise".to_owned()
        }
        CampaignNote::NoRepeats => {
            "no repeated dwells: nothing but the fit itself tells noise from what the model leaves out".to_owned()
        }
        CampaignNote::NoiseGrows { times } => {
            format!("the residuals at the fastest rate are {times:.1} times those at rest; sigmas follow them")
        }
        CampaignNote::ErrorsOverstated { gyros } => {
            overstated_note(gyros.iter().map(|(slot, times)| (slot.name(), *times))).unwrap_or_default()
        }
        CampaignNote::ResidualsExceedNoise { gyros } => {
            let gyros: Vec<&str> = gyros.iter().map(|slot| slot.name()).collect();
            format!("{}: residuals exceed the noise; the model leaves something out (see diagnose)", gyros.join(", "))
        }
        CampaignNote::EffectLeftOut { slot, effect, why } => {
            let slot = slot.map_or_else(String::new, |slot| format!("{}: ", slot.name()));
            let why = match why {
                LeftOut::Lacks(what) => what,
                LeftOut::NotTold => "these dwells cannot tell it from the other terms",
            };
            format!("{slot}{} is left out of the fit: {why}", effect.id())
        }
        CampaignNote::EffectsLeftOut { why } => format!("the effects of the model are left out: {why}"),
        CampaignNote::NominalAxis { slot, scale } => format!(
            "{}: the campaign does not determine E; the nominal input axis and {scale:.4} pulse/arcsec are used",
            slot.name()
        ),
    }
}

pub(super) fn parameters(note: &CampaignNote) -> Map<String, Value> {
    let pointers = |dwells: &[usize], field: &str| -> Vec<String> {
        dwells.iter().map(|k| format!("/dwells/{k}/{field}")).collect()
    };
    let value = match note {
        CampaignNote::Missing { column, dwells, of } => {
            let field = match column {
                Column::Attitude => "attitude",
                Column::Temperature => "temperature_c",
                Column::StandardErrors => "output_sem_pulse_s",
            };
            json!({"pointers": pointers(dwells, field), "of": of})
        }
        CampaignNote::TemperatureOutlier { dwell, celsius, median } => json!({
            "pointer": format!("/dwells/{dwell}/temperature_c"), "value": celsius, "median": median
        }),
        CampaignNote::Commanded(finding) => commanded::parameters(finding),
        CampaignNote::RateNotOfAttitude { off, of, dwell, most_arcsec_s } => json!({
            "pointer": format!("/dwells/{dwell}/rate_arcsec_s"), "dwells": off, "of": of, "arcsec_s": most_arcsec_s
        }),
        CampaignNote::NoStandardErrors | CampaignNote::NoRepeats => json!({}),
        CampaignNote::NoiseGrows { times } => json!({"times": times}),
        CampaignNote::ErrorsOverstated { gyros } => {
            let times: Map<String, Value> =
                gyros.iter().map(|(s, times)| (s.name().to_owned(), json!(times))).collect();
            json!({"times": times})
        }
        CampaignNote::ResidualsExceedNoise { gyros } => {
            json!({"slots": gyros.iter().map(|slot| slot.name()).collect::<Vec<_>>()})
        }
        CampaignNote::EffectLeftOut { slot, effect, .. } => match slot {
            Some(slot) => json!({"slot": slot.name(), "effect": effect.id()}),
            None => json!({"effect": effect.id()}),
        },
        CampaignNote::EffectsLeftOut { .. } => json!({}),
        CampaignNote::NominalAxis { slot, scale } => json!({"slot": Slot::name(*slot), "pulse_per_arcsec": scale}),
    };
    match value {
        Value::Object(members) => members,
        _ => Map::new(),
    }
}

/// `/dwells/3, /dwells/7 and 12 more`.
fn places(dwells: &[usize]) -> String {
    let named: Vec<String> = dwells.iter().take(NAMED).map(|k| format!("/dwells/{k}")).collect();
    let more = dwells.len().saturating_sub(NAMED);
    if more > 0 { format!("{} and {more} more", named.join(", ")) } else { named.join(", ") }
}
