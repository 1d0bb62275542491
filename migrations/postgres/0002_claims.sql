-- Campaigns that a server is diagnosing, until when by the database's clock. Others take what nobody has; what a server that died
-- had is anybody's when its time is over. That two make the same diagnosis does no harm.
CREATE TABLE diagnosis_claim (
    record BIGINT PRIMARY KEY,
    holder BIGINT NOT NULL,
    until  TIMESTAMPTZ NOT NULL
);

-- No one server makes them for all any more.
DELETE FROM lease WHERE name = 'diagnoses';
