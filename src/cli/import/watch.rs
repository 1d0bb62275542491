//! `import --watch`: the station agent. A file dropped into the folder is sent, and moves only when its fate is known.
//!
//! The folder is the whole state: a file that lies there has not been acknowledged, so that a restart after any
//! kind of death goes on where it was. What was stored but not yet moved is sent again, which does no harm.
//!
//! Who may write to the folder must not make the agent read or write anything else: see [`folder`](super::folder).

use std::collections::{HashMap, HashSet};
use std::ffi::{OsStr, OsString};
use std::io::Write;
use std::time::{Duration, Instant};

use super::answer_summary::AnswerSummary;
use super::folder::{Dir, FileStamp};
use super::revise::{self, REVISE, WHY, with};
use super::send::{Event, ImportCounts, Importer, Refusal, end};
use super::source::{self, Content, UnfinishedFile};
use crate::cli::client::{ClientError, Service};
use crate::cli::errors::with_causes;
use crate::cli::prelude::*;
use crate::core::message::Message;
use crate::core::time::UtcMicros;
use crate::system::Clock;
use crate::wire::record_table::TableMap;

const POLL: Duration = Duration::from_millis(200);
/// How long a file must not change before it is sent: one document in JSON, and what has no end of its own.
const SETTLE: Duration = Duration::from_secs(1);
const SETTLE_OPEN: Duration = Duration::from_secs(30);
const FIRST_PAUSE: Duration = Duration::from_millis(500);
const LONGEST_PAUSE: Duration = Duration::from_secs(60);
/// Where files go whose fate is known.
const SENT: &str = "sent";
const REFUSED: &str = "refused";
/// What programs call a file that they have not finished, and what Windows leaves in a folder.
const UNFINISHED: [&str; 6] = [".tmp", ".part", ".partial", ".crdownload", ".swp", "~"];
const OF_WINDOWS: [&str; 2] = ["desktop.ini", "thumbs.db"];

/// Watches until the process is ended.
///
/// `digest`: each file is an import, whose end the service is told.
pub async fn watch(
    dir: &Path,
    map: TableMap,
    settle: Option<Duration>,
    service: &Service,
    digest: bool,
) -> anyhow::Result<()> {
    let mut folder = Folder { map, digest, ..Folder::open(dir, settle)? };
    announce(message!("terminal_watching", folder = dir.display().to_string(), service = service.base().to_string()));
    loop {
        folder.pass(service).await;
        folder.revise(service).await;
        tokio::time::sleep(POLL).await;
    }
}

struct Folder {
    path: PathBuf,
    /// As it was opened for this pass.
    dir: Dir,
    /// For how long a file must not change; by its kind where nothing is said.
    settle: Option<Duration>,
    digest: bool,
    map: TableMap,
    waiting: HashMap<OsString, PendingFile>,
    /// Symbolic links that somebody has heard of.
    links: HashSet<OsString>,
    /// Trouble that concerns every file: the folder cannot be read, or no service answers.
    trouble: RetryState,
    /// Trouble with `revise` as a whole, and with each file that waits in it.
    revising: RetryState,
    revisions: HashMap<OsString, RetryState>,
}

fn is_left_alone(name: &str) -> bool {
    let name = name.to_lowercase();
    // `~$run.xlsx` says that Excel has run.xlsx open.
    let hidden = name.starts_with('.') || name.starts_with("~$") || OF_WINDOWS.contains(&name.as_str());
    hidden || UNFINISHED.iter().any(|ending| name.ends_with(ending))
}

/// A JSON document says itself where it ends; a table and lines of JSON may go on.
fn usual_settle(name: &OsStr) -> Duration {
    if name.to_string_lossy().to_lowercase().ends_with(".json") { SETTLE } else { SETTLE_OPEN }
}

struct PendingFile {
    stamp: FileStamp,
    since: Instant,
    /// Trouble with this file alone.
    trouble: RetryState,
}

