//! `diagnose`: where a campaign and the error model part, which unmodelled effect parts them, how far the gap shrinks.

use super::predict::against_model;
use super::{diagnose_all, diagnose_gyro, diagnose_record, hypothesis, model, settings};
use crate::cli::document::{coefficient, verdict};
use crate::cli::prelude::*;
use crate::core::augmented::{AugmentedModel, Options};
use crate::core::calibrate::outcome::check_scales;
use crate::core::campaign::Campaign;
use crate::core::diagnose::{Diagnosis, FALSE_ALARM, Reference, diagnose, may_be_split, split};
use crate::core::imu_model::changed_since;
use crate::core::message::list;
use crate::pages::{Subject, diagnosis_report};
use crate::wire::campaign::parse_json;
use crate::wire::diagnosis::{DiagnosisBody, TableBody};
use crate::wire::document::{DocumentKind, is_csv, parse};
use crate::wire::forecast::ChangedBody;
use crate::wire::record::parse_record;
use crate::wire::split::SplitBody;
use crate::wire::{self, unit};
use crate::words::asked;

/// Diagnose the gap between a campaign and the error model, or all campaigns of a running service
#[derive(Debug, clap::Args)]
pub struct Diagnose {
    /// The campaign, in JSON or CSV, or a calibration record, whose closure is then diagnosed; `-` is standard input
    #[arg(required_unless_present_any = ["all", "gyro"])]
    campaign: Option<PathBuf>,

    /// The error model in use: terms of bias, g_linear, g_squared, scale, parted by commas, or a model file
    /// [default: the campaign's own terms, or all]
    #[arg(long, value_name = "TERMS|FILE", value_parser = model::choice)]
    model: Option<model::Choice>,

    /// A hypothesis of one's own, in TOML: an equation for the drift, which then competes with the catalogue. Several
    /// compete together (docs/how-to/own-hypothesis.md)
    #[arg(long, value_name = "FILE", conflicts_with_all = ["all", "gyro"])]
    hypothesis: Vec<PathBuf>,

    /// Write the model in use with what is named added to it: a model file for --model
    #[arg(long, value_name = "FILE")]
    adopt: Option<PathBuf>,

    /// Also write a report that needs nothing else, in HTML
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,

    /// An earlier campaign or calibration record of the IMU: also say how much of the gap is parameters that have
    /// moved since, how much is structure and how much noise
    #[arg(long, value_name = "FILE")]
    reference: Option<PathBuf>,

    #[arg(long, value_enum, default_value_t)]
    format: Format,

    /// Instead of a file: have a running service (--url) diagnose its stored campaigns, those that are up to date
    /// left alone, and print what all of them say together: which effects, in which gyros, at which stations, since
    /// when. Breaking off loses nothing: the service goes on, and the same command finds the order again
    #[arg(long, conflicts_with_all = ["campaign", "model", "adopt", "report", "reference"])]
    all: bool,

    /// Instead of a file: why the coefficients of this gyro changed over its history, as a running service (--url)
    /// says it with the fleet beside it: its station, ageing, an event, temperature, a step, or nothing
    #[arg(long, value_name = "SERIAL",
        conflicts_with_all = ["campaign", "model", "adopt", "report", "reference", "all"])]
    gyro: Option<String>,

    #[command(flatten)]
    fleet: diagnose_all::FleetArgs,
}

impl Diagnose {
    pub fn run(self) -> anyhow::Result<()> {
        match (&self.campaign, &self.gyro) {
            (Some(path), _) => self.one(path),
            (None, Some(serial)) => diagnose_gyro::run(serial, &self.fleet, self.format),
            (None, None) => diagnose_all::run(&self.fleet, self.format),
        }
    }

