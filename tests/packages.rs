//! What is installed elsewhere, as far as it can be told without installing it: `scripts/packages` and
//! `scripts/bare_debian` are the long forms.

use crate::prelude::*;
use crate::support::required;

fn read(path: impl AsRef<Path>) -> String {
    let path = root().join(path);
    std::fs::read_to_string(&path).unwrap_or_else(|why| panic!("{}: {why}", path.display()))
}

/// Runs a program to its end, and what it has said.
fn ran(program: &str, arguments: &[&str]) -> (bool, String) {
    let done = Command::new(program).args(arguments).current_dir(root()).output().unwrap();
    (done.status.success(), String::from_utf8_lossy(&[done.stdout, done.stderr].concat()).into_owned())
}

/// The configuration that these variables, or this file, come to.
fn config(variables: &[(&str, &str)], file: Option<&str>) -> String {
    let dir = tempfile::tempdir().unwrap();
    let mut command = gyrowatch();
    command.arg("config").current_dir(dir.path()).envs(variables.iter().copied());
    if let Some(file) = file {
        command.arg("--config").arg(root().join(file));
    }
    let done = command.output().unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    String::from_utf8(done.stdout).unwrap()
}

/// What the manifest says of the Debian package.
fn of_package() -> toml::Table {
    let manifest: toml::Table = read("Cargo.toml").parse().unwrap();
    manifest["package"]["metadata"]["deb"].as_table().unwrap().clone()
}

/// Where the package puts what there is in the repository; what `scripts/packages` makes first is taken to be there.
fn installed() -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for asset in of_package()["assets"].as_array().unwrap() {
        let [source, target, mode] = [0, 1, 2].map(|part| asset[part].as_str().unwrap().to_owned());
        assert!(["644", "755"].contains(&&*mode), "{source}");
        let made = source.starts_with("target/packages/");
        assert!(!made || read("scripts/packages").contains(source.rsplit('/').nth(1).unwrap()), "{source}");
        let (folder, pattern) = source.rsplit_once('/').unwrap();
        let names = match pattern.split_once('*') {
            Some((_, ending)) if !made => {
                let files = std::fs::read_dir(root().join(folder)).unwrap().map(|file| file.unwrap());
                let files = files.filter(|file| file.file_type().unwrap().is_file());
                files
                    .map(|file| file.file_name().into_string().unwrap())
                    .filter(|name| name.ends_with(ending))
                    .collect()
            }
            _ => vec![pattern.to_owned()],
        };
        assert!(!names.is_empty(), "{source}");
        for name in names {
            assert!(made || root().join(folder).join(&name).is_file(), "{folder}/{name}");
            found.insert(if target.ends_with('/') { format!("/{target}{name}") } else { format!("/{target}") });
        }
    }
    found
}

#[test]
fn what_the_debian_package_installs_is_there_and_its_scripts_are_sound() {
    let package = of_package();
    let installed = installed();
    assert!(installed.contains("/usr/bin/gyrowatch"), "{installed:?}");
    for file in package["conf-files"].as_array().unwrap() {
        assert!(installed.contains(file.as_str().unwrap()), "{file}");
    }
    let scripts = package["maintainer-scripts"].as_str().unwrap();
    for script in ["postinst", "postrm"] {
        let script = format!("{scripts}/{script}");
        let (well, said) = ran("sh", &["-n", &script]);
        assert!(well, "{said}");
        // Where cargo-deb puts what starts and stops the unit.
        assert!(read(&script).contains("#DEBHELPER#"), "{script}");
    }
    assert!(config(&[], Some("config/deb/gyrowatch.toml")).contains("/var/lib/gyrowatch/gyrowatch.db"));

    // The unit as `scripts/packages` packs it: what it names is installed.
    let unit = read("config/gyrowatch.service").replace("/usr/local/", "/usr/");
    let named = unit.lines().filter(|line| line.starts_with("ExecStart=") || line.starts_with("Documentation="));
    let named: Vec<&str> = named.flat_map(|line| line.split(['=', ' '])).filter_map(path_in).collect();
    assert!(named.len() >= 3, "{named:?}");
    for path in named {
        assert!(installed.contains(path), "the unit names {path}, which is not installed");
    }
}

fn path_in(word: &str) -> Option<&str> {
    let path = word.strip_prefix("file:").unwrap_or(word);
    path.starts_with('/').then_some(path)
}