enum FileOutcome {
    Stored(ImportCounts),
    Refused(Vec<Refusal>),
    /// Breaks off, and is young.
    Unfinished,
}

impl Folder {
    fn open(path: &Path, settle: Option<Duration>) -> anyhow::Result<Self> {
        std::fs::create_dir_all(path).with_context(|| path.display().to_string())?;
        let dir = Dir::open(path).with_context(|| path.display().to_string())?;
        for within in [SENT, REFUSED, REVISE] {
            dir.within(within).with_context(|| path.join(within).display().to_string())?;
        }
        Ok(Self {
            path: path.to_owned(),
            dir,
            settle,
            digest: false,
            map: TableMap::default(),
            waiting: HashMap::new(),
            links: HashSet::new(),
            trouble: RetryState::default(),
            revising: RetryState::default(),
            revisions: HashMap::new(),
        })
    }

    /// Looks once, and tries every file whose time has come, in the order of their names.
    async fn pass(&mut self, service: &Service) {
        if !self.trouble.due() {
            return;
        }
        if let Err(error) = self.look() {
            return self.trouble.again(&format!("{}: {error}", self.path.display()), None);
        }
        let settle = |name: &OsStr| self.settle.unwrap_or_else(|| usual_settle(name));
        let due = |name: &OsStr, w: &PendingFile| w.since.elapsed() >= settle(name) && w.trouble.due();
        let mut files: Vec<_> =
            self.waiting.iter().filter(|(name, w)| due(name, w)).map(|(name, _)| name.clone()).collect();
        files.sort();
        for name in files {
            let outcome = self.deliver(&name, service).await.and_then(|outcome| self.conclude(&name, outcome));
            let Err(error) = outcome else {
                self.trouble.over();
                continue;
            };
            match error.downcast_ref::<ClientError>() {
                Some(ClientError::Unreachable(why)) => return self.trouble.again(why, None),
                Some(ClientError::Retry { after, .. }) => self.again(&name, &error, *after),
                Some(ClientError::Fatal { .. }) | None => self.again(&name, &error, None),
            }
        }
    }

    /// Tries every file in `revise`.
    async fn revise(&mut self, service: &Service) {
        if !self.revising.due() {
            return;
        }
        match self.revise_all(&service.clone().with_notify_query("")).await {
            Ok(()) => self.revising.over(),
            Err(error) => self.revising.again(&stays(format!("{REVISE}: {}", with_causes(&error))), None),
        }
    }

    async fn revise_all(&mut self, service: &Service) -> anyhow::Result<()> {
        let dir = self.within(REVISE)?;
        let mut before = std::mem::take(&mut self.revisions);
        let mut names = dir.names()?;
        names.sort();
        for name in names {
            let shown = name.to_string_lossy().into_owned();
            if is_left_alone(&shown) || shown.ends_with(WHY) || dir.stamp(&name).is_none() {
                continue;
            }
            let mut retry = before.remove(&name).unwrap_or_default();
            if retry.due() {
                match self.revise_one(&dir, &name, service).await {
                    Ok(()) => retry.over(),
                    Err(error) => match error.downcast_ref::<ClientError>() {
                        Some(ClientError::Unreachable(_)) => return Err(error),
                        _ => retry.again(&stays(format!("{REVISE}/{shown}: {}", with_causes(&error))), None),
                    },
                }
            }
            self.revisions.insert(name, retry);
        }
        Ok(())
    }

