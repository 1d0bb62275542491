-- Long texts that an earlier version stored as they were sent, until the service has deflated them (0023).
CREATE INDEX record_unpacked ON record (id) WHERE packed IS NULL AND length(CAST(body AS BLOB)) >= 2048;
