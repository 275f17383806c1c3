//! Which way dependencies point, read from the sources: see "Which way dependencies point" in the crate's documentation of its
//! layers. What only the tests of a file use is passed over.

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
};

/// What each layer may use: another layer, or one module of it.
const ARROWS: [(&str, &[&str]); 9] = [
    // A macro for enums with names, which every layer may use.
    ("named", &[]),
    ("math", &[]),
    ("noise", &["math"]),
    ("frame", &["math"]),
    ("input", &[]),
    ("effect", &["math", "noise", "frame"]),
    ("config", &["effect", "noise"]),
    ("display", &["frame"]),
    ("app", &["effect", "display", "input", "config", "math", "noise", "frame"]),
];

/// What one module may use beyond its layer.
const EXCEPTIONS: [([&str; 2], [&str; 2]); 1] = [(["display", "fault"], ["math", "random"])];

/// The one module of the core that may be unsafe; its head says why.
const UNSAFE: [&str; 2] = ["math", "lanes"];

/// A piece of Rust that matters here.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Token {
    /// A word: identifier, keyword or number.
    Word(String),
    /// `::`
    Colons,
    /// Any other sign.
    Sign(char),
}

impl Token {
    fn is(&self, word: &str) -> bool {
        matches!(self, Self::Word(own) if own == word)
    }
}

/// The tokens of a source, without comments, texts, characters and lifetimes.
fn tokens(source: &str) -> Vec<Token> {
    let chars: Vec<char> = source.chars().collect();
    let (mut at, mut tokens) = (0, Vec::new());
    let next = |at: usize| chars.get(at).copied().unwrap_or('\0');
    while at < chars.len() {
        let c = chars[at];
        match (c, next(at + 1)) {
            ('/', '/') => at = (at..chars.len()).find(|&i| chars[i] == '\n').unwrap_or(chars.len()),
            ('/', '*') => at = end_of_block_comment(&chars, at),
            ('"', _) => at = end_of_text(&chars, at + 1),
            ('\'', _) => at = end_of_quote(&chars, at),
            (':', ':') => {
                tokens.push(Token::Colons);
                at += 2;
            }
            _ if c.is_alphanumeric() || c == '_' => {
                let mut end = at;
                // `x.0.1` is no number.
                let in_number = c.is_ascii_digit() && tokens.last() != Some(&Token::Sign('.'));
                while next(end).is_alphanumeric()
                    || next(end) == '_'
                    || in_number && next(end) == '.' && next(end + 1).is_ascii_digit()
                {
                    end += 1;
                }
                let word: String = chars[at..end].iter().collect();
                let raw = matches!(&word[..], "r" | "br" | "cr") && matches!(next(end), '"' | '#');
                at = if raw { end_of_raw_text(&chars, end) } else { end };
                if !raw {
                    tokens.push(Token::Word(word));
                }
            }
            _ => {
                if !c.is_whitespace() {
                    tokens.push(Token::Sign(c));
                }
                at += 1;
            }
        }
    }
    tokens
}

fn end_of_block_comment(chars: &[char], start: usize) -> usize {
    let (mut depth, mut at) = (0, start);
    while at < chars.len() {
        match (chars[at], chars.get(at + 1)) {
            ('/', Some('*')) => (depth, at) = (depth + 1, at + 2),
            ('*', Some('/')) => (depth, at) = (depth - 1, at + 2),
            _ => at += 1,
        }
        if depth == 0 {
            break;
        }
    }
    at
}

fn end_of_text(chars: &[char], mut at: usize) -> usize {
    while at < chars.len() && chars[at] != '"' {
        at += if chars[at] == '\\' { 2 } else { 1 };
    }
    at + 1
}

fn end_of_raw_text(chars: &[char], start: usize) -> usize {
    let hashes = chars[start..].iter().take_while(|&&c| c == '#').count();
    let mut at = start + hashes + 1;
    while at < chars.len() {
        if chars[at] == '"' && chars[at + 1..].iter().take_while(|&&c| c == '#').count() >= hashes {
            return at + 1 + hashes;
        }
        at += 1;
    }
    at
}

/// The end of a character, or of a lifetime's tick.
fn end_of_quote(chars: &[char], start: usize) -> usize {
    match (chars.get(start + 1), chars.get(start + 2)) {
        (Some('\\'), _) => (start + 3..chars.len()).find(|&i| chars[i] == '\'').unwrap_or(chars.len()) + 1,
        (_, Some('\'')) => start + 3,
        _ => start + 1,
    }
}

/// Takes out what is compiled for tests only.
fn without_tests(tokens: &[Token]) -> Vec<Token> {
    let cfg_test = self::tokens("#[cfg(test)]");
    let (mut kept, mut at) = (Vec::new(), 0);
    while at < tokens.len() {
        if tokens[at..].starts_with(&cfg_test) {
            at = end_of_item(tokens, at + cfg_test.len());
        } else {
            kept.push(tokens[at].clone());
            at += 1;
        }
    }
    kept
}

