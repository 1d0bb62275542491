//! The inputs that fuzzing has kept, each through its target, and mutations of them: what was once reached stays right.
//!
//! The mutations are blind where those of `scripts/soak fuzz` follow what the program does; they need no other
//! compiler.

#[path = "../fuzz/targets.rs"]
mod targets;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use crate::support::root;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn corpus(target: &str) -> Vec<Vec<u8>> {
    let dir = root().join("fuzz/corpus").join(target);
    let entries = std::fs::read_dir(&dir).unwrap_or_else(|error| panic!("{}: {error}", dir.display()));
    let mut files: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files.iter().map(|file| std::fs::read(file).unwrap()).collect()
}

fn run(name: &str, target: fn(&[u8]), input: &[u8]) {
    if let Err(panic) = catch_unwind(AssertUnwindSafe(|| target(input))) {
        eprintln!("{name} breaks on: {}", input.escape_ascii());
        std::panic::resume_unwind(panic);
    }
}

#[test]
fn every_input_that_fuzzing_has_kept_is_read_without_harm() {
    for (name, target) in targets::TARGETS {
        let inputs = corpus(name);
        assert!(inputs.len() >= 5, "fuzz/corpus/{name} holds {} inputs", inputs.len());
        inputs.iter().for_each(|input| run(name, target, input));
    }
}

/// What often finds a way around a check.
const PIECES: [&[u8]; 20] = [
    b"0",
    b"-0",
    b"-1",
    b"1e308",
    b"1e-308",
    b"1e999",
    b"NaN",
    b"9007199254740993",
    b"null",
    b"\"\"",
    b"[]",
    b"{}",
    b"\n",
    b"\"",
    b",",
    b"\\u0000",
    b"\xff",
    b"\xef\xbb\xbf",
    b"+99:99",
    b"=",
];

fn mutated(inputs: &[Vec<u8>], random: &mut ChaCha8Rng) -> Vec<u8> {
    let mut bytes = inputs[random.random_range(0..inputs.len())].clone();
    for _ in 0..1 << random.random_range(0..4) {
        let at = random.random_range(0..=bytes.len());
        let end = bytes.len().min(at + (1 << random.random_range(0..8)));
        match random.random_range(0..7) {
            0 if at < bytes.len() => bytes[at] ^= 1 << random.random_range(0..8),
            1 => _ = bytes.drain(at..end),
            2 => {
                let again = bytes[at..end].to_vec();
                bytes.splice(at..at, again);
            }
            3 => _ = bytes.splice(at..at, PIECES[random.random_range(0..PIECES.len())].iter().copied()),
            // A number, if there is one ahead, becomes another.
            4 => {
                let numeric = |byte: &u8| byte.is_ascii_digit() || b"+-.eE".contains(byte);
                let Some(start) = bytes[at..].iter().position(u8::is_ascii_digit).map(|ahead| at + ahead) else {
                    continue;
                };
                let end = bytes[start..].iter().position(|byte| !numeric(byte)).map_or(bytes.len(), |len| start + len);
                bytes.splice(start..end, PIECES[random.random_range(0..8)].iter().copied());
            }
            5 => {
                let other = &inputs[random.random_range(0..inputs.len())];
                let from = random.random_range(0..=other.len());
                let to = other.len().min(from + (1 << random.random_range(0..8)));
                bytes.splice(at..end, other[from..to].iter().copied());
            }
            _ => bytes.truncate(at.max(bytes.len() / 2)),
        }
    }
    bytes
}

#[test]
fn mutations_of_the_kept_inputs_are_read_without_harm() {
    let asked = |name: &str| std::env::var(name).ok();
    let seconds = asked("GYROWATCH_SOAK_SECONDS").map_or(0.5, |text| text.parse().unwrap());
    let seed = asked("GYROWATCH_SOAK_SEED").map_or(3, |text| text.parse().unwrap());
    let only = asked("GYROWATCH_SOAK_TARGET");
    for (name, target) in targets::TARGETS {
        if only.as_ref().is_some_and(|only| only != name) {
            continue;
        }
        let (inputs, mut random) = (corpus(name), ChaCha8Rng::seed_from_u64(seed));
        let (began, mut runs) = (Instant::now(), 0);
        while began.elapsed() < Duration::from_secs_f64(seconds) {
            run(name, target, &mutated(&inputs, &mut random));
            runs += 1;
        }
        println!("{name}: {runs} mutations in {seconds} s, no harm");
    }
}
