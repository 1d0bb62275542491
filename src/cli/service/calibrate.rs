//! `calibrate`: campaigns of raw dwells in, the fit and the drift coefficients out. Nothing is stored or judged.

use super::separate::{SeparationMethod, check_kind, drift_and_mounting, figure};
use super::{model, settings};
use crate::cli::document::{coefficient, part_of};
use crate::cli::prelude::*;
use crate::config::Config;
use crate::core::calibrate::outcome::{Outcome, evaluate_with};
use crate::core::calibrate::repeats_between::repeated;
use crate::core::calibrate::reseated::reseated;
use crate::core::campaign::{Campaign, TestKind};
use crate::core::diagnose::{Verdict, diagnose};
use crate::core::imu_model::of_one_imu;
use crate::core::numerics::between::differs;
use crate::wire::calibration::{CampaignAnswer, CampaignsAnswer, GyroFitBody, RepeatedBody, ReseatedBody};
use crate::wire::diagnosis::DiagnosisBody;
use crate::wire::document::{DocumentKind, open_table, parse};
use crate::wire::note::NoteBody;
use crate::wire::unit;
use crate::words::asked;

/// Dwells with the largest standardised residuals that the table shows.
const SHOWN_RESIDUALS: usize = 5;

/// Fit the error model to campaigns of raw dwells, and separate their gyros
#[derive(Debug, clap::Args)]
pub struct Calibrate {
    /// The campaign, in JSON or CSV; `-` is standard input. Several of one IMU: also what repeats between them
    #[arg(required = true, value_name = "CAMPAIGN")]
    campaigns: Vec<PathBuf>,

    /// What to fit: terms of bias, g_linear, g_squared, scale, parted by commas, or a model file
    /// [default: the campaign's own terms, else all four]
    #[arg(long, value_name = "TERMS|FILE", value_parser = model::choice)]
    model: Option<model::Choice>,

    /// In the JSON: the method of d_i and d_s; the other is always reported beside it
    #[arg(long, value_enum, default_value_t)]
    method: SeparationMethod,

    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// A campaign, its fit and what is answered.
struct FittedFile {
    file: String,
    campaign: Campaign,
    outcome: Outcome,
    answer: CampaignAnswer,
    /// The verdict, in words, of a diagnosis that sees more than noise; asked for tables alone.
    gap: Option<String>,
}

/// Refuses campaigns, in the order of time, that are not of one IMU, by the names of their files.
pub(super) fn files_of_one_imu(files: &[(&str, &Campaign)]) -> anyhow::Result<()> {
    for (i, (file, one)) in files.iter().enumerate() {
        for (beside, other) in &files[..i] {
            of_one_imu(&[other, one]).with_context(|| {
                let (first, second) = ((*file).to_owned(), (*beside).to_owned());
                said(message!("beside", first, second))
            })?;
        }
    }
    Ok(())
}

/// Refuses one measurement under two times: what it repeats would be taken for a second one's.
fn refuse_copies(files: &[(&str, &Campaign)]) -> anyhow::Result<()> {
    for (i, (file, one)) in files.iter().enumerate() {
        let is_copy = |other: &Campaign| {
            let outputs = other.dwells.iter().map(|dwell| &dwell.output_pulse_s);
            outputs.eq(one.dwells.iter().map(|dwell| &dwell.output_pulse_s))
        };
        if let Some((beside, _)) = files[..i].iter().find(|(_, other)| is_copy(other)) {
            bail!(said(message!("terminal_copies", first = (*beside).to_owned(), second = (*file).to_owned())));
        }
    }
    Ok(())
}

impl Calibrate {
    pub fn run(self) -> anyhow::Result<()> {
        let config = settings::config()?;
        let mut fitted =
            self.campaigns.iter().map(|path| self.fitted(path, &config)).collect::<anyhow::Result<Vec<_>>>()?;
        if let [one] = fitted.as_slice() {
            return self.format.show(&one.answer, || tables(one));
        }
        fitted.sort_by_key(|one| one.campaign.measured_at);
        let files: Vec<_> = fitted.iter().map(|one| (one.file.as_str(), &one.campaign)).collect();
        files_of_one_imu(&files)?;
        refuse_copies(&files)?;
        let pairs: Vec<_> = fitted.iter().map(|one| (&one.campaign, &one.outcome)).collect();
        let between: Vec<RepeatedBody> = repeated(&pairs).iter().map(RepeatedBody::from).collect();
        let reseated: Vec<ReseatedBody> = reseated(&pairs).iter().map(ReseatedBody::from).collect();
        match self.format {
            Format::Table => document::print(&tables_between(&fitted, &between, &reseated)),
            Format::Json => document::print_json(&CampaignsAnswer {
                campaigns: fitted.into_iter().map(|one| one.answer).collect(),
                between_campaigns: between,
                reseated,
            }),
        }
    }