/// The end of an item: its `;` or the brace that closes it, whichever comes first.
fn end_of_item(tokens: &[Token], start: usize) -> usize {
    let mut depth = 0;
    for (at, token) in tokens.iter().enumerate().skip(start) {
        match token {
            Token::Sign('{' | '(' | '[') => depth += 1,
            Token::Sign('}' | ')' | ']') => {
                depth -= 1;
                if depth == 0 && *token == Token::Sign('}') {
                    return at + 1;
                }
            }
            Token::Sign(';') if depth == 0 => return at + 1,
            _ => {}
        }
    }
    tokens.len()
}

/// The full paths, from the crate's root, that the code of `module` names by `crate` or `super`.
fn paths(tokens: &[Token], module: &[String]) -> BTreeSet<Vec<String>> {
    let mut found = Vec::new();
    for at in 0..tokens.len() {
        let starts = tokens[at].is("crate") || tokens[at].is("super");
        if starts && (at == 0 || tokens[at - 1] != Token::Colons) {
            tree(tokens, at, &[], &mut found);
        }
    }
    found.iter().map(|path| resolve(path, module)).filter(|path| !path.is_empty()).collect()
}

/// Collects the paths of the tree that starts at token `at`, and tells where it ends.
fn tree(tokens: &[Token], mut at: usize, prefix: &[String], found: &mut Vec<Vec<String>>) -> usize {
    let mut path = prefix.to_vec();
    loop {
        match tokens.get(at) {
            Some(Token::Word(word)) => path.push(word.clone()),
            Some(Token::Sign('{')) => {
                at += 1;
                while !matches!(tokens.get(at), None | Some(Token::Sign('}'))) {
                    at = tree(tokens, at, &path, found);
                    while !matches!(tokens.get(at), None | Some(Token::Sign(',' | '}'))) {
                        at += 1; // `as name`, `*`
                    }
                    at += usize::from(tokens.get(at) == Some(&Token::Sign(',')));
                }
                return at + 1;
            }
            _ => {}
        }
        if tokens.get(at + 1) != Some(&Token::Colons) {
            found.push(path);
            return at + 1;
        }
        at += 2;
    }
}

/// A path from the crate's root: `crate` and `super` replaced by what they mean in `module`.
fn resolve(path: &[String], module: &[String]) -> Vec<String> {
    let mut full = match path[0].as_str() {
        "crate" => Vec::new(),
        _ => module.to_vec(),
    };
    for word in path {
        match word.as_str() {
            "crate" | "self" => {}
            "super" => drop(full.pop()),
            word => full.push(word.to_owned()),
        }
    }
    full
}

/// What is wrong with the code of `module` outside its tests, a line each.
fn faults(source: &str, module: &[String]) -> Vec<String> {
    let all = tokens(source);
    let code = without_tests(&all);
    let Some(layer) = module.first().filter(|layer| *layer != "os") else { return Vec::new() };
    let mut faults = Vec::new();
    match ARROWS.iter().find(|(name, _)| name == layer) {
        None => faults.push(format!("`{layer}` is no layer that is known here")),
        Some((_, allowed)) => {
            for path in paths(&code, module) {
                let exception = EXCEPTIONS.iter().any(|(from, to)| {
                    module.starts_with(&from.map(String::from)) && path.starts_with(&to.map(String::from))
                });
                if path[0] != *layer && !allowed.contains(&&*path[0]) && !exception {
                    faults.push(format!("uses {}", path.join("::")));
                }
            }
        }
    }
    for (at, token) in code.iter().enumerate() {
        let Token::Word(word) = token else { continue };
        let follows = |word: &str| at > 0 && code[at - 1].is(word);
        let in_core = at > 1 && code[at - 1] == Token::Colons && code[at - 2].is("core");
        let path = code.get(at + 1) == Some(&Token::Colons) && !in_core;
        match word.as_str() {
            "std" | "alloc" if path || follows("use") || follows("crate") => {
                faults.push(format!("uses {word}"));
            }
            "f32" | "f64" => faults.push(format!("uses {word}")),
            number if is_float(number) => faults.push(format!("uses the float {number}")),
            _ => {}
        }
    }
    if module != UNSAFE {
        faults.extend(all.iter().filter(|token| token.is("unsafe")).map(|_| "is unsafe".to_owned()));
    }
    faults
}

fn is_float(word: &str) -> bool {
    word.starts_with(|c: char| c.is_ascii_digit())
        && (word.contains('.') || word.ends_with("f32") || word.ends_with("f64"))
        && !word.starts_with("0x")
}

fn sources() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

/// Every module of the library that is compiled outside tests: its path, and its source.
fn modules() -> Vec<(Vec<String>, String)> {
    let mut found = Vec::new();
    let top = tokens(&fs::read_to_string(sources().join("lib.rs")).expect("lib.rs"));
    for pair in top.windows(2) {
        if let [word, Token::Word(name)] = pair
            && word.is("mod")
        {
            visit(vec![name.clone()], &mut found);
        }
    }
    found
}

