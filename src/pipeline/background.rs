//! Work that can wait, on threads of its own that the operating system lets run when nobody else wants the processor.

use tokio::sync::oneshot;

/// Runs `work` behind everything else; none where it panicked or no thread could be had.
pub(super) async fn behind_others<T: Send + 'static>(
    name: &'static str,
    work: impl FnOnce() -> T + Send + 'static,
) -> Option<T> {
    let (done, result) = oneshot::channel();
    let started = std::thread::Builder::new().name(name.to_owned()).spawn(move || {
        step_back();
        // Whoever asked may have gone.
        let _gone = done.send(work());
    });
    if let Err(error) = started {
        tracing::error!(%error, name, "no thread could be started");
        return None;
    }
    result.await.ok()
}

/// The least priority that a thread can give itself. It cannot take it back, so the thread must end with its work.
#[cfg(target_os = "linux")]
fn step_back() {
    const LEAST: i32 = 19;
    // What POSIX says of a process Linux does for the calling thread alone.
    if let Err(error) = rustix::process::nice(LEAST) {
        tracing::debug!(%error, "the priority of a thread could not be lowered");
    }
}

#[cfg(not(target_os = "linux"))]
fn step_back() {}

#[cfg(test)]
mod tests {
    use super::behind_others;

    #[tokio::test]
    async fn its_result_comes_back_and_a_panic_comes_back_as_nothing() {
        assert_eq!(behind_others("work", || 6 * 7).await, Some(42));
        assert_eq!(behind_others("work", || panic!("on purpose")).await, None::<()>);
    }

    #[cfg(target_os = "linux")]
    #[tokio::test]
    async fn only_its_own_thread_steps_back() {
        let niceness = || rustix::process::nice(0).expect("reading it changes nothing");
        let before = niceness();
        assert_eq!(behind_others("work", niceness).await, Some(19));
        assert_eq!(niceness(), before);
    }
}
