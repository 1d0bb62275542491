//! Admitting the result of a bench test.

use std::sync::Arc;

use super::context::Admission;
use super::group::Group;
use crate::core::id::Id;
use crate::pipeline::ingest::same_content::benches_agree;
use crate::pipeline::ingest::submission::BenchTest;
use crate::pipeline::{Accepted, Refused};
use crate::store;
use crate::store::{BenchRow, NamesOf, StoreError};

impl Admission<'_> {
    pub(super) async fn bench(&mut self, sent: &BenchTest, group: &mut Group) -> Result<Accepted, Refused> {
        if let Some(there) = self.by_key(sent.idempotency_key.as_deref(), &sent.body_sha256, group).await? {
            return Ok(there);
        }
        let result = &sent.result;
        let (at, method) = (result.measured_at, result.method);
        if let Some(gyro) = self.number(NamesOf::Gyros, result.serial.as_str(), group) {
            let mut counting = None;
            if let Some((id, hash)) = group.benches.get(&(gyro, at, method)) {
                if *hash == sent.body_sha256 {
                    return Ok(Accepted::There { id: *id, same_bytes: true });
                }
                counting = Some(*id);
            }
            for there in store::bench::at(self.store, gyro, at, method).await? {
                let same_bytes = there.hash == sent.body_sha256;
                let counts = !there.voided && !group.changes.withdrawn.benches.contains(&(there.id, gyro));
                // What was voided and is sent again stays as it is: the sender does not know.
                if same_bytes || self.is_alike(there.id, &sent.body).await? {
                    return Ok(Accepted::There { id: there.id, same_bytes: same_bytes || !counts });
                }
                counting = counting.or(counts.then_some(there.id));
            }
            if let Some(id) = counting {
                return Ok(Accepted::There { id, same_bytes: false });
            }
        }
        let id = self.ids.next(self.now);
        let home = store::names::cell_of_gyro(self.store, result.serial.as_str());
        let gyro = self.take_number(NamesOf::Gyros, result.serial.as_str(), home, group);
        let station = self.take_number(NamesOf::Stations, result.station.as_str(), home, group);
        let sent_by = Some(self.sent("bench-results", id, group));
        group.benches.insert((gyro, at, method), (id, sent.body_sha256));
        group.take_key(sent.idempotency_key.as_deref(), id, sent.body_sha256);
        group.changes.benches.push(BenchRow {
            id,
            gyro,
            station,
            measured_at: at,
            method,
            d: [result.d_i, result.d_s],
            sd: [result.d_i_sd, result.d_s_sd],
            voided: false,
            received_at: self.now,
            body: Arc::clone(&sent.body),
            body_sha256: sent.body_sha256,
            sent_by,
        });
        Ok(Accepted::stored(id))
    }

    async fn is_alike(&self, bench: Id, body: &str) -> Result<bool, StoreError> {
        Ok(store::bench::get(self.store, bench).await?.is_some_and(|stored| benches_agree(&stored.body, body)))
    }
}
