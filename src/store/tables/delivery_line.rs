//! The lines of the outbox: deliveries of one hook and alert, the oldest first. One that tells of many alerts stands
//! in the line of each.

use super::*;

/// The lines (hook and alert) that a delivery stands in.
fn lines_of(delivery: &str) -> String {
    format!(
        "(SELECT self.hook, self.alert FROM delivery AS self WHERE self.id = {delivery} AND self.alert IS NOT NULL
          UNION ALL SELECT each.hook, each.alert FROM delivery_part AS each WHERE each.delivery = {delivery})"
    )
}

/// The first of a line that is not done.
fn first_open(line: &str) -> String {
    format!(
        "(SELECT min(id) FROM (SELECT min(open.id) AS id FROM delivery AS open WHERE open.hook = {line}.hook
              AND open.alert = {line}.alert AND open.state IN ('behind', 'waiting')
          UNION ALL SELECT min(part.delivery) FROM delivery_part AS part JOIN delivery AS open ON open.id = part.delivery
              WHERE part.hook = {line}.hook AND part.alert = {line}.alert AND open.state IN ('behind', 'waiting')) AS firsts)"
    )
}

/// Whether in one of a delivery's lines another is before it.
fn stands_behind() -> String {
    format!(
        "EXISTS (SELECT 1 FROM (SELECT {} AS first FROM {} AS own) AS heads WHERE heads.first < delivery.id)",
        first_open("own"),
        lines_of("delivery.id")
    )
}

/// For each delivery, the first of each of its lines that is not done waits, due at the instant, where it is the
/// first of all its own lines; where that waits already, nothing.
pub(crate) fn move_up(lines: impl Iterator<Item = (Id, UtcMicros)>, batch: &mut Batch) {
    let (first, lines_of, stands_behind) = (first_open("line"), lines_of("$C0"), stands_behind());
    batch.add(
        &format!(
            "UPDATE delivery SET state = 'waiting', due_at = $C1 WHERE state = 'behind'
                 AND id IN (SELECT {first} FROM {lines_of} AS line) AND NOT {stands_behind}"
        ),
        &format!(
            "UPDATE delivery SET state = 'waiting', due_at = head.at
             FROM (SELECT min(at) AS at, first AS id
                   FROM (SELECT $C1 AS at, {first} AS first FROM $ROWS JOIN LATERAL {lines_of} AS line ON true) AS firsts
                   GROUP BY first) AS head
             WHERE delivery.id = head.id AND delivery.state = 'behind' AND NOT {stands_behind}"
        ),
        Rows::of(lines),
    );
}

/// After deliveries that are sent again, what waits of their hooks and stands behind another waits for its turn.
pub(crate) fn fall_back(again: &[(Id, UtcMicros)], batch: &mut Batch) {
    let stands_behind = stands_behind();
    batch.add(
        &format!(
            "UPDATE delivery SET state = 'behind' WHERE state = 'waiting'
                 AND hook = (SELECT again.hook FROM delivery AS again WHERE again.id = $C0) AND {stands_behind}"
        ),
        &format!(
            "UPDATE delivery SET state = 'behind' WHERE state = 'waiting'
                 AND hook IN (SELECT again.hook FROM delivery AS again WHERE again.id IN (SELECT $C0 FROM $ROWS))
                 AND {stands_behind}"
        ),
        Rows::of(again.iter().map(|(id, _)| *id)),
    );
}
