-- What was noted about a record when it came, as versioned JSON (wire/history_note.rs); null where there was nothing.
ALTER TABLE record ADD COLUMN notes TEXT;

-- A record whose time is in doubt is set aside: `voided` holds its id, and nothing in `correction` says why. Here is who confirmed its
-- time, from when on it counts as any other.
CREATE TABLE confirmation (
    record INTEGER PRIMARY KEY REFERENCES record (id),
    at     INTEGER NOT NULL,
    author TEXT NOT NULL,
    reason TEXT NOT NULL
) STRICT;
