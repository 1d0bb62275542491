-- The text of a campaign, and of a diagnosis, deflated (RFC 1950) where it is long: then `body` is empty. What an earlier version stored
-- stays in `body`.
ALTER TABLE record ADD COLUMN packed BLOB;
ALTER TABLE diagnosis ADD COLUMN packed BLOB;
