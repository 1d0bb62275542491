//! `separate`: one record in, its drift coefficients out. Nothing is stored; what is judged is E and G against what
//! is required of them, which takes no history.

use comfy_table::Table;

use super::settings;
use crate::cli::prelude::*;
use crate::config::Judging;
use crate::core::fault::{Fault, Faults};
use crate::core::judge::{State, Verdict};
use crate::core::record::{GyroParameters, Record};
use crate::core::separate::{JudgedMethod, NotPublished, Published, Separation, separate, stated_covariance};
use crate::pages::figure::with_sd;
use crate::wire::answer::{RecordAnswer, SeparationBody, VerdictBody};
use crate::wire::document::DocumentKind;
use crate::wire::record::parse_record;
use crate::words::asked;

/// Separate D_I and D_S of the gyros of one calibration record
#[derive(Debug, clap::Args)]
pub struct Separate {
    /// The record, in JSON; `-` is standard input
    record: PathBuf,

    /// In the JSON: the method of d_i and d_s; the other is always reported beside it
    #[arg(long, value_enum, default_value_t)]
    method: SeparationMethod,

    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum SeparationMethod {
    /// The nominal triad carried along to the measured input axis
    #[default]
    Rigid,
    /// Equations (7) to (13) of the paper, its errata applied
    Published,
}

impl From<SeparationMethod> for JudgedMethod {
    fn from(method: SeparationMethod) -> Self {
        match method {
            SeparationMethod::Rigid => Self::Rigid,
            SeparationMethod::Published => Self::Published,
        }
    }
}

/// Refuses a document that shows itself to be of another kind than `wanted`.
pub(super) fn check_kind(wanted: DocumentKind, bytes: &[u8], file: impl Fn() -> String) -> anyhow::Result<()> {
    let instead = match DocumentKind::instead_of(wanted, bytes) {
        Some(DocumentKind::Campaign) => message!("terminal_is_campaign"),
        Some(DocumentKind::Record) => message!("terminal_is_record"),
        Some(DocumentKind::Bench) => message!("terminal_is_bench_result"),
        None => return Ok(()),
    };
    bail!("{}: {}", file(), said(instead))
}

impl Separate {
    pub fn run(self) -> anyhow::Result<()> {
        let bytes = document::read(&self.record)?;
        let file = || document::name(&self.record);
        check_kind(DocumentKind::Record, &bytes, file)?;
        let mut config = settings::config()?;
        // The comparison with the paper's tables is for the reader; what is configured for the fleet goes before it.
        config.judging.requirements = true;
        let record = parse_record(&bytes, &config.plausibility.limits()).with_context(file)?;
        let separations = separate_all(&record).with_context(file)?;
        let verdicts: Vec<_> = record.gyros.iter().map(|gyro| required(&record, gyro, &config.judging)).collect();
        self.format
            .show(&answer(&record, &separations, &verdicts, self.method), || tables(&record, &separations, &verdicts))
    }
}

/// On E and G, where something is required of them.
type Requirements = [Option<Verdict>; 2];

fn required(record: &Record, gyro: &GyroParameters, judging: &Judging) -> Requirements {
    let (whose, sds) = ((gyro.slot, &record.imu, &gyro.serial), (gyro.e_sd.as_ref(), gyro.g_sd.as_ref()));
    judging.of_parameters(&record.geometry, whose, (&gyro.e, &gyro.g), sds)
}

fn separate_all(record: &Record) -> Result<Vec<Separation>, Faults> {
    let one = |(i, gyro): (usize, &GyroParameters)| {
        separate(&record.geometry, gyro.slot, &gyro.e, &gyro.g, stated_covariance(gyro).as_ref())
            .map_err(|why| Fault { pointer: format!("/gyros/{i}"), message: why.message() }.into())
    };
    record.gyros.iter().enumerate().map(one).collect()
}

fn answer(
    record: &Record,
    separations: &[Separation],
    verdicts: &[Requirements],
    method: SeparationMethod,
) -> RecordAnswer {
    let body = |(gyro, s): (&GyroParameters, _)| SeparationBody::of(gyro.serial.as_str(), s, method.into());
    let separations = record.gyros.iter().zip(separations).map(body).collect();
    let said = |(gyro, verdicts): (&GyroParameters, &Requirements)| {
        verdicts.iter().flatten().map(|verdict| VerdictBody::of(gyro.serial.as_str(), verdict)).collect::<Vec<_>>()
    };
    let verdicts = record.gyros.iter().zip(verdicts).flat_map(said).collect();
    RecordAnswer { id: None, separations, notes: Vec::new(), verdicts }
}

fn tables(record: &Record, separations: &[Separation], verdicts: &[Requirements]) -> String {
    let (imu, station) = (record.imu.to_string(), record.station.to_string());
    let at = time::format(record.calibrated_at);
    let head = said(message!("terminal_separated", imu, station, at));
    let rows = record.gyros.iter().zip(separations).map(|(gyro, s)| (gyro.serial.as_str(), s));
    let requirements = requirement_table(record.gyros.iter().zip(verdicts));
    format!("{head}\n\n{}{requirements}", drift_and_mounting(rows))
}

/// How E and G keep to what is required of them, and below the table why where they do not; empty where nothing is
/// required.
fn requirement_table<'a>(gyros: impl Iterator<Item = (&'a GyroParameters, &'a Requirements)>) -> String {
    let (mut statuses, mut reasons) = (table_of("terminal_requirements_head", 4..4), String::new());
    for (gyro, verdicts) in gyros.filter(|(_, verdicts)| verdicts.iter().any(Option::is_some)) {
        let (slot, serial) = (gyro.slot.name(), gyro.serial.as_str());
        let [e, g] = verdicts.map(|verdict| verdict.map_or("-", |verdict| word(&verdict.status().word().code)));
        statuses.add_row([slot, serial, e, g]);
        for verdict in verdicts.iter().flatten().filter(|verdict| verdict.state != State::Within) {
            reasons.push_str(&format!("\n{slot} {serial}: {}", asked().reason(verdict)));
        }
    }
    if statuses.is_empty() {
        String::new()
    } else {
        format!("\n\n{}\n{statuses}{reasons}", word("terminal_requirements"))
    }
}

