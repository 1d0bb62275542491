//! What a service asked of its disk, in order, as `strace` saw it; and the disk after a power cut at any moment of
//! that.

pub mod disk;

use std::collections::HashMap;
use std::path::Path;

/// Calls that reach the disk, and those that answer clients.
pub const CALLS: &str = "trace=pwrite64,write,writev,sendto,sendmsg,fdatasync,fsync,ftruncate,openat,unlink,unlinkat,rename,renameat,renameat2";

/// One call of the service. Files go by their names within the directory of the database.
#[derive(Debug)]
pub enum Call {
    /// A file is there, made where it was not.
    Create { file: String },
    /// Bytes at a place of a file.
    Write { file: String, at: usize, data: Vec<u8> },
    /// A file cut off, or made longer.
    Resize { file: String, len: usize },
    /// A file is on the disk.
    Flush { file: String },
    /// What files there are is on the disk.
    FlushDirectory,
    /// A file is gone.
    Remove { file: String },
    /// Bytes for a client, or for whoever started the service.
    Tell { text: Vec<u8> },
}

/// Calls of several threads overlap: each begins, and later succeeds.
#[derive(Debug, Clone, Copy)]
pub enum Moment {
    Begins(usize),
    Succeeds(usize),
}

#[derive(Debug, Default)]
pub struct Recording {
    pub calls: Vec<Call>,
    pub moments: Vec<Moment>,
}

impl Recording {
    /// Reads what `strace -f -y -xx` has written about a service whose database lies in `dir`.
    pub fn read(trace: &str, dir: &Path) -> Self {
        let mut recording = Self::default();
        let mut under_way: HashMap<&str, Option<usize>> = HashMap::new();
        for line in trace.lines() {
            let (thread, rest) = line.split_once(' ').unwrap();
            let rest = rest.trim_start();
            if rest.starts_with("+++") || rest.starts_with("---") {
                continue;
            }
            if rest.starts_with("<... ") {
                if let Some(call) = under_way.remove(thread).flatten()
                    && succeeded(rest)
                {
                    recording.moments.push(Moment::Succeeds(call));
                }
                continue;
            }
            let call = call(rest, dir).map(|call| {
                recording.calls.push(call);
                let number = recording.calls.len() - 1;
                recording.moments.push(Moment::Begins(number));
                number
            });
            if rest.ends_with("<unfinished ...>") {
                under_way.insert(thread, call);
            } else if let Some(call) = call
                && succeeded(rest)
            {
                recording.moments.push(Moment::Succeeds(call));
            }
        }
        recording
    }

    /// The first moment from which on the service has said `text`.
    pub fn said(&self, text: &str) -> usize {
        let says = |moment: &Moment| match moment {
            Moment::Begins(call) => {
                matches!(&self.calls[*call], Call::Tell { text: told } if String::from_utf8_lossy(told).contains(text))
            }
            Moment::Succeeds(_) => false,
        };
        self.moments.iter().position(says).unwrap_or_else(|| panic!("it never said {text}"))
    }
}

fn succeeded(line: &str) -> bool {
    let result = line.rsplit_once(" = ").map_or("-1", |(_, result)| result);
    !result.starts_with('-') && !result.starts_with('?')
}

/// The call that a line begins; none where it is of no concern.
fn call(line: &str, dir: &Path) -> Option<Call> {
    let (name, arguments) = line.split_once('(')?;
    let file = |path: &str| {
        let path = path.trim_end_matches(" (deleted)");
        let file = Path::new(path).strip_prefix(dir).ok()?.to_str()?.to_owned();
        (file.starts_with("gyrowatch.db") && !file.ends_with("-shm") && !file.ends_with(".lock")).then_some(file)
    };
    let described = || {
        let path = &arguments[arguments.find('<')? + 1..];
        String::from_utf8(unescaped(&path[..path.find('>')?])).ok()
    };
    match name {
        "openat" if arguments.contains("O_CREAT") => {
            Some(Call::Create { file: file(&String::from_utf8(strings(arguments).0).ok()?)? })
        }
        "pwrite64" => {
            let (data, rest) = strings(arguments);
            let mut numbers = rest.split([',', ')', ' ']).filter_map(|number| number.parse::<usize>().ok());
            let (len, at) = (numbers.next()?, numbers.next()?);
            assert_eq!(data.len(), len, "strace has cut a write short: {:.80}", line);
            Some(Call::Write { file: file(&described()?)?, at, data })
        }
        "ftruncate" => {
            let len = arguments.rsplit_once(">, ")?.1.split([')', ' ']).next()?.parse().unwrap();
            Some(Call::Resize { file: file(&described()?)?, len })
        }
        "fsync" | "fdatasync" => {
            let path = described()?;
            if Path::new(&path) == dir { Some(Call::FlushDirectory) } else { Some(Call::Flush { file: file(&path)? }) }
        }
        "unlink" | "unlinkat" => Some(Call::Remove { file: file(&String::from_utf8(strings(arguments).0).ok()?)? }),
        "rename" | "renameat" | "renameat2" => panic!("a database is never renamed: {line:.200}"),
        "write" | "writev" | "sendto" | "sendmsg" => Some(Call::Tell { text: strings(arguments).0 }),
        _ => None,
    }
}

/// All quoted strings of a call's arguments as one, and what follows them.
fn strings(arguments: &str) -> (Vec<u8>, &str) {
    let (mut text, mut rest) = (Vec::new(), arguments);
    while let Some((_, after)) = rest.split_once('"') {
        let (string, after) = after.split_once('"').unwrap_or((after, ""));
        text.extend(unescaped(string));
        rest = after;
    }
    (text, rest)
}

/// `\x2f` is a slash; all else stands for itself.
fn unescaped(text: &str) -> Vec<u8> {
    let (bytes, mut plain, mut at) = (text.as_bytes(), Vec::with_capacity(text.len() / 4), 0);
    let digit = |byte: u8| char::from(byte).to_digit(16).unwrap() as u8;
    while at < bytes.len() {
        if bytes[at..].starts_with(b"\\x") {
            plain.push(digit(bytes[at + 2]) << 4 | digit(bytes[at + 3]));
            at += 4;
        } else {
            plain.push(bytes[at]);
            at += 1;
        }
    }
    plain
}
