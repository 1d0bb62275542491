//! `/docs`: the API as `/openapi.json` describes it, all routes on one page, and a page for each group of them.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::{Map, Value};

use super::layout::{encoded, joined, with_symbols};
use super::prelude::*;

const METHODS: [&str; 5] = ["get", "post", "put", "patch", "delete"];
const SCHEMAS: &str = "#/components/schemas/";
/// Characters of a line of an example, and items of a list and lines of a text that are shown of it.
const LINE: usize = 76;
const ITEMS: usize = 3;
const LINES: usize = 12;

/// What the document says of one method of a path.
struct Operation<'a> {
    method: &'static str,
    path: &'a str,
    said: &'a Value,
}

fn operations<'a>(api: &'a Value) -> Vec<Operation<'a>> {
    let paths = api["paths"].as_object().into_iter().flatten();
    let of_path = |(path, item): (&'a String, &'a Value)| {
        METHODS.into_iter().filter_map(move |method| Some(Operation { method, path, said: item.get(method)? }))
    };
    paths.flat_map(of_path).collect()
}

impl<'a> Operation<'a> {
    fn group(&self) -> &'a str {
        word(&self.said["tags"][0])
    }

    fn id(&self) -> &'a str {
        word(&self.said["operationId"])
    }

    fn address(&self) -> String {
        format!("{}#{}", address(self.group()), self.id())
    }
}

fn word(value: &Value) -> &str {
    value.as_str().unwrap_or_default()
}

fn address(group: &str) -> String {
    format!("/docs/{}", encoded(group))
}

fn object(value: &Value) -> impl Iterator<Item = (&String, &Value)> {
    value.as_object().into_iter().flat_map(Map::iter)
}

fn list(value: &Value) -> impl Iterator<Item = &Value> {
    value.as_array().into_iter().flatten()
}

/// All routes, by group.
pub(super) async fn all(PageContext(ref pages, ref viewer): PageContext) -> Page {
    let t = viewer.text();
    let operations = operations(&pages.api);
    let body = html! {
        h1 { (t.api) }
        p lang="en" { (with_symbols(word(&pages.api["info"]["description"]))) }
        p { a href="/openapi.json" { "/openapi.json" } " · " a href="/book/api" { (t.book) } }
        @for group in groups(&operations) {
            h2 lang="en" { a href=(address(group)) { (group) } }
            div.scroll tabindex="0" { table { tbody { @for one in operations.iter().filter(|one| one.group() == group) {
                tr {
                    td { code { (one.method.to_uppercase()) } }
                    th scope="row" { a href=(one.address()) { code { (one.path) } } }
                    td lang="en" { (inline(word(&one.said["summary"]))) }
                }
            } } } }
        }
    };
    framed(t, "", &operations, &body)
}

/// The routes of one group, with what is sent and answered.
pub(super) async fn group(
    Path(group): Path<String>,
    PageContext(ref pages, ref viewer): PageContext,
) -> Result<Page, Problem> {
    let t = viewer.text();
    let (api, operations) = (&*pages.api, operations(&pages.api));
    let own: Vec<&Operation<'_>> = operations.iter().filter(|one| one.group() == group).collect();
    if own.is_empty() {
        let no_such = message!("no_such_path", path = format!("/docs/{group}"));
        return Err(Problem::new(404, "title_no_such_page", no_such));
    }
    let mut schemas = BTreeSet::new();
    own.iter().for_each(|one| reach(api, one.said, &mut schemas));
    let here = || format!("http://localhost:8080{}", viewer.base_path);
    let url = &pages.config.hooks.external_url().map_or_else(here, str::to_owned);
    let body = html! {
        h1 lang="en" { (group) }
        p.note { (t.api_token) }
        @for one in own { (operation(t, api, one, url)) }
        h2 #schemas { (t.schemas) }
        @for name in schemas {
            @let schema = &api["components"]["schemas"][name];
            h3 id=(name) { code { (name) } }
            (prose(word(&schema["description"])))
            (members(t, schema))
        }
    };
    Ok(framed(t, &group, &operations, &body))
}

