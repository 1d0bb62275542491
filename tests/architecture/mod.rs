//! Keeps the rules of the house that would otherwise have to be repeated in every review (docs/architecture.md).
//!
//! Each rule is a function from a file's text to the complaints about it, and each is first tried on a text that
//! breaks it: a rule that cannot complain keeps nothing.

mod house;

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use crate::support::root;
use house::House;

const PEERS: [&str; 4] = ["store", "http", "alert", "pages"];
const CORE_CRATES: [&str; 9] = [
    "std",
    "core",
    "alloc",
    "nalgebra",
    "thiserror",
    "statrs",
    "unicode_normalization",
    "unicode_properties",
    "unicode_security",
];
const IMPURE_STD: [&str; 7] = ["fs", "io", "net", "env", "process", "thread", "time"];
const MOST_FILES_OF_A_TYPE: usize = 2;

/// Every file below `dir`, sorted, without what git ignores.
fn files_below(dir: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut open = vec![dir.to_owned()];
    while let Some(dir) = open.pop() {
        for entry in fs::read_dir(&dir).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            if matches!(name.as_str(), ".git" | "target" | "node_modules") {
                continue;
            }
            if path.is_dir() { open.push(path) } else { found.push(path) }
        }
    }
    found.sort();
    found
}

/// Runs one rule over the Rust files below `dir` (relative to the repository) and fails with all its complaints.
fn keep(dir: &str, rule: impl Fn(&str, &str) -> Vec<String>) {
    let dir = root().join(dir);
    if !dir.exists() {
        return;
    }
    let complaints: Vec<String> = files_below(&dir)
        .into_iter()
        .filter(|path| path.extension().is_some_and(|e| e == "rs") && !is_test(path))
        .flat_map(|path| {
            let name = path.strip_prefix(root()).unwrap().display().to_string();
            let text = fs::read_to_string(&path).unwrap();
            rule(&name, &text).into_iter().map(move |c| format!("{name}: {c}"))
        })
        .collect();
    assert!(complaints.is_empty(), "\n{}", complaints.join("\n"));
}

/// A file of unit tests beside what it tests, as `judge/tests.rs` or `store/tables/delivery_tests.rs`.
fn is_test(path: &Path) -> bool {
    path.file_stem().is_some_and(|stem| stem.to_string_lossy().ends_with("tests"))
}

/// What ships: the lines before the unit tests.
fn production(text: &str) -> &str {
    text.find("\n#[cfg(test)]").map_or(text, |end| &text[..end])
}

/// What `production` would not show: items after those for unit tests.
fn code_after_unit_tests(text: &str) -> Vec<String> {
    let items = syn::parse_file(text).unwrap().items;
    let hidden = items.iter().skip_while(|item| !house::is_for_tests(item)).filter(|item| !house::is_for_tests(item));
    let hidden = hidden.count();
    if hidden > 0 { vec![format!("{hidden} items stand after those for unit tests")] } else { Vec::new() }
}

/// Production code without its comments.
fn code(text: &str) -> String {
    production(text).lines().map(|line| line.split("//").next().unwrap_or("")).collect::<Vec<_>>().join("\n")
}

