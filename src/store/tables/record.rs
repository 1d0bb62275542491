//! Records as stations sent them, and what was decided about them.

use super::*;
use crate::core::kind::{Kind, RecordEntry};
use crate::store::RecordVerdicts;
use crate::store::packed::text;
use crate::store::tables::names::look_up_numbers;

fn code(kind: Kind) -> i64 {
    match kind {
        Kind::Record => 0,
        Kind::Campaign => 1,
    }
}

impl Column for Kind {
    type Stored = i64;
    const KIND: CellKind = CellKind::Integer;

    fn put_one(&self, row: &mut Row<'_>) {
        row.integer(code(*self));
    }

    fn of(stored: i64) -> Option<Self> {
        [Self::Record, Self::Campaign].into_iter().find(|kind| code(*kind) == stored)
    }
}

/// One record with its verdicts.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordRow {
    pub id: Id,
    pub kind: Kind,
    pub imu: u32,
    pub station: u32,
    pub calibrated_at: UtcMicros,
    pub received_at: UtcMicros,
    /// Word for word.
    pub body: Arc<str>,
    pub body_sha256: [u8; 32],
    pub verdicts: RecordVerdicts,
    /// It does not count: it was voided or revised, or is set aside until its time is confirmed.
    pub voided: bool,
    /// What was noted about it, as versioned JSON.
    pub notes: Option<Arc<str>>,
    /// The line of the audit trail that says who sent it; none of what an earlier version stored.
    pub sent_by: Option<Id>,
    /// At which it was calibrated, deg C; none where nothing states it, and of what an earlier version stored.
    pub temperature_c: Option<f64>,
}

columns! {
    RecordEntry in "record" { id, kind, imu, station, calibrated_at, received_at, voided }
}

/// What a list of records is narrowed down to.
#[derive(Debug, Clone, Copy)]
pub struct RecordFilter {
    pub kind: Option<Kind>,
    pub imu: Option<u32>,
    pub station: Option<u32>,
    pub calibrated: Span,
}

/// An item at an instant that was asked for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecordAt {
    pub id: Id,
    /// SHA-256 of its text.
    pub hash: Vec<u8>,
    /// It does not count any more.
    pub voided: bool,
}

part! {
    RecordAt { id, hash, voided }
}

/// The text of a stored record as it was sent.
#[derive(Debug)]
pub struct LongText {
    pub record: Id,
    imu: u32,
    body: String,
}

part! {
    LongText { record, imu, body }
}

/// The same, deflated.
#[derive(Debug, PartialEq)]
pub struct PackedText {
    record: Id,
    pub imu: u32,
    packed: Vec<u8>,
}

impl LongText {
    /// None where it does not become shorter.
    pub fn packed(&self) -> Option<PackedText> {
        let (_, packed) = text::pack(&self.body);
        Some(PackedText { record: self.record, imu: self.imu, packed: packed? })
    }
}

pub(crate) fn pack(texts: &[PackedText], batch: &mut Batch) {
    let rows = Rows::each(texts, |text, row| _ = row.put(&text.record).bytes(&text.packed));
    batch.change("UPDATE record SET body = '', packed = $C1", "id = $C0 AND packed IS NULL", rows);
}

/// Of records with a long text that an earlier version stored as it was sent; as the index `record_unpacked` has it.
const UNPACKED: Sql = Sql {
    sqlite: "packed IS NULL AND length(CAST(body AS BLOB)) >= 2048",
    postgres: "packed IS NULL AND octet_length(body) >= 2048",
};

/// How many records have a long text that is not deflated.
pub async fn count_unpacked(store: &Store) -> Result<usize> {
    let sql = AssertSqlSafe(format!("SELECT count(*) FROM record WHERE {}", store.readers.words(UNPACKED)));
    read!(store, one, sql)
}

