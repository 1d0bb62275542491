//! Which role each route takes at the least. A route without a rule is nobody's: a test fails until it has one.

use std::collections::HashMap;
use std::sync::LazyLock;

use axum::http::Method;

use crate::core::access::Role;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Least {
    /// Without a token too.
    Anyone,
    Role(Role),
    /// There is no rule.
    Nobody,
}

const ANYONE: Least = Least::Anyone;
const VIEWER: Least = Least::Role(Role::Viewer);
const STATION: Least = Least::Role(Role::Station);
const ENGINEER: Least = Least::Role(Role::Engineer);
const ADMIN: Least = Least::Role(Role::Admin);

/// Method, route, and who may use it. Administrators decide where data leave to (hooks) and who comes in (tokens).
const RULES: &[(&str, &str, Least)] = &[
    // The service.
    ("GET", "/healthz", ANYONE),
    ("GET", "/readyz", ANYONE),
    ("GET", "/metrics", VIEWER),
    ("GET", "/openapi.json", VIEWER),
    ("GET", "/docs", VIEWER),
    ("GET", "/docs/", VIEWER),
    ("GET", "/docs/{*rest}", VIEWER),
    // What is measured.
    ("POST", "/v1/records", STATION),
    ("GET", "/v1/records/{id}", VIEWER),
    ("GET", "/v1/records/{id}/diagnosis", VIEWER),
    ("POST", "/v1/campaigns", STATION),
    ("GET", "/v1/campaigns/{id}", VIEWER),
    ("GET", "/v1/campaigns/{id}/diagnosis", VIEWER),
    ("POST", "/v1/bench-results", STATION),
    ("GET", "/v1/bench-results/{id}", VIEWER),
    ("POST", "/v1/import", STATION),
    ("GET", "/v1/gyros", VIEWER),
    ("GET", "/v1/gyros/{serial}", VIEWER),
    ("GET", "/v1/gyros/{serial}/trend", VIEWER),
    ("GET", "/v1/gyros/{serial}/agreement", VIEWER),
    ("GET", "/v1/gyros/{serial}/diagnosis", VIEWER),
    ("GET", "/v1/gyros/{serial}/events", VIEWER),
    ("GET", "/v1/imus/{imu}/model", VIEWER),
    ("GET", "/v1/diagnoses", VIEWER),
    ("GET", "/v1/diagnoses/summary", VIEWER),
    ("GET", "/v1/diagnoses/{id}", VIEWER),
    ("GET", "/v1/alerts", VIEWER),
    ("GET", "/v1/alerts/{id}", VIEWER),
    ("GET", "/v1/silences", VIEWER),
    ("GET", "/v1/silences/{id}", VIEWER),
    // What is made of it.
    ("POST", "/v1/records/{id}/void", ENGINEER),
    ("POST", "/v1/records/{id}/confirm", ENGINEER),
    ("POST", "/v1/records/{id}/revise", ENGINEER),
    ("POST", "/v1/campaigns/{id}/void", ENGINEER),
    ("POST", "/v1/campaigns/{id}/revise", ENGINEER),
    ("POST", "/v1/bench-results/{id}/void", ENGINEER),
    ("POST", "/v1/gyros/{serial}/events", ENGINEER),
    ("POST", "/v1/gyros/{serial}/baseline", ENGINEER),
    ("POST", "/v1/imus/{imu}/model", ENGINEER),
    ("POST", "/v1/diagnoses", ENGINEER),
    ("DELETE", "/v1/diagnoses/{id}", ENGINEER),
    ("POST", "/v1/alerts/{id}/acknowledge", ENGINEER),
    ("POST", "/v1/alerts/{id}/unacknowledge", ENGINEER),
    ("POST", "/v1/alerts/{id}/silence", ENGINEER),
    ("POST", "/v1/silences", ENGINEER),
    ("POST", "/v1/silences/{id}/end", ENGINEER),
    ("GET", "/v1/hooks", ENGINEER),
    ("GET", "/v1/hooks/{id}", ENGINEER),
    ("GET", "/v1/hooks/{id}/deliveries", ENGINEER),
    ("GET", "/v1/deliveries/{id}", ENGINEER),
    ("POST", "/v1/deliveries/{id}/redeliver", ENGINEER),
    ("POST", "/v1/hooks/{id}/test", ENGINEER),
    // Where it goes, and who comes in.
    ("POST", "/v1/hooks", ADMIN),
    ("PATCH", "/v1/hooks/{id}", ADMIN),
    ("DELETE", "/v1/hooks/{id}", ADMIN),
    ("GET", "/v1/tokens", ADMIN),
    ("POST", "/v1/tokens", ADMIN),
    ("DELETE", "/v1/tokens/{id}", ADMIN),
    ("GET", "/v1/audit", ADMIN),
    // Pages.
    ("GET", "/sign-in", ANYONE),
    ("POST", "/sign-in", ANYONE),
    ("POST", "/sign-out", ANYONE),
    ("GET", "/preference", ANYONE),
    ("GET", "/assets/{name}", ANYONE),
    ("GET", "/", VIEWER),
    ("GET", "/gyros/{serial}", VIEWER),
    ("GET", "/gyros/{serial}/report", VIEWER),
    ("GET", "/gyros/{serial}/events/new", ENGINEER),
    ("POST", "/gyros/{serial}/events/new", ENGINEER),
    ("GET", "/imus/{imu}", VIEWER),
    ("GET", "/imus/{imu}/report", VIEWER),
    ("GET", "/alerts", VIEWER),
    ("GET", "/alerts/{id}/{deed}", ENGINEER),
    ("POST", "/alerts/{id}/{deed}", ENGINEER),
    ("GET", "/silences/new", ENGINEER),
    ("POST", "/silences/new", ENGINEER),
    ("GET", "/silences/{id}/end", ENGINEER),
    ("POST", "/silences/{id}/end", ENGINEER),
    ("GET", "/hooks", ENGINEER),
    ("GET", "/hooks/{id}", ENGINEER),
    ("POST", "/hooks/{id}/test", ENGINEER),
    ("POST", "/hooks/{id}/redeliver", ENGINEER),
    ("POST", "/hooks/{id}/deliveries/{delivery}/redeliver", ENGINEER),
    ("GET", "/hooks/new", ADMIN),
    ("POST", "/hooks/new", ADMIN),
    ("POST", "/hooks/{id}/enabled", ADMIN),
    ("GET", "/hooks/{id}/delete", ADMIN),
    ("POST", "/hooks/{id}/delete", ADMIN),
    ("GET", "/records/{id}", VIEWER),
    ("GET", "/records/{id}/void", ENGINEER),
    ("POST", "/records/{id}/void", ENGINEER),
    ("GET", "/records/{id}/confirm", ENGINEER),
    ("POST", "/records/{id}/confirm", ENGINEER),
    ("GET", "/campaigns/{id}", VIEWER),
    ("GET", "/campaigns/{id}/void", ENGINEER),
    ("POST", "/campaigns/{id}/void", ENGINEER),
    ("GET", "/campaigns/{id}/diagnosis", VIEWER),
    ("GET", "/diagnoses", VIEWER),
    ("POST", "/diagnoses", ENGINEER),
    ("POST", "/diagnoses/{id}/cancel", ENGINEER),
    ("GET", "/bench-results/{id}/void", ENGINEER),
    ("POST", "/bench-results/{id}/void", ENGINEER),
    ("GET", "/stations", VIEWER),
    ("GET", "/import", STATION),
    ("POST", "/import/preview", STATION),
    ("POST", "/import/store", STATION),
];