    fn one(&self, path: &Path) -> anyhow::Result<()> {
        let file = || document::name(path);
        let bytes = document::read(path)?;
        if is_record(&bytes) {
            let of_dwells = [&self.adopt, &self.report, &self.reference].into_iter().any(Option::is_some);
            if of_dwells || self.model.is_some() || !self.hypothesis.is_empty() {
                bail!("{}: {}", file(), word("terminal_record_without_dwells"));
            }
            return diagnose_record::run(&bytes, self.format).with_context(file);
        }
        let campaign = settings::campaign(path, &bytes)?;
        if let Some(path) = &self.adopt {
            model::may_be_replaced(path)?;
        }
        let in_use = model::chosen(self.model.as_ref())?;
        let hypotheses = hypothesis::files(&self.hypothesis, &in_use)?;
        hypothesis::defined_in(&hypotheses, &campaign).with_context(file)?;
        let options = Options { hypotheses, ..in_use.options(&campaign) };
        let diagnosed = diagnose(&campaign, &options).with_context(file)?;
        let mut diagnosis = DiagnosisBody::from(&diagnosed).noted(in_use.notes_of_others(&campaign));
        diagnosis.effects_against_model = changed_since(&in_use, &campaign).map(|changed| ChangedBody::from(&changed));
        if let Some(path) = &self.reference {
            let parts = split(&campaign, &options, &diagnosed.residuals, &reference(path, &campaign)?);
            diagnosis.reference = Some(SplitBody::from(&parts.with_context(|| document::name(path))?));
        }
        if let Some(path) = &self.report {
            let page = diagnosis_report(&Subject::of(&campaign), &diagnosis, asked());
            document::write(path, &page)?;
        }
        if let Some(path) = &self.adopt {
            adopt(path, &in_use, &campaign, &diagnosed)?;
        }
        self.format.show(&diagnosis, || tables(&campaign, &diagnosis))
    }
}

/// A campaign, or a record. That it is no reference for `campaign` is said before what its outputs contradict.
fn reference(path: &Path, campaign: &Campaign) -> anyhow::Result<Reference> {
    let bytes = document::read(path)?;
    let file = || document::name(path);
    if is_record(&bytes) {
        return parse_record(&bytes, &settings::plausibility()?).map(Reference::Record).with_context(file);
    }
    document::note_open_end(path, &bytes);
    let limits = settings::plausibility()?;
    let possible = |other: Campaign| check_scales(&other, &limits).map(|()| Reference::Campaign(other));
    parse(&bytes).and_then(possible).or_else(|faults| {
        if let Ok(other) = parse_json(&bytes).map(Reference::Campaign) {
            may_be_split(campaign, &other).with_context(file)?;
        }
        Err(faults).with_context(file)
    })
}

/// A document with the time or the E of a record and no dwells; whatever else is no campaign is refused as one.
fn is_record(bytes: &[u8]) -> bool {
    !is_csv(bytes) && DocumentKind::is_record(bytes)
}

/// Writes the model in use with what was named, and says on standard error what it holds. Only a model file is
/// replaced: a name mistyped must not cost a campaign.
fn adopt(path: &Path, in_use: &AugmentedModel, campaign: &Campaign, diagnosed: &Diagnosis) -> anyhow::Result<()> {
    document::write(path, &(wire::model::to_json(&in_use.adopting(campaign, diagnosed)) + "\n"))?;
    let named: Vec<&str> = diagnosed.effects.iter().map(|e| e.effect.id()).collect();
    let what = if named.is_empty() { word("terminal_nothing_adopted").to_owned() } else { named.join(", ") };
    eprintln!("{}: {what}", path.display());
    Ok(())
}

