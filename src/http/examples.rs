//! Examples of what is sent and answered, in the description of the API. `tests/api_examples.rs` plays the scenario in
//! which the service answers so, and writes them.

use std::collections::BTreeMap;

use serde::Deserialize;
use serde_json::Value;
use utoipa::openapi::example::ExampleBuilder;
use utoipa::openapi::path::Operation;
use utoipa::openapi::{Content, OpenApi, Ref, RefOr};

use crate::routes::operations;

#[derive(Deserialize)]
struct Examples {
    /// By name.
    examples: BTreeMap<String, Value>,
    /// Names of examples by operation, then `request` or a status, then media type.
    operations: BTreeMap<String, BTreeMap<String, BTreeMap<String, String>>>,
}

/// Adds its examples to every body and answer.
pub fn describe(openapi: &mut OpenApi) {
    let Examples { examples, operations: names } =
        serde_json::from_str(include_str!("examples.json")).expect("a test writes it");
    for item in openapi.paths.paths.values_mut() {
        for (_, operation) in operations(item) {
            let named = operation.operation_id.as_ref().and_then(|id| names.get(id));
            for (what, of_media_type) in named.into_iter().flatten() {
                for (media_type, name) in of_media_type {
                    if let Some(content) = content(operation, what, media_type) {
                        let target = Ref::new(format!("#/components/examples/{name}"));
                        content.examples.insert(name.clone(), RefOr::Ref(target));
                    }
                }
            }
        }
    }
    let example = |value| RefOr::T(ExampleBuilder::new().value(Some(value)).build());
    let components = openapi.components.get_or_insert_default();
    components.examples = examples.into_iter().map(|(name, value)| (name, example(value))).collect();
}

fn content<'a>(operation: &'a mut Operation, what: &str, media_type: &str) -> Option<&'a mut Content> {
    let content = if what == "request" {
        let Some(RefOr::T(body)) = &mut operation.request_body else { return None };
        body.content.get_mut(media_type)
    } else {
        let Some(RefOr::T(answer)) = operation.responses.responses.get_mut(what) else { return None };
        answer.content.get_mut(media_type)
    };
    match content {
        Some(RefOr::T(content)) => Some(content),
        _ => None,
    }
}
