//! `gyrowatch model fit`: the model of one IMU from its campaigns.

use clap::Subcommand;

use super::calibrate::files_of_one_imu;
use super::{hypothesis, model, settings};
use crate::cli::document::coefficient;
use crate::cli::prelude::*;
use crate::core::augmented::{Adopted, AugmentedModel};
use crate::core::campaign::Campaign;
use crate::core::diagnose::Verdict;
use crate::core::effects::{Effect, known};
use crate::core::imu_model::{CampaignSample, Chosen, Identified, Of, asked_for, identify, named};
use crate::core::message::sent;
use crate::core::model::{Term, Terms};
use crate::core::mounting::Slot;
use crate::system::sha256;
use crate::wire::{self, unit};

/// Make a model of one IMU from its campaigns
#[derive(Debug, Args)]
pub struct Model {
    #[command(subcommand)]
    what: ModelCommand,
}

#[derive(Debug, Subcommand)]
enum ModelCommand {
    Fit(FitArgs),
}

/// Fit the coefficients of one IMU to one or several of its campaigns
///
/// The model file holds D0, G, P and E of every gyro, the effects, and the covariance of all of them. It is for
/// `predict`, `gap`, `diagnose --model`, `calibrate --model`, `simulate --model` and POST /v1/imus/{imu}/model.
#[derive(Debug, Args)]
struct FitArgs {
    /// Campaigns of one IMU, in JSON or CSV, in any order
    #[arg(required = true)]
    campaigns: Vec<PathBuf>,

    /// Effects beside model (6): what the diagnoses of the campaigns name (`auto`), `none`, or ids of the catalogue
    /// with commas between them, in all gyros
    #[arg(long, value_name = "auto|none|IDS", default_value = "auto")]
    effects: String,

    /// A hypothesis of one's own, in TOML: its id may then stand among --effects
    #[arg(long, value_name = "FILE")]
    hypothesis: Vec<PathBuf>,

    /// Terms of bias, g_linear, g_squared, scale, with commas between them [default: the newest campaign's own, or all]
    #[arg(long, value_name = "TERMS", value_parser = model::terms)]
    terms: Option<Terms>,

    /// Write the model file here instead of to standard output
    #[arg(short, long, alias = "adopt", value_name = "FILE")]
    out: Option<PathBuf>,

    /// With --out: how the result is printed
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

impl Model {
    pub fn run(self) -> anyhow::Result<()> {
        match self.what {
            ModelCommand::Fit(fit) => fit.run(),
        }
    }
}

/// A campaign and the hash of its file.
fn read(path: &Path) -> anyhow::Result<(Campaign, String)> {
    let bytes = document::read(path)?;
    Ok((settings::campaign(path, &bytes)?, format!("sha256:{}", hex::encode(sha256(&bytes)))))
}

fn samples<'a>(read: &'a [(Campaign, String)], occasions: &[Vec<Adopted>]) -> Vec<CampaignSample<'a>> {
    let one = |((campaign, source), occasions): (&'a (Campaign, String), &Vec<Adopted>)| CampaignSample {
        campaign,
        source: Some(source.clone()),
        occasions: occasions.clone(),
    };
    read.iter().zip(occasions).map(one).collect()
}

impl FitArgs {
    fn run(self) -> anyhow::Result<()> {
        if let Some(path) = &self.out {
            model::may_be_replaced(path)?;
        }
        let mut paths: Vec<_> =
            self.campaigns.iter().map(|path| Ok((path, read(path)?))).collect::<anyhow::Result<_>>()?;
        paths.sort_by_key(|(_, (campaign, _))| campaign.measured_at);
        let (names, read): (Vec<String>, Vec<_>) =
            paths.into_iter().map(|(path, read)| (document::name(path), read)).unzip();
        let campaigns: Vec<&Campaign> = read.iter().map(|(campaign, _)| campaign).collect();
        let files: Vec<_> = names.iter().map(String::as_str).zip(campaigns.iter().copied()).collect();
        files_of_one_imu(&files)?;
        // What does not fit together is said before anything is diagnosed.
        let plain = AugmentedModel { terms: self.terms, ..AugmentedModel::default() };
        let nothing = vec![Vec::new(); read.len()];
        let plainly = samples(&read, &nothing);
        identify(&plainly, &plain)?;
        let chosen = self.chosen(&campaigns)?;
        let identified = identify(&samples(&read, &chosen.occasions), &chosen.model)?;
        for (campaign, verdict) in campaigns.iter().zip(&chosen.verdicts) {
            if matches!(verdict, Verdict::PartlyExplained | Verdict::Unexplained) {
                let at = time::format(campaign.measured_at);
                let verdict = said(document::verdict(verdict.name()));
                let warning = message!("terminal_fit_short", at, verdict);
                eprintln!("{}", said(warning));
            }
        }
        for id in self.asked().filter(|id| identified.effects.iter().all(|adopted| adopted.effect.id() != *id)) {
            let left_out = message!("terminal_fit_left_out", effect = id.to_owned());
            eprintln!("--effects: {}", said(left_out));
        }
        let shown = tables(&identified);
        let file = identified.into_model(&chosen.model);
        let text = wire::model::to_json(&file);
        match &self.out {
            None => document::print(&text),
            Some(path) => {
                document::write(path, &(text + "\n"))?;
                self.format.show(&wire::model::ModelBody::from(&file), || shown)
            }
        }
    }

