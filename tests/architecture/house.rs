//! The house as its source says it is: modules, what each defines, and which takes what from which.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use syn::visit::{self, Visit};

/// A module of the crate, as its path below the crate: `["core", "judge"]`.
pub type Module = Vec<String>;

#[derive(Default)]
struct Source {
    file: String,
    defines: BTreeSet<String>,
    types: BTreeSet<String>,
    /// Name here -> what it stands for, with whether it is handed on.
    uses: BTreeMap<String, (Vec<String>, bool)>,
    globs: Vec<Vec<String>>,
    paths: BTreeSet<Vec<String>>,
    impls: BTreeSet<Vec<String>>,
    lines: usize,
    long_lines: usize,
}

pub struct House {
    modules: BTreeMap<Module, Source>,
}

pub const MOST_COLUMNS: usize = 120;

impl House {
    /// Reads every file below `src`, without unit tests.
    pub fn read(src: &Path) -> Self {
        let mut modules = BTreeMap::new();
        for path in super::files_below(src) {
            if path.extension().is_none_or(|e| e != "rs") || super::is_test(&path) {
                continue;
            }
            let name = path.strip_prefix(src).unwrap().display().to_string();
            let module = module_of(&name);
            // A binary is a crate of its own.
            if name != "main.rs" {
                modules.insert(module, Source::of(name, &fs::read_to_string(&path).unwrap()));
            }
        }
        Self { modules }
    }

    /// Of files given by name and text.
    pub fn of(files: &[(&str, &str)]) -> Self {
        let modules = files.iter().map(|(name, text)| (module_of(name), Source::of((*name).to_owned(), text)));
        Self { modules: modules.collect() }
    }

    pub fn files(&self) -> usize {
        self.modules.len()
    }

    pub fn lines(&self) -> usize {
        self.modules.values().map(|source| source.lines).sum()
    }

    pub fn long_lines(&self) -> usize {
        self.modules.values().map(|source| source.long_lines).sum()
    }

    /// All arrows: a file, and what it takes from which other.
    pub fn arrows(&self) -> BTreeMap<&Module, BTreeMap<&Module, BTreeSet<String>>> {
        let mut arrows: BTreeMap<&Module, BTreeMap<&Module, BTreeSet<String>>> = BTreeMap::new();
        for (module, source) in &self.modules {
            let taken = source.uses.values().filter(|(_, handed_on)| !handed_on).map(|(path, _)| path);
            let globs = source.globs.iter().filter_map(|path| self.absolute(module, path));
            for (to, name) in taken.chain(&source.paths).filter_map(|path| self.resolve(module, path)) {
                arrows.entry(module).or_default().entry(to).or_default().insert(name);
            }
            for glob in globs {
                if let Some((to, _)) = self.modules.get_key_value(&glob) {
                    arrows.entry(module).or_default().entry(to).or_default().insert("*".into());
                }
            }
            if let Some(to) = arrows.get_mut(module) {
                to.remove(module);
            }
        }
        arrows
    }

    /// Sets of files each of which takes something from another of them, and so on in a circle.
    pub fn circles(&self) -> Vec<Vec<String>> {
        let arrows = self.arrows();
        let names: Vec<&Module> = self.modules.keys().collect();
        let place: BTreeMap<&Module, usize> = names.iter().enumerate().map(|(i, m)| (*m, i)).collect();
        let mut reaches = vec![vec![false; names.len()]; names.len()];
        for (start, row) in reaches.iter_mut().enumerate() {
            let mut open = vec![start];
            while let Some(at) = open.pop() {
                for to in arrows.get(names[at]).into_iter().flat_map(BTreeMap::keys) {
                    if !std::mem::replace(&mut row[place[to]], true) {
                        open.push(place[to]);
                    }
                }
            }
        }
        let mut found = BTreeSet::new();
        for (i, reached) in reaches.iter().enumerate() {
            if reached[i] {
                let members = (0..names.len()).filter(|&j| reached[j] && reaches[j][i]);
                found.insert(members.map(|j| self.modules[names[j]].file.clone()).collect::<Vec<_>>());
            }
        }
        found.into_iter().collect()
    }

    /// The arrows within one circle, to show what ties it.
    pub fn ties(&self, circle: &[String]) -> Vec<String> {
        self.arrows_that(|from, to| circle.contains(from) && circle.contains(to))
    }

    /// The arrows into the files below a place.
    pub fn takes_from(&self, place: &str) -> Vec<String> {
        self.arrows_that(|from, to| to.starts_with(place) && !from.starts_with(place))
    }

