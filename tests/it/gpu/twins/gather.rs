//! Twin of shaders/gather.wgsl.

use super::{C, first_of, second_of, together};
use narrowbeam::filter::gpu::{Gather, Record};

type Vec4 = [f32; 4];
type Wave = [C; 4];

const NODES: usize = 8;

fn product(a: Vec4, b: Vec4) -> Vec4 {
    std::array::from_fn(|c| if c == 0 { a[0] * b[0] } else { a[c] * b[0] + a[0] * b[c] })
}

fn times(wave: Wave, factor: Vec4) -> Wave {
    let value = wave[0];
    std::array::from_fn(|c| if c == 0 { value * factor[0] } else { wave[c] * factor[0] + value * factor[c] })
}

fn over(wave: Wave, divisor: Vec4) -> Wave {
    let inverse = 1.0 / divisor[0];
    let value = wave[0] * inverse;
    std::array::from_fn(|c| if c == 0 { value } else { (wave[c] - value * divisor[c]) * inverse })
}

fn lit(light: C, factor: Vec4) -> Wave {
    factor.map(|f| light * f)
}

fn sum(a: Wave, b: Wave) -> Wave {
    std::array::from_fn(|c| a[c] + b[c])
}

fn plus(a: Vec4, b: Vec4) -> Vec4 {
    std::array::from_fn(|c| a[c] + b[c])
}

fn scaled(a: Vec4, factor: f32) -> Vec4 {
    a.map(|v| v * factor)
}

/// What the shader is given.
pub struct Input<'a> {
    pub gather: Gather,
    pub records: &'a [Record],
    pub tables: &'a [Vec4],
    pub axes: &'a [Vec4],
    pub spectra: &'a [C],
}

impl Input<'_> {
    fn radial(&self, begin: u32, per_w: f32, w: f32) -> Vec4 {
        let place = w * per_w;
        let i = place as u32;
        let t = place - i as f32;
        let first = (begin + i) as usize;
        let weights = [
            -t * (t - 1.0) * (t - 2.0) / 6.0,
            (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0,
            -(t + 1.0) * t * (t - 2.0) / 2.0,
            (t + 1.0) * t * (t - 1.0) / 6.0,
        ];
        let mut sum = [0.0; 4];
        for (k, weight) in weights.into_iter().enumerate() {
            sum = plus(sum, scaled(self.tables[first + k], weight));
        }
        sum
    }

    fn basis(&self, entry: usize, node: usize) -> f32 {
        self.axes[3 * entry + 1 + node / 4][node % 4]
    }

    fn aliases(&self, record: &Record, kx: usize, entry: usize) -> Vec4 {
        let mut sum = [0.0; 4];
        for j in 0..NODES {
            let mut line = [0.0; 4];
            for node in 0..NODES {
                let value = self.tables[record.aliases as usize + node * NODES + j];
                line = plus(line, scaled(value, self.basis(kx, node)));
            }
            sum = plus(sum, scaled(line, self.basis(entry, j)));
        }
        sum
    }

    /// The stage, on the two pairs.
    pub fn run(&self, pairs: &mut [Vec<C>; 2]) {
        let gather = &self.gather;
        let [width, height] = gather.size.map(|n| n as usize);
        for column in 0..gather.columns as usize {
            let kx = gather.begin as usize + column;
            for ky in 0..=height / 2 {
                self.at(pairs, [width, height], column, kx, ky);
            }
        }
    }

    fn at(&self, pairs: &mut [Vec<C>; 2], [width, height]: [usize; 2], column: usize, kx: usize, ky: usize) {
        let gather = &self.gather;
        let (slices, half) = (gather.slices as usize, width / 2 + 1);
        let across = self.axes[3 * kx];
        let entry = half + ky;
        let down = self.axes[3 * entry];
        let w = (across[0] * across[0] + down[0] * down[0]).sqrt();
        let weight = across[1] * down[1];
        let scale = if gather.occluded == 1 {
            self.radial(gather.scale, gather.scale_per_w, w)
        } else {
            [1.0, 0.0, 0.0, 0.0]
        };
        let mirrored_y = if ky > 0 && 2 * ky < height { height - ky } else { ky };
        let opposite_x = (width - kx) % width;
        let rows = [ky, mirrored_y];
        let here = rows.map(|y| kx * height + y);
        let opposite = rows.map(|y| opposite_x * height + (height - y) % height);
        let mut sums = [Wave::default(); 2];
        let mut directs = [Wave::default(); 2];
        let planes = slices * (1 + gather.sloping as usize);
        for (number, record) in self.records.iter().enumerate() {
            let scattered = plus(
                scaled(self.radial(record.baseband, record.per_w, w), weight),
                product(self.aliases(record, kx, entry), scale),
            );
            if number < slices {
                let first = (column * planes + number) * height;
                for side in 0..2 {
                    let light = self.spectra[first + rows[side]];
                    sums[side] = sum(sums[side], lit(light, scattered));
                    if gather.sloping == 1 {
                        let factor = scaled(
                            self.radial(record.slope_correction, record.slope_correction_per_w, w),
                            weight,
                        );
                        let source = self.spectra[first + slices * height + rows[side]];
                        sums[side] = sum(sums[side], lit(source, factor));
                    }
                    if gather.occluded == 1 {
                        directs[side] = sum(directs[side], lit(light, record.direct));
                    }
                }
                continue;
            }
            let whole = plus(scattered, product(record.unscattered, scale));
            for side in 0..2 {
                if gather.carried == 1 && number == slices {
                    let wave = self.carried(pairs, here[side], opposite[side]);
                    sums[side] = sum(sums[side], times(wave, whole));
                } else {
                    let divisor = [whole[0].max(0.1), whole[1], whole[2], whole[3]];
                    let own = times(directs[side], scattered);
                    let rest = std::array::from_fn(|c| sums[side][c] - own[c]);
                    sums[side] = over(rest, divisor);
                }
            }
        }
        self.store(pairs, sums[0], here[0], opposite[0]);
        if mirrored_y != ky {
            self.store(pairs, sums[1], here[1], opposite[1]);
        }
    }

    fn carried(&self, pairs: &[Vec<C>; 2], here: usize, opposite: usize) -> Wave {
        let [first, second] = pairs;
        let mut wave = Wave::default();
        wave[0] = first_of(first[here], first[opposite]);
        if self.gather.derivatives == 1 {
            wave[1] = second_of(first[here], first[opposite]);
            wave[2] = first_of(second[here], second[opposite]);
            wave[3] = second_of(second[here], second[opposite]);
        }
        wave
    }

    fn store(&self, pairs: &mut [Vec<C>; 2], sum: Wave, here: usize, opposite: usize) {
        let mut first = C::default();
        if self.gather.derivatives == 1 {
            first = sum[1];
            pairs[1][here] = together(sum[2], sum[3]);
            if opposite != here {
                pairs[1][opposite] = together(sum[2].conj(), sum[3].conj());
            }
        }
        pairs[0][here] = together(sum[0], first);
        if opposite != here {
            pairs[0][opposite] = together(sum[0].conj(), first.conj());
        }
    }
}