/// Two tables: drift coefficients by every method, and the mounting, for gyros given by serial.
pub(super) fn drift_and_mounting<'a>(gyros: impl Iterator<Item = (&'a str, &'a Separation)>) -> String {
    let mut drift = table_of("terminal_drift_head", 3..6);
    let mut mounting = table_of("terminal_mounting_head", 1..7);
    for (serial, s) in gyros {
        add_drift_rows(&mut drift, serial, s);
        let alpha = s.alpha.map(|a| format!("{:.6}", a.to_degrees()));
        let [x, y, z] = alpha;
        let (off, clocking) = (s.misalignment.to_degrees() * 60.0, s.rigid.clocking().to_degrees());
        let scale = format!("{:.6}", s.scale_factor);
        mounting.add_row([s.slot.name().into(), scale, x, y, z, format!("{off:.3}'"), format!("{clocking:+.4}")]);
    }
    let [drifts, mountings] = ["terminal_drift", "terminal_mounting"].map(word);
    format!("{drifts}\n{drift}\n\n{mountings}\n{mounting}")
}

fn add_drift_rows(table: &mut Table, serial: &str, s: &Separation) {
    let (slot, serial) = (s.slot.name().to_owned(), serial.to_owned());
    let [i_sd, s_sd, o_sd] = s.rigid.sd().map_or([None; 3], |sd| sd.map(Some));
    let r = &s.rigid;
    let figures = [figure(r.d_i, i_sd), figure(r.d_s, s_sd), figure(r.d_o, o_sd)];
    let [d_i, d_s, d_o] = figures;
    table.add_row([slot, serial, word("method_rigid").into(), d_i, d_s, d_o, "D_O".into()]);
    for (name, published) in [("terminal_published", &s.published), ("terminal_as_printed", &s.as_printed)] {
        table.add_row(published_row(word(name), published));
    }
}

fn published_row(name: &str, published: &Result<Published, NotPublished>) -> [String; 7] {
    let blank = String::new;
    match published {
        Ok(p) => {
            let [i_sd, s_sd] = p.sd().map_or([None; 2], |sd| sd.map(Some));
            let method = format!("{name} ({})", p.branch.name());
            let closure = format!("{:.6}", p.closure_rms);
            [blank(), blank(), method, figure(p.d_i, i_sd), figure(p.d_s, s_sd), closure, word("terminal_rms").into()]
        }
        Err(why) => {
            let why = word(match why {
                NotPublished::Geometry => "terminal_not_skewed",
                NotPublished::Degenerate => "terminal_directions_coincide",
            });
            [blank(), blank(), name.into(), "-".into(), "-".into(), "-".into(), why.into()]
        }
    }
}

/// Decimals of a figure whose standard deviation is not known.
const DECIMALS: usize = 6;

/// The value with its sign, and its standard deviation where it is known: both as far as two digits of it go, as on
/// the pages.
pub(super) fn figure(value: f64, sd: Option<f64>) -> String {
    let mut text = with_sd(value, sd, DECIMALS);
    if value >= 0.0 {
        // With a power of ten for both, the two stand in a bracket.
        text.insert(usize::from(text.starts_with('(')), '+');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::figure;

    #[test]
    fn a_figure_has_the_digits_that_its_standard_deviation_needs() {
        for (value, sd, text) in [
            (0.8473, Some(1.2e-7), "+0.84730000 ± 0.00000012"),
            (-0.6011, Some(2.5e-4), "-0.60110 ± 0.00025"),
            (2.957643, None, "+2.957643"),
            (-2.957643, None, "-2.957643"),
            (1.108e-6, Some(8.7e-8), "(+1.108 ± 0.087)e-6"),
            (-1.108e-6, Some(8.7e-8), "(-1.108 ± 0.087)e-6"),
            (0.0, None, "+0.000000"),
            (-1e-7, Some(2.2e-4), "0.00000 ± 0.00022"),
        ] {
            assert_eq!(figure(value, sd), text);
        }
    }
}
