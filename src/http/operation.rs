//! What operations have in common, described once: the parameter of a path, what a request may be refused for, and
//! which answers name what other operations are about. What a handler says itself stays.

use axum::http::Method;
use utoipa::openapi::link::Link;
use utoipa::openapi::path::{Operation, Parameter, ParameterIn};
use utoipa::openapi::security::SecurityRequirement;
use utoipa::openapi::{Content, OpenApi, Ref, RefOr, Required, Response};
use utoipa::{PartialSchema, ToSchema};

use super::problem::PROBLEM_JSON;
use crate::core::access::Role;
use crate::routes::{MinimumRole, Rules, operations};
use crate::wire::problem::ProblemBody;

/// The scheme of [`SecurityRequirement`]s.
pub const TOKEN: &str = "token";

/// What the paths `at` and below are about.
struct Resource {
    at: &'static str,
    name: &'static str,
    /// What it is known by.
    by: &'static str,
    /// The answer that names it: path, status and JSON pointer.
    answer: (&'static str, &'static str, &'static str),
}

const fn resource(
    at: &'static str,
    name: &'static str,
    answer: (&'static str, &'static str, &'static str),
) -> Resource {
    Resource { at, name, by: "identifier", answer }
}

const RESOURCES: [Resource; 13] = [
    resource("/v1/records/{id}", "record", ("/v1/records", "201", "/id")),
    resource("/v1/campaigns/{id}", "campaign", ("/v1/campaigns", "201", "/id")),
    resource("/v1/bench-results/{id}", "bench result", ("/v1/bench-results", "201", "/id")),
    Resource {
        by: "name",
        ..resource("/v1/hypotheses/{id}", "hypothesis", ("/v1/hypotheses", "201", "/hypothesis/id"))
    },
    resource("/v1/diagnoses/{id}", "order", ("/v1/diagnoses", "202", "/id")),
    resource("/v1/alerts/{id}", "alert", ("/v1/alerts", "200", "/alerts/0/id")),
    resource("/v1/silences/{id}", "silence", ("/v1/silences", "201", "/id")),
    resource("/v1/hooks/{id}", "hook", ("/v1/hooks", "201", "/id")),
    resource("/v1/deliveries/{id}", "delivery", ("/v1/hooks/{id}/test", "202", "/id")),
    resource("/v1/tokens/{id}", "token", ("/v1/tokens", "201", "/id")),
    Resource { by: "serial number", ..resource("/v1/gyros/{serial}", "gyro", ("/v1/gyros", "200", "/gyros/0/serial")) },
    Resource { by: "name", ..resource("/v1/stations/{name}", "station", ("/v1/stations", "200", "/stations/0/name")) },
    Resource { by: "name", ..resource("/v1/imus/{imu}", "IMU", ("/v1/imus", "200", "/imus/0/imu")) },
];

impl Resource {
    fn holds(&self, path: &str) -> bool {
        path.strip_prefix(self.at).is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
    }

    fn parameter(&self) -> &'static str {
        self.at.split(['{', '}']).nth(1).expect("each is at a path with a parameter")
    }
}

/// Describes what the handlers leave out.
pub fn complete(openapi: &mut OpenApi, rules: &Rules) {
    for (path, item) in &mut openapi.paths.paths {
        let resource = RESOURCES.iter().find(|resource| resource.holds(path));
        for (method, operation) in operations(item) {
            let least = rules.get(&method, path).flatten();
            if let Some(resource) = resource {
                name_parameter(operation, resource);
            }
            if least.is_some() {
                operation.security = Some(vec![SecurityRequirement::new(TOKEN, [""; 0])]);
            }
            for (status, why) in refusals(operation, (&method, path), resource, least) {
                operation.responses.responses.entry(status.to_owned()).or_insert_with(|| Response::new(why).into());
            }
            for (status, response) in &mut operation.responses.responses {
                if let RefOr::T(response) = response
                    && status.starts_with(['4', '5'])
                    && response.content.is_empty()
                {
                    let problem = Content::new(Some(Ref::from_schema_name(ProblemBody::name())));
                    response.content.insert(PROBLEM_JSON.to_owned(), problem.into());
                }
            }
        }
    }
    link(openapi);
}

fn name_parameter(operation: &mut Operation, resource: &Resource) {
    let parameters = operation.parameters.get_or_insert_default();
    let is_named = |parameter: &RefOr<Parameter>| matches!(parameter, RefOr::T(p) if p.name == resource.parameter());
    if !parameters.iter().any(is_named) {
        let named = Parameter::builder()
            .name(resource.parameter())
            .parameter_in(ParameterIn::Path)
            .required(Required::True)
            .description(Some(format!("{} of the {}", resource.by, resource.name)))
            .schema(Some(String::schema()));
        parameters.insert(0, RefOr::T(named.build()));
    }
}

/// What any request like this one may be refused for.
fn refusals(
    operation: &Operation,
    (method, path): (&Method, &str),
    resource: Option<&Resource>,
    least: MinimumRole,
) -> Vec<(&'static str, String)> {
    let writes = !method.is_safe();
    let taken: Vec<&str> = match &operation.request_body {
        Some(RefOr::T(body)) => body.content.keys().map(String::as_str).collect(),
        _ => Vec::new(),
    };
    let (json, no_body) = (taken.contains(&"application/json"), taken.is_empty());
    let document = json || taken.contains(&"text/csv");
    let bad = match (path.starts_with("/v1/"), json) {
        (true, true) => Some("not JSON, or a parameter that cannot be used"),
        (true, false) => Some("a parameter that cannot be used"),
        (false, _) => None,
    };
    let found = [
        bad.map(|why| ("400", why.to_owned())),
        least.map(|_| ("401", "no token, or one that is not valid".to_owned())),
        least.map(|role| ("403", forbidden(role))),
        resource.map(|resource| ("404", format!("no such {}", resource.name))),
        document.then(|| ("413", "too large".to_owned())),
        (!no_body).then(|| ("415", format!("not {}", taken.join(" or ")))),
        document.then(|| ("422", "a document that cannot be stored; the places are named".to_owned())),
        least.map(|_| ("429", "too many requests, or too many wrong tokens; `Retry-After` says when".to_owned())),
        // An import says so of each line.
        (writes && (document || no_body)).then(|| ("503", "too busy or not writable; try again".to_owned())),
        (writes && (document || no_body)).then(|| ("507", "no room left".to_owned())),
    ];
    found.into_iter().flatten().collect()
}

/// Every token is a viewer's at least.
fn forbidden(least: Role) -> String {
    let elsewhere = "without any token, from elsewhere than loopback";
    match least {
        Role::Viewer => elsewhere.to_owned(),
        role => format!("not with this token: it takes the role `{}` or one above", role.name()),
    }
}

/// Adds to answers the links to operations on what they name.
fn link(openapi: &mut OpenApi) {
    for resource in &RESOURCES {
        let (path, status, at) = resource.answer;
        let below = openapi.paths.paths.iter_mut().filter(|(path, _)| resource.holds(path));
        let about: Vec<String> =
            below.flat_map(|(_, item)| operations(item)).filter_map(|(_, of)| of.operation_id.clone()).collect();
        let by = openapi.paths.paths.get_mut(path);
        let answer = by
            .and_then(|item| item.post.as_mut().or(item.get.as_mut()))
            .and_then(|operation| operation.responses.responses.get_mut(status));
        let Some(RefOr::T(answer)) = answer else { continue };
        for id in about {
            let from = format!("$response.body#{at}");
            let link = Link::builder().operation_id(&id).parameter(resource.parameter(), from).build();
            answer.links.insert(id, RefOr::T(link));
        }
    }
}
