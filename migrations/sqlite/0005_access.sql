-- Who may use the service. Of a token the hash of its secret is kept; a revoked one stays for the sake of the audit trail.
CREATE TABLE token (
    id            INTEGER PRIMARY KEY,
    name          TEXT NOT NULL,
    role          TEXT NOT NULL,
    station       TEXT,
    secret_sha256 BLOB NOT NULL,
    created_at    INTEGER NOT NULL,
    expires_at    INTEGER,
    revoked_at    INTEGER
) STRICT;

-- Browsers that have signed in with a token.
CREATE TABLE session (
    id            INTEGER PRIMARY KEY,
    token         INTEGER NOT NULL REFERENCES token (id),
    secret_sha256 BLOB NOT NULL,
    began_at      INTEGER NOT NULL,
    expires_at    INTEGER NOT NULL
) STRICT;

-- Who did what, when and from where; what it was about before and after (JSON). Only ever added to.
CREATE TABLE audit (
    id      INTEGER PRIMARY KEY,
    at      INTEGER NOT NULL,
    who     TEXT NOT NULL,
    token   INTEGER REFERENCES token (id),
    source  TEXT NOT NULL,
    action  TEXT NOT NULL,
    subject TEXT NOT NULL,
    before  TEXT,
    after   TEXT
) STRICT;
CREATE TRIGGER audit_is_not_changed BEFORE UPDATE ON audit
BEGIN SELECT raise(ABORT, 'the audit trail is only ever added to'); END;
CREATE TRIGGER audit_is_not_deleted BEFORE DELETE ON audit
BEGIN SELECT raise(ABORT, 'the audit trail is only ever added to'); END;
