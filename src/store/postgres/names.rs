//! Names that other servers have given numbers to.

use crate::store::db::{PgReaders, Readers};
use crate::store::error::StoreError;
use crate::store::open::Store;
use crate::store::tables::names::{Commit, Names, Tables};
use crate::store::tables::record::RecordRow;

/// Names that were committed after `$1`, or all where `$2`; as kind 3 the newest commit; as kind 4 that of `$1`,
/// where it is known.
const NEW: &str = "SELECT 0 AS kind, id, name, CAST(0 AS BIGINT) AS stamp FROM imu WHERE since > $1 OR $2
    UNION ALL SELECT 1, id, name, 0 FROM station WHERE since > $1 OR $2
    UNION ALL SELECT 2, id, serial, 0 FROM gyro WHERE since > $1 OR $2
    UNION ALL SELECT 3, version, '', stamp FROM turn
    UNION ALL SELECT 4, version, '', stamp FROM turn_commit WHERE version = $1";

/// What [`NEW`] finds.
#[derive(Debug, Default)]
struct New {
    names: [Vec<(u32, String)>; 3],
    newest: Commit,
    /// The commit up to which names were asked for, as the database has it.
    seen: Option<Commit>,
}

impl New {
    async fn since(readers: &PgReaders, version: i64, all: bool) -> Result<Self, StoreError> {
        let rows: Vec<(i32, i64, String, i64)> = sqlx::query_as(NEW).bind(version).bind(all).fetch_all(readers).await?;
        let mut new = Self::default();
        for (kind, number, name, stamp) in rows {
            match usize::try_from(kind).ok().and_then(|kind| new.names.get_mut(kind)) {
                Some(names) => {
                    let wrong = |_| StoreError::Damaged(format!("`{name}` has the number {number}"));
                    let number = u32::try_from(number).map_err(wrong)?;
                    names.push((number, name));
                }
                None if kind == 3 => new.newest = Commit { version: number, stamp },
                None => new.seen = Some(Commit { version: number, stamp }),
            }
        }
        Ok(new)
    }

    /// Enters the names, and how far they are known.
    fn enter(self, tables: &mut Tables) -> Result<(), StoreError> {
        tables.seen = self.newest;
        for (table, names) in tables.all_mut().into_iter().zip(&self.names) {
            if let Some((_, name)) = names.iter().find(|(number, name)| !table.add(*number, name)) {
                return Err(StoreError::Damaged(format!("`{name}` has more than one number")));
            }
        }
        Ok(())
    }
}

/// Learns the names that came after those that are known; all of them where the database has lost commits that
/// brought known ones.
///
/// # Errors
/// [`StoreError`]; then what was known before is known.
pub(super) async fn learn_new(readers: &PgReaders, names: &Names) -> Result<(), StoreError> {
    loop {
        let seen = names.read().seen;
        let is_first = seen == Commit::default();
        let mut new = New::since(readers, seen.version, is_first).await?;
        let is_lost = !is_first && new.seen != Some(seen);
        if is_lost {
            tracing::warn!("the database has lost commits: all names are read again");
            new = New::since(readers, 0, true).await?;
        }
        let mut entered = None;
        names.change(|tables| {
            // Where somebody else has learned meanwhile, these may be the older ones.
            if tables.seen == seen {
                if is_lost {
                    *tables = Tables::default();
                }
                entered = Some(new.enter(tables));
            }
        });
        if let Some(entered) = entered {
            return entered;
        }
    }
}

/// A row of another server's may be read before the names that came with it were heard of.
///
/// # Errors
/// As [`learn_new`].
pub(in crate::store) async fn know_names_of(store: &Store, row: &RecordRow) -> Result<(), StoreError> {
    let Readers::Postgres(readers) = &store.readers else { return Ok(()) };
    let are_known = {
        let tables = store.names.read();
        tables.imus.name(row.imu).is_some()
            && tables.stations.name(row.station).is_some()
            && row.verdicts.0.iter().all(|(gyro, _)| tables.gyros.name(*gyro).is_some())
    };
    if are_known { Ok(()) } else { learn_new(readers, &store.names).await }
}