/// An upgrade keeps what somebody has configured: the kept version's configuration file is still one, and still taken.
#[test]
fn the_kept_debian_package_can_be_upgraded_from() {
    if !required("dpkg-deb") {
        return;
    }
    let dir = tempfile::tempdir().unwrap();
    let unpacked = dir.path().to_str().unwrap();
    for kept in std::fs::read_dir(root().join("tests/data/kept")).unwrap() {
        let kept = kept.unwrap().path();
        if kept.extension().is_none_or(|ending| ending != "deb") {
            continue;
        }
        let (well, said) = ran("dpkg-deb", &["-R", kept.to_str().unwrap(), unpacked]);
        assert!(well, "{said}");
        let conf_files = std::fs::read_to_string(dir.path().join("DEBIAN/conffiles")).unwrap();
        for file in conf_files.split_whitespace() {
            assert!(installed().contains(file), "{file}");
            config(&[], Some(dir.path().join(&file[1..]).to_str().unwrap()));
        }
        let control = std::fs::read_to_string(dir.path().join("DEBIAN/control")).unwrap();
        assert!(control.contains("Package: gyrowatch\n"), "{control}");
    }
}

#[test]
fn the_container_file_keeps_its_promises() {
    let text = read("config/Containerfile").replace("\\\n", " ");
    let lines: Vec<(&str, &str)> =
        text.lines().filter(|line| !line.starts_with('#')).filter_map(|line| line.split_once(' ')).collect();
    let of = |word: &'static str| lines.iter().filter(move |(first, _)| *first == word).map(|(_, rest)| rest.trim());
    let manifest: toml::Table = read("Cargo.toml").parse().unwrap();
    let said = |member: &str| manifest["package"][member].as_str().unwrap();

    // Both images can be pinned by their digests, and the compiler is as new as the program asks for.
    let images: Vec<&str> = of("ARG").collect();
    assert!(
        images.iter().any(|image| *image == format!("RUST=docker.io/library/rust:{}-bookworm", said("rust-version")))
    );
    let from: Vec<&str> = of("FROM").map(|from| from.split(' ').next().unwrap()).collect();
    assert_eq!(from, ["$RUST", "$DEBIAN"], "{images:?}");
    // What is built without a lock differs from day to day.
    assert!(of("RUN").any(|run| run.starts_with("cargo build") && run.contains("--locked")));

    // A user of its own, the same in every build: volumes keep their owner.
    let run = of("RUN").find(|run| run.starts_with("useradd")).unwrap();
    assert!(run.contains("--uid 10001") && run.ends_with(of("USER").next().unwrap()), "{run}");
    let position = |word: &str| lines.iter().rposition(|(first, _)| *first == word).unwrap();
    assert!(position("USER") < position("ENTRYPOINT"));
    assert_eq!(of("WORKDIR").next_back(), of("VOLUME").next());

    let labels = of("LABEL").next().unwrap();
    for label in ["title=\"gyrowatch\"".to_owned(), format!("licenses=\"{}\"", said("license"))] {
        assert!(labels.contains(&label), "{labels}");
    }
    // The configuration that it sets is taken as it is, and listens where it is exposed.
    let set: Vec<(&str, &str)> =
        of("ENV").next().unwrap().split_whitespace().filter_map(|one| one.split_once('=')).collect();
    let in_force = config(&set, None);
    for (name, value) in set.iter().filter(|(name, _)| name.starts_with("GYROWATCH_")) {
        assert!(in_force.contains(value), "{name}={value}\n{in_force}");
    }
    let listen = set.iter().find(|(name, _)| *name == "GYROWATCH_LISTEN").unwrap().1;
    assert!(listen.ends_with(&format!(":{}", of("EXPOSE").next().unwrap())), "{listen}");
    // What it runs, the program knows.
    let json = |text: &str| serde_json::from_str::<Vec<String>>(text).unwrap();
    let [entry] = &json(of("ENTRYPOINT").next().unwrap())[..] else { panic!() };
    let check = of("HEALTHCHECK").next().unwrap().split_once("CMD ").unwrap().1;
    assert_eq!(&json(check)[..], [entry, "healthcheck"]);
    for command in [json(of("CMD").next().unwrap()).concat(), "healthcheck".to_owned()] {
        assert!(gyrowatch().args([&command, "--help"]).output().unwrap().status.success(), "{command}");
    }
    assert!(of("COPY").any(|copied| copied.ends_with(entry.as_str())));
}

/// `--version` names the commit that a package is told, or that a release build finds; a development build none.
#[test]
fn a_build_knows_which_commit_it_is_of() {
    if !required("rustc") {
        return;
    }
    let dir = tempfile::tempdir().unwrap();
    let program = dir.path().join("build");
    let (well, said) = ran("rustc", &["--edition=2024", "build.rs", "-o", program.to_str().unwrap()]);
    assert!(well, "{said}");
    let said = |commit: &str, profile: &str| {
        let mut build = Command::new(&program);
        build.current_dir(root()).env("GYROWATCH_COMMIT", commit).env("PROFILE", profile);
        String::from_utf8(build.output().unwrap().stdout).unwrap()
    };
    assert!(said("abc123", "debug").contains("cargo::rustc-env=GYROWATCH_COMMIT=abc123"));
    assert!(!said("", "debug").contains("rustc-env"));
    if root().join(".git").exists() {
        let (_, head) = ran("git", &["rev-parse", "--short=12", "HEAD"]);
        assert!(said("", "release").contains(&format!("cargo::rustc-env=GYROWATCH_COMMIT={head}")));
    }
    let version = String::from_utf8(gyrowatch().arg("--version").output().unwrap().stdout).unwrap();
    let number = format!("gyrowatch {}", env!("CARGO_PKG_VERSION"));
    assert!(version.trim_end() == number || version.starts_with(&format!("{number} (")), "{version}");
}

