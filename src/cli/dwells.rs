//! `dwells`: raw logs of a station in, the campaign of their dwells out. Nothing is stored.

use super::Usage;
use super::prelude::*;
use crate::core::campaign::Campaign;
use crate::core::fault::{Fault, Faults};
use crate::logs::campaign::{LogCampaign, campaign_of};
use crate::logs::error::LogError;
use crate::logs::guess::{answered, guess};
use crate::logs::map::Map;
use crate::logs::report::report;
use crate::logs::text::of_any;
use crate::wire::campaign::to_json;
use crate::wire::campaign_csv::to_csv;
use crate::wire::differences::counted;
use crate::words;

/// Make a campaign from raw logs: find what is still and what turns, average it, and say how far the means are known
///
/// LOG is a table of samples: CSV of any delimiter, MAT (version 5 to 7), xlsx, NumPy (.npy, .npz), or Parquet in a
/// program built to read it. The map says once which columns are what (docs/stations.md); --guess writes a first one.
/// Logs follow one another, or run beside one another where the map says `log = 2`.
#[derive(Debug, clap::Args)]
pub struct Dwells {
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,

    /// What the columns are, in TOML
    #[arg(long, value_name = "FILE", required_unless_present = "guess")]
    map: Option<PathBuf>,

    /// What the table was told: 24 (six faces in four headings), or a table (CSV, xlsx) of positions and turns
    #[arg(long, value_name = "24|FILE")]
    programme: Option<String>,

    /// Print a map for the logs, with reasons, to be checked
    #[arg(long, conflicts_with_all = ["map", "programme", "report"])]
    guess: bool,

    /// Write the campaign here (CSV where the name ends in .csv) instead of to standard output
    #[arg(short, long, value_name = "FILE")]
    out: Option<PathBuf>,

    /// Also write a page that shows the intervals over the signals, in HTML
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,

    /// In place of the map's
    #[arg(long)]
    imu: Option<String>,

    /// In place of the map's
    #[arg(long)]
    station: Option<String>,

    /// In place of the map's: RFC 3339, with offset
    #[arg(long)]
    measured_at: Option<String>,

    /// In place of the map's: "G1 LFG-0101, G2 LFG-0102"
    #[arg(long, value_delimiter = ',')]
    gyros: Vec<String>,
}

impl Dwells {
    pub fn run(self) -> anyhow::Result<()> {
        if self.guess {
            let map = guess(&self.logs, words::asked())?;
            return match &self.out {
                Some(path) => document::write(path, &map),
                None => document::print(map.trim_end()),
            };
        }
        let map = self.map()?;
        let made = campaign_of(&self.logs, &map, self.programme.as_deref())?;
        if let Some(path) = &self.report {
            let names: Vec<_> = self.logs.iter().map(|path| document::name(path)).collect();
            document::write(path, &report(&made, &names.join(", "), words::asked()))?;
        }
        say(&made);
        match made.campaign() {
            Ok(campaign) => self.write(&campaign),
            Err(faults) => bail!("{}: {}", document::name(&self.logs[0]), by_dwell(&faults)),
        }
    }

    fn map(&self) -> anyhow::Result<Map> {
        let Some(path) = &self.map else {
            return Err(Usage(said(message!("parameter_missing", parameter = "--map"))).into());
        };
        let fail = |fault| LogError::new(document::name(path), fault);
        let text = of_any(&document::read(path)?);
        answered(&text).map_err(fail)?;
        let mut map = Map::parse(&text).map_err(fail)?;
        map.imu = self.imu.clone().or(map.imu);
        map.station = self.station.clone().or(map.station);
        map.measured_at = self.measured_at.clone().or(map.measured_at);
        if !self.gyros.is_empty() {
            map.gyros.clone_from(&self.gyros);
        }
        Ok(map)
    }

    fn write(&self, campaign: &Campaign) -> anyhow::Result<()> {
        let Some(path) = &self.out else { return document::print(&to_json(campaign)) };
        let is_csv = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("csv"));
        document::write(path, &if is_csv { to_csv(campaign) } else { to_json(campaign) + "\n" })
    }
}

/// Faults of a document that nobody wrote, by dwell and figure.
fn by_dwell(faults: &Faults) -> String {
    let one = |fault: &Fault| match counted(&fault.pointer).as_str() {
        "" => said(&fault.message),
        place => format!("{place}: {}", said(&fault.message)),
    };
    faults.0.iter().map(one).collect::<Vec<_>>().join("\n  ")
}

/// What was found, on standard error: the campaign may be on standard output.
fn say(made: &LogCampaign) {
    let rounded =
        |values: &[f64], digits: usize| values.iter().map(|v| format!("{v:.digits$}")).collect::<Vec<_>>().join(" ");
    let mut table = table_of("terminal_dwells_head", 0..7);
    for (k, d) in made.dwells.iter().enumerate() {
        table.add_row([
            (k + 1).to_string(),
            d.commanded.phase.name().to_owned(),
            rounded(&[d.start_s], 1),
            rounded(&[d.duration_s], 1),
            rounded(d.commanded.force_g0.as_slice(), 4),
            rounded(&d.output, 4),
            rounded(&d.output_sem, 4),
        ]);
    }
    eprintln!("{table}");
    for remark in &made.remarks {
        eprintln!("{}", document::note(&said(remark)));
    }
}
