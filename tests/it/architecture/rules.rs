//! What the files of `src` must keep to, as functions from files to complaints.

use super::source::{File, Import};
use std::collections::{BTreeMap, BTreeSet};

/// A name, and the names that go with it, with blanks between: mostly a module, and the modules beside it that it may import.
pub type Rule = (&'static str, &'static str);

/// The names that go with that of a rule.
pub fn words(names: &'static str) -> impl Iterator<Item = &'static str> {
    names.split_whitespace()
}

/// Which child of a module imports which, and where.
pub type Graph = BTreeMap<String, BTreeMap<String, String>>;

/// Imports between the children of module `parent`, those through names that `parent` re-exports among them.
pub fn imports_within(files: &[File], parent: &[String]) -> Graph {
    let depth = parent.len();
    let child = |path: &[String]| (path.starts_with(parent)).then(|| path.get(depth).cloned()).flatten();
    let children: BTreeSet<String> = files.iter().filter_map(|f| child(&f.module)).collect();
    let of_parent = files.iter().filter(|f| f.module == parent).flat_map(File::imports);
    let named: BTreeMap<String, String> =
        of_parent.filter_map(|i| Some((i.name.clone(), re_exported(&i, depth, parent)?))).collect();
    let mut graph = Graph::new();
    for file in files {
        let Some(from) = child(&file.module) else { continue };
        for import in file.imports() {
            let Some(name) = child(&import.path) else { continue };
            // Everything at once might be anything, and no rule allows it.
            let is_known = name == "*" || children.contains(&name);
            let to =
                if is_known { Some(&name) } else { named.get(&name).filter(|to| children.contains(*to)) };
            if let Some(to) = to.filter(|to| **to != from) {
                graph.entry(from.clone()).or_default().insert(to.clone(), file.path.clone());
            }
        }
    }
    graph
}

/// The child that a name of `parent` comes from.
fn re_exported(import: &Import, depth: usize, parent: &[String]) -> Option<String> {
    import.path.starts_with(parent).then(|| import.path.get(depth).cloned()).flatten()
}

/// Imports that no rule allows, and modules without a rule.
pub fn forbidden(graph: &Graph, modules: &BTreeSet<String>, rules: &[Rule]) -> Vec<String> {
    let mut complaints = Vec::new();
    for module in modules {
        let Some((_, allowed)) = rules.iter().find(|(name, _)| name == module) else {
            complaints.push(format!("no rule says what {module} may import"));
            continue;
        };
        let imports = graph.get(module).into_iter().flatten();
        let wrong = imports.filter(|(to, _)| !words(allowed).any(|name| name == *to));
        complaints.extend(wrong.map(|(to, path)| format!("{path}: {module} must not import {to}")));
    }
    complaints
}

/// What modules must not even reach by way of others.
pub fn reached(graph: &Graph, never: &[Rule]) -> Vec<String> {
    let mut complaints = Vec::new();
    for (from, banned) in never {
        let mut seen = BTreeSet::new();
        let mut open = vec![*from];
        while let Some(module) = open.pop() {
            for to in graph.get(module).into_iter().flatten().map(|(to, _)| to.as_str()) {
                if seen.insert(to) {
                    open.push(to);
                }
            }
        }
        complaints.extend(words(banned).filter(|b| seen.contains(b)).map(|b| format!("{from} reaches {b}")));
    }
    complaints
}

/// A circle of imports, as the modules along it.
pub fn circle(graph: &Graph) -> Option<String> {
    fn walk<'g>(
        graph: &'g Graph,
        module: &'g str,
        way: &mut Vec<&'g str>,
        done: &mut BTreeSet<&'g str>,
    ) -> Option<String> {
        if let Some(start) = way.iter().position(|m| *m == module) {
            return Some(format!("{} → {module}", way[start..].join(" → ")));
        }
        if !done.insert(module) {
            return None;
        }
        way.push(module);
        let found = graph.get(module).into_iter().flatten().find_map(|(to, _)| walk(graph, to, way, done));
        way.pop();
        found
    }
    let mut done = BTreeSet::new();
    graph.keys().find_map(|module| walk(graph, module, &mut Vec::new(), &mut done))
}

/// Circles between the children of any module.
pub fn circles(files: &[File]) -> Vec<String> {
    let parents: BTreeSet<&[String]> =
        files.iter().flat_map(|f| (0..f.module.len()).map(|n| &f.module[..n])).collect();
    let found =
        |parent: &[String]| Some(format!("in {}: {}", name(parent), circle(&imports_within(files, parent))?));
    parents.into_iter().filter_map(found).collect()
}

fn name(module: &[String]) -> String {
    if module.is_empty() { "the crate".into() } else { module.join("::") }
}

/// Crates that are mentioned outside the files or folders where they belong.
pub fn strays(files: &[File], homes: &[Rule]) -> Vec<String> {
    let stray = |file: &File, (word, homes): &Rule| {
        let at_home = words(homes).any(|home| file.path.starts_with(home));
        (!at_home && file.mentions(word)).then(|| format!("{} mentions {word}", file.path))
    };
    files.iter().flat_map(|file| homes.iter().filter_map(move |rule| stray(file, rule))).collect()
}

/// Files below `folder` of more than `most` lines.
pub fn long_files(files: &[File], folder: &str, most: usize) -> Vec<String> {
    let long = files.iter().filter(|f| f.path.starts_with(folder) && f.lines() > most);
    long.map(|f| format!("{} has {} lines", f.path, f.lines())).collect()
}

/// Functions below `folder` of more than `most` lines.
pub fn long_functions(files: &[File], folder: &str, most: usize) -> Vec<String> {
    let all = files
        .iter()
        .filter(|f| f.path.starts_with(folder))
        .flat_map(|f| f.functions().into_iter().map(move |x| (f, x)));
    all.filter(|(_, (_, lines))| *lines > most)
        .map(|(f, (name, lines))| format!("{}: {name} has {lines} lines", f.path))
        .collect()
}
