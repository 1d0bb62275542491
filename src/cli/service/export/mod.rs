//! `export`: the history of every gyro as one file, for those who analyse elsewhere.

mod columns;
mod csv;
#[cfg(feature = "parquet")]
mod parquet;

use std::fs::File;
use std::io::BufWriter;
use std::sync::Arc;

use anyhow::anyhow;
use clap::ValueEnum;

use self::columns::ExportRow;
use self::csv::Csv;
#[cfg(feature = "parquet")]
use self::parquet::Parquet;
use super::settings::ConfigArgs;
use crate::cli::common::{Usage, block_on, end, start};
use crate::cli::prelude::*;
use crate::core::figures::Figures;
use crate::core::time::{Span, UtcMicros};
use crate::pipeline::Statuses;
use crate::store::{self, Store};

/// Write the history of every gyro into one file, CSV or Parquet: one row per gyro and calibration, all methods, all
/// verdicts
#[derive(Debug, Args)]
pub struct Export {
    /// The file to write; it must not exist. What follows its last dot says the form, unless --format does
    file: PathBuf,
    #[arg(long)]
    format: Option<ExportFormat>,
    /// Only this gyro; repeat for several
    #[arg(long = "serial", value_name = "SERIAL")]
    serials: Vec<String>,
    /// Oldest instant, RFC 3339 or a day (UTC), itself included
    #[arg(long, value_name = "TIME", value_parser = start)]
    from: Option<UtcMicros>,
    /// Newest instant, itself included
    #[arg(long, value_name = "TIME", value_parser = end)]
    to: Option<UtcMicros>,
    /// Also what was voided or revised, flagged in the column `voided`
    #[arg(long)]
    voided: bool,
    #[command(flatten)]
    config: ConfigArgs,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ExportFormat {
    Csv,
    Parquet,
}

/// Rows of one read: a gyro may have a hundred thousand.
const BLOCK: usize = 8192;

impl Export {
    pub fn run(self) -> anyhow::Result<()> {
        let form = self.form()?;
        let database = self.config.load()?.database;
        let file = File::create_new(&self.file).with_context(|| self.file.display().to_string())?;
        let written = block_on(async {
            let store = store::open_to_read(&database.options())
                .await
                .with_context(|| said(message!("terminal_database", url = database.options().shown())))?;
            let written = self.write(&store, Sink::new(form, file)?).await;
            store.close().await;
            written
        });
        if written.is_err() {
            let _may_be_gone = std::fs::remove_file(&self.file);
        }
        let (rows, gyros) = written?;
        let exported = message!("terminal_exported", rows = rows.to_string(), gyros = gyros.to_string());
        eprintln!("{}: {}", self.file.display(), said(exported));
        Ok(())
    }

    fn form(&self) -> anyhow::Result<ExportFormat> {
        let named = || {
            let ending = self.file.extension().and_then(|ending| ending.to_str());
            ending.and_then(|ending| ExportFormat::from_str(ending, true).ok())
        };
        let unsaid = || Usage(said(message!("terminal_export_form", file = self.file.display().to_string())));
        Ok(self.format.or_else(named).ok_or_else(unsaid)?)
    }

    /// Rows and gyros that were written.
    async fn write(&self, store: &Store, mut sink: Sink) -> anyhow::Result<(usize, usize)> {
        let (mut rows, mut gyros) = (0, 0);
        for (gyro, serial) in self.gyros(store)? {
            let before = rows;
            let mut span = Span { from: self.from.unwrap_or(Span::EVER.from), to: self.to.unwrap_or(Span::EVER.to) };
            if self.voided {
                let voided = store::history::voided(store, gyro, span).await?;
                let statuses = Statuses::of(store, gyro, voided.iter(), &[0, 1, 2]).await?;
                rows += sink.write(named(store, &serial, &voided, &statuses, true)?)?;
            }
            loop {
                let block = store::history::oldest(store, gyro, span, BLOCK).await?;
                let statuses = Statuses::of(store, gyro, block.iter(), &[0, 1, 2]).await?;
                rows += sink.write(named(store, &serial, &block, &statuses, false)?)?;
                match block.last() {
                    Some(last) if block.len() == BLOCK => span.from = UtcMicros(last.at.0 + 1),
                    _ => break,
                }
            }
            gyros += usize::from(rows > before);
        }
        sink.finish()?;
        Ok((rows, gyros))
    }

    /// By number and serial, in the order of serials.
    fn gyros(&self, store: &Store) -> anyhow::Result<Vec<(u32, Arc<str>)>> {
        let tables = store.names().read();
        if let Some(unknown) = self.serials.iter().find(|serial| tables.gyros.number(serial).is_none()) {
            bail!(said(message!("unknown_gyro", serial = unknown.clone())));
        }
        let asked = || self.serials.iter().filter_map(|serial| tables.gyros.number(serial));
        let mut numbers = if self.serials.is_empty() { tables.gyros.numbers() } else { asked().collect() };
        numbers.sort_by_key(|number| tables.gyros.text(*number));
        numbers.dedup();
        Ok(numbers.into_iter().map(|number| (number, tables.gyros.text(number).into())).collect())
    }
}

/// The rows of a gyro with the names that their numbers stand for.
fn named(
    store: &Store,
    serial: &Arc<str>,
    block: &[Figures],
    statuses: &Statuses,
    voided: bool,
) -> anyhow::Result<Vec<ExportRow>> {
    let tables = store.names().read();
    let rows = block.iter().map(|figures| {
        let nameless = || anyhow!(said(message!("terminal_nameless", record = figures.record.to_string())));
        Ok(ExportRow {
            serial: serial.clone(),
            imu: tables.imus.name(figures.imu).map(Arc::from).ok_or_else(nameless)?,
            station: tables.stations.name(figures.station).map(Arc::from).ok_or_else(nameless)?,
            figures: *figures,
            statuses: [0, 1, 2].map(|column| statuses.get(figures, column)),
            status: statuses.worst(figures),
            voided,
        })
    });
    rows.collect()
}

/// Where rows go.
enum Sink {
    Csv(Csv<BufWriter<File>>),
    #[cfg(feature = "parquet")]
    Parquet(Parquet),
}

impl Sink {
    fn new(form: ExportFormat, file: File) -> anyhow::Result<Self> {
        match form {
            ExportFormat::Csv => Ok(Self::Csv(Csv::new(BufWriter::new(file))?)),
            #[cfg(feature = "parquet")]
            ExportFormat::Parquet => Ok(Self::Parquet(Parquet::new(file)?)),
            #[cfg(not(feature = "parquet"))]
            ExportFormat::Parquet => {
                bail!(said(message!("terminal_no_parquet")))
            }
        }
    }

    fn write(&mut self, rows: Vec<ExportRow>) -> anyhow::Result<usize> {
        let count = rows.len();
        match self {
            Self::Csv(csv) => csv.write(&rows)?,
            #[cfg(feature = "parquet")]
            Self::Parquet(parquet) => parquet.write(rows)?,
        }
        Ok(count)
    }

    fn finish(self) -> anyhow::Result<()> {
        match self {
            Self::Csv(csv) => csv.finish(),
            #[cfg(feature = "parquet")]
            Self::Parquet(parquet) => parquet.finish(),
        }
    }
}
