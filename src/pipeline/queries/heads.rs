//! The rows of the table `head`, by what is stored or about to be.

use crate::config::Judging;
use crate::core::judge::{BudgetProjection, Need, Older};
use crate::pipeline::alerts::NameLookup;
use crate::pipeline::ingest::judge::gyro_window::{GyroWindow, read_ahead};
use crate::pipeline::prelude::*;
use crate::pipeline::queries::gyro_status::{Facts, StoredFacts};
use crate::store::HeadRow;
use crate::system::sha256;

/// Gyros whose histories are held at once.
const WINDOWS_AT_ONCE: usize = 128;

/// The row of a gyro by what its standing follows from.
pub(crate) fn row_of(facts: &Facts<'_>, judging: &Judging, naming: &NameLookup<'_>) -> HeadRow {
    let names = facts.newest.map(|Figures { imu, station, .. }| (naming.imu(imu), naming.station(station)));
    let (imu, station) = names.unwrap_or_default();
    facts.head(judging, &imu, &station)
}

pub(crate) async fn stored_rows(store: &Store, judging: &Judging, gyros: &[u32]) -> Result<Vec<HeadRow>, StoreError> {
    let newest = store::histories::last(store, gyros).await?;
    let projections = stored_projections(store, judging, &newest).await?;
    let stored = StoredFacts::of(store, &newest, projections).await?;
    let naming = NameLookup { tables: &store.names().read(), new: None };
    let row = |(gyro, newest): &(u32, Option<Figures>)| {
        row_of(&stored.facts(*gyro, naming.gyro(*gyro).into(), *newest), judging, &naming)
    };
    Ok(newest.iter().map(row).collect())
}

/// How gyros with these newest calibrations lie to their budgets and where they go, judged anew by what is stored.
pub(crate) async fn stored_projections(
    store: &Store,
    judging: &Judging,
    newest: &[(u32, Option<Figures>)],
) -> Result<HashMap<u32, BudgetProjection>, StoreError> {
    let need = Need::of(&judging.limits("", ""));
    let mut projections = HashMap::with_capacity(newest.len());
    for some in newest.chunks(WINDOWS_AT_ONCE) {
        let gyros: Vec<u32> = some.iter().map(|(gyro, _)| *gyro).collect();
        let rows = store::histories::newest_ever(store, &gyros, read_ahead(need)).await?;
        let read: Vec<_> = gyros.into_iter().zip(rows).collect();
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
                judging.limits(tables.imus.text(figures.imu), tables.gyros.text(*gyro))
            };
            projections.insert(*gyro, BudgetProjection::of(&window.judge_newest(&limits, Older::NONE)));
        }
    }
    Ok(projections)
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

/// Of what a row says: another one has all made anew.
const FORM: u32 = 2;

/// Of all that decides how a gyro stands besides what is stored.
pub(crate) fn checksum(judging: &Judging) -> String {
    hex::encode(sha256(format!("{FORM} {judging:?}").as_bytes()))
}
