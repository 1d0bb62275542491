//! What was found by a look at many rows, kept for who asks next; answers that may take long, for who does not wait.

use tokio::sync::Mutex;
use tokio::time::{Instant, timeout_at};

use crate::pipeline::prelude::*;

/// The last answer to a question: it holds until something is written that it is about, by any server, or an instant
/// has passed.
#[derive(Debug)]
pub(in crate::pipeline) struct CachedAnswer<T>(Mutex<Option<Answer<T>>>);

#[derive(Debug)]
struct Answer<T> {
    found: Arc<T>,
    version: [i64; 2],
    /// First and last instant at which the answer is the same.
    holds: [UtcMicros; 2],
    begun: Instant,
}

impl<T> Default for CachedAnswer<T> {
    fn default() -> Self {
        Self(Mutex::new(None))
    }
}

impl<T> CachedAnswer<T> {
    /// What `find` finds at an instant; with it comes the last instant at which it would find the same where the
    /// version is the same. Who asks while it is sought waits for it.
    pub async fn at(
        &self,
        version: impl Future<Output = Result<[i64; 2], StoreError>>,
        now: UtcMicros,
        find: impl Future<Output = Result<(T, UtcMicros), StoreError>>,
    ) -> Result<Arc<T>, StoreError> {
        let asked = Instant::now();
        let mut kept = self.0.lock().await;
        // Read before the rows: what is written meanwhile is another version.
        let version = version.await?;
        let holds = |answer: &&Answer<T>| {
            let is_current = answer.version == version || answer.begun >= asked;
            is_current && answer.holds[0] <= now && now <= answer.holds[1]
        };
        if let Some(answer) = kept.as_ref().filter(holds) {
            return Ok(answer.found.clone());
        }
        let begun = Instant::now();
        let (found, until) = find.await?;
        let found = Arc::new(found);
        *kept = Some(Answer { found: found.clone(), version, holds: [now, until], begun });
        Ok(found)
    }

    /// Whether an answer is being sought.
    pub fn is_computing(&self) -> bool {
        self.0.try_lock().is_err()
    }
}

/// What is found until an instant; later it is found to the end all the same, for who asks next.
pub(in crate::pipeline) async fn found_until<T: Send + 'static>(
    until: Instant,
    found: impl Future<Output = T> + Send + 'static,
) -> Option<T> {
    timeout_at(until, tokio::spawn(found)).await.ok()?.ok()
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    async fn asked(kept: &CachedAnswer<i64>, version: i64, now: i64, finds: i64) -> i64 {
        let find = async {
            tokio::time::sleep(Duration::from_millis(20)).await;
            Ok::<_, StoreError>((finds, UtcMicros(now + 10)))
        };
        *kept.at(async { Ok([version, 0]) }, UtcMicros(now), find).await.unwrap()
    }

    #[tokio::test]
    async fn an_answer_is_kept_until_something_is_written_or_time_changes_it() {
        let kept = CachedAnswer::default();
        for (version, now, finds, found) in
            [(1, 100, 7, 7), (1, 110, 8, 7), (1, 111, 8, 8), (1, 100, 9, 9), (2, 105, 10, 10), (2, 105, 11, 10)]
        {
            assert_eq!(asked(&kept, version, now, finds).await, found, "version {version} at {now}");
        }
    }

    #[tokio::test]
    async fn who_waits_shares_what_was_sought_after_they_asked_and_nothing_older() {
        let kept = CachedAnswer::default();
        let all = tokio::join!(asked(&kept, 1, 100, 7), asked(&kept, 2, 100, 8), asked(&kept, 3, 100, 9));
        assert_eq!(all, (7, 8, 8));
        assert_eq!(asked(&kept, 4, 100, 10).await, 10);
    }
}
