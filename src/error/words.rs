//! Words of errors: a single line, whatever a file or a name holds.

use std::path::Path;

/// Most characters of a foreign text in an error.
const LONGEST: usize = 400;
/// Most digits in a row.
const DIGITS: usize = 24;

/// `text` on one line: control characters escaped, long numbers and long texts cut.
pub(crate) fn one_line(text: &str) -> String {
    let mut line = String::new();
    let mut digits = 0;
    for c in text.trim_end().chars() {
        digits = if c.is_ascii_digit() { digits + 1 } else { 0 };
        match c {
            _ if digits == DIGITS + 1 => line.push('…'),
            _ if digits > DIGITS => (),
            _ if is_invisible(c) => line.extend(c.escape_default()),
            _ => line.push(c),
        }
    }
    match line.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}…", &line[..end]),
        None => line,
    }
}

/// What would break a line, or write it backwards.
fn is_invisible(c: char) -> bool {
    c.is_control() || matches!(c, '\u{2028}' | '\u{2029}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// `path` on one line, never cut.
pub(crate) fn shown(path: &Path) -> String {
    let path = path.display().to_string();
    path.chars().map(|c| if is_invisible(c) { c.escape_default().to_string() } else { c.into() }).collect()
}

/// `value` as a person writes it: very large and very small ones with an exponent.
pub(crate) fn number(value: f64) -> String {
    match value.abs() {
        magnitude if magnitude != 0.0 && magnitude.is_finite() && !(1e-5..1e15).contains(&magnitude) => {
            format!("{value:e}")
        }
        _ => value.to_string(),
    }
}

/// `bytes` with a unit, three digits.
pub(crate) fn size(bytes: u64) -> String {
    const UNITS: [&str; 7] = ["B", "KiB", "MiB", "GiB", "TiB", "PiB", "EiB"];
    let power = (bytes.max(1).ilog2() / 10) as usize;
    let value = bytes as f64 / (1_u64 << (10 * power)) as f64;
    let digits = if power == 0 || value >= 99.95 { 0 } else { 1 };
    format!("{value:.digits$} {}", UNITS[power])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn foreign_text_stays_on_one_line() {
        assert_eq!(one_line("a\nb\tc\u{1b}[2K\u{202e}d\n"), "a\\nb\\tc\\u{1b}[2K\\u{202e}d");
        assert_eq!(one_line(&format!("{} is", 1e300)), format!("1{}… is", "0".repeat(23)));
        assert_eq!(one_line(&"é".repeat(1000)).chars().count(), LONGEST + 1);
        assert_eq!(shown(Path::new("a\nb/c d.exr")), "a\\nb/c d.exr");
    }

    #[test]
    fn numbers_are_short() {
        let words = [0.0, -0.25, 1e300, -4e-310, 1e9, 65504.0, f64::NAN, f64::NEG_INFINITY].map(number);
        assert_eq!(words, ["0", "-0.25", "1e300", "-4e-310", "1000000000", "65504", "NaN", "-inf"]);
    }

    #[test]
    fn sizes_have_a_unit() {
        let words = [0, 795, 1 << 10, 1_500_000, 7 << 30, 1 << 40, u64::MAX].map(size);
        assert_eq!(words, ["0 B", "795 B", "1.0 KiB", "1.4 MiB", "7.0 GiB", "1.0 TiB", "16.0 EiB"]);
    }
}
