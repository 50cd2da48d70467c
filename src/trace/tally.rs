//! What is counted at one plane, and the search for a radius bin.

/// Bits of r² (as f32) left out of the table index: 3 of the 23 mantissa bits stay, eight cells per octave.
const CELL_BITS: u32 = 20;

/// Finds the bin of r² among increasing edges without a logarithm: a table over the leading bits of the float,
/// which grow with its value, gives the bin of the cell's lower end, and a short walk does the rest.
#[derive(Debug)]
pub(super) struct Bins {
    squares: Vec<f32>,
    first_cell: u32,
    table: Vec<u32>,
}

impl Bins {
    /// Bins between the radii `edges`, increasing and above 0. Bin i holds the radii with i edges at or below
    /// them: bin 0 lies below the first edge, bin `edges.len()` beyond the last.
    pub(super) fn new(edges: &[f64]) -> Self {
        let squares: Vec<f32> = edges.iter().map(|r| (r * r) as f32).collect();
        let cell = |r2: f32| r2.to_bits() >> CELL_BITS;
        // One cell before the first edge: smaller values are looked up there too, and lie in bin 0.
        let (first_cell, last_cell) = (cell(squares[0]) - 1, cell(squares[squares.len() - 1]));
        let below = |c: u32| squares.partition_point(|&e| e <= f32::from_bits(c << CELL_BITS)) as u32;
        let table = (first_cell..=last_cell + 1).map(below).collect();
        Self { squares, first_cell, table }
    }

    /// The bin of a squared radius.
    #[inline]
    pub(super) fn of(&self, r2: f32) -> usize {
        let cell = (r2.to_bits() >> CELL_BITS).saturating_sub(self.first_cell) as usize;
        let mut bin = self.table[cell.min(self.table.len() - 1)] as usize;
        while bin < self.squares.len() && r2 >= self.squares[bin] {
            bin += 1;
        }
        bin
    }
}

/// Sums over the paths at one plane.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tally {
    /// Sum of w and of w² of the scattered paths in each radius bin.
    pub(super) bins: Vec<[f64; 2]>,
    /// Sum of w r² and of (w r²)².
    pub(super) moment: [f64; 2],
    /// Paths that arrived unscattered.
    pub(super) direct: u64,
    /// Paths that arrived scattered.
    pub(super) scattered: u64,
    /// Paths that will never arrive.
    pub(super) lost: u64,
}

impl Tally {
    pub(super) fn new(bins: usize) -> Self {
        Self { bins: vec![[0.0; 2]; bins], moment: [0.0; 2], direct: 0, scattered: 0, lost: 0 }
    }

    /// Counts a scattered path of weight `w` at squared radius `r2`.
    #[inline]
    pub(super) fn score(&mut self, bin: usize, w: f64, r2: f64) {
        let cell = &mut self.bins[bin];
        cell[0] += w;
        cell[1] += w * w;
        let moment = w * r2;
        self.moment[0] += moment;
        self.moment[1] += moment * moment;
        self.scattered += 1;
    }

    /// Adds the sums of other paths.
    pub(super) fn add(&mut self, other: &Self) {
        for (mine, theirs) in self.bins.iter_mut().zip(&other.bins) {
            mine[0] += theirs[0];
            mine[1] += theirs[1];
        }
        self.moment[0] += other.moment[0];
        self.moment[1] += other.moment[1];
        self.direct += other.direct;
        self.scattered += other.scattered;
        self.lost += other.lost;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_finds_the_bin_that_a_search_finds() {
        for edges in [vec![1e-6, 1e-3, 1.1e-3, 2.0, 3.0, 1e4], vec![0.7], vec![0.5, 0.500_001, 0.6]] {
            let bins = Bins::new(&edges);
            let exact = |r2: f32| edges.iter().filter(|&&e| (e * e) as f32 <= r2).count();
            let mut r2 = 1e-20_f32;
            while r2 < 1e20 {
                assert_eq!(bins.of(r2), exact(r2), "{r2} {edges:?}");
                r2 *= 1.003;
            }
            for r2 in edges.iter().map(|e| (e * e) as f32).chain([0.0]) {
                assert_eq!(bins.of(r2), exact(r2), "{r2} {edges:?}");
            }
        }
    }
}