#[test]
fn scripts_are_read_without_a_fault() {
    for script in std::fs::read_dir(root().join("scripts")).unwrap() {
        let path = script.unwrap().path();
        if std::fs::read_to_string(&path).unwrap().starts_with("#!/usr/bin/env bash") {
            let (well, said) = ran("bash", &["-n", path.to_str().unwrap()]);
            assert!(well, "{said}");
        }
    }
}

/// `scripts/bare_debian` runs what ships and what the documents show, with other ports and paths: those are there to be
/// changed, and the files that it sends and looks for are there too.
#[test]
fn what_is_tried_on_a_bare_debian_is_what_ships() {
    let script = read("scripts/bare_debian");
    let changed = [read("config/prometheus/prometheus.yml"), read("docs/how-to/nginx.md")].concat();
    let begins = |at: usize| !script[..at].ends_with(|c: char| c.is_ascii_alphanumeric());
    let commands = script.match_indices("s|").filter(|(at, _)| begins(*at));
    let sought: Vec<&str> = commands.map(|(at, _)| script[at + 2..].split('|').next().unwrap()).collect();
    assert!(sought.len() >= 8, "{sought:?}");
    for text in sought {
        assert!(changed.contains(text), "{text}");
    }
    assert!(read("docs/how-to/nginx.md").contains("\n```nginx\n"));
    assert!(root().join("tests/data/paper.json").is_file() && script.contains("tests/data/paper.json"));
    let installed = installed();
    let checked = script.split("test -f ").skip(1).map(|rest| rest.split([' ', '\'', '\n']).next().unwrap());
    for path in checked.filter(|path| path.contains("/share/")) {
        // dpkg packs man pages.
        let is_it =
            |file: &String| file == path.trim_end_matches(".gz") || file == &path.replace("gyrowatch.1.gz", "*.1");
        assert!(installed.iter().any(is_it), "{path}: {installed:?}");
    }
}

/// Without a network the sources build from what is packed with them, SQLite as it is always built.
#[test]
fn the_source_archive_keeps_the_settings_of_the_build_beside_where_dependencies_are() {
    let script = read("scripts/packages");
    let packing = script.split_once("source_archive() {").unwrap().1.split_once("\n}\n").unwrap().0;
    assert!(packing.contains(">>\"$out/$name/.cargo/config.toml\""), "{packing}");
    let tables = packing.split_once("<<'TOML'\n").unwrap().1.split_once("TOML\n").unwrap().0;
    let settings: toml::Table = [&*read(".cargo/config.toml"), tables].concat().parse().unwrap();
    assert_eq!(settings["source"]["crates-io"]["replace-with"].as_str(), Some("vendored-sources"));
    assert_eq!(settings["source"]["vendored-sources"]["directory"].as_str(), Some("vendor"));
    assert!(settings["env"]["LIBSQLITE3_FLAGS"].as_str().unwrap().contains("HAVE_FDATASYNC"));
}

/// The agent's task on Windows runs what the archive holds, with options that there are.
#[test]
fn the_task_for_windows_runs_what_is_packed() {
    let task = read("config/windows/gyrowatch-agent.xml");
    let within = |name: &str| task.split_once(&format!("<{name}>")).unwrap().1.split('<').next().unwrap().to_owned();
    let command = within("Command");
    let file = command.rsplit('\\').next().unwrap();
    assert_eq!(within("ExecutionTimeLimit"), "PT0S", "or Windows ends it after three days");
    let line = read(format!("config/windows/{file}"));
    let line = line.lines().last().unwrap();
    assert!(line.starts_with("\"%~dp0gyrowatch.exe\" import "), "{line}");
    let help = String::from_utf8(gyrowatch().args(["import", "--help"]).output().unwrap().stdout).unwrap();
    let options: Vec<&str> = line.split(' ').filter(|word| word.starts_with("--")).collect();
    assert!(options.len() >= 2, "{line}");
    for option in options {
        assert!(help.contains(option), "{option}\n{help}");
    }
    assert!(read("scripts/packages").contains("gyrowatch-agent.cmd"));
}