    async fn revise_one(&self, dir: &Dir, name: &OsStr, service: &Service) -> anyhow::Result<()> {
        let shown = name.to_string_lossy();
        let settle = self.settle.unwrap_or_else(|| usual_settle(name));
        let (to, words) = match revise::deliver(dir, name, settle, service).await? {
            None | Some(revise::RevisionOutcome::Asked { now: false }) => return Ok(()),
            Some(revise::RevisionOutcome::Asked { now: true }) => {
                let file = shown.into_owned();
                announce(message!(
                    "terminal_revise_asked",
                    file = format!("{REVISE}/{file}"),
                    beside = format!("{file}{WHY}")
                ));
                return Ok(());
            }
            Some(revise::RevisionOutcome::Done(words)) => (SENT, words),
            Some(revise::RevisionOutcome::Refused(words)) => (REFUSED, words),
        };
        let target = self.within(to)?;
        let new_name = free_name(&target, name);
        if to == REFUSED {
            target.write(&with(&new_name, ".reason.txt"), format!("{words}\n").as_bytes())?;
        }
        dir.move_to(name, &target, &new_name)?;
        dir.move_to(&with(name, WHY), &target, &free_name(&target, &with(&new_name, WHY)))?;
        say(&format!("{REVISE}/{shown}: {words}"));
        Ok(())
    }

    /// Notes new and changed files, forgets those that are gone.
    fn look(&mut self) -> std::io::Result<()> {
        self.dir = Dir::open(&self.path)?;
        let mut before = std::mem::take(&mut self.waiting);
        let mut links = HashSet::new();
        for name in self.dir.names()? {
            let text = name.to_string_lossy();
            if is_left_alone(&text) {
                continue;
            }
            let Some(stamp) = self.dir.stamp(&name) else {
                if self.dir.is_link(&name) {
                    if !self.links.contains(&name) {
                        announce(message!("terminal_link", file = text.into_owned()));
                    }
                    links.insert(name);
                }
                continue;
            };
            let new = || PendingFile { stamp, since: Instant::now(), trouble: RetryState::default() };
            let waiting = before.remove(&name).filter(|w| w.stamp == stamp).unwrap_or_else(new);
            self.waiting.insert(name, waiting);
        }
        self.links = links;
        Ok(())
    }

    async fn deliver(&self, name: &OsStr, service: &Service) -> anyhow::Result<FileOutcome> {
        let path = self.path.join(name);
        // What is no plain file any more is left out from the next look on.
        let Some(file) = self.dir.file(name)? else { return Ok(FileOutcome::Unfinished) };
        let age = self.age(name);
        let if_unfinished = if age < source::CUT_SHORT { UnfinishedFile::Waits } else { UnfinishedFile::TakesAsItIs };
        let read = source::read_file(file, &self.map, if_unfinished)?;
        // Since it was found due, others have been sent, which takes time.
        if self.dir.stamp(name) != self.waiting.get(name).map(|w| w.stamp) {
            return Ok(FileOutcome::Unfinished);
        }
        let content = match read {
            // Whatever the file is called, more lines may follow.
            Ok(Content::Lines(_)) if age < self.settle.unwrap_or(SETTLE_OPEN) => return Ok(FileOutcome::Unfinished),
            Ok(content) => content,
            Err(unreadable) if age < unreadable.may_go_on => return Ok(FileOutcome::Unfinished),
            Err(unreadable) => return Ok(FileOutcome::Refused(vec![Refusal { line: None, why: unreadable.why }])),
        };
        let (mut refusals, mut summary) = (Vec::new(), String::new());
        let mut tell = |event: Event<'_>| match event {
            Event::Refused(refusal) => refusals.push(refusal),
            Event::Answered(answer) => summary = AnswerSummary(answer).to_string(),
            Event::Noted { line, note } => say(&format!("{}:{line}: {}", path.display(), document::note(note))),
            Event::Carried { .. } => {}
        };
        let tally = Importer::new(service, &[], &mut tell).carry(content).await?;
        // What is known may have been stored by a try that broke off.
        if self.digest && tally.stored + tally.known > 0 {
            end(service).await;
        }
        if !summary.is_empty() {
            say(&format!("{}\n{}", path.display(), summary.trim_end()));
        }
        Ok(if refusals.is_empty() { FileOutcome::Stored(tally) } else { FileOutcome::Refused(refusals) })
    }

    /// Moves a file whose fate is known; one that changed meanwhile stays, to be sent as it is now.
    fn conclude(&mut self, name: &OsStr, outcome: FileOutcome) -> anyhow::Result<()> {
        if self.dir.stamp(name) != self.waiting.get(name).map(|w| w.stamp) {
            return Ok(());
        }
        let shown = name.to_string_lossy();
        match outcome {
            FileOutcome::Stored(tally) => {
                let sent = self.within(SENT)?;
                self.move_to(name, &sent, &free_name(&sent, name))?;
                say(&format!("{shown}: {tally}"));
            }
            FileOutcome::Refused(refusals) => {
                let refused = self.within(REFUSED)?;
                let target = free_name(&refused, name);
                let reasons: String = refusals.iter().map(|refusal| format!("{refusal}\n")).collect();
                let note = with(&target, ".reason.txt");
                refused.write(&note, reasons.as_bytes()).with_context(|| note.display().to_string())?;
                self.move_to(name, &refused, &target)?;
                let refused = word("terminal_file_refused");
                say(&format!("{shown}: {refused}\n{}", reasons.trim_end()));
            }
            FileOutcome::Unfinished => return Ok(()),
        }
        self.waiting.remove(name);
        Ok(())
    }

    fn within(&self, name: &str) -> anyhow::Result<Dir> {
        self.dir.within(name).with_context(|| self.path.join(name).display().to_string())
    }

    fn move_to(&self, name: &OsStr, to: &Dir, target: &OsStr) -> anyhow::Result<()> {
        self.dir
            .move_to(name, to, target)
            .with_context(|| said(message!("terminal_cannot_move", file = target.display().to_string())))
    }

    fn age(&self, name: &OsStr) -> Duration {
        self.waiting.get(name).map_or(Duration::ZERO, |w| w.since.elapsed())
    }

    fn again(&mut self, name: &OsStr, error: &anyhow::Error, after: Option<Duration>) {
        if let Some(waiting) = self.waiting.get_mut(name) {
            let path = self.path.join(name);
            waiting.trouble.again(&stays(format!("{}: {}", path.display(), with_causes(error))), after);
        }
    }
}