fn framed(t: &Text, group: &str, operations: &[Operation<'_>], body: &Markup) -> Page {
    let here = |one: &str| (one == group).then_some("page");
    let body = html! {
        div.book {
            nav.contents aria-label=(t.contents) { details open {
                summary { (t.contents) }
                ul {
                    li { a href="/docs" aria-current=[here("")] { (t.api) } }
                    @for group in groups(operations) {
                        li { a href=(address(group)) lang="en" aria-current=[here(group)] { (group) } }
                    }
                }
            } }
            article { (body) }
        }
    };
    let title = if group.is_empty() { t.api.to_owned() } else { format!("{} {}", t.api, address(group)) };
    Page { title, section: Section::Api, body }
}

/// In the order of their first paths.
fn groups<'a>(operations: &[Operation<'a>]) -> Vec<&'a str> {
    let mut groups: Vec<&str> = Vec::new();
    for one in operations {
        if !groups.contains(&one.group()) {
            groups.push(one.group());
        }
    }
    groups
}

fn operation(t: &Text, api: &Value, one: &Operation<'_>, url: &str) -> Markup {
    let Operation { method, path, said } = one;
    let body = &said["requestBody"]["content"];
    html! {
        section id=(one.id()) {
            h2 { a href={ "#" (one.id()) } { code { (method.to_uppercase()) " " (path) } } }
            (prose(word(&said["summary"])))
            (prose(word(&said["description"])))
            @if list(&said["parameters"]).next().is_some() {
                (wide_table("small", html! {
                    th { (t.parameter) } th { (t.place) } th { (t.kind) } th { (t.meaning_word) }
                }, html! { @for one in list(&said["parameters"]) { tr {
                    th scope="row" { code { (word(&one["name"])) } }
                    td { code { (word(&one["in"])) } }
                    td { (kind(&one["schema"])) }
                    td { (meaning(t, one, one["required"] == true)) }
                } } }))
            }
            @for (media_type, content) in object(body) {
                h3 { (t.request_body) (t.colon) code { (media_type) } " " (kind(&content["schema"])) }
                @if let Some(name) = referred(&content["schema"]) { (members(t, &api["components"]["schemas"][name])) }
                (example(t, api, content))
            }
            h3 { (t.answers) }
            (wide_table("small", html! {
                th { (t.status_word) } th { (t.meaning_word) } th { (t.kind) }
            }, html! { @for (status, answer) in object(&said["responses"]) { tr {
                th scope="row" { (status) }
                td lang="en" { (inline(word(&answer["description"]))) }
                td { @for (media_type, content) in object(&answer["content"]) {
                    code { (media_type) } " " (kind(&content["schema"])) " "
                } }
            } } }))
            // What was there before is answered as what is new.
            @let good = object(&said["responses"]).filter(|(status, _)| status.starts_with('2'));
            @let answers: BTreeMap<&String, &Value> = good.flat_map(|(_, answer)| object(&answer["content"])).collect();
            @for content in answers.values() { (example(t, api, content)) }
            pre tabindex="0" { code { (curl(one, url)) } }
        }
    }
}

/// A call of it from a shell.
fn curl(one: &Operation<'_>, url: &str) -> String {
    let required = list(&one.said["parameters"]).filter(|one| one["in"] == "query" && one["required"] == true);
    let query: Vec<String> = required.map(|one| format!("{0}={{{0}}}", word(&one["name"]))).collect();
    let query = if query.is_empty() { String::new() } else { format!("?{}", query.join("&")) };
    let method = if one.method == "get" { String::new() } else { format!("-X {} ", one.method.to_uppercase()) };
    let mut line = format!("curl -g {method}'{url}{}{query}'", one.path);
    if list(&one.said["security"]).next().is_some() {
        line += " \\\n  -H \"Authorization: Bearer $TOKEN\"";
    }
    if let Some((media_type, _)) = object(&one.said["requestBody"]["content"]).next() {
        line += &format!(" \\\n  -H 'Content-Type: {media_type}' --data-binary @FILE");
    }
    line
}

/// What a schema lists, what lies within one another by dots.
fn members(t: &Text, schema: &Value) -> Markup {
    let mut found = Vec::new();
    listed(schema, "", &mut found);
    html! {
        @if found.is_empty() { p { (kind(schema)) } }
        @else {
            (wide_table("small", html! {
                th { (t.member) } th { (t.kind) } th { (t.meaning_word) }
            }, html! { @for (name, schema, required) in &found { tr {
                th scope="row" { code { (name) } }
                td { (kind(schema)) }
                td { (meaning(t, schema, *required)) }
            } } }))
        }
    }
}

