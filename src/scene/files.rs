//! Which files a scene is made of.

use super::source::Source;
use std::path::PathBuf;
use toml::Value;

/// The scene file, and every file that exists and whose name is the value of some key in it.
pub(super) fn files(source: &Source) -> Vec<PathBuf> {
    let mut files = vec![source.path.to_path_buf()];
    // A pipe can be read only once.
    let text = source.path.is_file().then(|| std::fs::read_to_string(source.path).ok()).flatten();
    if let Some(Ok(table)) = text.map(|text| text.parse::<toml::Table>()) {
        gather(&Value::Table(table), source, &mut files);
    }
    files
}

fn gather(value: &Value, source: &Source, files: &mut Vec<PathBuf>) {
    match value {
        Value::String(name) => {
            let path = source.resolve(name.as_ref());
            if path.is_file() && !files.contains(&path) {
                files.push(path);
            }
        }
        Value::Array(values) => values.iter().for_each(|value| gather(value, source, files)),
        Value::Table(table) => table.values().for_each(|value| gather(value, source, files)),
        _ => (),
    }
}
