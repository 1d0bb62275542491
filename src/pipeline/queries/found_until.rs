//! Answers that may take long, for who does not wait.

use tokio::time::{Instant, timeout_at};

/// What is found until an instant; later it is found to the end all the same, for who asks next.
pub(super) async fn found_until<T: Send + 'static>(
    until: Instant,
    found: impl Future<Output = T> + Send + 'static,
) -> Option<T> {
    timeout_at(until, tokio::spawn(found)).await.ok()?.ok()
}
