//! Imports go one way, within the command line too, and no file grows beyond what one reads in one go.

use std::path::{Path, PathBuf};

use crate::support::repository;

/// The modules of the library and the binary from the ground up. A module imports from lines above
/// its own only, never from its neighbours.
const LAYERS: &[&[&str]] = &[
    &["error", "limits", "cancel"],
    &["geom"],
    &["volume", "mesh"],
    &["source", "kernel", "sink", "reader"],
    &["pipeline", "phantom"],
    &["cli"],
    &["main"],
];

/// Names at the top of the library that are no modules, and where they come from.
const ALIASES: [(&str, &str); 4] =
    [("Error", "error"), ("Kind", "error"), ("mesh_placed", "pipeline"), ("with_planes", "source")];

const MOST_LINES: usize = 400;

fn layer(module: &str) -> Option<usize> {
    LAYERS.iter().position(|layer| layer.contains(&module))
}

/// All files under a folder of the repository whose names end so.
fn files(folder: &str, extensions: &[&str]) -> Vec<PathBuf> {
    let mut found: Vec<PathBuf> = walkdir::WalkDir::new(repository(folder))
        .into_iter()
        .filter_map(Result::ok)
        .filter(|entry| entry.file_type().is_file())
        .map(walkdir::DirEntry::into_path)
        .filter(|path| {
            let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
            extensions.contains(&extension)
        })
        .collect();
    found.sort();
    found
}

