-- What an event with a duration was: when it was over, and which environmental test was made (vibration, thermal cycling, ...).
ALTER TABLE event ADD COLUMN until INTEGER;
ALTER TABLE event ADD COLUMN test TEXT;