    fn fitted(&self, path: &Path, config: &Config) -> anyhow::Result<FittedFile> {
        let bytes = document::read(path)?;
        let file = || document::name(path);
        check_kind(DocumentKind::Campaign, &bytes, file)?;
        let mut campaign = config.stations.complete(parse(&bytes).with_context(file)?);
        let chosen = model::chosen(self.model.as_ref())?;
        for note in chosen.notes_of_others(&campaign) {
            eprintln!("{}: {}", file(), said(note));
        }
        let options = chosen.options(&campaign);
        campaign.model = options.terms;
        if campaign.test != TestKind::Imu && !options.adopted.is_empty() {
            bail!("{}: {}", file(), word("model_effects_of_imu"));
        }
        let limits = config.plausibility.limits();
        campaign.check_known_scales(&limits).with_context(file)?;
        let outcome = evaluate_with(&campaign, &options, &limits).with_context(file)?;
        let mut answer = CampaignAnswer::of(&campaign, &outcome, self.method.into());
        answer.notes.extend(open_table(&bytes).as_ref().map(NoteBody::of));
        let is_asked = campaign.test == TestKind::Imu && matches!(self.format, Format::Table);
        let diagnosed = is_asked.then(|| diagnose(&campaign, &options).ok()).flatten();
        let seen = diagnosed.filter(|diagnosis| diagnosis.verdict != Verdict::NoGap);
        let gap = seen.map(|diagnosis| gap_in_words(&DiagnosisBody::from(&diagnosis)));
        Ok(FittedFile { file: file(), campaign, outcome, answer, gap })
    }
}

/// The verdict of a diagnosis, and what it names.
fn gap_in_words(diagnosis: &DiagnosisBody) -> String {
    let causes: Vec<String> =
        diagnosis.effects.iter().map(|one| format!("{} ({})", one.effect, one.gyros.join(", "))).collect();
    let named = (!causes.is_empty()).then(|| said(message!("terminal_causes", causes = causes.join(", "))));
    [Some(diagnosis.verdict_in_words(asked())), named].into_iter().flatten().collect::<Vec<_>>().join(" ")
}

/// D_I and D_S of every campaign, and what repeats between them.
fn tables_between(fitted: &[FittedFile], between: &[RepeatedBody], reseated: &[ReseatedBody]) -> String {
    let mut each = table_of("terminal_campaigns_head", 4..6);
    let (imu, count) = (fitted[0].answer.imu.clone(), fitted.len().to_string());
    let mut text = format!("{}\n\n", said(message!("terminal_campaigns", imu, count)));
    for FittedFile { file, answer, .. } in fitted {
        for s in &answer.separations {
            each.add_row([
                file.clone(),
                answer.station.clone(),
                answer.measured_at.clone(),
                s.slot.name().to_owned(),
                figure(s.d_i.value, s.d_i.sd),
                figure(s.d_s.value, s.d_s.sd),
            ]);
        }
    }
    text.push_str(&format!("{}\n{each}\n", word("terminal_drift")));
    let mut repeats = table_of("terminal_repeats_head", 5..10);
    for r in between {
        let [low, high] = r.ratio_interval;
        let beyond = if r.beyond_sd > 0.0 { format!("{:.2e}", r.beyond_sd) } else { "-".to_owned() };
        repeats.add_row([
            r.slot.name().to_owned(),
            r.coefficient.to_owned(),
            r.campaigns.to_string(),
            figure(r.mean, Some(r.sd)),
            unit::of_people(r.unit),
            format!("{:.2e}", r.stated_sd),
            format!("{:.2e}", r.scatter_sd),
            format!("{:.2} [{low:.2}, {high:.2}]", r.ratio),
            r.p_value.map_or("-".to_owned(), |p| format!("{p:.1e}")),
            beyond,
        ]);
    }
    text.push_str(&format!("\n{}\n{repeats}\n", word("terminal_repeats")));
    let is_told = |r: &&RepeatedBody| r.p_value.is_some_and(|p| differs(p, between.len()));
    let beyond: Vec<String> =
        between.iter().filter(is_told).map(|r| format!("{} {}", r.slot.name(), r.coefficient)).collect();
    let differ = match beyond.as_slice() {
        [] if between.is_empty() => Some(message!("terminal_repeats_nothing")),
        // An IMU that was seated anew differs.
        [] => reseated.is_empty().then(|| message!("terminal_repeats_none")),
        some => Some(message!("terminal_repeats_beyond", coefficients = some.join(", "))),
    };
    text.extend(differ.map(said));
    for one in reseated {
        let [about_x, about_y, about_z] = [0, 1, 2].map(|axis| {
            let (turned, sd) = (one.rotation_arcsec.0[axis], one.sd_arcsec.0[axis]);
            format!("{turned:+.2} ± {sd:.2}")
        });
        let (file, first) = (fitted[one.campaign].file.clone(), fitted[0].file.clone());
        text.push('\n');
        text.push_str(&said(message!("terminal_reseated", file, first, about_x, about_y, about_z)));
        if !one.explains_d_o_of.is_empty() {
            let gyros = one.explains_d_o_of.iter().map(|slot| slot.name()).collect::<Vec<_>>().join(", ");
            text.push(' ');
            text.push_str(&said(message!("terminal_reseated_explains", gyros)));
        }
    }
    for one in fitted {
        for remark in remarks(one) {
            text.push_str(&format!("\n{}: {remark}", one.file));
        }
    }
    text
}

/// What is said below the tables of a campaign.
fn remarks(FittedFile { file, answer, gap, .. }: &FittedFile) -> impl Iterator<Item = String> {
    let beyond = gap
        .iter()
        .map(|verdict| said(message!("terminal_gap_beside_fit", verdict = verdict.clone(), file = file.clone())));
    let separated = answer.not_separated.iter().map(|gyro| {
        let slot = gyro.slot.name().to_owned();
        let (serial, reason) = (gyro.serial.clone(), gyro.reason.clone());
        said(message!("terminal_not_separated", slot, serial, reason))
    });
    separated.chain(answer.notes.iter().map(|note| document::note(&note.detail))).chain(beyond)
}

fn tables(fitted: &FittedFile) -> String {
    let FittedFile { campaign, outcome, answer, .. } = fitted;
    let CampaignAnswer { imu, station, measured_at, calibration, .. } = answer;
    let head = message!(
        "terminal_calibrated",
        imu = imu.clone(),
        station = station.clone(),
        at = measured_at.clone(),
        dwells = calibration.dwells,
        model = calibration.model.join(", ")
    );
    let mut text = format!("{}\n\n", said(head));
    text.push_str(&fit_table(&calibration.gyros));
    text.push_str(&parameter_table(&calibration.gyros));
    text.push_str(&residual_table(campaign, &calibration.gyros));
    if let Outcome::Imu { calibration, separations, .. } = outcome {
        let separated = calibration.gyros.iter().zip(separations);
        let rows: Vec<_> = separated.filter_map(|(g, s)| Some((g.serial.as_str(), s.as_ref().ok()?))).collect();
        if !rows.is_empty() {
            text.push_str(&drift_and_mounting(rows.into_iter()));
            text.push('\n');
            text.push_str(&uncertainty_table(answer));
        }
    }
    for remark in remarks(fitted) {
        text.push('\n');
        text.push_str(&remark);
    }
    text
}

/// What the standard deviations of D_I and D_S are made of.
fn uncertainty_table(answer: &CampaignAnswer) -> String {
    let mut parts = table_of("terminal_uncertainties_head", 2..9);
    for separation in &answer.separations {
        let Some(uncertainty) = &separation.uncertainty else { continue };
        let of = [("D_I", separation.d_i, uncertainty.d_i), ("D_S", separation.d_s, uncertainty.d_s)];
        for (name, figure, u) in of {
            let cell = |sd: Option<f64>| sd.map_or("-".to_owned(), |sd| format!("{sd:.6}"));
            let sds = [Some(u.statistical), u.levelling, u.azimuth, u.fixture, u.discrepancy, Some(u.combined)];
            let gyro = separation.slot.name().to_owned();
            parts.add_row([gyro, name.to_owned(), cell(figure.sd)].into_iter().chain(sds.map(cell)));
        }
    }
    let stated = if answer.calibration.station_uncertainty.stated {
        String::new()
    } else {
        format!("{}\n", word("terminal_uncertainties_unstated"))
    };
    format!("\n{}\n{parts}\n{stated}", word("terminal_uncertainties"))
}

fn fit_table(gyros: &[GyroFitBody]) -> String {
    let mut fits = table_of("terminal_fit_head", 3..8);
    for gyro in gyros {
        let noise = &gyro.noise;
        let factor = match (noise.sem_factor, noise.sem_factor_sd) {
            (Some(f), Some(sd)) if sd > 0.0 => {
                let (source, factor) = (noise.source.clone(), format!("{f:.2} ± {sd:.2}"));
                said(message!("terminal_fit_source", source, factor))
            }
            _ => noise.source.clone(),
        };
        let optional = |value: Option<f64>, digits: usize| value.map_or("-".to_owned(), |v| format!("{v:.digits$}"));
        fits.add_row([
            gyro.slot.name().to_owned(),
            gyro.serial.clone(),
            gyro.e_source.clone(),
            part_of(gyro.rank.to_string(), gyro.parameters.len() as u64),
            gyro.dof.to_string(),
            optional(gyro.reduced_chi2, 2),
            gyro.p_value.map_or("-".to_owned(), |p| format!("{p:.2e}")),
            optional(noise.rms_deg_per_h, 5),
            factor,
        ]);
    }
    let gauges: Vec<String> = gyros.iter().flat_map(|g| &g.null_directions).filter_map(|n| n.gauge.clone()).collect();
    let gauge = gauges
        .first()
        .map_or(String::new(), |gauge| format!("{}\n", said(message!("terminal_gauge", gauge = gauge.clone()))));
    format!("{}\n{fits}\n{gauge}\n", word("terminal_fit"))
}

fn parameter_table(gyros: &[GyroFitBody]) -> String {
    let mut parameters = table_of("terminal_parameters_head", 2..3);
    for gyro in gyros {
        for p in &gyro.parameters {
            let remark = if p.determined { "" } else { word("terminal_not_determined") };
            parameters.add_row([
                gyro.slot.name().to_owned(),
                p.name.clone(),
                figure(p.value, p.sd),
                unit::of_people(&p.unit),
                remark.to_owned(),
            ]);
        }
        for e in &gyro.effects {
            parameters.add_row([
                gyro.slot.name().to_owned(),
                format!("{} {}", e.effect, e.name),
                coefficient(e.value, e.sd),
                unit::of_people(&e.unit),
                word("terminal_effect").to_owned(),
            ]);
        }
    }
    format!("{}\n{parameters}\n\n", word("terminal_parameters"))
}

/// The dwells that fit worst, over all gyros.
fn residual_table(campaign: &Campaign, gyros: &[GyroFitBody]) -> String {
    let mut worst: Vec<(f64, &GyroFitBody, usize)> = gyros
        .iter()
        .flat_map(|g| g.residuals.standardised.iter().flatten().enumerate().map(move |(k, r)| (*r, g, k)))
        .collect();
    worst.sort_by(|a, b| b.0.abs().total_cmp(&a.0.abs()));
    if worst.is_empty() {
        return String::new();
    }
    let mut residuals = table_of("terminal_residuals_head", 3..7);
    for (standardised, gyro, k) in worst.into_iter().take(SHOWN_RESIDUALS) {
        let list = &gyro.residuals;
        residuals.add_row([
            k.to_string(),
            gyro.slot.name().to_owned(),
            campaign.dwells[k].phase.name().to_owned(),
            format!("{:+.6}", list.pulse_per_s[k]),
            list.deg_per_h.as_ref().map_or("-".to_owned(), |d| format!("{:+.6}", d[k])),
            format!("{standardised:+.2}"),
            format!("{:.3}", list.leverage[k]),
        ]);
    }
    format!("{}\n{residuals}\n\n", word("terminal_residuals"))
}
