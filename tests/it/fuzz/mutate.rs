//! Random damage that depends on a number alone.

use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// A stream of random choices.
pub struct Random(Xoshiro256PlusPlus);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(Xoshiro256PlusPlus::seed_from_u64(seed))
    }

    /// A number below `end`, which is above 0.
    pub fn below(&mut self, end: usize) -> usize {
        (self.0.next_u64() % end as u64) as usize
    }

    pub fn of<'t, T>(&mut self, all: &'t [T]) -> &'t T {
        &all[self.below(all.len())]
    }
}

/// Numbers and words at which readers stumble.
const TOKENS: [&str; 34] = [
    "0",
    "-0",
    "1",
    "-1",
    "1e300",
    "-1e300",
    "1e-300",
    "nan",
    "inf",
    "-inf",
    "9223372036854775807",
    "18446744073709551616",
    "1e15",
    "1e16",
    "\"object.exr\"",
    "\"depth.exr\"",
    "\"missing.exr\"",
    "\"\"",
    "\"free\"",
    "\"a\\nb\"",
    "[1, 2, 3]",
    "[[0, 1], [0, 1], [0, 1]]",
    "[]",
    "{}",
    "true",
    "2026-01-01",
    "\"planar\"",
    "\"mirror\"",
    "\"hg\"",
    "\"bandlimited\"",
    "\"/dev/zero\"",
    "\"..\"",
    "\"shift\"",
    "\"R\"",
];
/// Lines that begin something.
const LINES: [&str; 16] = [
    "[object]",
    "[[object.layer]]",
    "[camera]",
    "[observation]",
    "[medium]",
    "[fit]",
    "[illumination]",
    "channels = [\"Y\"]",
    "layer_name = \"a\"",
    "depth_channel = \"Z\"",
    "fov_x_deg = 40",
    "g = 0.9",
    "direction = [0, 0, 1]",
    "irradiance = 2",
    "veil = \"free\"",
    "start = { sigma_s = 1 }",
];
/// Integers at which decoders stumble.
const INTEGERS: [u32; 10] = [0, 1, 2, 0x7f, 0xff, 0xffff, 0x7fff_ffff, 0x8000_0000, 0xffff_ffff, 0x0100_0000];

/// One of `texts`, with some of its values, lines and bytes replaced.
pub fn damaged_text(random: &mut Random, texts: &[Vec<u8>]) -> Vec<u8> {
    let text = String::from_utf8_lossy(random.of::<Vec<u8>>(texts)).into_owned();
    let mut lines: Vec<String> = text.lines().map(str::to_string).collect();
    for _ in 0..1 + random.below(3) {
        let at = random.below(lines.len().max(1)).min(lines.len().saturating_sub(1));
        match random.below(7) {
            0..=2 => {
                if let Some((key, _)) = lines.get(at).and_then(|line| line.split_once('=')) {
                    lines[at] = format!("{key}= {}", random.of(&TOKENS));
                }
            }
            3 => lines.insert(at, random.of(&LINES).to_string()),
            4 if !lines.is_empty() => drop(lines.remove(at)),
            5 if !lines.is_empty() => lines.push(lines[at].clone()),
            _ => {
                let bytes = damaged_bytes(random, &[lines.join("\n").into_bytes()]);
                return bytes;
            }
        }
    }
    lines.join("\n").into_bytes()
}

/// One of `files`, with some bytes replaced, taken out or cut off.
pub fn damaged_bytes(random: &mut Random, files: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = random.of(files).clone();
    for _ in 0..1 + random.below(4) {
        if bytes.is_empty() {
            return bytes;
        }
        // Headers decide more than pixels do.
        let reach = if random.below(3) == 0 { bytes.len() } else { bytes.len().min(500) };
        let at = random.below(reach);
        match random.below(6) {
            0 => bytes[at] = random.below(256) as u8,
            1 => bytes[at] ^= 1 << random.below(8),
            2 | 3 => {
                let integer = random.of(&INTEGERS).to_le_bytes();
                bytes.iter_mut().skip(at).zip(integer).for_each(|(byte, new)| *byte = new);
            }
            4 => drop(bytes.drain(at..(at + 1 + random.below(8)).min(bytes.len()))),
            _ if random.below(4) == 0 => bytes.truncate(at),
            _ => {
                let piece: Vec<u8> = bytes[at..(at + 8).min(bytes.len())].to_vec();
                let to = random.below(bytes.len());
                bytes.splice(to..to, piece);
            }
        }
    }
    bytes
}

#[test]
fn damage_depends_on_its_number_alone_and_changes_something() {
    let file = [(0..=255).collect::<Vec<u8>>()];
    let damaged = |number: u64| damaged_bytes(&mut Random::new(number), &file);
    assert!((0..100).all(|number| damaged(number) == damaged(number)));
    assert!((0..100).filter(|&number| damaged(number) != file[0]).count() > 95);
    let text = [b"[object]\ndepth = 1\n".to_vec()];
    let texts: std::collections::HashSet<_> =
        (0..100).map(|number| damaged_text(&mut Random::new(number), &text)).collect();
    assert!(texts.len() > 60, "{}", texts.len());
}