/// Tries that failed: when the next is due, and what has been said already.
struct RetryState {
    not_before: Option<Instant>,
    pause: Duration,
    said: String,
}

impl Default for RetryState {
    fn default() -> Self {
        Self { not_before: None, pause: FIRST_PAUSE, said: String::new() }
    }
}

impl RetryState {
    fn due(&self) -> bool {
        self.not_before.is_none_or(|instant| Instant::now() >= instant)
    }

    /// Waits twice as long each time; `after` is what the service itself asked for. The same words are said once.
    fn again(&mut self, why: &str, after: Option<Duration>) {
        if self.said != why {
            say(why);
            why.clone_into(&mut self.said);
        }
        self.not_before = Some(Instant::now() + after.unwrap_or(self.pause).min(LONGEST_PAUSE));
        self.pause = (2 * self.pause).min(LONGEST_PAUSE);
    }

    fn over(&mut self) {
        *self = Self::default();
    }
}

/// `name`, or `name.2`, `name.3`, … where earlier files of that name have gone before.
fn free_name(dir: &Dir, name: &OsStr) -> OsString {
    let numbered = (2..).map(|n| with(name, &format!(".{n}")));
    let mut names = std::iter::once(name.to_owned()).chain(numbered);
    names.find(|name| !dir.has(name)).expect("some number is free, or the directory would be infinite")
}

fn stays(trouble: String) -> String {
    said(message!("terminal_stays", trouble))
}

fn announce(message: Message) {
    say(&said(message));
}

