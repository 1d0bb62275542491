//! `gyrowatch predict`: what the model of an IMU forecasts of a campaign, and how far it came true.

use super::{model, settings};
use crate::cli::document::coefficient;
use crate::cli::prelude::*;
use crate::core::campaign::Campaign;
use crate::core::imu_model::{Identified, changed, compare, forecast, ladder, most_telling, promised};
use crate::core::judge::Limits;
use crate::core::message::Message;
use crate::simulate::of_model::scenario_of;
use crate::simulate::{Scenario, simulate};
use crate::wire::forecast::{ChangedBody, ClosingBody, ComparedBody, ForecastBody, RungBody};
use crate::wire::triple::Triple;
use crate::wire::unit;

/// Dwells that a table shows.
const SHOWN: usize = 8;

/// Forecast a campaign from the model of its IMU, and compare it where it is measured
///
/// Nothing is fitted to the campaign: the forecast takes what it commands and the temperatures that it reads.
#[derive(Debug, Args)]
pub struct Predict {
    /// A model file with the coefficients of an IMU (gyrowatch model fit)
    model: PathBuf,

    /// A measured campaign in JSON or CSV, or what is still to be measured: a scenario in TOML as `simulate` takes it, of
    /// which the programme counts; IMU and gyros are the model's
    campaign: PathBuf,

    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

impl Predict {
    pub fn run(self) -> anyhow::Result<()> {
        let model = identified(&self.model)?;
        let file = || document::name(&self.campaign);
        let body = if self.campaign.extension().is_some_and(|e| e == "toml") {
            let campaign = programme(document::toml(&self.campaign)?, &model).with_context(file)?;
            let informative = most_telling(&model, &campaign, SHOWN).with_context(file)?;
            body(&model, &campaign).with_context(file)?.to_measure(&campaign, &informative)
        } else {
            let campaign = settings::campaign(&self.campaign, &document::read(&self.campaign)?)?;
            held_against(&model, &campaign).with_context(file)?
        };
        self.format.show(&body, || tables(&body))
    }
}

/// The model of an IMU in a file.
pub(super) fn identified(path: &Path) -> anyhow::Result<std::sync::Arc<Identified>> {
    match model::file(path)?.identified {
        Some(identified) => Ok(identified),
        None => bail!(said(message!("terminal_model_without_imu", file = document::name(path)))),
    }
}

/// A campaign of the model's IMU as a scenario commands it.
fn programme(scenario: Scenario, model: &Identified) -> anyhow::Result<Campaign> {
    let mut campaign = simulate(&scenario_of(&scenario, model)?)?.campaign;
    // What it would state of its noise is the simulator's; the model has its own.
    campaign.dwells.iter_mut().for_each(|dwell| dwell.output_sem_pulse_s = None);
    Ok(campaign)
}

fn body(model: &Identified, campaign: &Campaign) -> anyhow::Result<ForecastBody> {
    Ok(ForecastBody::of(model, campaign, &forecast(model, campaign)?, promised(model, campaign)?))
}

/// The forecast of a measured campaign, with how far it came true.
fn held_against(model: &Identified, campaign: &Campaign) -> anyhow::Result<ForecastBody> {
    let compared = compare(model, campaign)?;
    let changed = if model.effects.is_empty() { None } else { changed(model, campaign) };
    let limits = Limits::default().forecast();
    Ok(body(model, campaign)?.compared(&compared, &ladder(model, campaign)?, changed.as_ref(), (model, limits)))
}

fn tables(body: &ForecastBody) -> String {
    let model = &body.model;
    let head = message!(
        "terminal_forecast",
        imu = body.imu.clone(),
        station = body.station.clone(),
        at = body.measured_at.clone(),
        model = model.measured_at.clone(),
        campaigns = model.campaigns,
        effects = model.effects.join(", "),
        count = model.effects.len()
    );
    let mut out = format!("{}\n", said(head));
    if let Some(promised) = &body.promised {
        let promised = message!("terminal_promised", closes = closing(promised));
        out.push_str(&format!("{}\n", said(promised)));
    }
    match &body.compared {
        Some(compared) => out.push_str(&comparison(compared)),
        None => {
            out.push_str(&forecast_table(body));
            out.push_str(&to_measure(body));
        }
    }
    if let Some(changed) = &body.effects_against_model {
        out.push_str(&against_model(changed));
    }
    for note in &body.notes {
        out.push('\n');
        out.push_str(&document::note(note));
    }
    out
}

fn closing(c: &ClosingBody) -> Message {
    let [before, after] = [c.before_deg_per_h, c.after_deg_per_h].map(|x| format!("{x:.2e}"));
    match c.interval {
        Some([low, high]) => {
            let [closure, low, high] = [c.closure, low, high].map(|share| format!("{:.1}", 100.0 * share));
            message!("terminal_closes", closure, low, high, before, after)
        }
        None => message!("terminal_closes_nothing", before, after),
    }
}

fn forecast_table(body: &ForecastBody) -> String {
    let mut rows = table_of("terminal_foretold_head", 0..1);
    for gyro in &body.gyros {
        for k in 0..gyro.predicted_pulse_s.len() {
            let (sd, noise) = (gyro.sd_pulse_s[k], gyro.noise_sd_pulse_s[k]);
            let told = !gyro.not_foretold.contains(&k);
            rows.add_row([
                k.to_string(),
                gyro.slot.clone(),
                if told {
                    format!("{:+.6}", gyro.predicted_pulse_s[k])
                } else {
                    word("terminal_not_foretold").to_owned()
                },
                if told { format!("{sd:.6}") } else { "-".to_owned() },
                format!("{noise:.6}"),
            ]);
        }
    }
    format!("{rows}\n")
}

fn to_measure(body: &ForecastBody) -> String {
    let mut rows = table_of("terminal_to_measure_head", 3..5);
    let three = |v: Triple, decimals: usize| v.0.map(|x| format!("{x:+.decimals$}")).join(" ");
    for one in &body.next_dwells {
        rows.add_row([
            one.dwell.to_string(),
            three(one.specific_force_g0, 3),
            three(one.rate_arcsec_s, 1),
            format!("{:.2}", one.information),
            format!("{:.2}", one.sd_over_noise),
        ]);
    }
    format!("\n{}\n{rows}\n", word("terminal_to_measure"))
}

fn comparison(c: &ComparedBody) -> String {
    let measured = message!(
        "terminal_forecast_measured",
        state = state(&c.state).to_owned(),
        rms = format!("{:.3}", c.rms_over_sd),
        count = c.count,
        p = format!("{:.2e}", c.p_value),
        pit = format!("{:.2}", c.pit_p_value)
    );
    let mut out = format!("{}\n", said(measured));
    if let Some(verdict) = c.verdict.as_ref().filter(|verdict| !verdict.is_within()) {
        out.push_str(&format!("{}\n", verdict.reason));
    }
    if let Some(seen) = &c.closing {
        let seen = message!("terminal_seen", closes = closing(seen));
        out.push_str(&format!("{}\n", said(seen)));
    }
    let mut gyros = table_of("terminal_forecast_gyros_head", 1..3);
    for gyro in &c.gyros {
        gyros.add_row([gyro.slot.clone(), format!("{:.3}", gyro.rms_over_sd), format!("{:.2e}", gyro.p_value)]);
    }
    out.push_str(&format!("\n{gyros}\n"));
    out.push_str(&steps(c));
    if !c.missed.is_empty() {
        let mut missed = table_of("terminal_missed_head", 0..1);
        for miss in c.missed.iter().take(SHOWN) {
            missed.add_row([miss.dwell.to_string(), miss.slot.clone(), format!("{:+.1}", miss.z)]);
        }
        let title = said(message!("terminal_missed", count = c.missed.len()));
        out.push_str(&format!("\n{title}\n{missed}\n"));
    }
    out
}

/// How a campaign came out, in words.
pub(super) fn state(state: &str) -> &'static str {
    word(match state {
        "outside" => "terminal_forecast_outside",
        "as_foretold" => "terminal_forecast_met",
        _ => "terminal_forecast_not_judged",
    })
}

