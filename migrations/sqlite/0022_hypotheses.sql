-- Hypotheses of one's own that compete in every diagnosis, word for word (JSON), as long as none has ended them.
CREATE TABLE hypothesis (
    id       INTEGER PRIMARY KEY,
    body     TEXT NOT NULL,
    author   TEXT NOT NULL,
    reason   TEXT NOT NULL,
    added_at INTEGER NOT NULL,
    ended_at INTEGER
) STRICT;