fn listed<'a>(schema: &'a Value, within: &str, found: &mut Vec<(String, &'a Value, bool)>) {
    for part in list(&schema["allOf"]) {
        match part.get("properties").or(part.get("allOf")) {
            Some(_) => listed(part, within, found),
            None => found.push((format!("{within}…"), part, true)),
        }
    }
    for (name, member) in object(&schema["properties"]) {
        let path = format!("{within}{name}");
        found.push((path.clone(), member, list(&schema["required"]).any(|one| one == name)));
        listed(member, &format!("{path}."), found);
        listed(&member["items"], &format!("{path}[]."), found);
        for one in ["oneOf", "anyOf"].iter().flat_map(|how| list(&member[*how])) {
            listed(one, &format!("{path}."), found);
        }
    }
}

/// The schema that another one stands for.
fn referred(schema: &Value) -> Option<&str> {
    schema["$ref"].as_str()?.strip_prefix(SCHEMAS)
}

/// The name of a type, or the way to the schema that has it.
fn kind(schema: &Value) -> Markup {
    if let Some(name) = referred(schema) {
        return html! { a href={ "#" (name) } { code { (name) } } };
    }
    let either = ["oneOf", "anyOf", "allOf"].iter().find_map(|how| schema[*how].as_array());
    let types = match &schema["type"] {
        Value::Array(types) => types.iter().map(word).collect::<Vec<_>>().join(" | "),
        one => word(one).to_owned(),
    };
    let format = schema["format"].as_str().map(|format| format!(" ({format})"));
    match (&schema["enum"], either) {
        (Value::Array(values), _) => joined(" | ", values.iter().map(|value| html! { code { (value) } })),
        (_, Some(all)) => joined(" | ", all.iter().map(kind)),
        _ if schema.get("items").is_some() => html! { (kind(&schema["items"])) code { "[]" } },
        _ if schema["additionalProperties"].is_object() => {
            html! { code { "{…: " } (kind(&schema["additionalProperties"])) code { "}" } }
        }
        _ => html! { code { (types) (format.unwrap_or_default()) } },
    }
}

/// What is said of a parameter or a member, whether it has to be there, and its limits.
fn meaning(t: &Text, of: &Value, required: bool) -> Markup {
    let schema = of.get("schema").unwrap_or(of);
    let limits = [("minimum", "≥"), ("exclusiveMinimum", ">"), ("maximum", "≤"), ("exclusiveMaximum", "<")];
    let limits = limits.iter().filter_map(|(key, sign)| Some(format!("{sign} {}", schema.get(key)?)));
    // Of what may be null, its other form says it.
    let forms = ["oneOf", "anyOf", "allOf"].iter().flat_map(|how| list(&schema[*how]));
    let text = [of].into_iter().chain(forms).map(|one| word(&one["description"])).find(|text| !text.is_empty());
    html! {
        @if required { strong { (t.required_word) } " " }
        span lang="en" { (inline(text.unwrap_or_default())) }
        @for limit in limits { " " code { (limit) } }
    }
}

/// Names of the schemas that something refers to, and those of what these refer to.
fn reach<'a>(api: &'a Value, from: &'a Value, found: &mut BTreeSet<&'a str>) {
    match from {
        Value::Object(members) => {
            if let Some(name) = referred(from)
                && found.insert(name)
            {
                reach(api, &api["components"]["schemas"][name], found);
            }
            members.values().for_each(|one| reach(api, one, found));
        }
        Value::Array(items) => items.iter().for_each(|one| reach(api, one, found)),
        _ => {}
    }
}

fn example(t: &Text, api: &Value, content: &Value) -> Markup {
    let name = object(&content["examples"]).next().map(|(name, _)| name);
    let value = name.map(|name| &api["components"]["examples"][name]["value"]);
    html! { @if let Some(value) = value {
        details { summary { (t.example) } pre tabindex="0" { code { (shown(value)) } } }
    } }
}

