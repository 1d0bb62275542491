-- Long texts that an earlier version stored as they were sent, until the service has deflated them (0016).
CREATE INDEX record_unpacked ON record (id) WHERE packed IS NULL AND octet_length(body) >= 2048;
