//! `table`: killed and gone on with, its seed, and the table that comes with the program.

use narrowbeam::lab::table::node;
use narrowbeam::phase::Family;
use narrowbeam::spread::wide_angle::layout::Layout;
use narrowbeam::spread::wide_angle::table::Table;
use std::process::{Child, Command, Stdio};
use std::time::Duration;
use tempfile::{TempDir, tempdir};

/// The table that comes with the program, the paths and the seed that made it.
const SHIPPED: &[u8] = include_bytes!("../../../tables/wide-angle.table");
const MADE_BY: [&str; 2] = ["800000", "1"];

/// Bytes of a node.
const NODE: usize = 4 * NUMBERS;
/// Numbers of a node of the Gaussian's table.
const NUMBERS: usize = 58;
/// Nodes in which the shape depends on tracing: half-way along tau.
const BEGUN: usize = 560;

/// What a run of so many paths and this seed writes, `count` of its nodes being those of the table that comes with the
/// program.
fn begun(count: usize, paths: &str, seed: &str) -> Vec<u8> {
    let version = env!("CARGO_PKG_VERSION");
    let mut bytes = Table::line(&format!("seed {seed}; paths {paths}; narrowbeam {version}")).into_bytes();
    let nodes = 1 + SHIPPED.iter().position(|&byte| byte == b'\n').unwrap();
    bytes.extend(&SHIPPED[nodes..nodes + count * NODE]);
    bytes
}

struct Maker(TempDir);

impl Maker {
    /// A folder in which a run was stopped after writing `part`.
    fn after(part: &[u8]) -> Self {
        let maker = Self(tempdir().unwrap());
        maker.put(part);
        maker
    }

    fn put(&self, part: &[u8]) {
        std::fs::write(self.0.path().join("t.table.part"), part).unwrap();
    }

    fn part(&self) -> Option<Vec<u8>> {
        std::fs::read(self.0.path().join("t.table.part")).ok()
    }

    fn start(&self, [paths, seed]: [&str; 2]) -> Child {
        Command::new(env!("CARGO_BIN_EXE_narrowbeam"))
            .current_dir(self.0.path())
            .args(["table", "--out", "t.table", "--paths", paths, "--seed", seed])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap()
    }

    /// Runs `table`, kills it as soon as what it has written is `enough`, and returns that.
    fn killed_once(&self, made_by: [&str; 2], enough: impl Fn(&[u8]) -> bool) -> Vec<u8> {
        let mut child = self.start(made_by);
        while !self.part().is_some_and(|part| enough(&part)) {
            assert!(child.try_wait().unwrap().is_none(), "{made_by:?} ended before");
            std::thread::sleep(Duration::from_millis(5));
        }
        child.kill().unwrap();
        child.wait().unwrap();
        self.part().unwrap()
    }
}

#[test]
fn a_killed_run_goes_on_to_the_same_bytes_and_another_seed_to_others() {
    let (seven, eight) = (["300", "7"], ["300", "8"]);
    let before = begun(BEGUN, "300", "7");
    let length = |more: usize| before.len() + more * NODE;
    let at_once = Maker::after(&before).killed_once(seven, |part| part.len() >= length(32));

    // Killed in the middle of a node, too.
    let twice = Maker::after(&before);
    let mut torn = twice.killed_once(seven, |part| part.len() >= length(16));
    torn.truncate(length(16) - 5);
    twice.put(&torn);
    let resumed = twice.killed_once(seven, |part| part.len() >= length(32));
    assert!(resumed[..length(32)] == at_once[..length(32)]);

    let other = Maker::after(&begun(BEGUN, "300", "8"));
    let others = other.killed_once(eight, |part| part.len() >= length(16));
    assert!(others[length(0)..length(16)] != at_once[length(0)..length(16)]);
    // What one seed has begun another does not go on with.
    other.put(&at_once);
    let anew = other.killed_once(eight, |part| part.starts_with(&begun(0, "300", "8")));
    assert!(anew.len() < length(0));
}

#[test]
fn the_shipped_table_is_what_its_command_makes() {
    assert!(SHIPPED.len() <= 4 << 20);
    let [paths, seed] = MADE_BY;
    assert!(SHIPPED.starts_with(Table::line("").trim_end().as_bytes()));
    let layout = Layout::of(Family::Gaussian);
    assert_eq!(layout.numbers(), NUMBERS);
    let places = layout.places();
    let count = places.len();
    let line = String::from_utf8_lossy(&SHIPPED[..SHIPPED.len() - count * NODE]);
    assert!(line.contains(&format!("seed {seed}; paths {paths};")), "{line}");
    // All but its last node are there already; it is made, where media are thickest.
    let before = begun(count - 1, paths, seed);
    let maker = Maker::after(&before);
    assert!(maker.start(MADE_BY).wait().unwrap().success());
    assert!(maker.part().is_none());
    let made = std::fs::read(maker.0.path().join("t.table")).unwrap();
    assert!(made.starts_with(&before) && made.len() == before.len() + NODE);
    let numbers_of = |table: &[u8], i: usize| -> Vec<f32> {
        let nodes = table.len() - count * NODE;
        let bytes = table[nodes + i * NODE..nodes + (i + 1) * NODE].chunks_exact(4);
        bytes.map(|c| f32::from_le_bytes(c.try_into().unwrap())).collect()
    };
    // Another processor's exponentials may be rounded otherwise; the noise of another seed is a hundred times as much.
    let apart = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    let shipped = |i: usize| numbers_of(SHIPPED, i);
    println!("largest difference {:e}", apart(&numbers_of(&made, count - 1), &shipped(count - 1)));
    assert!(apart(&numbers_of(&made, count - 1), &shipped(count - 1)) < 1e-4);
    let other = node(layout, &places[count - 1], 20_000, 2).unwrap();
    assert!(apart(&other, &shipped(count - 1)) > 1e-2);
    // So are the first, where next to nothing is traced, and one half-way along tau: each node has its own seed.
    for i in [0, BEGUN] {
        let paths = paths.parse().unwrap();
        let again = node(layout, &places[i], paths, (count + i) as u64).unwrap();
        println!("node {i}: {:e}", apart(&again, &shipped(i)));
        assert!(apart(&again, &shipped(i)) < 1e-4);
    }
}
