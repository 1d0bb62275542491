//! Campaigns and bench tests of the same gyros at the same time: a gyro cannot be in two.

use super::lookup::Lookup;
use super::recent_records::NearbyRecords;
use crate::core::history_note::{HistoryNote, LONGEST_DAYS, NamedRecord};
use crate::pipeline::prelude::*;
use crate::wire::campaign;

/// A gyro of what is sent: its number, its serial, and what is known of it about that time.
pub(super) type Tested<'a> = (u32, &'a str, &'a NearbyRecords);

/// Campaigns and bench tests that were under way while these gyros were tested, from the first to the last instant
/// of `sent`: of the few campaigns before it, the next after it, and all bench tests. One longer than
/// [`LONGEST_DAYS`] is not looked for, nor is what states no dwells.
pub(super) async fn overlapping(
    known: &mut Lookup<'_>,
    sent: Span,
    gyros: &[Tested<'_>],
) -> Result<Vec<HistoryNote>, StoreError> {
    let mut near: BTreeMap<(UtcMicros, Id), (Option<UtcMicros>, Vec<(u32, &str)>)> = BTreeMap::new();
    for (gyro, serial, around) in gyros {
        for row in around.before.iter().chain(&around.next).filter(|row| may_overlap(row.at, sent)) {
            near.entry((row.at, row.record)).or_insert_with(|| (row.ends_at, Vec::new())).1.push((*gyro, serial));
        }
    }
    let mut found = Vec::new();
    for ((at, id), (remembered, tested)) in near {
        let ends_at = match remembered {
            Some(ends_at) => ends_at,
            None => {
                // What has no dwells has no length.
                let ends_at = body_of(id, known).await?.and_then(|body| end_of(&body)).unwrap_or(at);
                tested.iter().for_each(|(gyro, _)| known.memory.note_end(*gyro, id, ends_at));
                ends_at
            }
        };
        found.extend(overlaps((id, at, ends_at), sent, tested.iter().map(|(_, serial)| *serial)));
    }
    let window = Span { from: sent.from.plus_days(-LONGEST_DAYS), to: sent.to };
    for (gyro, serial, _) in gyros {
        let stored = match known.benched.get(gyro) {
            Some(false) => Vec::new(),
            _ => store::bench::of_gyro(known.store, *gyro, window).await?,
        };
        let withdrawn = &known.group.changes.withdrawn.benches;
        let stored = stored.iter().filter(|bench| !withdrawn.contains(&(bench.id, *gyro)));
        let new = known.group.changes.benches.iter().filter(|bench| bench.gyro == *gyro);
        for bench in stored.chain(new).filter(|bench| may_overlap(bench.measured_at, sent)) {
            let ends_at = end_of(&bench.body).unwrap_or(bench.measured_at);
            found.extend(overlaps((bench.id, bench.measured_at, ends_at), sent, std::iter::once(*serial)));
        }
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

fn overlaps<'a>(
    (id, at, ends_at): (Id, UtcMicros, UtcMicros),
    sent: Span,
    serials: impl Iterator<Item = &'a str>,
) -> Option<HistoryNote> {
    (ends_at > at && ends_at > sent.from).then(|| HistoryNote::OverlapsInTime {
        serials: serials.map(str::to_owned).collect(),
        record: NamedRecord { record: id.to_string(), at },
    })
}