/// One event a line, with its time: what an operator, or the journal, reads.
fn say(words: &str) {
    let now = Clock::System.now();
    let whole_second = UtcMicros(now.0 - now.0.rem_euclid(UtcMicros::SECOND));
    // Nobody may be reading any more; the files matter, not the words.
    let _unread = writeln!(std::io::stdout(), "{} {words}", time::format(whole_second));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_are_taken_are_numbered() {
        let at = tempfile::tempdir().unwrap();
        let dir = Dir::open(at.path()).unwrap();
        let names: Vec<OsString> = (0..3)
            .map(|_| {
                let name = free_name(&dir, OsStr::new("run.json"));
                std::fs::write(at.path().join(&name), "").unwrap();
                name
            })
            .collect();
        assert_eq!(names, ["run.json", "run.json.2", "run.json.3"]);
    }

    #[tokio::test]
    async fn a_file_that_is_swapped_for_a_link_after_it_was_seen_is_not_read() {
        crate::system::install_crypto();
        let (at, elsewhere) = (tempfile::tempdir().unwrap(), tempfile::NamedTempFile::new().unwrap());
        std::fs::write(elsewhere.path(), "secret").unwrap();
        let file = at.path().join("run.json");
        std::fs::write(&file, "secret").unwrap();
        let mut folder = Folder::open(at.path(), Some(Duration::ZERO)).unwrap();
        folder.look().unwrap();
        assert!(folder.waiting.contains_key(OsStr::new("run.json")));
        std::fs::remove_file(&file).unwrap();
        std::os::unix::fs::symlink(elsewhere.path(), &file).unwrap();
        let nobody = Service::at("127.0.0.1:1", None).unwrap();
        let outcome = folder.deliver(OsStr::new("run.json"), &nobody).await.unwrap();
        assert!(matches!(outcome, FileOutcome::Unfinished));
    }

    #[tokio::test]
    async fn a_file_that_is_written_on_after_it_was_found_due_is_not_sent_yet() {
        crate::system::install_crypto();
        let at = tempfile::tempdir().unwrap();
        let mut folder = Folder::open(at.path(), Some(Duration::ZERO)).unwrap();
        let nobody = Service::at("127.0.0.1:1", None).unwrap();
        let name = OsStr::new("run.json");
        std::fs::write(at.path().join(name), "{\"gyros\": []}").unwrap();
        folder.look().unwrap();
        std::fs::write(at.path().join(name), "{\"gyros\": [], \"dwells\": []}").unwrap();
        assert!(matches!(folder.deliver(name, &nobody).await.unwrap(), FileOutcome::Unfinished));
        folder.look().unwrap();
        assert!(folder.deliver(name, &nobody).await.is_err(), "it is sent when it has not changed");
    }

    #[tokio::test]
    async fn lines_that_may_go_on_wait_as_long_as_a_table_whatever_the_file_is_called() {
        crate::system::install_crypto();
        assert_eq!(usual_settle(OsStr::new("run.JSON")), SETTLE);
        for open in ["run.ndjson", "run.jsonl", "run.csv"] {
            assert_eq!(usual_settle(OsStr::new(open)), SETTLE_OPEN, "{open}");
        }
        let at = tempfile::tempdir().unwrap();
        let (name, nobody) = (OsStr::new("run.json"), Service::at("127.0.0.1:1", None).unwrap());
        std::fs::write(at.path().join(name), "{\"gyros\": []}\n{\"gyros\": []}\n").unwrap();
        let mut folder = Folder::open(at.path(), None).unwrap();
        folder.look().unwrap();
        assert!(matches!(folder.deliver(name, &nobody).await.unwrap(), FileOutcome::Unfinished));
        folder.settle = Some(Duration::ZERO);
        assert!(folder.deliver(name, &nobody).await.is_err(), "lines are sent");
        std::fs::write(at.path().join(name), "{\"gyros\": []}\n{\"gyros\": []}").unwrap();
        folder.look().unwrap();
        assert!(
            matches!(folder.deliver(name, &nobody).await.unwrap(), FileOutcome::Unfinished),
            "its last line has no end"
        );
    }

    #[test]
    fn pauses_double_up_to_a_minute_and_start_afresh_after_success() {
        let mut retry = RetryState::default();
        assert!(retry.due());
        retry.again("down", None);
        assert!(!retry.due());
        for _ in 0..20 {
            retry.again("down", None);
        }
        assert_eq!(retry.pause, LONGEST_PAUSE);
        retry.over();
        assert!(retry.due());
        assert_eq!(retry.pause, FIRST_PAUSE);
    }
}
