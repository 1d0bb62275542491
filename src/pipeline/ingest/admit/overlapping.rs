//! Campaigns and bench tests of the same gyros at the same time: a gyro cannot be in two.

use super::lookup::Lookup;
use super::recent_records::NearbyRecords;
use crate::core::history_note::{HistoryNote, LONGEST_DAYS, NamedRecord};
use crate::pipeline::prelude::*;
use crate::wire::campaign;

/// A gyro of what is sent: its number, its serial, and what is known of it about that time.
pub(super) type Tested<'a> = (u32, &'a str, &'a NearbyRecords);

/// Campaigns and bench tests that were under way while these gyros were tested, from the first to the last instant of
/// `sent`: of the few campaigns before it, the next after it, and all bench tests. One longer than [`LONGEST_DAYS`] is
/// not looked for, nor is what states no dwells.
pub(super) async fn overlapping(
    sent: Span,
    gyros: &[Tested<'_>],
    known: &Lookup<'_>,
) -> Result<Vec<HistoryNote>, StoreError> {
    let mut near: BTreeMap<(UtcMicros, Id), (Option<UtcMicros>, Vec<&str>)> = BTreeMap::new();
    for (_, serial, around) in gyros {
        for row in around.before.iter().chain(&around.next).filter(|row| may_overlap(row.at, sent)) {
            near.entry((row.at, row.record)).or_insert_with(|| (row.ends_at, Vec::new())).1.push(serial);
        }
    }
    let mut found = Vec::new();
    for ((at, id), (remembered, serials)) in near {
        let ends_at = match remembered {
            Some(ends_at) => Some(ends_at),
            None => body_of(id, known).await?.and_then(|body| end_of(&body)),
        };
        found.extend(overlaps((id, at, ends_at), sent, &serials));
    }
    let window = Span { from: sent.from.plus_days(-LONGEST_DAYS), to: sent.to };
    let numbers: Vec<u32> = gyros.iter().map(|gyro| gyro.0).collect();
    let on_benches = store::bench::on_benches(known.store, &numbers).await?;
    for (gyro, serial, _) in gyros {
        let stored = match on_benches.contains(gyro) {
            true => store::bench::of_gyro(known.store, *gyro, window).await?,
            false => Vec::new(),
        };
        let changes = &known.group.changes;
        let stored = stored.iter().filter(|bench| !changes.withdrawn.benches.contains(&(bench.id, *gyro)));
        let new = changes.benches.iter().filter(|bench| bench.gyro == *gyro);
        let all = stored.chain(new).filter(|bench| may_overlap(bench.measured_at, sent));
        found.extend(
            all.filter_map(|bench| overlaps((bench.id, bench.measured_at, end_of(&bench.body)), sent, &[*serial])),
        );
    }
    Ok(found)
}

fn may_overlap(at: UtcMicros, sent: Span) -> bool {
    at < sent.to && sent.from.days_since(at) <= LONGEST_DAYS
}

async fn body_of(id: Id, known: &Lookup<'_>) -> Result<Option<Arc<str>>, StoreError> {
    if let Some(record) = known.group.changes.records.iter().find(|record| record.id == id) {
        return Ok(Some(Arc::clone(&record.body)));
    }
    Ok(store::record::get(known.store, id).await?.map(|record| record.body))
}

/// None of what is no campaign.
fn end_of(body: &str) -> Option<UtcMicros> {
    Some(campaign::parse_json(body.as_bytes()).ok()?.ends_at())
}

fn overlaps(
    (id, at, ends_at): (Id, UtcMicros, Option<UtcMicros>),
    sent: Span,
    serials: &[&str],
) -> Option<HistoryNote> {
    let serials = serials.iter().map(|serial| (*serial).to_owned()).collect();
    let record = NamedRecord { record: id.to_string(), at };
    // What has no dwells has no length.
    let is_long = ends_at.is_some_and(|ends_at| ends_at > at && ends_at > sent.from);
    is_long.then_some(HistoryNote::OverlapsInTime { serials, record })
}