static LEAST: LazyLock<HashMap<(&str, &str), Least>> =
    LazyLock::new(|| RULES.iter().map(|&(method, route, least)| ((method, route), least)).collect());

/// Who may use a method of a route.
pub(super) fn least(method: &Method, route: &str) -> Least {
    let method = if *method == Method::HEAD { "GET" } else { method.as_str() };
    LEAST.get(&(method, route)).copied().unwrap_or(Least::Nobody)
}

/// What watches a service asks these, under whatever name it knows it by; they tell nothing of what is measured.
pub(super) fn is_probed(route: &str) -> bool {
    ["/healthz", "/readyz", "/metrics"].contains(&route)
}

#[cfg(test)]
pub(in crate::http) fn has(method: &str, route: &str) -> bool {
    LEAST.contains_key(&(method, route))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_of_the_documentation_is_this_one() {
        let role = |least: &Least| match least {
            Least::Anyone => "-",
            Least::Role(role) => role.name(),
            Least::Nobody => unreachable!("a rule names somebody"),
        };
        let rows: Vec<String> =
            RULES.iter().map(|(method, route, least)| format!("| {method} | `{route}` | {} |", role(least))).collect();
        let documented: Vec<&str> =
            include_str!("../../../docs/routes.md").lines().filter(|line| line.contains(" | `/")).collect();
        assert_eq!(documented, rows, "docs/routes.md");
    }
}