/// Long texts that are not deflated, of the first records after `after`, as many as `limit`.
pub async fn unpacked(store: &Store, after: Id, limit: u32) -> Result<Vec<LongText>> {
    let sql = format!(
        "SELECT id, imu, body FROM record WHERE {} AND id > $1 ORDER BY id LIMIT $2",
        store.readers.words(UNPACKED)
    );
    let texts: Vec<LongText> = read!(store, all, AssertSqlSafe(sql), after, limit)?;
    look_up_numbers(store, [texts.iter().map(|text| text.imu).collect(), Vec::new(), Vec::new()]).await?;
    Ok(texts)
}

/// The verdicts of a stored record, some of them new, beside those that were there. They are of several gyros, which
/// may be at home in different cells: whoever changes those of one must not undo what others have made of another.
#[derive(Debug, Clone, PartialEq)]
pub struct RejudgedVerdicts {
    pub sheet: RecordVerdicts,
    packed_before: Vec<u8>,
}

pub(crate) fn update_verdicts(sheets: &[(Id, RejudgedVerdicts)], batch: &mut Batch) {
    let rows = Rows::each(sheets, |(id, RejudgedVerdicts { sheet, packed_before }), row| {
        row.put(id).written(|out| sheet.pack(*id, out)).bytes(packed_before);
    });
    let sql = Sql {
        sqlite: "UPDATE record SET verdicts = $C1 WHERE id = $C0",
        postgres: "UPDATE record SET verdicts = $C1 FROM $ROWS WHERE id = $C0 AND verdicts = $C3",
    };
    batch.add_to_all(sql, rows);
}

impl Part for RecordRow {
    fn put(&self, row: &mut Row<'_>) {
        let (body, packed) = text::pack(&self.body);
        row.put(&self.id).put(&self.kind).put(&self.imu).put(&self.station).put(&self.calibrated_at);
        row.put(&self.received_at).words(body).put(&self.body_sha256);
        row.written(|out| self.verdicts.pack(self.id, out)).integer(if self.voided { self.id.0 } else { 0 });
        row.optional_words(self.notes.as_deref()).put(&self.sent_by).put(&self.temperature_c);
        row.optional_bytes(packed.as_deref());
    }

    fn get(found: &mut Found<'_, impl AnyRow>) -> Result<Self> {
        let id: Id = found.part()?;
        let (kind, imu, station, calibrated_at, received_at) = found.part()?;
        let (body, body_sha256): (String, _) = found.part()?;
        let verdicts = RecordVerdicts::unpack(id, &found.cell::<Vec<u8>>()?)?;
        let (voided, notes, sent_by, temperature_c) = found.part()?;
        let body = text::unpack(body, found.cell()?, || format!("record {id}"))?.into();
        Ok(Self {
            id,
            kind,
            imu,
            station,
            calibrated_at,
            received_at,
            body,
            body_sha256,
            verdicts,
            voided,
            notes,
            sent_by,
            temperature_c,
        })
    }
}

impl Columns for RecordRow {
    const TABLE: &'static str = "record";
    const COLUMNS: &'static str = "id, kind, imu, station, calibrated_at, received_at, body, body_sha256, verdicts, \
        voided, notes, sent_by, temperature_c, packed";
}

pub async fn get(store: &Store, id: Id) -> Result<Option<RecordRow>> {
    let found: Option<RecordRow> = read!(store, first, RecordRow::select("WHERE id = $1"), id)?;
    if let Some(row) = &found {
        let gyros = row.verdicts.0.iter().map(|(gyro, _)| *gyro).collect();
        look_up_numbers(store, [vec![row.imu], vec![row.station], gyros]).await?;
    }
    Ok(found)
}

/// Every record, in order of arrival.
pub async fn ids(store: &Store) -> Result<Vec<Id>> {
    read!(store, all, "SELECT id FROM record ORDER BY id")
}

/// The records of an IMU at an instant: the one that counts first (there is one at the most), then those that do not.
pub async fn at(store: &Store, imu: u32, at: UtcMicros) -> Result<Vec<RecordAt>> {
    Ok(at_many(store, &[(imu, at)]).await?.pop().unwrap_or_default())
}