fn tables(campaign: &Campaign, d: &DiagnosisBody) -> String {
    let measured = message!(
        "terminal_measured_by",
        imu = campaign.imu.to_string(),
        station = campaign.station.to_string(),
        at = time::format(campaign.measured_at),
        verdict = verdict(&d.verdict)
    );
    let figure = |value: f64| format!("{value:.3e}");
    let gap = message!(
        "terminal_gap",
        floor = figure(d.noise_floor.deg_per_h),
        source = d.noise_floor.source.to_string(),
        gap = figure(d.gap.rms_deg_per_h),
        noise = figure(d.gap.noise_alone_deg_per_h),
        chi2 = format!("{:.2}", d.gap.reduced_chi2),
        p = format!("{:.1e}", d.gap.p_value)
    );
    let model = message!("terminal_model", terms = d.model.listed());
    let [measured, gap, model] = [measured, gap, model].map(said);
    let mut out = format!("{measured}\n{}\n\n{gap}\n{model}\n", d.verdict_in_words(asked()));
    let against = d.effects_against_model.as_ref().map(|changed| against_model(changed).trim().to_owned());
    let sections = [
        reference_parts(d),
        against,
        effects(d),
        impact(d),
        signs(d),
        candidates(d),
        within_noise(d),
        blind_spots(d),
        next(d),
    ];
    for section in sections.into_iter().flatten() {
        out.push('\n');
        out.push_str(&section);
        out.push('\n');
    }
    for note in &d.notes {
        out.push_str(&format!("\n{}", document::note(note)));
    }
    out
}

fn reference_parts(d: &DiagnosisBody) -> Option<String> {
    let split = d.reference.as_ref()?;
    let mut parts = table_of("terminal_split_head", 1..6);
    let all = [(word("terminal_all"), &split.all)].into_iter();
    for (slot, p) in all.chain(split.gyros.iter().map(|gyro| (gyro.slot.as_str(), &gyro.parts))) {
        let rms = [p.whole_deg_per_h, p.parameters_deg_per_h, p.structure_deg_per_h, p.noise_deg_per_h];
        let [whole, parameters, structure, noise] = rms.map(|x| format!("{x:.3e}"));
        parts.add_row([slot.to_owned(), whole, parameters, structure, noise, format!("{:.1e}", p.p_value)]);
    }
    let mut moved = table_of("terminal_moved_head", 2..5);
    for m in &split.moved {
        let shift = coefficient(m.shift, m.sd);
        let [reference, now] = [m.reference, m.now].map(|x| format!("{x:+.6}"));
        moved.add_row([m.slot.clone(), m.coefficient.clone(), reference, now, shift, unit::of_people(&m.unit)]);
    }
    let notes: String = split.notes.iter().map(|note| format!("\n{}", document::note(note))).collect();
    let (imu, station, at) = (split.imu.clone(), split.station.clone(), split.measured_at.clone());
    let against = said(message!("terminal_split", imu, station, at));
    Some(format!("{against}\n{parts}\n\n{}\n{moved}{notes}", word("terminal_moved")))
}

fn effects(d: &DiagnosisBody) -> Option<String> {
    let mut rows = table_of("terminal_effects_head", 3..4);
    for effect in &d.effects {
        let h = &effect.held_out;
        let others: Vec<&str> = effect.class.iter().map(String::as_str).filter(|id| *id != effect.effect).collect();
        let alone = effect.wider_in.iter().map(|wider| {
            let more = wider.class.iter().filter(|id| !effect.class.contains(id)).cloned();
            said(message!("terminal_alone", slot = wider.slot.clone(), effects = list(more)))
        });
        let others: Vec<String> = (!others.is_empty()).then(|| others.join(", ")).into_iter().chain(alone).collect();
        let [from, to] = h.interval.map(|end| format!("{end:.2}"));
        let interval = message!("terminal_to", from, to);
        let mut first = [
            effect.effect.clone(),
            effect.gyros.join(" "),
            format!("{:.2} ({})", h.closure, said(interval)),
            format!("{:.1e}", effect.p_value_adjusted),
            format!("{:.1}", effect.detectability),
            others.join("; "),
        ];
        for e in &effect.estimates {
            let [name, gyros, closure, p, detectability, class] = std::mem::take(&mut first);
            let parameter = format!("{} {}", e.slot, e.name);
            rows.add_row([
                name,
                gyros,
                parameter,
                coefficient(e.value, Some(e.sd)),
                unit::of_people(&e.unit),
                closure,
                p,
                detectability,
                class,
            ]);
        }
    }
    let (title, key) = (word("terminal_effects"), said(message!("terminal_effects_key")));
    (!d.effects.is_empty()).then(|| format!("{title}\n{rows}\n{key}"))
}