    /// Those from one file to another that are told, each in a line.
    fn arrows_that(&self, are_told: impl Fn(&String, &String) -> bool) -> Vec<String> {
        let mut ties = Vec::new();
        for (from, to) in self.arrows() {
            for (to, names) in to {
                let (from, to) = (&self.modules[from].file, &self.modules[to].file);
                if are_told(from, to) {
                    ties.push(format!("{from} -> {to}: {}", Vec::from_iter(names).join(", ")));
                }
            }
        }
        ties
    }

    /// Types by the files that have inherent implementations of them.
    pub fn implementations(&self) -> BTreeMap<(Module, String), BTreeSet<String>> {
        let mut found: BTreeMap<(Module, String), BTreeSet<String>> = BTreeMap::new();
        for (module, source) in &self.modules {
            for path in &source.impls {
                if let Some((home, name)) = self.resolve(module, path) {
                    found.entry((home.clone(), name)).or_default().insert(source.file.clone());
                }
            }
        }
        found
    }

    /// Type names with the files that define one of that name.
    pub fn types(&self) -> BTreeMap<String, Vec<String>> {
        let mut found: BTreeMap<String, Vec<String>> = BTreeMap::new();
        for source in self.modules.values() {
            for name in &source.types {
                found.entry(name.clone()).or_default().push(source.file.clone());
            }
        }
        found
    }

    /// The path from the crate's root; none of another crate's.
    fn absolute(&self, module: &Module, path: &[String]) -> Option<Vec<String>> {
        let head = path.first()?;
        let mut base = module.clone();
        let mut rest = path;
        match head.as_str() {
            "crate" => return Some(path[1..].to_vec()),
            "self" => rest = &rest[1..],
            "super" => {
                while rest.first().is_some_and(|segment| segment == "super") {
                    base.pop()?;
                    rest = &rest[1..];
                }
            }
            name => {
                let mut child = module.clone();
                child.push(name.to_owned());
                let source = self.modules.get(module)?;
                // `use open::open` beside `mod open`: the name in a path is the module.
                let used = source
                    .uses
                    .get(name)
                    .filter(|(target, _)| target.first() != Some(head) || !self.modules.contains_key(&child));
                if let Some((target, _)) = used {
                    if target.first() == Some(head) {
                        return None;
                    }
                    let target = self.absolute(module, target)?;
                    return Some([&target, &path[1..]].concat());
                }
                if !self.modules.contains_key(&child) && !source.defines.contains(name) {
                    let from_glob = source.globs.iter().filter(|glob| glob.first() != Some(head));
                    let from_glob =
                        from_glob.filter(|glob| is_rooted(glob)).filter_map(|glob| self.absolute(module, glob));
                    let home = from_glob.into_iter().find(|home| self.hands_on(home, name))?;
                    return Some([&home, path].concat());
                }
            }
        }
        Some([&base, rest].concat())
    }

    fn hands_on(&self, module: &[String], name: &str) -> bool {
        self.modules.get(module).is_some_and(|s| s.defines.contains(name) || s.uses.contains_key(name))
    }

    /// The module that defines what a path names, through all that hand it on, with the name that is taken.
    fn resolve(&self, module: &Module, path: &[String]) -> Option<(&Module, String)> {
        let is_local = path.len() == 1;
        let mut path = self.absolute(module, path)?;
        for _ in 0..8 {
            let mut known = (0..=path.len()).rev().find(|&n| self.modules.contains_key(&path[..n]))?;
            // `store::open` is what the store hands on by that name, not the module; `open` alone may be a variable.
            if !is_local && known == path.len() && known > 0 && self.hands_on(&path[..known - 1], &path[known - 1]) {
                known -= 1;
            }
            let (home, source) = self.modules.get_key_value(&path[..known])?;
            let name = path.get(known)?;
            if source.defines.contains(name) {
                return Some((home, name.clone()));
            }
            if let Some((target, _)) = source.uses.get(name) {
                path = [&self.absolute(home, target)?, &path[known + 1..]].concat();
            } else {
                let globs = source.globs.iter().filter_map(|glob| self.absolute(home, glob));
                let from = globs.into_iter().find(|glob| self.hands_on(glob, name))?;
                path = [&from, &path[known..]].concat();
            }
        }
        None
    }
}

/// Whether a path says by itself where it begins.
fn is_rooted(path: &[String]) -> bool {
    path.first().is_some_and(|head| matches!(head.as_str(), "crate" | "self" | "super"))
}

fn module_of(file: &str) -> Module {
    let stem = file.strip_suffix(".rs").unwrap_or(file);
    let mut module: Module = stem.split('/').map(str::to_owned).collect();
    if matches!(module.last().map(String::as_str), Some("mod" | "lib")) {
        module.pop();
    }
    module
}