    /// Effects by their ids, where they are asked for so.
    fn asked(&self) -> impl Iterator<Item = &str> {
        let ids = if matches!(self.effects.as_str(), "auto" | "none") { None } else { Some(self.effects.split(',')) };
        ids.into_iter().flatten().map(str::trim)
    }

    fn chosen(&self, campaigns: &[&Campaign]) -> anyhow::Result<Chosen> {
        if !self.hypothesis.is_empty() && matches!(self.effects.as_str(), "auto" | "none") {
            bail!(word("terminal_hypothesis_by_id"));
        }
        let none = |model| Chosen { model, occasions: vec![Vec::new(); campaigns.len()], verdicts: Vec::new() };
        match self.effects.as_str() {
            "auto" => Ok(named(campaigns, self.terms)?),
            "none" => Ok(none(AugmentedModel { terms: self.terms, ..AugmentedModel::default() })),
            _ => {
                let own = hypothesis::files(&self.hypothesis, &AugmentedModel::default())?;
                let effects = self.asked().map(|id| lasting(id, &own)).collect::<anyhow::Result<Vec<_>>>()?;
                let newest = campaigns[campaigns.len() - 1];
                hypothesis::defined_in(&own, newest)?;
                Ok(none(asked_for(&effects, newest, self.terms)?))
            }
        }
    }
}

/// An effect that may act in campaigns to come.
fn lasting(id: &str, own: &[Effect]) -> anyhow::Result<Effect> {
    let own = own.iter().find(|own| own.id() == id).copied();
    let Some(effect) = Effect::from_id(id).or(own) else {
        bail!("--effects: {}", said(message!("unknown_effect", effect = sent(id), effects = known())));
    };
    let entry = effect.entry();
    if entry.one_occasion {
        bail!(said(message!("terminal_one_occasion", effect = entry.id)));
    }
    if entry.closure_only {
        bail!(said(message!("terminal_part_of_g", effect = entry.id)));
    }
    Ok(effect)
}

fn tables(model: &Identified) -> String {
    let at = |t| time::format(t);
    let none = || word("terminal_no_temperature").to_owned();
    let head = message!(
        "terminal_model_of",
        imu = model.imu.to_string(),
        coefficients = model.coefficients.len(),
        campaigns = model.campaigns.len(),
        first = at(model.campaigns[0].measured_at),
        last = at(model.measured_at),
        reference = model.reference_c.map_or_else(none, |t| format!("{t:.2} deg C"))
    );
    let mut out = format!("{}\n\n", said(head));
    let mut drift = table_of("terminal_model_gyros_head", 2..8);
    let (values, covariance) = (model.values(), &model.covariance);
    for gyro in &model.gyros {
        let figure = |value: f64, sd: f64| format!("{value:+.5} ± {sd:.5}");
        let bias = model.coefficients.iter().position(|c| c.slot == Some(gyro.slot) && c.of == Of::Term(Term::Bias, 0));
        let k = gyro.e.norm();
        let d_f = bias.map_or("-".to_owned(), |place| figure(values[place] / k, model.sd(place) / k));
        let row = match model.separation(gyro.slot, &values, covariance) {
            Some(s) => {
                let sd = s.rigid.sd().unwrap_or_default();
                let [d_i, d_s, d_o] = [(s.rigid.d_i, sd[0]), (s.rigid.d_s, sd[1]), (s.rigid.d_o, sd[2])]
                    .map(|(value, sd)| figure(value, sd));
                [d_i, d_s, d_o, format!("{:.6}", s.scale_factor)]
            }
            None => ["-", "-", "-", "-"].map(str::to_owned),
        };
        let [d_i, d_s, d_o, e] = row;
        let noise = format!("{:.2e}", gyro.noise.random_walk);
        drift.add_row([gyro.slot.name().to_owned(), gyro.serial.to_string(), d_f, d_i, d_s, d_o, e, noise]);
    }
    out.push_str(&format!("{}\n{drift}\n", word("terminal_model_gyros")));
    let mut effects = table_of("terminal_model_effects_head", 3..4);
    for (place, c) in model.coefficients.iter().enumerate() {
        let Of::Effect(effect, number) = c.of else { continue };
        let adopted = &model.effects[effect];
        let one = adopted.effect.entry().coefficients(adopted.shape)[number];
        effects.add_row([
            adopted.effect.id().to_owned(),
            c.slot.map_or_else(|| word("terminal_all"), Slot::name).to_owned(),
            one.name.to_owned(),
            coefficient(c.value, Some(model.sd(place))),
            unit::of_people(one.unit),
        ]);
    }
    if model.effects.is_empty() {
        out.push_str(&format!("\n{}\n", word("terminal_model_plain")));
    } else {
        out.push_str(&format!("\n{}\n{effects}\n", word("terminal_model_effects")));
    }
    out
}
