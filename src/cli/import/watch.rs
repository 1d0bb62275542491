//! `import --watch`: the station agent. A file dropped into the folder is sent, and moves only when its fate is known.
//!
//! The folder is the whole state: a file that lies there has not been acknowledged, so that a restart after any
//! kind of death goes on where it was. What was stored but not yet moved is sent again, which does no harm.

use std::collections::HashMap;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

use anyhow::Context;

use super::gist::Gist;
use super::send::{Courier, Event, Refusal, Tally};
use super::source;
use crate::cli::client::{Service, Trouble};
use crate::core::time::UtcMicros;
use crate::system::Clock;
use crate::wire::time;

const POLL: Duration = Duration::from_millis(200);
/// How long a text that breaks off may still be somebody's unfinished writing.
const CUT_SHORT_GRACE: Duration = Duration::from_secs(60);
const FIRST_PAUSE: Duration = Duration::from_millis(500);
const LONGEST_PAUSE: Duration = Duration::from_secs(60);
/// What programs call a file that they have not finished.
const UNFINISHED: [&str; 6] = [".tmp", ".part", ".partial", ".crdownload", ".swp", "~"];

/// Watches until the process is ended.
///
/// `digest`: each file is an import, whose end the service is told.
pub async fn watch(dir: &Path, settle: Duration, service: &Service, digest: bool) -> anyhow::Result<()> {
    let mut folder = Folder { digest, ..Folder::open(dir, settle)? };
    say(&format!("watching {} for {}", dir.display(), service.base()));
    loop {
        folder.pass(service).await;
        tokio::time::sleep(POLL).await;
    }
}

/// Size and time of change: while they stand still, so does the file.
type Stamp = (u64, Option<SystemTime>);

struct Folder {
    dir: PathBuf,
    sent: PathBuf,
    refused: PathBuf,
    settle: Duration,
    digest: bool,
    waiting: HashMap<PathBuf, Waiting>,
    /// Trouble that concerns every file: the folder cannot be read, or no service answers.
    trouble: Trials,
}

struct Waiting {
    stamp: Stamp,
    since: Instant,
    /// Trouble with this file alone.
    trouble: Trials,
}

enum Fate {
    Stored(Tally),
    Refused(Vec<Refusal>),
    /// Breaks off, and is young.
    Unfinished,
}

impl Folder {
    fn open(dir: &Path, settle: Duration) -> anyhow::Result<Self> {
        let (sent, refused) = (dir.join("sent"), dir.join("refused"));
        for dir in [&sent, &refused] {
            fs::create_dir_all(dir).with_context(|| format!("cannot create {}", dir.display()))?;
        }
        let (waiting, trouble) = (HashMap::new(), Trials::default());
        Ok(Self { dir: dir.to_owned(), sent, refused, settle, digest: false, waiting, trouble })
    }

    /// Looks once, and tries every file whose time has come, in the order of their names.
    async fn pass(&mut self, service: &Service) {
        if !self.trouble.due() {
            return;
        }
        if let Err(error) = self.look() {
            return self.trouble.again(&format!("cannot read {}: {error}", self.dir.display()), None);
        }
        let due = |w: &Waiting| w.since.elapsed() >= self.settle && w.trouble.due();
        let mut files: Vec<_> = self.waiting.iter().filter(|(_, w)| due(w)).map(|(path, _)| path.clone()).collect();
        files.sort();
        for path in files {
            let outcome = self.deliver(&path, service).await.and_then(|fate| self.conclude(&path, fate));
            let Err(error) = outcome else {
                self.trouble.over();
                continue;
            };
            match error.downcast_ref::<Trouble>() {
                Some(Trouble::Away(why)) => return self.trouble.again(why, None),
                Some(Trouble::Again { after, .. }) => self.again(&path, &error, *after),
                Some(Trouble::Stop(_)) | None => self.again(&path, &error, None),
            }
        }
    }

    /// Notes new and changed files, forgets those that are gone.
    fn look(&mut self) -> std::io::Result<()> {
        let mut before = std::mem::take(&mut self.waiting);
        for entry in fs::read_dir(&self.dir)? {
            let path = entry?.path();
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            if name.starts_with('.') || UNFINISHED.iter().any(|ending| name.ends_with(ending)) {
                continue;
            }
            let Some(stamp) = stamp(&path) else { continue };
            let new = || Waiting { stamp, since: Instant::now(), trouble: Trials::default() };
            let waiting = before.remove(&path).filter(|w| w.stamp == stamp).unwrap_or_else(new);
            self.waiting.insert(path, waiting);
        }
        Ok(())
    }