fn is_ident(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// The first segment of every path in `code` (`serde` of `serde::Serialize`), and of every plain `use serde;`.
fn path_roots(code: &str) -> BTreeSet<String> {
    let mut roots = BTreeSet::new();
    for (at, _) in code.match_indices("::") {
        let before = &code[..at];
        let start = before.rfind(|c| !is_ident(c)).map_or(0, |i| i + 1);
        if start < at && !before[..start].ends_with("::") {
            roots.insert(before[start..].to_owned());
        }
    }
    for (at, _) in code.match_indices("use ") {
        roots.insert(code[at + 4..].chars().take_while(|&c| is_ident(c)).collect());
    }
    roots
}

/// What follows `prefix` in paths: `store` and `http` of `crate::{store::Store, http}` for the prefix `crate::`.
fn segments_after(code: &str, prefix: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for (at, _) in code.match_indices(prefix) {
        if code[..at].ends_with(is_ident) {
            continue;
        }
        let rest = code[at + prefix.len()..].trim_start();
        match rest.strip_prefix('{') {
            Some(group) => found.extend(group_heads(group)),
            None => _ = found.insert(rest.chars().take_while(|&c| is_ident(c)).collect()),
        }
    }
    found
}

/// Heads of the top-level members of a `use` group, whose opening brace has been read.
fn group_heads(group: &str) -> Vec<String> {
    let (mut depth, mut heads, mut head) = (0, Vec::new(), String::new());
    for c in group.chars() {
        match c {
            '{' => depth += 1,
            '}' if depth == 0 => break,
            '}' => depth -= 1,
            ',' if depth == 0 => heads.push(std::mem::take(&mut head)),
            c if depth == 0 => head.push(c),
            _ => {}
        }
    }
    heads.push(head);
    heads.iter().map(|h| h.trim().chars().take_while(|&c| is_ident(c)).collect()).collect()
}

fn dependencies() -> BTreeSet<String> {
    let manifest: toml::Table = fs::read_to_string(root().join("Cargo.toml")).unwrap().parse().unwrap();
    let of_unix = &manifest["target"]["cfg(unix)"]["dependencies"];
    [&manifest["dependencies"], &manifest["dev-dependencies"], of_unix]
        .into_iter()
        .filter_map(toml::Value::as_table)
        .flat_map(|table| table.keys().map(|name| name.replace('-', "_")))
        .collect()
}

/// `message!` is of `core/message.rs`, and like every exported macro found at the root.
const MACRO: &str = "message";

fn core_is_pure(text: &str) -> Vec<String> {
    let code = code(text);
    let foreign = dependencies();
    let mut complaints: Vec<String> = path_roots(&code)
        .into_iter()
        .filter(|root| foreign.contains(root) && !CORE_CRATES.contains(&root.as_str()))
        .map(|root| format!("core must not use the crate {root}"))
        .collect();
    let crate_parts = segments_after(&code, "crate::").into_iter().filter(|m| m != "core" && m != MACRO);
    complaints.extend(crate_parts.map(|m| format!("core must not use crate::{m}")));
    let std_parts = segments_after(&code, "std::").into_iter().filter(|m| IMPURE_STD.contains(&m.as_str()));
    complaints.extend(std_parts.map(|m| format!("core must not use std::{m}")));
    complaints
        .extend(["println!", "print!"].iter().filter(|p| code.contains(*p)).map(|p| format!("core must not use {p}")));
    complaints
}

/// `store`, `http`, `alert` and `pages` meet only in `pipeline` and in the wiring of the command line.
fn peers_do_not_meet(name: &str, text: &str) -> Vec<String> {
    let Some(me) = PEERS.iter().find(|peer| name.starts_with(&format!("src/{peer}"))) else { return Vec::new() };
    let code = code(text);
    let used = segments_after(&code, "crate::").into_iter().chain(segments_after(&code, "super::"));
    used.filter(|m| PEERS.contains(&m.as_str()) && m != me).map(|m| format!("must not use {m}")).collect()
}

/// The wire formats know the core and its words alone, and the database knows nothing of the wire formats.
fn wire_is_an_edge(name: &str, text: &str) -> Vec<String> {
    let used = segments_after(&code(text), "crate::").into_iter();
    if name.starts_with("src/wire") {
        used.filter(|m| !matches!(m.as_str(), "core" | "wire" | "words" | MACRO))
            .map(|m| format!("wire must not use {m}"))
            .collect()
    } else if name.starts_with("src/store") {
        used.filter(|m| m == "wire").map(|_| "store must not use wire".to_owned()).collect()
    } else {
        Vec::new()
    }
}

fn anyhow_stays_outside(name: &str, text: &str) -> Vec<String> {
    let outside = name == "src/main.rs" || name.starts_with("src/cli");
    let used = path_roots(&code(text)).contains("anyhow");
    if used && !outside { vec!["anyhow belongs to main and the subcommands".into()] } else { Vec::new() }
}

fn nothing_is_left_behind(text: &str) -> Vec<String> {
    let marks =
        [concat!("TO", "DO"), concat!("FIX", "ME"), concat!("XX", "X:"), concat!("db", "g!("), concat!("to", "do!(")];
    let mut complaints = Vec::new();
    for (number, line) in text.lines().enumerate() {
        complaints.extend(marks.iter().filter(|m| line.contains(*m)).map(|m| format!("{m} in line {}", number + 1)));
    }
    complaints
}

fn no_machine_paths(text: &str) -> Vec<String> {
    let needles = [concat!("/", "work/"), concat!("/", "root/"), concat!("../", "shared"), concat!("/", "home/")];
    let mut complaints = Vec::new();
    for needle in needles {
        let foreign = |(at, _): &(usize, &str)| !text[..*at].ends_with(|c| is_ident(c) || c == '}' || c == '.');
        if let Some((at, _)) = text.match_indices(needle).find(foreign) {
            complaints.push(format!("{needle} in line {}", text[..at].matches('\n').count() + 1));
        }
    }
    complaints
}

/// Words of PostgreSQL's SQL that CockroachDB and YugabyteDB, which speak its protocol, do not document as their own,
/// or that make servers wait for one another in ways that they do not know.
fn only_what_relatives_run_too(text: &str) -> Vec<String> {
    const FOREIGN: [&str; 10] = [
        "create trigger",
        "create extension",
        "create sequence",
        "create rule",
        "nextval(",
        "bigserial",
        "pg_advisory",
        "pg_notify",
        "lock table",
        "listen \"",
    ];
    let text = text.to_lowercase();
    FOREIGN.iter().filter(|word| text.contains(*word)).map(|word| format!("{word:?}")).collect()
}

/// Public functions without a doc comment, attributes between passed over.
fn undocumented(text: &str) -> Vec<String> {
    let lines: Vec<&str> = production(text).lines().map(str::trim).collect();
    let is_function = |line: &str| ["pub fn ", "pub const fn ", "pub async fn "].iter().any(|p| line.starts_with(p));
    let is_documented = |k: usize| {
        let above = lines[..k].iter().rev().find(|line| !line.starts_with("#["));
        above.is_some_and(|line| line.starts_with("///"))
    };
    let at = (0..lines.len()).filter(|&k| is_function(lines[k]) && !is_documented(k));
    at.map(|k| format!("no doc comment above {:?}", lines[k])).collect()
}

/// The names that the types of a file have in the description of the API.
fn schema_names(text: &str) -> Vec<String> {
    let name = |item: &str| item.chars().take_while(|&c| is_ident(c)).collect::<String>();
    let described = production(text)
        .split("#[derive(")
        .skip(1)
        .filter(|item| item.split(')').next().unwrap().split(',').any(|derived| derived.trim().ends_with("ToSchema")));
    described
        .filter_map(|item| {
            let (attributes, rest) = item.split_once("struct ").or_else(|| item.split_once("enum "))?;
            Some(attributes.split_once("schema(as = ").map_or(name(rest), |(_, given)| name(given)))
        })
        .collect()
}

/// Of two with one name the description keeps the last, and then tells clients of what they do not get.
fn schemas_of_one_name(names: &[String]) -> Vec<String> {
    let mut seen = BTreeSet::new();
    names.iter().filter(|name| !seen.insert(*name)).cloned().collect()
}

#[test]
fn no_two_types_of_the_api_have_the_same_name_in_its_description() {
    let named = schema_names(
        "#[derive(ToSchema)]\nstruct A {\n}\n#[derive(Debug, utoipa::ToSchema)]\n#[schema(as = A)]\npub enum B {}",
    );
    assert_eq!(schemas_of_one_name(&named), ["A"], "{named:?}");
    let files = files_below(&root().join("src"));
    let files = files.iter().filter(|path| path.extension().is_some_and(|e| e == "rs") && !is_test(path));
    let names: Vec<String> = files.flat_map(|path| schema_names(&fs::read_to_string(path).unwrap())).collect();
    assert!(names.len() > 100, "{names:?}");
    assert_eq!(schemas_of_one_name(&names), [""; 0]);
}

#[test]
fn core_uses_only_std_nalgebra_thiserror_and_statrs() {
    assert_eq!(core_is_pure("use serde::Serialize;").len(), 1);
    assert_eq!(core_is_pure("fn f() { tokio::spawn(g()) }").len(), 1);
    assert_eq!(core_is_pure("use crate::store::Store;").len(), 1);
    assert_eq!(core_is_pure("use std::time::Instant;").len(), 1);
    assert_eq!(core_is_pure("use std::{fs, fmt};").len(), 1);
    assert_eq!(core_is_pure("fn f() { println!() }").len(), 1);
    assert!(core_is_pure("use nalgebra::Vector3;\nuse std::fmt;\nuse crate::core::units;\n// serde::x").is_empty());
    assert!(core_is_pure("fn f() {}\n#[cfg(test)]\nmod tests { use rand::Rng; }").is_empty());
    keep("src/core", |_, text| core_is_pure(text));
}

#[test]
fn unit_tests_end_a_file() {
    assert_eq!(code_after_unit_tests("fn a() {}\n#[cfg(test)]\nmod tests;\nmod b;\nfn c() {}").len(), 1);
    assert!(code_after_unit_tests("fn a() {}\n#[cfg(test)]\nfn b() {}\n#[cfg(test)]\nmod tests;").is_empty());
    keep("src", |_, text| code_after_unit_tests(text));
}

#[test]
fn store_http_alert_and_pages_never_use_one_another() {
    assert_eq!(peers_do_not_meet("src/http/records.rs", "use crate::store::Store;").len(), 1);
    assert_eq!(peers_do_not_meet("src/http/mod.rs", "use crate::{core::record, store::{Store, Row}};").len(), 1);
    assert_eq!(peers_do_not_meet("src/alert/mod.rs", "fn f() { super::pages::render() }").len(), 1);
    assert!(peers_do_not_meet("src/store/mod.rs", "use crate::store::rows; use super::alerts;").is_empty());
    assert!(peers_do_not_meet("src/pipeline.rs", "use crate::store::Store; use crate::alert::Payload;").is_empty());
    keep("src", peers_do_not_meet);
}

#[test]
fn wire_formats_know_the_core_alone_and_the_store_does_not_know_them() {
    assert_eq!(wire_is_an_edge("src/wire/record.rs", "use crate::http::Problem;").len(), 1);
    assert_eq!(wire_is_an_edge("src/store/records.rs", "use crate::wire::record;").len(), 1);
    assert!(wire_is_an_edge("src/wire/record.rs", "use crate::core::record::Record;").is_empty());
    keep("src", wire_is_an_edge);
}

#[test]
fn anyhow_is_for_main_and_the_subcommands() {
    assert_eq!(anyhow_stays_outside("src/store/mod.rs", "use anyhow::Result;").len(), 1);
    assert!(anyhow_stays_outside("src/cli/service/serve.rs", "use anyhow::Result;").is_empty());
    keep("src", anyhow_stays_outside);
}

/// A circle of files, and what ties it.
fn circles(house: &House) -> Vec<String> {
    house.circles().iter().map(|circle| format!("{circle:?}\n  {}", house.ties(circle).join("\n  "))).collect()
}

fn spread_types(house: &House) -> Vec<String> {
    let spread = house.implementations().into_iter().filter(|(_, files)| files.len() > MOST_FILES_OF_A_TYPE);
    spread.map(|((module, name), files)| format!("{}::{name}: {files:?}", module.join("::"))).collect()
}

/// Who may take from the store: the pipeline, whoever puts it together, the configuration that says how a database is
/// opened, and the subcommands that look after the database itself with what words its errors.
const KNOW_THE_STORE: [&str; 11] = [
    "pipeline/",
    "config/mod.rs",
    "cli/errors.rs",
    "cli/service/serve.rs",
    "cli/service/backup.rs",
    "cli/service/copy.rs",
    "cli/service/export/mod.rs",
    "cli/service/fleet_noise.rs",
    "cli/service/restore.rs",
    "cli/service/token.rs",
    "cli/service/verify.rs",
];

fn takes_from_the_store(house: &House) -> Vec<String> {
    let taken = house.takes_from("store/").into_iter();
    taken.filter(|tie| !KNOW_THE_STORE.iter().any(|place| tie.starts_with(place))).collect()
}

fn the_house() -> House {
    House::read(&root().join("src"))
}

#[test]
fn no_files_take_from_one_another_in_a_circle() {
    let broken = [
        ("lib.rs", "mod a;\nmod b;"),
        ("a/mod.rs", "mod c;\npub use c::C;\nuse crate::b::B;"),
        ("a/c.rs", "pub struct C;\nfn f() { super::super::b::g() }"),
        ("b.rs", "use crate::a::C;\npub struct B;\npub fn g() {}"),
    ];
    assert_eq!(House::of(&broken).circles(), [["a/c.rs", "b.rs"]]);
    let handed_on = [("a/mod.rs", "mod c;\npub use c::C;\npub struct A;"), ("a/c.rs", "pub struct C(super::A);")];
    assert!(House::of(&handed_on).circles().is_empty());
    let in_macros =
        [("a.rs", "fn f() { html! { (crate::b::g()) } }\npub fn h() {}"), ("b.rs", "pub fn g() { crate::a::h() }")];
    assert_eq!(House::of(&in_macros).circles(), [["a.rs", "b.rs"]]);
    let circles = circles(&the_house());
    assert!(circles.is_empty(), "{} circles\n{}", circles.len(), circles.join("\n"));
}

#[test]
fn nothing_but_the_pipeline_and_whoever_keeps_the_database_takes_from_the_store() {
    let broken = [
        ("pages/a.rs", "use crate::pipeline::{Row, store};\nfn f(row: &Row) { store::g() }"),
        ("pipeline/mod.rs", "pub use crate::store;\npub use crate::store::Row;"),
        ("cli/a.rs", "use crate::store;\nfn f() { store::open() }"),
        ("cli/service/copy.rs", "use crate::store::Row;"),
        ("http.rs", "use crate::store::{open, Kept};"),
        ("store/mod.rs", "mod open;\npub use open::{open, Kept};\npub struct Row;\npub fn g() {}"),
        ("store/open.rs", "pub struct Kept;\npub fn open() {}"),
    ];
    let found = [
        "cli/a.rs -> store/open.rs: open",
        "http.rs -> store/open.rs: Kept, open",
        "pages/a.rs -> store/mod.rs: Row, g",
    ];
    assert_eq!(takes_from_the_store(&House::of(&broken)), found);
    let taken = takes_from_the_store(&the_house());
    assert!(taken.is_empty(), "\n{}", taken.join("\n"));
}

#[test]
fn what_a_type_does_stands_in_at_most_two_files() {
    let broken = [
        ("a.rs", "pub struct A; impl A {}"),
        ("b.rs", "use crate::a::A; impl A {}"),
        ("c.rs", "use crate::a; impl a::A {}"),
    ];
    assert_eq!(spread_types(&House::of(&broken)).len(), 1);
    let spread = spread_types(&the_house());
    assert!(spread.is_empty(), "{}\n{}", spread.len(), spread.join("\n"));
}

/// `cargo test --test architecture figures -- --nocapture`
#[test]
fn figures_of_the_house() {
    let house = the_house();
    let types = house.types();
    let twice = types.values().filter(|files| files.len() > 1).count();
    let implementations = house.implementations();
    let widest = implementations.iter().max_by_key(|(_, files)| files.len()).unwrap();
    println!("lines before unit tests   {}", house.lines());
    println!("files                     {}", house.files());
    println!("circles of files          {}", house.circles().len());
    println!("types in most files       {} in {}", widest.0.1, widest.1.len());
    println!("type names used twice     {twice} of {}", types.len());
    println!("lines over {} columns    {}", house::MOST_COLUMNS, house.long_lines());
    println!("{}", [circles(&house), spread_types(&house)].concat().join("\n"));
    assert!(house.files() > 100 && house.arrows().len() > 100);
}

/// Effects that `text` names by hand, as variants or in quotes.
fn effects_named(text: &str, ids: &[String]) -> Vec<String> {
    let code = code(text);
    let variants = segments_after(&code, "Effect::").into_iter().filter(|name| name.starts_with(char::is_uppercase));
    let quoted = ids.iter().filter(|id| code.contains(&format!("\"{id}\"")));
    variants.chain(quoted.cloned()).collect()
}

/// What the program knows of an effect is its entry: a new one touches its family, the enum, its independent
/// injection, its words and the documentation.
#[test]
fn nothing_but_the_catalogue_lists_effects() {
    let families = files_below(&root().join("src/core/effects"));
    let texts: Vec<String> = families.iter().map(|path| fs::read_to_string(path).unwrap()).collect();
    let id = |line: &str| Some(line.trim().strip_prefix("id: \"")?.strip_suffix("\",")?.to_owned());
    // Terms of model (6), a symptom of commanded vectors, and what residuals go with, have these names in their own right.
    let of_model = ["g_linear", "g_squared", "scale", "heading", "temperature_and_time"];
    let ids: Vec<String> = texts.iter().flat_map(|text| text.lines()).filter_map(id).collect();
    let ids: Vec<String> = ids.into_iter().filter(|id| !id.is_empty() && !of_model.contains(&id.as_str())).collect();
    assert!(ids.len() > 40, "{ids:?}");
    assert_eq!(effects_named("match e { Effect::TimeRamp => 1 }", &ids), ["TimeRamp"]);
    assert_eq!(effects_named("const SLOW: [&str; 1] = [\"time_ramp\"];", &ids), ["time_ramp"]);
    assert!(effects_named("Effect::from_id(id) // \"time_ramp\"", &ids).is_empty());
    let knows = |name: &str| {
        name.starts_with("src/core/effects/")
            // Its own, independent definitions; stories that are told with some; the words.
            || name.starts_with("src/simulate/")
            || name == "src/cli/service/demo/campaigns.rs"
            // The two readings of one number, in a record: the physics of this pair and of no other.
            || name == "src/core/diagnose/record_closure.rs"
            // The rotations that a station states an uncertainty of, and what they do: the columns of their effects.
            || matches!(name, "src/core/calibrate/station.rs" | "src/core/campaign/station_uncertainty.rs")
    };
    keep("src", |name, text| if knows(name) { Vec::new() } else { effects_named(text, &ids) });
}

#[test]
fn nothing_unfinished_is_left_behind() {
    assert_eq!(nothing_is_left_behind(concat!("a\n// TO", "DO later\n")).len(), 1);
    for dir in ["src", "tests", "benches", "fuzz"] {
        keep(dir, |_, text| nothing_is_left_behind(text));
    }
}

#[test]
fn what_postgresql_is_asked_its_relatives_run_too() {
    assert_eq!(only_what_relatives_run_too("SELECT pg_advisory_lock(1)").len(), 1);
    keep("src/store", |_, text| only_what_relatives_run_too(production(text)));
    let migrations = files_below(&root().join("migrations/postgres"));
    assert!(!migrations.is_empty());
    for path in migrations {
        let complaints = only_what_relatives_run_too(&fs::read_to_string(&path).unwrap());
        assert!(complaints.is_empty(), "{}: {complaints:?}", path.display());
    }
}

#[test]
fn public_functions_of_the_mathematics_and_the_simulation_say_what_they_do() {
    assert_eq!(undocumented("pub fn a() {}\n/// B.\n#[must_use]\npub const fn b() {}\nfn c() {}").len(), 1);
    for dir in ["src/core", "src/simulate"] {
        keep(dir, |_, text| undocumented(text));
    }
}

#[test]
fn no_file_names_a_path_of_somebodys_machine() {
    assert_eq!(no_machine_paths(concat!("see /", "work/x")).len(), 1);
    assert!(no_machine_paths("a network/worker").is_empty());
    let mut complaints = Vec::new();
    for path in files_below(root()) {
        let Ok(text) = fs::read_to_string(&path) else { continue };
        complaints.extend(no_machine_paths(&text).into_iter().map(|c| format!("{}: {c}", path.display())));
    }
    assert!(complaints.is_empty(), "\n{}", complaints.join("\n"));
}

#[test]
fn every_file_of_commands_and_of_tests_is_wired_in() {
    for (folder, frame) in [("src/cli", "mod.rs"), ("src/cli/service", "mod.rs"), ("tests", "main.rs")] {
        let folder = root().join(folder);
        let frame = folder.join(frame);
        let names = fs::read_to_string(&frame).unwrap();
        let files = fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path());
        for path in files.filter(|path| path.extension().is_some_and(|e| e == "rs") && *path != frame) {
            let name = path.file_stem().unwrap().display().to_string();
            assert!(name == "mod" || names.contains(&format!("mod {name};")), "{} is not compiled", path.display());
        }
    }
}