/// Adds a module and, by its `mod` lines, those within it.
fn visit(module: Vec<String>, found: &mut Vec<(Vec<String>, String)>) {
    let base = sources().join(module.iter().collect::<PathBuf>());
    let files = [base.with_extension("rs"), base.join("mod.rs")];
    let Some(source) = files.iter().find_map(|file| fs::read_to_string(file).ok()) else {
        panic!("{} has no file", module.join("::"))
    };
    let code = without_tests(&tokens(&source));
    for three in code.windows(3) {
        if let [word, Token::Word(name), Token::Sign(';')] = three
            && word.is("mod")
        {
            visit([&module[..], std::slice::from_ref(name)].concat(), found);
        }
    }
    found.push((module, source));
}

fn module(path: &str) -> Vec<String> {
    path.split("::").map(String::from).collect()
}

#[test]
fn no_arrow_points_the_wrong_way_and_the_core_stays_portable() {
    let modules = modules();
    assert!(modules.len() > 50, "only {} modules were found", modules.len());
    let faults: Vec<String> = modules
        .iter()
        .flat_map(|(module, source)| {
            faults(source, module).into_iter().map(|fault| format!("{}: {fault}", module.join("::")))
        })
        .collect();
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
}

#[test]
fn the_layers_have_an_order() {
    let mut settled: BTreeSet<&str> = BTreeSet::new();
    while settled.len() < ARROWS.len() {
        let before = settled.len();
        for (layer, uses) in ARROWS {
            if uses.iter().all(|used| settled.contains(used)) {
                settled.insert(layer);
            }
        }
        assert!(settled.len() > before, "a circle among {ARROWS:?}");
    }
}

#[test]
fn the_program_is_thin_and_uses_only_what_knows_the_system() {
    let main = tokens(&fs::read_to_string(sources().join("main.rs")).expect("main.rs"));
    let uses: Vec<&[Token]> = main.windows(3).filter(|three| three[0].is("yurameki")).collect();
    assert!(!uses.is_empty() && uses.iter().all(|three| three[2].is("os")), "{uses:?}");
}

#[test]
fn a_wrong_arrow_is_found_however_it_is_written() {
    let bad = [
        ("math", "use crate::frame::Size;"),
        ("noise::white", "use crate::{math::Sample, frame};"),
        ("noise::white", "use crate::{math::{Sample, Turns}, config::{self as c, Life}};"),
        ("frame::pack", "fn f() { crate::effect::shimmer::g(); }"),
        ("frame::pack", "use super::super::effect::Paint;"),
        ("frame::pack", "use super::{super::{noise::Kind}, Size};"),
        ("effect::shimmer", "use crate::display::Mode;"),
        ("effect", "impl crate::os::Thing for X {}"),
        ("display::sim", "use crate::math::random::Rng;"),
        ("display::fault", "use crate::math::Turns;"),
        ("input::script", "pub use crate::math;"),
        ("config", "use crate::app::Show;"),
        ("app::show", "use crate::os::args::Args;"),
        ("surprise", "fn f() {}"),
    ];
    for (name, source) in bad {
        assert!(!faults(source, &module(name)).is_empty(), "{name}: {source}");
    }
}

#[test]
fn std_floats_and_unsafe_are_found_in_the_core() {
    let bad = [
        "use std::vec::Vec;",
        "extern crate alloc;",
        "fn f() -> ::std::string::String {}",
        "fn f() { let v = alloc::vec::Vec::new(); }",
        "fn f(x: f32) {}",
        "fn f() { g(0.5); }",
        "fn f() { g(1_f64); }",
        "fn f() { unsafe { g() } }",
        "#[cfg(test)] mod tests { fn f() { unsafe { g() } } }",
        "#[cfg(test)] use core::x; use std::fmt;",
    ];
    for source in bad {
        let faults = faults(source, &module("math"));
        assert!(!faults.is_empty(), "{source}");
    }
}

#[test]
fn what_is_allowed_is_let_through() {
    let good = [
        (
            "noise::white",
            "use crate::math::Sample; use super::Kind; use core::{fmt}; use core::alloc::Layout;",
        ),
        ("effect::shimmer::storage", "use super::{super::{Photo, StorageTooSmall}, spans::{self, Span}};"),
        ("display::fault", "use crate::{frame::Layout, math::random::Rng};"),
        (
            "frame",
            "// use crate::os;\n/* std:: /* f64 */ unsafe */ pub(crate) fn f<'a>(x: &'a str) { g('\"', \"std::f64\") }",
        ),
        ("frame", "fn f() { r#\"std::vec \"quoted\" 0.5\"#; '\\''; for i in 0..5 { x.0.1; } }"),
        ("math", "#[cfg(test)] mod tests { use std::f64; fn f() { 0.5; } } fn g() {}"),
        ("math", "#[cfg(test)]\n#[derive(Debug)]\nstruct Twin { x: f64 }"),
        ("os::run", "use std::fs; use crate::app::Show; fn f() { unsafe { g(0.5) } }"),
    ];
    for (name, source) in good {
        assert_eq!(faults(source, &module(name)), Vec::<String>::new(), "{name}: {source}");
    }
}
