//! `revise/` in a watched folder: a right file takes the place of what is stored for its IMU and time, as soon as a
//! file beside it says who wants that and why. The agent writes that file, to be filled in.

use std::ffi::{OsStr, OsString};
use std::io::Read;
use std::time::{Duration, SystemTime};

use super::folder::Dir;
use super::source::MAX_DOCUMENT_BYTES;
use crate::cli::client::Service;
use crate::cli::correct::{ReasonArgs, replace};
use crate::cli::prelude::*;
use crate::logs::sheet::readable;
use crate::logs::text::of_any;
use crate::system::Clock;

pub const REVISE: &str = "revise";
/// What the file that says who and why is called after the one that it is about.
pub const WHY: &str = ".why.txt";
const ASKED: &str = "author: \nreason: \n";

/// What became of a file.
pub enum RevisionOutcome {
    /// Nobody has said yet who and why.
    Asked {
        now: bool,
    },
    Done(String),
    Refused(String),
}

/// Tries one file that has not changed for `settle`; none of one that has, or that changes while it is sent.
///
/// # Errors
/// Trouble with the folder or the service: it is tried again.
pub async fn deliver(
    dir: &Dir,
    name: &OsStr,
    settle: Duration,
    service: &Service,
) -> anyhow::Result<Option<RevisionOutcome>> {
    let why = with(name, WHY);
    let Some(typed) = text(dir, &why)? else {
        dir.write(&why, ASKED.as_bytes()).with_context(|| why.display().to_string())?;
        return Ok(Some(RevisionOutcome::Asked { now: true }));
    };
    let now = SystemTime::UNIX_EPOCH + Duration::from_micros(Clock::System.now().0.unsigned_abs());
    let still = |name: &OsStr| {
        let changed = dir.stamp(name).and_then(|(_, changed)| changed);
        changed.and_then(|at| now.duration_since(at).ok()).is_some_and(|age| age >= settle)
    };
    if !still(name) || !still(&why) {
        return Ok(None);
    }
    let typed = of_any(&typed);
    let Some(who) = remark(&typed) else {
        if typed.trim() == ASKED.trim() {
            return Ok(Some(RevisionOutcome::Asked { now: false }));
        }
        let why = why.display().to_string();
        anyhow::bail!("{}", said(message!("terminal_revise_unsaid", file = why)));
    };
    let as_sent = dir.stamp(name);
    let Some(bytes) = text(dir, name)? else { return Ok(None) };
    let bytes = match readable(bytes) {
        Ok(bytes) => bytes,
        Err(fault) => return Ok(Some(RevisionOutcome::Refused(said(fault)))),
    };
    let fate = match replace(service, &bytes, None, &who).await? {
        Ok(done) => RevisionOutcome::Done(done),
        Err(refused) => RevisionOutcome::Refused(refused),
    };
    // One that changed meanwhile stays, to be sent as it is now.
    Ok((dir.stamp(name) == as_sent).then_some(fate))
}

/// The name of a file that belongs to another.
pub fn with(name: &OsStr, ending: &str) -> OsString {
    let mut name = name.to_owned();
    name.push(ending);
    name
}

fn text(dir: &Dir, name: &OsStr) -> std::io::Result<Option<Vec<u8>>> {
    if !dir.has(name) {
        return Ok(None);
    }
    let Some(file) = dir.file(name)? else { return Ok(None) };
    let mut bytes = Vec::new();
    file.take(MAX_DOCUMENT_BYTES).read_to_end(&mut bytes)?;
    Ok(Some(bytes))
}

/// Author and reason; none where one is not said.
fn remark(text: &str) -> Option<ReasonArgs> {
    let value = |key: &str| {
        let of_key = |line: &str| {
            let (name, value) = line.split_once([':', '：'])?;
            (name.trim().eq_ignore_ascii_case(key) && !value.trim().is_empty()).then(|| value.trim().to_owned())
        };
        text.lines().find_map(of_key)
    };
    Some(ReasonArgs { author: value("author")?, reason: value("reason")? })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn who(author: &str, reason: &str) -> Option<ReasonArgs> {
        Some(ReasonArgs { author: author.to_owned(), reason: reason.to_owned() })
    }

    #[test]
    fn a_remark_needs_author_and_reason() {
        let both = who("Li Wei", "wrong latitude: 34");
        assert_eq!(remark("author: Li Wei\r\nReason: wrong latitude: 34\r\n"), both);
        assert_eq!(remark(ASKED), None);
        assert_eq!(remark("author: Li Wei\n"), None);
        assert_eq!(remark("author：Li Wei\nreason：wrong latitude: 34\n"), both, "full-width colons");
    }

    #[test]
    fn who_and_why_are_read_as_notepad_saves_them() {
        const TYPED: &str = "author: 李伟\r\nreason: 纬度错误\r\n";
        let said = who("李伟", "纬度错误");
        let gbk = encoding_rs::GBK.encode(TYPED).0;
        let little: Vec<u8> = [0xfeff].into_iter().chain(TYPED.encode_utf16()).flat_map(u16::to_le_bytes).collect();
        for bytes in [TYPED.as_bytes(), &gbk, &little] {
            assert_eq!(remark(&of_any(bytes)), said);
        }
    }
}
