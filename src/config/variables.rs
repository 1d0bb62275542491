//! The environment: what of it is read, and what looks as if it should be.

use config::Environment;

use crate::core::message::{Message, text};
use crate::message;
use crate::wire::table::nearest;

/// Every key with its default.
pub(super) const DEFAULTS: &str = include_str!("../../config/default.toml");
const WITHOUT_DEFAULT: [&str; 3] = ["server.tls_certificate", "server.tls_key", "hooks.ca_file"];
/// Letters of a name that allow for one slip more.
const LETTERS_TO_A_SLIP: usize = 8;
/// What is read elsewhere.
const KNOWN: [&str; 6] = ["LISTEN", "DATABASE_URL", "SECRETS_KEY", "URL", "TOKEN", "PROXY"];
/// What tests read, and what a cluster sets for its services.
const OF_OTHERS: [&str; 6] = ["TEST_", "SOAK_", "BENCH_", "SERVICE_HOST", "SERVICE_PORT", "PORT_"];

/// GYROWATCH_LISTEN and GYROWATCH_DATABASE_URL in their sections; other programs' variables left out.
fn in_sections((name, value): (String, String)) -> Option<(String, String)> {
    match name.as_str() {
        "GYROWATCH_LISTEN" => Some(("GYROWATCH_SERVER__LISTEN".into(), value)),
        "GYROWATCH_DATABASE_URL" => Some(("GYROWATCH_DATABASE__URL".into(), value)),
        _ => (name.starts_with("GYROWATCH_") && name.contains("__")).then_some((name, value)),
    }
}

pub(super) fn variables(environment: impl IntoIterator<Item = (String, String)>) -> Environment {
    let variables = environment.into_iter().filter_map(in_sections).collect();
    Environment::with_prefix("GYROWATCH")
        .prefix_separator("_")
        .separator("__")
        .try_parsing(true)
        .source(Some(variables))
}

/// What begins as ours and is read by nobody, with the variable that is likely meant.
pub fn unread(names: impl IntoIterator<Item = String>) -> Vec<Message> {
    names.into_iter().filter_map(|name| of_nobody(&name)).collect()
}

fn of_nobody(name: &str) -> Option<Message> {
    let own = name.strip_prefix("GYROWATCH_")?;
    // Those with two underscores are keys, of which an unknown one is refused.
    if own.contains("__") || KNOWN.contains(&own) || OF_OTHERS.iter().any(|start| own.starts_with(start)) {
        return None;
    }
    let keys = keys();
    let plain = |key: &str| key.replace('.', "_");
    let candidates: Vec<String> = keys.iter().map(|key| plain(key)).chain(KNOWN.map(str::to_lowercase)).collect();
    let variable = |at: usize| {
        let own = keys.get(at).map_or_else(|| candidates[at].clone(), |key| key.replace('.', "__"));
        format!("GYROWATCH_{}", own.to_uppercase())
    };
    let own = own.to_lowercase();
    let near = nearest(&own, candidates.iter().map(String::as_str), LETTERS_TO_A_SLIP).map(str::to_owned);
    // `GYROWATCH_BUDGET`: the section is left out.
    let without_section = || keys.iter().position(|key| key.ends_with(&format!(".{own}")));
    let at = near.and_then(|near| candidates.iter().position(|one| *one == near)).or_else(without_section);
    Some(match at.map(variable) {
        Some(meant) => message!("config_unread_like", name = text(name), meant),
        None => message!("config_unread", name = text(name)),
    })
}

/// Every key that has no keys below it, as `judging.budget`.
fn keys() -> Vec<String> {
    let sections: toml::Table = DEFAULTS.parse().unwrap_or_default();
    let of_section = |(section, keys): (&String, &toml::Value)| {
        let keys = keys.as_table().into_iter().flat_map(toml::Table::keys);
        keys.map(|key| format!("{section}.{key}")).collect::<Vec<_>>()
    };
    sections.iter().flat_map(of_section).chain(WITHOUT_DEFAULT.map(str::to_owned)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::words::Language;

    #[test]
    fn a_variable_that_nobody_reads_is_named_with_the_one_that_is_meant() {
        for (name, meant) in [
            ("GYROWATCH_JUDGING_BUDGET", Some("GYROWATCH_JUDGING__BUDGET")),
            ("GYROWATCH_SERVER_TLS_KEY", Some("GYROWATCH_SERVER__TLS_KEY")),
            ("GYROWATCH_JUDGNG_BUDGET", Some("GYROWATCH_JUDGING__BUDGET")),
            ("GYROWATCH_BUDGET", Some("GYROWATCH_JUDGING__BUDGET")),
            ("GYROWATCH_DATABASE_URI", Some("GYROWATCH_DATABASE__URL")),
            ("GYROWATCH_XYZZY", None),
        ] {
            let found = unread([name.to_owned()]);
            let said = Language::English.words(&found[0]);
            assert!(said.contains(name) && said.ends_with(meant.unwrap_or("nothing")), "{said}");
        }
        let known =
            ["GYROWATCH_LISTEN", "GYROWATCH_TOKEN", "GYROWATCH_TEST_DATABASE", "GYROWATCH_JUDGING__BUDGET", "HOME"];
        assert_eq!(unread(known.map(str::to_owned)), []);
    }
}
