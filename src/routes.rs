//! Routes, each written once with the least role that it takes. The router, who is admitted and the description of
//! the API follow from that.

use std::collections::HashMap;

use axum::Router;
use axum::handler::Handler;
use axum::http::Method;
use axum::routing::{self, MethodRouter};
use utoipa::openapi::path::{Operation, ParameterIn, PathItem};
use utoipa::openapi::{OpenApi, RefOr};
use utoipa_axum::router::{OpenApiRouter, UtoipaMethodRouter};

use crate::core::access::Role;

/// The least role that a route takes; none: it takes no token.
pub type MinimumRole = Option<Role>;

pub const ANYONE: MinimumRole = None;
pub const VIEWER: MinimumRole = Some(Role::Viewer);
pub const STATION: MinimumRole = Some(Role::Station);
pub const ENGINEER: MinimumRole = Some(Role::Engineer);
pub const ADMIN: MinimumRole = Some(Role::Admin);

/// What a request to the API may say beside its path and body, as it is described.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AcceptedInputs {
    pub parameters: Vec<String>,
    pub headers: Vec<String>,
}

impl AcceptedInputs {
    fn of(operation: &Operation) -> Self {
        let names = |place: ParameterIn| {
            let described = operation.parameters.iter().flatten().filter_map(|one| match one {
                RefOr::T(one) if one.parameter_in == place => Some(one.name.clone()),
                _ => None,
            });
            described.collect()
        };
        Self { parameters: names(ParameterIn::Query), headers: names(ParameterIn::Header) }
    }
}

/// Who may use a method of a path.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AccessRule {
    pub method: Method,
    pub path: String,
    pub least: MinimumRole,
    /// None of a page, which reads what it needs.
    pub takes: Option<AcceptedInputs>,
}

/// A router that knows who may use it.
pub struct Routes<S = ()> {
    router: OpenApiRouter<S>,
    rules: Vec<AccessRule>,
}

impl<S: Clone + Send + Sync + 'static> Default for Routes<S> {
    fn default() -> Self {
        Self { router: OpenApiRouter::default(), rules: Vec::new() }
    }
}

impl<S: Clone + Send + Sync + 'static> Routes<S> {
    /// A route of the API: `utoipa_axum::routes!` of a handler, which says method and path itself.
    #[must_use]
    pub fn api(mut self, least: MinimumRole, mut handler: UtoipaMethodRouter<S>) -> Self {
        for (path, item) in &mut handler.1.paths {
            let rule = |(method, operation): (Method, &mut Operation)| AccessRule {
                method,
                path: path.clone(),
                least,
                takes: Some(AcceptedInputs::of(operation)),
            };
            self.rules.extend(operations(item).map(rule));
        }
        self.map(|router| router.routes(handler))
    }

    /// A page.
    #[must_use]
    pub fn get<H: Handler<T, S>, T: 'static>(self, least: MinimumRole, path: &str, handler: H) -> Self {
        self.page(Method::GET, path, least, routing::get(handler))
    }

    /// What a form on a page is sent to.
    #[must_use]
    pub fn post<H: Handler<T, S>, T: 'static>(self, least: MinimumRole, path: &str, handler: H) -> Self {
        self.page(Method::POST, path, least, routing::post(handler))
    }

    fn page(mut self, method: Method, path: &str, least: MinimumRole, handler: MethodRouter<S>) -> Self {
        self.rules.push(AccessRule { method, path: path.to_owned(), least, takes: None });
        self.map(|router| router.route(path, handler))
    }

    /// Puts layers around the routes so far.
    #[must_use]
    pub fn map(self, change: impl FnOnce(OpenApiRouter<S>) -> OpenApiRouter<S>) -> Self {
        Self { router: change(self.router), rules: self.rules }
    }

    /// Both together.
    #[must_use]
    pub fn merge(self, other: Self) -> Self {
        Self { router: self.router.merge(other.router), rules: [self.rules, other.rules].concat() }
    }

    /// Gives the handlers their state.
    pub fn with_state(self, state: S) -> Routes {
        Routes { router: self.router.with_state(state), rules: self.rules }
    }

    /// What the API's description says of them.
    pub fn description(&self) -> &OpenApi {
        self.router.get_openapi()
    }

    /// In the order in which they were written down.
    pub fn rules(&self) -> &[AccessRule] {
        &self.rules
    }

    /// The handlers alone, without the roles: the caller checks them.
    pub fn into_router(self) -> Router<S> {
        self.router.into()
    }
}

pub fn operations(item: &mut PathItem) -> impl Iterator<Item = (Method, &mut Operation)> {
    let methods = [
        (Method::GET, &mut item.get),
        (Method::POST, &mut item.post),
        (Method::PUT, &mut item.put),
        (Method::PATCH, &mut item.patch),
        (Method::DELETE, &mut item.delete),
    ];
    methods.into_iter().filter_map(|(method, operation)| Some((method, operation.as_mut()?)))
}

#[derive(Debug)]
pub struct Rules(HashMap<String, HashMap<Method, (MinimumRole, Option<AcceptedInputs>)>>);

impl Rules {
    /// By path and method.
    pub fn of(rules: &[AccessRule]) -> Self {
        let mut by_path: HashMap<_, HashMap<_, _>> = HashMap::new();
        for AccessRule { method, path, least, takes } in rules.iter().cloned() {
            by_path.entry(path).or_default().insert(method, (least, takes));
        }
        Self(by_path)
    }

    /// Who may use a method of a path; none where it does not take the method.
    pub fn get(&self, method: &Method, path: &str) -> Option<MinimumRole> {
        Some(self.rule(method, path)?.0)
    }

    pub fn takes(&self, method: &Method, path: &str) -> Option<&AcceptedInputs> {
        self.rule(method, path)?.1.as_ref()
    }

    fn rule(&self, method: &Method, path: &str) -> Option<&(MinimumRole, Option<AcceptedInputs>)> {
        let method = if *method == Method::HEAD { &Method::GET } else { method };
        self.0.get(path)?.get(method)
    }
}
