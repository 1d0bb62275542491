//! The lines of the outbox: deliveries of one hook and alert, the oldest first. One that tells of many alerts stands
//! in the line of each.

use crate::core::id::Id;
use crate::core::time::UtcMicros;
use crate::store::batch::Batch;
use crate::store::db::Sql;
use crate::store::rows::Rows;

/// The lines (hook and alert) that a delivery stands in.
macro_rules! lines_of {
    ($delivery:literal) => {
        concat!(
            "(SELECT self.hook, self.alert FROM delivery AS self WHERE self.id = ",
            $delivery,
            " AND self.alert IS NOT NULL
              UNION ALL SELECT each.hook, each.alert FROM delivery_part AS each WHERE each.delivery = ",
            $delivery,
            ")"
        )
    };
}

/// The first of a line that is not done.
macro_rules! first_open {
    ($line:literal) => {
        concat!(
            "(SELECT min(id) FROM (SELECT min(open.id) AS id FROM delivery AS open WHERE open.hook = ",
            $line,
            ".hook AND open.alert = ",
            $line,
            ".alert AND open.state IN ('behind', 'waiting')
              UNION ALL SELECT min(part.delivery) FROM delivery_part AS part JOIN delivery AS open ON open.id = part.delivery
                        WHERE part.hook = ",
            $line,
            ".hook AND part.alert = ",
            $line,
            ".alert AND open.state IN ('behind', 'waiting')) AS firsts)"
        )
    };
}

/// Whether in one of a delivery's lines another is before it.
macro_rules! stands_behind {
    () => {
        concat!(
            "EXISTS (SELECT 1 FROM (SELECT ",
            first_open!("own"),
            " AS first FROM ",
            lines_of!("delivery.id"),
            " AS own) AS heads WHERE heads.first < delivery.id)"
        )
    };
}

/// For each delivery, the first of each of its lines that is not done waits, due at the instant, where it is the
/// first of all its own lines; where that waits already, nothing.
pub(crate) fn move_up(lines: impl Iterator<Item = (Id, UtcMicros)>, batch: &mut Batch) {
    let lines: Vec<_> = lines.collect();
    instants(
        Sql {
            sqlite: concat!(
                "UPDATE delivery SET state = 'waiting', due_at = $C1 WHERE state = 'behind' AND id IN (SELECT ",
                first_open!("line"),
                " FROM ",
                lines_of!("$C0"),
                " AS line) AND NOT ",
                stands_behind!()
            ),
            postgres: concat!(
                "UPDATE delivery SET state = 'waiting', due_at = head.at
                 FROM (SELECT min(line.at) AS at, line.first AS id
                       FROM (SELECT CAST(j.value->>1 AS BIGINT) AS at, ",
                first_open!("one"),
                " AS first FROM jsonb_array_elements(CAST($1 AS JSONB)) AS j(value) JOIN LATERAL ",
                lines_of!("CAST(j.value->>0 AS BIGINT)"),
                " AS one ON true) AS line GROUP BY line.first) AS head
                 WHERE delivery.id = head.id AND delivery.state = 'behind' AND NOT ",
                stands_behind!()
            ),
        },
        &lines,
        batch,
    );
}

/// After deliveries that are sent again, what waits of their hooks and stands behind another waits for its turn.
pub(crate) fn fall_back(again: &[(Id, UtcMicros)], batch: &mut Batch) {
    batch.add(
        Sql {
            sqlite: concat!(
                "UPDATE delivery SET state = 'behind' WHERE state = 'waiting'
                     AND hook = (SELECT again.hook FROM delivery AS again WHERE again.id = $C0) AND ",
                stands_behind!()
            ),
            postgres: concat!(
                "UPDATE delivery SET state = 'behind' WHERE state = 'waiting'
                     AND hook IN (SELECT again.hook FROM delivery AS again WHERE again.id IN
                         (SELECT CAST(j.value->>0 AS BIGINT) FROM jsonb_array_elements(CAST($1 AS JSONB)) AS j(value)))
                     AND ",
                stands_behind!()
            ),
        },
        Rows::of(again.iter().map(|(id, _)| id.0)),
    );
}

pub(crate) fn instants(sql: Sql, pairs: &[(Id, UtcMicros)], batch: &mut Batch) {
    let mut rows = Rows::default();
    for (id, at) in pairs {
        rows.row().put(id).put(at);
    }
    batch.add(sql, rows);
}
