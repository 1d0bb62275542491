//! `template`: a worked example of each document that a station writes, to be filled with its own figures.

use std::io::{IsTerminal, Write};

use clap::ValueEnum;
use clap::builder::PossibleValue;
use rust_xlsxwriter::{Format, Workbook};

use super::Usage;
use super::prelude::*;
use crate::simulate::presets::preset;
use crate::simulate::{Scenario, simulate};
use crate::wire::campaign::CampaignBody;
use crate::wire::campaign_csv::body_to_csv;

const RECORD: &str = include_str!("../../examples/templates/record.json");
const BENCH: &str = include_str!("../../examples/templates/bench.json");
const RECORD_TABLE: &str = include_str!("../../examples/templates/record.csv");
const BENCH_TABLE: &str = include_str!("../../examples/templates/bench.csv");
const MAP: &str = include_str!("../../examples/maps/pulses-on-a-table.toml");

/// Print a worked example of a document, to be filled with your own figures
///
/// The campaign is a simulated one that fits: `gyrowatch template campaign | gyrowatch calibrate -`.
#[derive(Debug, clap::Args)]
pub struct Template {
    #[arg(value_enum)]
    of: TemplateOf,

    /// csv, json or xlsx; of a programme csv or xlsx; a map is TOML
    #[arg(long, value_enum)]
    format: Option<TemplateFormat>,

