//! Work that computes for long, on threads of its own, and when it gives way to others.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use tokio::sync::oneshot;
use tokio::time::Instant;

/// Who waits for the work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum WorkPriority {
    /// A person: it is done like any request.
    Interactive,
    /// Nobody yet: the operating system gives it a tenth of a processor that others want too. Not less, because
    /// somebody may come to wait for it.
    Background,
}

/// Runs `work` on a thread of its own; none where it panicked or no thread could be had.
pub(crate) async fn beside_others<T: Send + 'static>(
    name: &'static str,
    awaited: WorkPriority,
    work: impl FnOnce() -> T + Send + 'static,
) -> Option<T> {
    let (done, result) = oneshot::channel();
    let started = std::thread::Builder::new().name(name.to_owned()).spawn(move || {
        if awaited == WorkPriority::Background {
            step_back();
        }
        // Whoever asked may have gone.
        let _gone = done.send(work());
    });
    if let Err(error) = started {
        tracing::error!(%error, name, "no thread could be started");
        return None;
    }
    result.await.ok()
}

/// The thread cannot take it back, so it must end with its work.
#[cfg(target_os = "linux")]
fn step_back() {
    const BEHIND: i32 = 10;
    // What POSIX says of a process Linux does for the calling thread alone.
    if let Err(error) = rustix::process::nice(BEHIND) {
        tracing::debug!(%error, "the priority of a thread could not be lowered");
    }
}

#[cfg(not(target_os = "linux"))]
fn step_back() {}

/// When something last came in whose sender waits for its answer. Cheap to clone.
#[derive(Debug, Clone)]
pub(crate) struct IdleDetector(Arc<Mutex<Instant>>);

/// What nobody waits for begins when nothing has come in for this long,
const QUIET: Duration = Duration::from_millis(100);
/// or when it has given way for this long.
const GIVES_WAY: Duration = Duration::from_secs(1);

impl IdleDetector {
    pub fn new() -> Self {
        Self(Arc::new(Mutex::new(Instant::now())))
    }

    /// Something comes in.
    pub fn note_activity(&self) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Instant::now();
    }

    /// Lets what comes in go first, for a second at the most.
    pub async fn give_way(&self) {
        self.wait_for_idle(QUIET, GIVES_WAY).await;
    }

    /// Returns when nothing has come in for as long as `quiet`, after `most` in any case.
    async fn wait_for_idle(&self, quiet: Duration, most: Duration) {
        let end = Instant::now() + most;
        loop {
            let settled = *self.0.lock().unwrap_or_else(PoisonError::into_inner) + quiet;
            if Instant::now() >= settled.min(end) {
                return;
            }
            tokio::time::sleep_until(settled.min(end)).await;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use tokio::time::Instant;

    use super::WorkPriority::{Background, Interactive};
    use super::{IdleDetector, beside_others};

    #[tokio::test]
    async fn its_result_comes_back_and_a_panic_comes_back_as_nothing() {
        assert_eq!(beside_others("work", Interactive, || 6 * 7).await, Some(42));
        assert_eq!(beside_others("work", Background, || panic!("on purpose")).await, None::<()>);
    }

    #[cfg(target_os = "linux")]
    #[tokio::test]
    async fn only_a_thread_that_nobody_waits_for_steps_back() {
        let niceness = || rustix::process::nice(0).expect("reading it changes nothing");
        let before = niceness();
        assert_eq!(beside_others("work", Background, niceness).await, Some((before + 10).min(19)));
        assert_eq!(beside_others("work", Interactive, niceness).await, Some(before));
        assert_eq!(niceness(), before);
    }

    #[tokio::test]
    async fn it_waits_for_a_lull_and_not_for_ever() {
        let (quiet, most) = (Duration::from_millis(200), Duration::from_millis(600));
        let begun = Instant::now();
        let idle = IdleDetector::new();
        idle.wait_for_idle(quiet, Duration::from_secs(3600)).await;
        assert!(begun.elapsed() >= quiet);

        let coming = idle.clone();
        let senders = tokio::spawn(async move {
            loop {
                coming.note_activity();
                tokio::time::sleep(Duration::from_millis(5)).await;
            }
        });
        let begun = Instant::now();
        idle.note_activity();
        idle.wait_for_idle(quiet, most).await;
        assert!(begun.elapsed() >= most);
        senders.abort();
    }
}