/// An example as a person reads it: the beginnings of long lists and texts.
fn shown(value: &Value) -> String {
    let mut text = String::new();
    match value.as_str() {
        Some(lines) => {
            let all: Vec<&str> = lines.lines().collect();
            text.push_str(&all[..all.len().min(LINES)].join("\n"));
            if all.len() > LINES {
                text.push_str("\n…");
            }
        }
        None => lay_out(value, 0, &mut text),
    }
    text
}

fn lay_out(value: &Value, indent: usize, text: &mut String) {
    let (open, items, close): (_, Vec<(String, &Value)>, _) = match value {
        Value::Object(members) => {
            ("{", members.iter().map(|(name, one)| (format!("\"{name}\": "), one)).collect(), "}")
        }
        Value::Array(items) => ("[", items.iter().map(|one| (String::new(), one)).collect(), "]"),
        _ => ("", Vec::new(), ""),
    };
    let short = value.to_string();
    if items.is_empty() || indent + short.len() < LINE {
        return text.push_str(&short);
    }
    let most = if value.is_array() { ITEMS } else { items.len() };
    let end = |indent: usize| format!("\n{}", " ".repeat(indent));
    text.push_str(open);
    for (k, (name, one)) in items.iter().take(most).enumerate() {
        text.push_str(if k > 0 { "," } else { "" });
        text.push_str(&(end(indent + 2) + name));
        lay_out(one, indent + 2, text);
    }
    if items.len() > most {
        text.push_str(&format!(",{}… ({})", end(indent + 2), items.len()));
    }
    text.push_str(&(end(indent) + close));
}

/// Paragraphs.
fn prose(text: &str) -> Markup {
    let paragraphs = text.split("\n\n").filter(|paragraph| !paragraph.trim().is_empty());
    html! { @for paragraph in paragraphs { p lang="en" { (inline(paragraph)) } } }
}

/// A sentence with what is code between its backticks.
fn inline(text: &str) -> Markup {
    html! { @for (k, part) in text.split('`').enumerate() { @if k % 2 == 1 { code { (part) } } @else { (part) } } }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn a_type_is_said_in_a_word_or_leads_to_its_schema() {
        let kind = |schema: Value| super::kind(&schema).into_string();
        assert_eq!(kind(json!({ "type": ["string", "null"], "format": "uri" })), "<code>string | null (uri)</code>");
        let body = json!({ "$ref": "#/components/schemas/Body" });
        assert_eq!(kind(json!({ "items": body })), "<a href=\"#Body\"><code>Body</code></a><code>[]</code>");
        let either = kind(json!({ "oneOf": [{ "type": "null" }, body] }));
        assert_eq!(either, "<code>null</code> | <a href=\"#Body\"><code>Body</code></a>");
        assert_eq!(kind(json!({ "enum": ["a", 2] })), "<code>&quot;a&quot;</code> | <code>2</code>");
    }

    #[test]
    fn members_within_members_and_parts_of_a_schema_are_listed() {
        let inner = json!({ "properties": { "b": {} }, "required": ["b"] });
        let schema = json!({ "allOf": [{ "$ref": "#/components/schemas/Head" }, { "properties": { "a": inner, "c": { "items": inner } } }] });
        let mut found = Vec::new();
        listed(&schema, "", &mut found);
        let found: Vec<(&str, bool)> = found.iter().map(|(name, _, required)| (name.as_str(), *required)).collect();
        assert_eq!(found, [("…", true), ("a", false), ("a.b", true), ("c", false), ("c[].b", true)]);
    }

    #[test]
    fn examples_show_the_beginnings_of_what_is_long() {
        assert_eq!(shown(&json!({ "a": [1, 2, 3, 4] })), "{\"a\":[1,2,3,4]}");
        let long = shown(&json!({ "a": (100_000..100_020).collect::<Vec<_>>() }));
        assert_eq!(long, "{\n  \"a\": [\n    100000,\n    100001,\n    100002,\n    … (20)\n  ]\n}");
        assert_eq!(shown(&json!(["x\n"; 30].concat())).lines().count(), LINES + 1);
    }

    #[test]
    fn what_is_described_runs_nothing() {
        let said = prose("a `<b>` c\n\n<script>").into_string();
        assert_eq!(said, "<p lang=\"en\">a <code>&lt;b&gt;</code> c</p><p lang=\"en\">&lt;script&gt;</p>");
    }
}