fn signs(d: &DiagnosisBody) -> Option<String> {
    let mut rows = table_of("terminal_signs_head", 2..3);
    for sign in &d.remaining.signs {
        rows.add_row([sign.in_words(asked()), sign.gyros.join(" "), format!("{:.1e}", sign.p_value)]);
    }
    (!d.remaining.signs.is_empty()).then(|| format!("{}\n{rows}", word("terminal_signs")))
}

fn candidates(d: &DiagnosisBody) -> Option<String> {
    let mut rows = table_of("terminal_candidates_head", 2..4);
    for c in d.candidates.iter().filter(|c| !c.within_noise) {
        let Some(closure) = c.closure else { continue };
        rows.add_row([
            c.effect.clone(),
            c.gyros.join(" "),
            format!("{closure:.2}"),
            format!("{:.1e}", c.p_value_adjusted),
            c.why_not.clone(),
        ]);
    }
    (!rows.is_empty()).then(|| format!("{}\n{rows}", word("terminal_candidates")))
}

/// What was tried and is no finding, in a few lines.
fn within_noise(d: &DiagnosisBody) -> Option<String> {
    let tried = d.candidates.iter().filter(|c| c.within_noise && c.closure.is_some());
    let tried: Vec<String> = tried.map(|c| format!("{} {:.2}", c.effect, c.p_value_adjusted)).collect();
    (!tried.is_empty()).then(|| {
        let title = message!("terminal_tried", level = FALSE_ALARM.to_string());
        format!("{}\n{}", said(title), lines(&tried))
    })
}

/// Words parted by commas, six to a line.
fn lines(words: &[String]) -> String {
    words.chunks(6).map(|line| format!("  {}", line.join(", "))).collect::<Vec<_>>().join(",\n")
}

fn impact(d: &DiagnosisBody) -> Option<String> {
    let mut rows = table_of("terminal_impact_head", 2..6);
    for (i, moved) in d.drift_before_and_after() {
        let figure = |value: f64, sd: Option<f64>| match sd {
            Some(sd) => format!("{value:+.6} ± {sd:.6}"),
            None => format!("{value:+.6}"),
        };
        let (plain, augmented) = (figure(i.plain, i.plain_sd), figure(i.augmented, Some(i.augmented_sd)));
        let shift = format!("{:+.6}", i.shift);
        rows.add_row([
            i.slot.clone(),
            i.coefficient.clone(),
            plain,
            augmented,
            shift,
            format!("{:.0} %", 100.0 * i.of_budget),
            word(if moved { "terminal_yes" } else { "terminal_within_noise" }).to_owned(),
        ]);
    }
    let told = !(d.impact.is_empty() && d.impact_within_noise.is_empty());
    told.then(|| format!("{}\n{rows}", word("terminal_impact")))
}

fn blind_spots(d: &DiagnosisBody) -> Option<String> {
    let mut rows = table_of("terminal_blind_head", 1..2);
    for n in &d.not_identifiable {
        let visible = format!("{:.0} %", 100.0 * n.visible_fraction);
        rows.add_row([n.effect.clone(), visible, n.reason.clone(), n.needs.clone()]);
    }
    (!d.not_identifiable.is_empty()).then(|| format!("{}\n{rows}", word("terminal_blind")))
}

fn next(d: &DiagnosisBody) -> Option<String> {
    let mut rows = table_of("terminal_next_head", 2..3);
    for n in &d.next_dwells {
        let Some(TableBody { up, north, rate_deg_s }) = &n.table else { continue };
        let (up, north) = (TableBody::direction(*up), TableBody::direction(*north));
        rows.add_row([up, north, format!("{rate_deg_s:.3}"), n.separates.join(", ")]);
    }
    (!d.next_dwells.is_empty()).then(|| format!("{}\n{rows}", word("terminal_next")))
}