    async fn deliver(&self, path: &Path, service: &Service) -> anyhow::Result<Fate> {
        let content = match source::open(path)? {
            Ok(content) => content,
            Err(unreadable) if unreadable.cut_short && self.age(path) < CUT_SHORT_GRACE => return Ok(Fate::Unfinished),
            Err(unreadable) => return Ok(Fate::Refused(vec![Refusal { line: None, why: unreadable.why }])),
        };
        let (mut refusals, mut gist) = (Vec::new(), String::new());
        let mut tell = |event: Event<'_>| match event {
            Event::Refused(refusal) => refusals.push(refusal),
            Event::Answered(answer) => gist = Gist(answer).to_string(),
            Event::Noted { line, note } => say(&format!("{}:{line}: note: {note}", path.display())),
            Event::Carried { .. } => {}
        };
        let tally = Courier::new(service, &[], &mut tell).carry(content).await?;
        if self.digest && tally.stored > 0 {
            super::end(service).await;
        }
        if !gist.is_empty() {
            say(&format!("{}\n{}", path.display(), gist.trim_end()));
        }
        Ok(if refusals.is_empty() { Fate::Stored(tally) } else { Fate::Refused(refusals) })
    }

    /// Moves a file whose fate is known; one that changed meanwhile stays, to be sent as it is now.
    fn conclude(&mut self, path: &Path, fate: Fate) -> anyhow::Result<()> {
        let sent_as = self.waiting.get(path).map(|w| w.stamp);
        if matches!(fate, Fate::Unfinished) || stamp(path) != sent_as {
            return Ok(());
        }
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        match fate {
            Fate::Stored(tally) => {
                move_to(path, &free_name(&self.sent, &name))?;
                say(&format!("{name}: {tally}"));
            }
            Fate::Refused(refusals) => {
                let target = free_name(&self.refused, &name);
                let reasons = reasons(&refusals);
                let note = target.with_file_name(format!("{}.reason.txt", file_name(&target)));
                fs::write(&note, &reasons).with_context(|| format!("cannot write {}", note.display()))?;
                move_to(path, &target)?;
                say(&format!("{name}: refused\n{}", reasons.trim_end()));
            }
            Fate::Unfinished => {}
        }
        self.waiting.remove(path);
        Ok(())
    }

    fn age(&self, path: &Path) -> Duration {
        self.waiting.get(path).map_or(Duration::ZERO, |w| w.since.elapsed())
    }

    fn again(&mut self, path: &Path, error: &anyhow::Error, after: Option<Duration>) {
        if let Some(waiting) = self.waiting.get_mut(path) {
            waiting.trouble.again(&format!("{}: {error:#}; it stays and is tried again", path.display()), after);
        }
    }
}

/// Tries that failed: when the next is due, and what has been said already.
struct Trials {
    not_before: Option<Instant>,
    pause: Duration,
    said: String,
}

impl Default for Trials {
    fn default() -> Self {
        Self { not_before: None, pause: FIRST_PAUSE, said: String::new() }
    }
}

impl Trials {
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

/// None for what is not a plain file, or is gone.
fn stamp(path: &Path) -> Option<Stamp> {
    let metadata = fs::metadata(path).ok().filter(|m| m.is_file())?;
    Some((metadata.len(), metadata.modified().ok()))
}

fn reasons(refusals: &[Refusal]) -> String {
    refusals.iter().map(|refusal| format!("{refusal}\n")).collect()
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// `name`, or `name.2`, `name.3`, … where earlier files of that name have gone before.
fn free_name(dir: &Path, name: &str) -> PathBuf {
    let numbered = (2..).map(|n| dir.join(format!("{name}.{n}")));
    let mut names = std::iter::once(dir.join(name)).chain(numbered);
    names.find(|path| !path.exists()).expect("some number is free, or the directory would be infinite")
}

fn move_to(path: &Path, target: &Path) -> anyhow::Result<()> {
    fs::rename(path, target).with_context(|| format!("cannot move it to {}", target.display()))
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
        let dir = tempfile::tempdir().unwrap();
        let names: Vec<String> = (0..3)
            .map(|_| {
                let path = free_name(dir.path(), "run.json");
                fs::write(&path, "").unwrap();
                file_name(&path)
            })
            .collect();
        assert_eq!(names, ["run.json", "run.json.2", "run.json.3"]);
    }

    #[test]
    fn pauses_double_up_to_a_minute_and_start_afresh_after_success() {
        let mut trials = Trials::default();
        assert!(trials.due());
        trials.again("down", None);
        assert!(!trials.due());
        for _ in 0..20 {
            trials.again("down", None);
        }
        assert_eq!(trials.pause, LONGEST_PAUSE);
        trials.over();
        assert!(trials.due());
        assert_eq!(trials.pause, FIRST_PAUSE);
    }
}
