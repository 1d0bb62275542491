-- Of every table, and of the schema itself (sqlite_schema): how many rows it has, and the sum of a checksum of each (store/checksum.rs). Kept in
-- the transaction of every change; `version` is the newest migration when they were first computed. Where there is none, the start computes all.
CREATE TABLE checksum (
    name    TEXT PRIMARY KEY,
    version INTEGER NOT NULL,
    rows    INTEGER NOT NULL,
    sum     INTEGER NOT NULL
) STRICT, WITHOUT ROWID;