/// As [`at`], of many places: of a database server in one question, of a file one by one, which costs nothing
/// there.
pub async fn at_many(store: &Store, places: &[(u32, UtcMicros)]) -> Result<Vec<Vec<RecordAt>>> {
    let mut all = vec![Vec::new(); places.len()];
    if places.is_empty() {
        return Ok(all);
    }
    if let Readers::Sqlite(..) = store.readers {
        let sql = "SELECT imu, calibrated_at, id, body_sha256, voided FROM record WHERE id = $3
                   OR id IN (SELECT record FROM calendar WHERE imu = $1 AND calibrated_at = $2) ORDER BY voided";
        for (&(imu, at), found) in places.iter().zip(&mut all) {
            let (waiting, newest) = {
                let index = store.write_behind.index.read();
                (index.at(imu, at), index.newest_of(imu))
            };
            if newest.is_none_or(|newest| newest < at) {
                continue;
            }
            let rows: Vec<((u32, UtcMicros), RecordAt)> = read!(store, all, sql, imu, at, waiting)?;
            if let Some((_, other)) = rows.iter().find(|(place, _)| *place != (imu, at)) {
                return Err(StoreError::damaged(format_args!("record {} is of another instant", other.id)));
            }
            found.extend(rows.into_iter().map(|(_, one)| one));
        }
        return Ok(all);
    }
    let sql = "SELECT CAST(key AS BIGINT), id, body_sha256, voided
               FROM jsonb_array_elements(CAST($1 AS JSONB)) WITH ORDINALITY AS j(value, key) JOIN record
               ON imu = CAST(j.value->>0 AS BIGINT) AND calibrated_at = CAST(j.value->>1 AS BIGINT) ORDER BY key, voided";
    let wanted: Vec<[i64; 2]> = places.iter().map(|(imu, at)| [i64::from(*imu), at.0]).collect();
    let found: Vec<(usize, RecordAt)> = read!(store, all, sql, serde_json::json!(wanted).to_string())?;
    for (key, one) in found {
        all[key - 1].push(one);
    }
    Ok(all)
}

/// When the newest record of an IMU was made, whether it counts or not.
pub async fn newest_of_imu(store: &Store, imu: u32) -> Result<Option<UtcMicros>> {
    match store.readers {
        Readers::Sqlite(..) => Ok(newest_in_file(store, imu)),
        Readers::Postgres(..) => read!(store, one, "SELECT max(calibrated_at) FROM record WHERE imu = $1", imu),
    }
}

/// As [`newest_of_imu`], of a database in a file.
pub fn newest_in_file(store: &Store, imu: u32) -> Option<UtcMicros> {
    store.write_behind.index.read().newest_of(imu)
}

/// Which IMU and gyros a record is of, where there is such a record.
pub async fn whose(store: &Store, id: Id) -> Result<Option<(u32, Vec<u32>)>> {
    let sql = "SELECT imu, verdicts FROM record WHERE id = $1";
    let found: Option<(u32, Vec<u8>)> = read!(store, first, sql, id)?;
    let whose = |(imu, verdicts): (u32, Vec<u8>)| {
        let sheet = RecordVerdicts::unpack(id, &verdicts)?;
        Ok((imu, sheet.0.into_iter().map(|(gyro, _)| gyro).collect()))
    };
    found.map(whose).transpose()
}

/// The verdicts of a record, to be changed.
pub async fn verdicts_to_rejudge(store: &Store, id: Id) -> Result<Option<RejudgedVerdicts>> {
    let sql = "SELECT verdicts FROM record WHERE id = $1";
    let found: Option<Vec<u8>> = read!(store, first, sql, id)?;
    let sheet = |packed_before: Vec<u8>| {
        Ok(RejudgedVerdicts { sheet: RecordVerdicts::unpack(id, &packed_before)?, packed_before })
    };
    found.map(sheet).transpose()
}

pub async fn record_verdicts(store: &Store, records: impl Iterator<Item = Id>) -> Result<HashMap<Id, RecordVerdicts>> {
    let sql = AssertSqlSafe(format!("SELECT id, verdicts FROM record WHERE id IN {}", store.readers.list("$1")));
    let records: Vec<Id> = records.collect();
    if records.is_empty() {
        return Ok(HashMap::new());
    }
    let rows: Vec<(Id, Vec<u8>)> = read!(store, all, sql, &records)?;
    rows.into_iter().map(|(id, bytes)| Ok((id, RecordVerdicts::unpack(id, &bytes)?))).collect()
}

