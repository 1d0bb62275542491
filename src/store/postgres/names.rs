//! Names that other servers have given numbers to.

use futures::TryStreamExt as _;
use sqlx::AssertSqlSafe;

use super::cell_rows::{AllCells, CellRow, ChangeTopic};
use crate::store::db::PgReaders;
use crate::store::error::StoreError;
use crate::store::name_tables::{Names, NamesOf, Tables};

/// A name: its kind, number, cell and text.
type Found = (i32, i64, i64, String);

pub(in crate::store) fn select([imus, stations, gyros]: [&str; 3]) -> AssertSqlSafe<String> {
    AssertSqlSafe(format!(
        "SELECT 0, id, cell, name FROM imu {imus} UNION ALL SELECT 1, id, cell, name FROM station {stations}
         UNION ALL SELECT 2, id, cell, serial FROM gyro {gyros}"
    ))
}

pub(in crate::store) fn read(found: Vec<Found>) -> Result<Vec<(NamesOf, u32, u8, String)>, StoreError> {
    found.into_iter().map(read_one).collect()
}

fn read_one((kind, number, cell, name): Found) -> Result<(NamesOf, u32, u8, String), StoreError> {
    let kind = usize::try_from(kind).ok().and_then(|kind| NamesOf::ALL.get(kind)).copied();
    let wrong = || StoreError::damaged(format_args!("`{name}` has the number {number} in cell {cell}"));
    let known = kind.zip(u32::try_from(number).ok()).zip(u8::try_from(cell).ok());
    let ((kind, number), cell) = known.ok_or_else(wrong)?;
    Ok((kind, number, cell, name))
}

/// Every name there is, in place of those that were known.
///
/// # Errors
/// [`StoreError`]; then what was known before is known.
pub(super) async fn learn_all(readers: &PgReaders, names: &Names) -> Result<(), StoreError> {
    // What comes after this look is newer, and is read again.
    let seen = AllCells::look(readers).await?.0.map(|row| row.stamp_of(ChangeTopic::Names));
    let mut tables = Tables { seen, ..Tables::default() };
    let mut rows = sqlx::query_as(select([""; 3])).fetch(readers);
    while let Some(found) = rows.try_next().await? {
        let (kind, number, cell, name) = read_one(found)?;
        tables.learn(kind, number, cell, &name)?;
    }
    drop(rows);
    names.change(|known| *known = tables);
    Ok(())
}

/// The names of cells in which there are new ones, or of which some were lost. Those who hold the cells know them all
/// then.
///
/// # Errors
/// [`StoreError`]; then what was known before is known.
pub(super) async fn learn_cells(readers: &PgReaders, names: &Names, found: &[CellRow]) -> Result<(), StoreError> {
    let seen = |row: &CellRow| names.read().seen[usize::from(row.cell)];
    let moved: Vec<(CellRow, i64)> = found
        .iter()
        .map(|row| (*row, seen(row)))
        .filter(|(row, seen)| row.stamp_of(ChangeTopic::Names) != *seen)
        .collect();
    if moved.is_empty() {
        return Ok(());
    }
    let cells: Vec<i64> = moved.iter().map(|(row, _)| i64::from(row.cell)).collect();
    let of_cells = select(["WHERE cell = ANY($1)"; 3]);
    let of_cells = read(sqlx::query_as(of_cells).bind(cells).fetch_all(readers).await?)?;
    names.change(|tables| {
        for (row, seen) in &moved {
            let place = usize::from(row.cell);
            // Where somebody else has learned meanwhile, these may be the older ones.
            if tables.seen[place] != *seen {
                continue;
            }
            let of_cell = of_cells.iter().filter(|(_, _, cell, _)| *cell == row.cell);
            tables.forget_others(row.cell, of_cell.clone().map(|(kind, number, ..)| (*kind, *number)).collect());
            for (kind, number, cell, name) in of_cell {
                tables.learn(*kind, *number, *cell, name)?;
            }
            tables.seen[place] = row.stamp_of(ChangeTopic::Names);
        }
        Ok(())
    })
}