/// The names that a line of code takes from the top of the crate. `depth` is how many `super` lead
/// there.
fn taken(line: &str, depth: usize) -> Vec<String> {
    let name = |rest: &str| {
        rest.split(|c: char| !(c.is_alphanumeric() || c == '_')).next().map(str::to_owned)
    };
    let mut names = Vec::new();
    for word in ["crate::", "mcubes::"] {
        for (at, _) in line.match_indices(word) {
            let rest = &line[at + word.len()..];
            let whole = !line[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_');
            match rest.strip_prefix('{') {
                _ if !whole => {}
                Some(list) => names.extend(list.split(',').filter_map(|n| name(n.trim_start()))),
                None => names.extend(name(rest)),
            }
        }
    }
    let chain = "super::".repeat(depth);
    if let Some((_, rest)) = line.split_once(&chain)
        && depth > 0
    {
        names.extend(name(rest.trim_start_matches("super::")));
    }
    names.retain(|n| !n.is_empty());
    names
}

/// What is wrong with the imports of one file of the module `module`, `depth` levels below the top.
fn wrong_imports(text: &str, module: &str, depth: usize) -> Vec<String> {
    let Some(own) = layer(module) else {
        return vec![format!("the module {module} has no place in the order")];
    };
    let mut wrong = Vec::new();
    for (number, line) in text.lines().enumerate() {
        let code = line.split("//").next().unwrap_or_default();
        for name in taken(code, depth) {
            let alias = ALIASES.iter().find(|(alias, _)| *alias == name);
            let from = alias.map_or(name.as_str(), |(_, module)| module);
            if from != module && layer(from).is_some_and(|theirs| theirs >= own) {
                wrong.push(format!("line {}: {module} imports {from}", number + 1));
            }
        }
    }
    wrong
}

fn module_of(path: &Path) -> (String, usize) {
    let inner = path.strip_prefix(repository("src")).unwrap().with_extension("");
    let mut parts: Vec<String> =
        inner.components().map(|c| c.as_os_str().to_string_lossy().into_owned()).collect();
    if parts.last().is_some_and(|last| last == "mod") {
        parts.pop();
    }
    (parts[0].clone(), parts.len())
}

#[test]
fn imports_go_one_way() {
    let mut wrong = Vec::new();
    let sources = files("src", &["rs"]);
    assert!(sources.len() > 50, "{} files", sources.len());
    for path in sources {
        let (module, depth) = module_of(&path);
        if module == "lib" {
            continue;
        }
        let text = std::fs::read_to_string(&path).unwrap();
        for line in wrong_imports(&text, &module, depth) {
            wrong.push(format!("{}: {line}", path.display()));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn an_import_against_the_order_is_found() {
    for (module, depth, line) in [
        ("geom", 1, "use crate::volume::Meta;"),
        ("source", 3, "    let x = crate::kernel::cpu();"),
        ("volume", 2, "use crate::mesh::Mesh;"),
        ("limits", 1, "use super::error::Kind;"),
        ("kernel", 1, "use super::pipeline::mesh;"),
        ("mesh", 2, "use crate::{geom, pipeline};"),
        ("mesh", 2, "use crate::mesh_placed;"),
    ] {
        assert_eq!(wrong_imports(line, module, depth).len(), 1, "{module}: {line}");
    }
    for (module, depth, line) in [
        ("cli", 2, "use crate::pipeline::{mesh, RunOptions};"),
        ("pipeline", 2, "use super::run::run; // never crate::cli"),
        ("source", 3, "use super::super::input::Input;"),
        ("main", 1, "    mcubes::cli::main()"),
    ] {
        assert_eq!(wrong_imports(line, module, depth), Vec::<String>::new(), "{module}: {line}");
    }
    assert_eq!(wrong_imports("", "elsewhere", 1).len(), 1);
}

#[test]
fn each_layer_is_a_module() {
    for module in LAYERS.iter().copied().flatten() {
        let found = [format!("src/{module}.rs"), format!("src/{module}/mod.rs")];
        assert!(found.iter().any(|path| repository(path).exists()), "{module}");
    }
}

/// The modules that a file of the command line imports from, of those in `all`; `own` is its own.
/// A module may import from those that it holds, so none of these from it.
fn imported(text: &str, own: &str, all: &[String]) -> Vec<String> {
    let mut found = Vec::new();
    for import in text.split("\nuse ").skip(1) {
        let import: String = import.split(';').next().unwrap().split_whitespace().collect();
        let mut base = own;
        let mut rest = import.as_str();
        while let Some(above) = rest.strip_prefix("super::") {
            (base, rest) = (base.rsplit_once("::").map_or("", |(above, _)| above), above);
        }
        if let Some(inner) = rest.strip_prefix("crate::") {
            (base, rest) = ("", inner);
        }
        let (path, names) = rest.split_once('{').unwrap_or((rest, ""));
        let names = names.trim_end_matches('}').split(',').map(|name| format!("{path}{name}"));
        for name in names {
            let whole = format!("{base}::{name}");
            let whole = whole.trim_start_matches("::");
            // The longest module that the path begins with; what is left are its items.
            let is_of = |module: &&String| {
                whole
                    .strip_prefix(module.as_str())
                    .is_some_and(|r| r.is_empty() || r.starts_with("::"))
            };
            found.extend(all.iter().filter(is_of).max_by_key(|module| module.len()).cloned());
        }
    }
    found.retain(|module| module != own);
    found
}

/// A circle of imports, if there is one.
fn circle(imports: &[(String, Vec<String>)]) -> Option<Vec<String>> {
    // What imports nothing that is left is taken away, until nothing is.
    let mut left: Vec<&(String, Vec<String>)> = imports.iter().collect();
    loop {
        let names: Vec<&String> = left.iter().map(|(name, _)| name).collect();
        let n = left.len();
        let mut kept = left.clone();
        kept.retain(|(_, from)| from.iter().any(|name| names.contains(&name)));
        if kept.is_empty() {
            return None;
        }
        if kept.len() == n {
            return Some(names.into_iter().cloned().collect());
        }
        left = kept;
    }
}

#[test]
fn imports_within_the_command_line_go_in_no_circle() {
    let path_of = |path: &PathBuf| {
        let inner = path.strip_prefix(repository("src")).unwrap().with_extension("");
        let name = inner.display().to_string().replace('/', "::");
        name.strip_suffix("::mod").map_or(name.clone(), str::to_owned)
    };
    let sources = files("src/cli", &["rs"]);
    let all: Vec<String> = sources.iter().map(path_of).collect();
    let imports: Vec<(String, Vec<String>)> = sources
        .iter()
        .zip(&all)
        .map(|(path, own)| {
            let text = std::fs::read_to_string(path).unwrap();
            (own.clone(), imported(&text, own, &all))
        })
        .collect();
    let n_imports: usize = imports.iter().map(|(_, from)| from.len()).sum();
    assert!(n_imports > 80, "{n_imports} imports");
    assert_eq!(circle(&imports), None);
}

#[test]
fn a_circle_is_found() {
    let all = ["cli", "cli::a", "cli::b", "cli::b::c"].map(str::to_owned);
    let a = "\nuse super::b::{c,\n    Item};\nuse crate::geom::Dims;";
    assert_eq!(imported(a, "cli::a", &all), ["cli::b::c", "cli::b"]);
    assert_eq!(imported("\nuse super::super::a::Item;", "cli::b::c", &all), ["cli::a"]);
    assert_eq!(imported("\nuse a::Item;\nuse std::fmt;", "cli", &all), ["cli::a"]);
    let of = |from: &[(&str, &[&str])]| {
        let owned = |names: &[&str]| names.iter().map(|&n| n.to_owned()).collect();
        from.iter().map(|&(n, names)| (n.to_owned(), owned(names))).collect::<Vec<_>>()
    };
    assert_eq!(circle(&of(&[("a", &["b"]), ("b", &["c"]), ("c", &[])])), None);
    assert!(circle(&of(&[("a", &["b"]), ("b", &["c"]), ("c", &["b"])])).is_some());
}

#[test]
fn no_file_is_longer_than_400_lines() {
    let mut long = Vec::new();
    for folder in ["src", "tests", "examples", "benches", "fuzz/fuzz_targets"] {
        for path in files(folder, &["rs", "py", "sh"]) {
            let text = std::fs::read_to_string(&path).unwrap();
            // A generated file names its generator at its head.
            let generated = text.lines().take(3).any(|line| line.contains("Generated by"));
            let lines = text.lines().count();
            if lines > MOST_LINES && !generated {
                long.push(format!("{}: {lines} lines", path.display()));
            }
        }
    }
    assert!(long.is_empty(), "{}", long.join("\n"));
}
