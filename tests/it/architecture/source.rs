//! Source files as the rules see them: what each imports, and how long it and its functions are.

use std::path::Path;

/// One file of `src`.
pub struct File {
    /// Its path from the root of the repository.
    pub path: String,
    /// Its module, from the crate's root; empty for `lib.rs`.
    pub module: Vec<String>,
    pub text: String,
}

impl File {
    pub fn new(path: &str, text: &str) -> Self {
        let inside = path.strip_prefix("src/").and_then(|p| p.strip_suffix(".rs")).expect("a file of src");
        let mut module: Vec<String> = inside.split('/').map(String::from).collect();
        if inside == "lib" || module.last().is_some_and(|last| last == "mod") {
            module.pop();
        }
        Self { path: path.into(), module, text: text.into() }
    }

    /// All files of `src`.
    pub fn all() -> Vec<Self> {
        let mut files = Vec::new();
        read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), "src", &mut files);
        files.sort_by(|a, b| a.path.cmp(&b.path));
        files
    }

    pub fn lines(&self) -> usize {
        self.text.lines().count()
    }

    /// Whether its code, comments and strings aside, contains this word.
    pub fn mentions(&self, word: &str) -> bool {
        tokens(&code(&self.text)).contains(&word)
    }

    /// What it imports of the crate: paths from the crate's root, and the names that they get here.
    pub fn imports(&self) -> Vec<Import> {
        let code = code(&self.text);
        let tokens = tokens(&code);
        let mut found = Vec::new();
        let mut here = self.module.clone();
        // The depths of braces at which inline modules began.
        let (mut depth, mut inline) = (0, Vec::new());
        let mut i = 0;
        while i < tokens.len() {
            match tokens[i] {
                "{" => {
                    depth += 1;
                    if i > 1 && tokens[i - 2] == "mod" {
                        here.push(tokens[i - 1].into());
                        inline.push(depth);
                    }
                }
                "}" => {
                    if inline.pop_if(|began| *began == depth).is_some() {
                        here.pop();
                    }
                    depth -= 1;
                }
                "crate" | "super" | "narrowbeam" if tokens.get(i + 1) == Some(&"::") => {
                    i = Import::add(&tokens, i, here.clone(), &mut found);
                    continue;
                }
                "use" if tokens.get(i + 1).is_some_and(|t| !matches!(*t, "crate" | "super")) => {
                    i = Import::add(&tokens, i + 1, here.clone(), &mut found);
                    continue;
                }
                _ => (),
            }
            i += 1;
        }
        found
    }

    /// Names and lengths, in lines, of its functions: from `fn` to the closing brace of the same indentation.
    pub fn functions(&self) -> Vec<(String, usize)> {
        let lines: Vec<&str> = self.text.lines().collect();
        let length = |(first, line): (usize, &&str)| {
            let indent = &line[..line.len() - line.trim_start().len()];
            let name = line.trim_start().split_once("fn ").filter(|(before, _)| is_qualifiers(before))?.1;
            let ends = |line: &&str| {
                let body = line.strip_prefix(indent).filter(|rest| !rest.starts_with(' '));
                body.is_some_and(|rest| rest.ends_with('}') || rest.ends_with(';'))
            };
            let last = lines[first..].iter().position(ends)?;
            Some((name.split(['(', '<']).next()?.into(), last + 1))
        };
        lines.iter().enumerate().filter_map(length).collect()
    }
}

fn is_qualifiers(text: &str) -> bool {
    let known = |word: &str| {
        word.starts_with("pub") || word.ends_with(')') || matches!(word, "const" | "async" | "unsafe")
    };
    text.split_whitespace().all(known)
}

fn read(dir: &Path, name: &str, files: &mut Vec<File>) {
    for entry in std::fs::read_dir(dir).unwrap() {
        let path = entry.unwrap().path();
        let name = format!("{name}/{}", path.file_name().unwrap().to_str().unwrap());
        if path.is_dir() {
            read(&path, &name, files);
        } else if name.ends_with(".rs") {
            files.push(File::new(&name, &std::fs::read_to_string(&path).unwrap()));
        }
    }
}

/// A path from the crate's root, and the name that it gets where it is imported.
#[derive(Debug, Clone, PartialEq)]
pub struct Import {
    pub path: Vec<String>,
    pub name: String,
}

impl Import {
    /// Adds the imports of the tree of paths that begins at token `i`, seen from module `base`; the token behind it.
    fn add(tokens: &[&str], mut i: usize, mut base: Vec<String>, found: &mut Vec<Self>) -> usize {
        while let Some(&token) = tokens.get(i) {
            match token {
                "{" => {
                    i += 1;
                    while !matches!(tokens.get(i), None | Some(&"}")) {
                        i = Self::add(tokens, i, base.clone(), found);
                        i += usize::from(tokens.get(i) == Some(&","));
                    }
                    return i + 1;
                }
                "crate" | "narrowbeam" => base.clear(),
                "super" => drop(base.pop()),
                "self" => (),
                name if is_word(name) || name == "*" => base.push(name.into()),
                _ => break,
            }
            i += 1;
            if tokens.get(i) != Some(&"::") {
                break;
            }
            i += 1;
        }
        let renamed = tokens.get(i) == Some(&"as");
        let name = if renamed { tokens[i + 1].into() } else { base.last().cloned().unwrap_or_default() };
        found.push(Self { path: base, name });
        if renamed { i + 2 } else { i.max(1) }
    }
}

fn is_word(token: &str) -> bool {
    token.starts_with(|c: char| c.is_alphabetic() || c == '_')
}

/// Words, `::`, and every other character that is not blank.
fn tokens(code: &str) -> Vec<&str> {
    let mut tokens = Vec::new();
    let mut rest = code.trim_start();
    while let Some(first) = rest.chars().next() {
        let length = match first {
            ':' if rest.starts_with("::") => 2,
            c if c.is_alphanumeric() || c == '_' => {
                rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len())
            }
            c => c.len_utf8(),
        };
        tokens.push(&rest[..length]);
        rest = rest[length..].trim_start();
    }
    tokens
}

/// `text` without comments, and without what stands in strings and characters.
fn code(text: &str) -> String {
    let mut code = String::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let skipped = match first {
            '/' if rest.starts_with("//") => rest.find('\n').unwrap_or(rest.len()),
            '/' if rest.starts_with("/*") => rest.find("*/").map_or(rest.len(), |end| end + 2),
            'r' if rest.starts_with("r\"")
                || rest.starts_with("r#") && rest.trim_start_matches(['r', '#']).starts_with('"') =>
            {
                let hashes = rest[1..].chars().take_while(|&c| c == '#').count();
                let end = format!("\"{}", "#".repeat(hashes));
                let open = hashes + 2;
                rest[open..].find(&end).map_or(rest.len(), |at| open + at + end.len())
            }
            '"' => quoted(rest, '"').unwrap_or(rest.len()),
            // A character; what has no quote where a character would end is a lifetime.
            '\'' => quoted(rest, '\'')
                .filter(|&end| rest[..end].chars().count() == 3 || rest[1..].starts_with('\\'))
                .unwrap_or(1),
            _ => 0,
        };
        let taken = if skipped == 0 { first.len_utf8() } else { skipped };
        code.push(if skipped == 0 { first } else { ' ' });
        rest = &rest[taken..];
    }
    code
}

/// The bytes of the quotation at the start of `text`, both quotes among them.
fn quoted(text: &str, quote: char) -> Option<usize> {
    let mut escaped = false;
    for (at, c) in text.char_indices().skip(1) {
        match c {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            c if c == quote => return Some(at + 1),
            _ => (),
        }
    }
    None
}
