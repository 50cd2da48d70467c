//! Where in a TOML file something stands.

use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Line and column, counted from 1, of the byte `at` of `text`.
pub(super) fn of_byte(text: &str, at: usize) -> [usize; 2] {
    let at = (0..=at.min(text.len())).rev().find(|&at| text.is_char_boundary(at)).unwrap_or(0);
    let before = &text[..at];
    let line = before.rfind('\n').map_or(0, |end| end + 1);
    [before.matches('\n').count() + 1, before[line..].chars().count() + 1]
}

/// Those of the key with which `message` begins, written `[section] key`, `[[section]] number key` or `[section] key inner`; of what is
/// there of it.
pub(super) fn of_key(text: &str, message: &str) -> Option<[usize; 2]> {
    let root = DeTable::parse(text).ok()?;
    let (section, rest) = message.trim_start_matches('[').split_once(']')?;
    let mut table = root.get_ref();
    let mut found = None;
    let words = rest.split_whitespace().map(|word| word.trim_matches([']', ':', ',']));
    for name in section.split('.').chain(words) {
        if name.is_empty() {
            continue;
        }
        let Some((key, value)) = table.iter().find(|(key, _)| key.get_ref() == name) else { break };
        let inner = inner(value, rest);
        found = Some(inner.map_or(key.span().start, |(at, _)| at));
        match inner {
            Some((_, inner)) => table = inner,
            None => break,
        }
    }
    found.map(|at| of_byte(text, at))
}

/// Where the table `value` begins, and the table; of an array of tables that whose number, from 1, `rest` names.
fn inner<'t, 'i>(value: &'t Spanned<DeValue<'i>>, rest: &str) -> Option<(usize, &'t DeTable<'i>)> {
    match value.get_ref() {
        DeValue::Table(table) => Some((value.span().start, table)),
        DeValue::Array(tables) => {
            let number = rest.trim_start_matches(']').split_whitespace().next()?;
            let table = tables.get(number.parse::<usize>().ok()?.checked_sub(1)?)?;
            Some((table.span().start, table.get_ref().as_table()?))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str =
        "[object]\ndepth = 1\n  layer = [{ depth = 3 }, { depth = 2 }]\n[fit]\nstart = { b = 2 }\n";

    #[test]
    fn keys_are_found_where_they_stand() {
        for (message, place) in [
            ("[object] depth = 1: must be", Some([2, 1])),
            ("[object] surface = 1: must be", Some([1, 1])),
            ("[[object.layer]] 2 depth = 2: must be", Some([3, 27])),
            ("[fit] start b = 2: must be", Some([5, 11])),
            ("[fit] start: wrong", Some([5, 9])),
            ("[camera] pixel_pitch is missing", None),
            ("section [object] is", None),
        ] {
            assert_eq!(of_key(TEXT, message), place, "{message}");
        }
    }

    #[test]
    fn columns_count_characters() {
        assert_eq!(of_byte("a\nöö = 1", 7), [2, 4]);
        assert_eq!(of_byte("ö", 1), [1, 1]);
        assert_eq!(of_byte("a", 9), [1, 2]);
    }
}