/// A model of the sequence: the effect that it adds, the error of the forecast, and that in standard deviations.
pub(super) fn step(rung: &RungBody) -> [String; 3] {
    let model = || word("terminal_model_6").to_owned();
    let name = rung.effect.as_ref().map_or_else(model, |effect| format!("+ {effect}"));
    [name, format!("{:.3e}", rung.rms_deg_per_h), format!("{:.2}", rung.rms_over_sd)]
}

/// The last line of that table.
pub(super) fn noise_floor(deg_per_h: f64) -> [String; 3] {
    [word("terminal_noise_floor").to_owned(), format!("{deg_per_h:.3e}"), "1.00".to_owned()]
}

/// The nested models, with the noise floor as the last line.
pub(super) fn steps(c: &ComparedBody) -> String {
    let mut steps = table_of("terminal_steps_head", 1..3);
    for rung in &c.ladder {
        steps.add_row(step(rung));
    }
    steps.add_row(noise_floor(c.noise_deg_per_h));
    format!("\n{steps}\n")
}

pub(super) fn against_model(changed: &ChangedBody) -> String {
    let mut rows = table_of("terminal_changed_head", 3..5);
    for effect in &changed.effects {
        for c in &effect.coefficients {
            rows.add_row([
                effect.effect.clone(),
                effect.slot.clone(),
                c.name.clone(),
                coefficient(c.model, Some(c.model_sd)),
                coefficient(c.now, Some(c.now_sd)),
                unit::of_people(&c.unit),
                format!("{:.1e}", effect.p_value),
                word(match (effect.changed, effect.undecided) {
                    (true, _) => "terminal_yes",
                    (false, true) => "terminal_cannot_tell",
                    (false, false) => "terminal_no",
                })
                .to_owned(),
            ]);
        }
    }
    let mut out = format!("\n{}\n{rows}\n", word("terminal_changed"));
    let whys = [(false, "terminal_cannot_tell_why"), (true, "terminal_cannot_tell_beyond")];
    for (beyond_seen, why) in whys {
        if changed.effects.iter().any(|effect| effect.undecided && effect.beyond_seen == beyond_seen) {
            out.push_str(word(why));
            out.push('\n');
        }
    }
    for shift in &changed.shifts {
        let (slot, coefficient) = (shift.slot.clone(), shift.coefficient.clone());
        let shift = format!("{:+.5} ± {:.5}", shift.shift, shift.sd);
        let moved = message!("terminal_moved_by", coefficient, slot, shift);
        out.push_str(&said(moved));
        out.push('\n');
    }
    out
}