fn names_of(path: &syn::Path) -> Vec<String> {
    path.segments.iter().map(|segment| segment.ident.to_string()).collect()
}

/// Whether an item is compiled for unit tests alone.
pub fn is_for_tests(item: &syn::Item) -> bool {
    use syn::Item;
    let attributes = match item {
        Item::Const(i) => &i.attrs,
        Item::Enum(i) => &i.attrs,
        Item::Fn(i) => &i.attrs,
        Item::Impl(i) => &i.attrs,
        Item::Macro(i) => &i.attrs,
        Item::Mod(i) => &i.attrs,
        Item::Static(i) => &i.attrs,
        Item::Struct(i) => &i.attrs,
        Item::Trait(i) => &i.attrs,
        Item::Type(i) => &i.attrs,
        Item::Use(i) => &i.attrs,
        _ => return false,
    };
    attributes
        .iter()
        .any(|a| a.path().is_ident("cfg") && a.meta.require_list().is_ok_and(|l| l.tokens.to_string() == "test"))
}

impl Source {
    fn of(file: String, text: &str) -> Self {
        let production = super::production(text);
        let lines = production.lines().count();
        let long_lines = production.lines().filter(|line| line.chars().count() > MOST_COLUMNS).count();
        let parsed = syn::parse_file(text).unwrap_or_else(|e| panic!("{file}: {e}"));
        let mut source = Self { file, lines, long_lines, ..Self::default() };
        source.visit_file(&parsed);
        source
    }

    fn define(&mut self, name: &syn::Ident) {
        self.defines.insert(name.to_string());
    }

    fn leaves(&mut self, tree: &syn::UseTree, before: &[String], handed_on: bool) {
        let with = |name: &syn::Ident| [before, &[name.to_string()]].concat();
        match tree {
            syn::UseTree::Path(path) => self.leaves(&path.tree, &with(&path.ident), handed_on),
            syn::UseTree::Group(group) => group.items.iter().for_each(|tree| self.leaves(tree, before, handed_on)),
            syn::UseTree::Glob(_) => self.globs.push(before.to_vec()),
            syn::UseTree::Name(name) if name.ident == "self" => {
                if let Some(last) = before.last() {
                    self.uses.insert(last.clone(), (before.to_vec(), handed_on));
                }
            }
            syn::UseTree::Name(name) => _ = self.uses.insert(name.ident.to_string(), (with(&name.ident), handed_on)),
            syn::UseTree::Rename(rename) => {
                self.uses.insert(rename.rename.to_string(), (with(&rename.ident), handed_on));
            }
        }
    }
}

impl<'ast> Visit<'ast> for Source {
    fn visit_item(&mut self, item: &'ast syn::Item) {
        use syn::Item;
        if is_for_tests(item) {
            return;
        }
        match item {
            Item::Fn(i) => self.define(&i.sig.ident),
            Item::Struct(i) => {
                self.define(&i.ident);
                self.types.insert(i.ident.to_string());
            }
            Item::Enum(i) => {
                self.define(&i.ident);
                self.types.insert(i.ident.to_string());
            }
            Item::Trait(i) => self.define(&i.ident),
            Item::Type(i) => self.define(&i.ident),
            Item::Const(i) => self.define(&i.ident),
            Item::Static(i) => self.define(&i.ident),
            Item::Macro(i) => i.ident.iter().for_each(|name| self.define(name)),
            Item::Use(i) => {
                let handed_on = !matches!(i.vis, syn::Visibility::Inherited);
                self.leaves(&i.tree, &[], handed_on);
            }
            Item::Impl(i) if i.trait_.is_none() => {
                if let syn::Type::Path(of) = &*i.self_ty {
                    self.impls.insert(names_of(&of.path));
                }
            }
            _ => {}
        }
        visit::visit_item(self, item);
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        self.paths.insert(names_of(path));
        visit::visit_path(self, path);
    }

    /// What a macro is given is not parsed: its paths are read from its text.
    fn visit_macro(&mut self, of: &'ast syn::Macro) {
        let text = of.tokens.to_string().replace(" :: ", "::").replace(":: ", "::");
        let words = text.split(|c: char| !super::is_ident(c) && c != ':').filter(|word| word.contains("::"));
        self.paths.extend(words.map(|path| path.split("::").map(str::to_owned).collect()));
        visit::visit_macro(self, of);
    }

    fn visit_visibility(&mut self, _: &'ast syn::Visibility) {}
}