    /// Write it here; an xlsx file is not printed
    #[arg(short, long, value_name = "FILE")]
    out: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum TemplateOf {
    /// Dwells of an IMU
    Campaign,
    /// Parameters that the station has fitted itself
    Record,
    /// D_I and D_S of one gyro on a bench
    Bench,
    /// Positions and turns of the table, for `dwells --programme`
    Programme,
    /// Columns of a raw log, for `dwells --map`
    Map,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum TemplateFormat {
    Csv,
    Json,
    Xlsx,
    Toml,
}

impl Template {
    pub fn run(self) -> anyhow::Result<()> {
        let extension = self.out.as_deref().and_then(Path::extension);
        let of_name = extension.and_then(|e| TemplateFormat::from_str(e.to_str()?, false).ok());
        let usual = match self.of {
            TemplateOf::Campaign | TemplateOf::Programme => TemplateFormat::Csv,
            TemplateOf::Record | TemplateOf::Bench => TemplateFormat::Json,
            TemplateOf::Map => TemplateFormat::Toml,
        };
        let text = match (self.of, self.format.or(of_name).unwrap_or(usual)) {
            (TemplateOf::Campaign, TemplateFormat::Json) => serde_json::to_string(&example())? + "\n",
            (TemplateOf::Campaign, TemplateFormat::Csv) => body_to_csv(&example()),
            (TemplateOf::Campaign, TemplateFormat::Xlsx) => return self.sheet(&body_to_csv(&example())),
            (TemplateOf::Record, TemplateFormat::Json) => RECORD.to_owned(),
            (TemplateOf::Bench, TemplateFormat::Json) => BENCH.to_owned(),
            (TemplateOf::Record, TemplateFormat::Csv) => RECORD_TABLE.to_owned(),
            (TemplateOf::Bench, TemplateFormat::Csv) => BENCH_TABLE.to_owned(),
            (TemplateOf::Record, TemplateFormat::Xlsx) => return self.sheet(RECORD_TABLE),
            (TemplateOf::Bench, TemplateFormat::Xlsx) => return self.sheet(BENCH_TABLE),
            (TemplateOf::Programme, TemplateFormat::Csv) => programme(),
            (TemplateOf::Programme, TemplateFormat::Xlsx) => return self.sheet(&programme()),
            (TemplateOf::Map, TemplateFormat::Toml) => MAP.to_owned(),
            (of, wanted) => {
                let name = |value: Option<PossibleValue>| value.map_or_else(String::new, |v| v.get_name().to_owned());
                let (of, wanted) = (name(of.to_possible_value()), name(wanted.to_possible_value()));
                return Err(Usage(said(message!("terminal_no_template", of, format = wanted))).into());
            }
        };
        match &self.out {
            Some(path) => document::write(path, &text),
            None => document::print(text.trim_end()),
        }
    }

    /// The CSV as a sheet: a cell a value, head matter in one cell a line.
    fn sheet(&self, text: &str) -> anyhow::Result<()> {
        let mut book = Workbook::new();
        let sheet = book.add_worksheet();
        let bold = Format::new().set_bold();
        for (row, line) in (0_u32..).zip(text.lines()) {
            if line.starts_with('#') {
                sheet.write_string(row, 0, line)?;
                continue;
            }
            let is_head = line.split(',').all(|cell| cell.parse::<f64>().is_err());
            for (column, cell) in (0_u16..).zip(line.split(',')) {
                match cell.parse::<f64>() {
                    Ok(number) => sheet.write_number(row, column, number)?,
                    Err(_) if is_head => sheet.write_string_with_format(row, column, cell, &bold)?,
                    Err(_) => sheet.write_string(row, column, cell)?,
                };
            }
        }
        let bytes = book.save_to_buffer()?;
        match &self.out {
            Some(path) => std::fs::write(path, bytes).with_context(|| document::name(path)),
            None if std::io::stdout().is_terminal() => Err(Usage(word("terminal_workbook_out").to_owned()).into()),
            None => Ok(std::io::stdout().lock().write_all(&bytes)?),
        }
    }
}

/// A simulated campaign of the usual programme, always the same, in figures as a station writes them.
fn example() -> CampaignBody {
    let scenario = preset("24-position").expect("the preset is one of the list");
    // Beside the record's example and not in its place.
    let scenario = Scenario { imu: "IMU-08".to_owned(), measured_at: "2026-03-02T08:00:00Z".to_owned(), ..scenario };
    let mut body = CampaignBody::from(&simulate(&scenario).expect("the preset's scenario is sound").campaign);
    let written = |value: f64| (value * 1e9).round() / 1e9 + 0.0;
    if let Some(site) = &mut body.site {
        site.gravity_g0 = written(site.gravity_g0);
    }
    for dwell in &mut body.dwells {
        let lists = [&mut dwell.specific_force_g0, &mut dwell.rate_arcsec_s, &mut dwell.output_pulse_s];
        let optional = [&mut dwell.attitude, &mut dwell.output_sem_pulse_s].into_iter().filter_map(Option::as_mut);
        lists.into_iter().chain(optional).for_each(|list| *list = list.map(written));
        dwell.temperature_c = dwell.temperature_c.map(|t| (t * 1e3).round() / 1e3);
    }
    body
}

/// 24 positions, then each axis up, turned both ways by a whole turn of a degree a second.
fn programme() -> String {
    const AXES: [&str; 6] = ["+X", "-X", "+Y", "-Y", "+Z", "-Z"];
    let mut text = String::from(
        "# up, north: body axes that point up and north. rate_deg_s: turn about the vertical, + seen from above.\n",
    );
    text.push_str("# start_s, duration_s: by the station's clock; leave both columns out where it keeps none.\n");
    text.push_str("up,north,rate_deg_s,start_s,duration_s\n");
    let mut start = 0;
    let mut row = |up: &str, north: &str, rate: &str, duration: u32| {
        text.push_str(&format!("{up},{north},{rate},{start},{duration}\n"));
        start += duration + 60;
    };
    for up in AXES {
        for north in AXES.iter().filter(|north| north[1..] != up[1..]) {
            row(up, north, "0", 180);
        }
    }
    for up in AXES {
        let north = if up.ends_with('Z') { "+X" } else { "+Z" };
        for rate in ["1", "-1"] {
            // A quarter more than a turn: its edges are cut off.
            row(up, north, rate, 450);
        }
    }
    text
}