/// The newest `limit` records of an IMU that count, newest first, without their bodies.
pub async fn of_imu(store: &Store, imu: u32, limit: u32) -> Result<Vec<RecordEntry>> {
    of_imu_before(store, imu, Span::EVER.to, limit).await
}

/// As [`of_imu`], those that were calibrated before `before`.
pub async fn of_imu_before(store: &Store, imu: u32, before: UtcMicros, limit: u32) -> Result<Vec<RecordEntry>> {
    // What waits counts. On a server nothing does, and $3 says so.
    let waiting: Vec<Id> = store.write_behind.index.read().last_of(imu, before, limit as usize).collect();
    let sql = RecordEntry::select(store.readers.words(Sql {
        sqlite: "WHERE voided = 0 AND id IN
                     (SELECT value FROM json_each($3) UNION ALL SELECT record FROM
                         (SELECT record FROM calendar WHERE imu = $1 AND voided = 0 AND calibrated_at < $4
                          ORDER BY calibrated_at DESC LIMIT $2))
                 ORDER BY calibrated_at DESC LIMIT $2",
        postgres: "WHERE imu = $1 AND voided = 0 AND $3 IS NOT NULL AND calibrated_at < $4
                   ORDER BY calibrated_at DESC LIMIT $2",
    }));
    read!(store, all, sql, imu, limit, &waiting, before)
}

/// Records and campaigns, the last to arrive first, from the one before `before` on, as many as `limit`.
pub async fn listed(store: &Store, filter: RecordFilter, before: Id, limit: u32) -> Result<Vec<RecordEntry>> {
    // An IMU's records are found by their index and then sorted; all others are read in the order of arrival.
    let RecordFilter { kind, imu, station, calibrated: Span { from, to } } = filter;
    let (waiting, order, of_imu): (Vec<Id>, _, _) = match imu {
        None => (Vec::new(), "id", "$3 IS NULL AND $4 IS NOT NULL"),
        Some(imu) => (
            store.write_behind.index.read().last_of(imu, Span::EVER.to, usize::MAX).collect(),
            "id + 0",
            store.readers.words(Sql {
                sqlite: "id IN (SELECT value FROM json_each($4)
                                UNION SELECT record FROM calendar WHERE imu = $3 AND calibrated_at BETWEEN $6 AND $7)",
                postgres: "imu = $3 AND $4 IS NOT NULL",
            }),
        ),
    };
    let sql = RecordEntry::select(&format!(
        "WHERE {order} < $1 AND ($2 IS NULL OR kind = $2) AND {of_imu} AND ($5 IS NULL OR station = $5)
             AND calibrated_at BETWEEN $6 AND $7
         ORDER BY {order} DESC LIMIT $8"
    ));
    let kind = kind.map(code);
    let found: Vec<RecordEntry> = read!(store, all, sql, before, kind, imu, &waiting, station, from, to, limit)?;
    let names = [found.iter().map(|one| one.imu).collect(), found.iter().map(|one| one.station).collect(), Vec::new()];
    look_up_numbers(store, names).await?;
    Ok(found)
}

/// All that a station has calibrated and that counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StationTotals {
    pub records: usize,
    /// That it has ever calibrated.
    pub gyros: usize,
    pub imus: usize,
    pub first: UtcMicros,
    pub last: UtcMicros,
}

part! {
    StationTotals { records, gyros, imus, first, last }
}

/// Of every station with a record that counts. Reads every record.
pub async fn of_stations(store: &Store) -> Result<HashMap<u32, StationTotals>> {
    let sql =
        "SELECT station, count(*), (SELECT count(*) FROM gyro_station WHERE gyro_station.station = record.station),
                      count(DISTINCT imu), min(calibrated_at), max(calibrated_at)
               FROM record WHERE voided = 0 GROUP BY station";
    let rows: Vec<(u32, StationTotals)> = read!(store, all, sql)?;
    Ok(rows.into_iter().collect())
}
