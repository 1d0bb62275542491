//! The rows of the table `head`, by what is stored or about to be.

use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

use crate::config::Judging;
use crate::core::figures::Figures;
use crate::core::judge::{Need, Older, Outlook};
use crate::core::time::Span;
use crate::pipeline::ingest::judge::gyro_window::{GyroWindow, read_ahead};
use crate::pipeline::queries::standing::{Facts, StoredFacts};
use crate::store;
use crate::store::{Changes, HeadRow, NewName, Store, StoreError, Tables};
use crate::system::sha256;

/// Gyros whose histories are held at once.
const WINDOWS_AT_ONCE: usize = 128;

/// The names of what is stored, and of what a transaction adds.
pub(crate) struct HeadNames<'a> {
    tables: &'a Tables,
    /// Of IMUs, stations and gyros.
    new: [HashMap<u32, &'a str>; 3],
}

impl<'a> HeadNames<'a> {
    pub fn new(tables: &'a Tables, changes: &'a Changes) -> Self {
        let by_number = |names: &'a Vec<NewName>| names.iter().map(|new| (new.number, new.name.as_str()));
        let new = [&changes.imus, &changes.stations, &changes.gyros].map(|names| by_number(names).collect());
        Self { tables, new }
    }

    /// The serial of a gyro.
    pub fn gyro(&self, number: u32) -> Arc<str> {
        let stored = self.tables.gyros.name(number).cloned();
        stored.unwrap_or_else(|| self.new[2].get(&number).copied().unwrap_or_default().into())
    }

    pub fn row(&self, facts: &Facts<'_>, judging: &Judging) -> HeadRow {
        let names = facts.newest.map(|Figures { imu, station, .. }| {
            let name = |known: Option<&'a Arc<str>>, of: usize, number: u32| {
                known.map(|name| &**name).or_else(|| self.new[of].get(&number).copied()).unwrap_or_default()
            };
            (name(self.tables.imus.name(imu), 0, imu), name(self.tables.stations.name(station), 1, station))
        });
        let (imu, station) = names.unwrap_or_default();
        facts.head(judging, imu, station)
    }
}

/// The rows of some gyros by what is stored.
pub(crate) async fn stored_rows(store: &Store, judging: &Judging, gyros: &[u32]) -> Result<Vec<HeadRow>, StoreError> {
    let ever: Vec<_> = gyros.iter().map(|gyro| (*gyro, Span::EVER)).collect();
    let rows = store::histories::newest(store, &ever, 1).await?;
    let newest: Vec<(u32, Option<Figures>)> =
        gyros.iter().zip(rows).map(|(gyro, mut rows)| (*gyro, rows.pop())).collect();
    let outlooks = stored_outlooks(store, judging, &newest).await?;
    let stored = StoredFacts::of(store, &newest, outlooks).await?;
    let (tables, nothing_new) = (store.names().read(), Changes::default());
    let names = HeadNames::new(&tables, &nothing_new);
    let row =
        |(gyro, newest): &(u32, Option<Figures>)| names.row(&stored.facts(*gyro, names.gyro(*gyro), *newest), judging);
    Ok(newest.iter().map(row).collect())
}

/// How gyros with these newest calibrations lie to their budgets and where they go, judged anew by what is stored.
pub(crate) async fn stored_outlooks(
    store: &Store,
    judging: &Judging,
    newest: &[(u32, Option<Figures>)],
) -> Result<HashMap<u32, Outlook>, StoreError> {
    let need = Need::of(&judging.limits("", ""));
    let mut outlooks = HashMap::with_capacity(newest.len());
    for some in newest.chunks(WINDOWS_AT_ONCE) {
        let ever: Vec<_> = some.iter().map(|(gyro, _)| (*gyro, Span::EVER)).collect();
        let rows = store::histories::newest(store, &ever, read_ahead(need)).await?;
        let read: Vec<_> = some.iter().map(|(gyro, _)| *gyro).zip(rows).collect();
        let mut windows: HashMap<u32, GyroWindow> =
            GyroWindow::load_many(store, &read, need, judging.method).await?.into_iter().collect();
        for (gyro, newest) in some {
            let Some(figures) = newest else { continue };
            let window = match windows.remove(gyro) {
                Some(window) => window,
                None => GyroWindow::load(store, *gyro, Span::EVER.to, need, judging.method).await?,
            };
            let limits = {
                let tables = store.names().read();
                let name = |name: Option<&Arc<str>>| name.cloned().unwrap_or_default();
                judging.limits(&name(tables.imus.name(figures.imu)), &name(tables.gyros.name(*gyro)))
            };
            outlooks.insert(*gyro, Outlook::of(&window.judge_newest(&limits, Older::NONE)));
        }
    }
    Ok(outlooks)
}

/// Which stations have ever calibrated gyros, station first.
pub(crate) async fn stations_of(store: &Store, gyros: &[u32]) -> Result<Vec<[u32; 2]>, StoreError> {
    let mut seen = BTreeSet::new();
    for some in gyros.chunks(WINDOWS_AT_ONCE) {
        let ever: Vec<_> = some.iter().map(|gyro| (*gyro, Span::EVER)).collect();
        for (gyro, rows) in some.iter().zip(store::histories::oldest(store, &ever, i32::MAX as usize).await?) {
            seen.extend(rows.iter().map(|row| [row.station, *gyro]));
        }
    }
    Ok(seen.into_iter().collect())
}

/// Of all that decides how a gyro stands besides what is stored.
pub(crate) fn checksum(judging: &Judging) -> String {
    hex::encode(sha256(format!("{judging:?}").as_bytes()))
}
