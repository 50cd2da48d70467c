//! Transfer functions as the stage `gather` reads them.

use super::super::canvas::Canvas;
use super::super::tables::{Lanes, RadialTable};
use super::super::transfer::{Transfer, Way};
use bytemuck::{Pod, Zeroable};

/// Counterpart of `Record` in shaders/gather.wgsl: where one slice's tables are.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
pub struct Record {
    /// Where the radial table begins, and its entries per rad/px.
    pub baseband: u32,
    /// Entries per rad/px.
    pub per_w: f32,
    /// The same of the slope term.
    pub slope_correction: u32,
    /// Entries per rad/px.
    pub slope_correction_per_w: f32,
    /// Where the aliases begin.
    pub aliases: u32,
    /// Fills the structure up.
    pub padding: [u32; 3],
    /// Share of the occluder's direct light that is this slice's.
    pub direct: Lanes,
    /// Direct light in units of the scale.
    pub unscattered: Lanes,
}

/// All records and tables of one gathering.
pub(super) struct Tables {
    /// Of the slices, of the light from farther occluders, of the divisor.
    pub records: Vec<Record>,
    pub entries: Vec<Lanes>,
    /// Where the table of the divisor's scale begins, and its entries per rad/px.
    pub scale: (u32, f32),
}

/// Units of the image and its derivatives on the device, chosen so that all four are of like size: two are transformed
/// as one complex image, and the roundings of one are noise in the other.
#[derive(Debug, Clone, Copy)]
pub(super) struct Units(pub [f64; 4]);

impl Units {
    /// For path lengths up to `z`, length, and a lobe of `width`, rad.
    pub(super) fn new(z: f64, width: f64) -> Self {
        Self([1.0, z, z, 1.0 / (width * width)])
    }

    fn apply(&self, value: &Lanes) -> Lanes {
        std::array::from_fn(|c| (f64::from(value[c]) / self.0[c]) as f32)
    }
}

impl Tables {
    pub(super) fn new(way: &Way, units: &Units) -> Self {
        let mut tables = Self::collected(way);
        for lanes in tables.entries.iter_mut() {
            *lanes = units.apply(lanes);
        }
        for record in &mut tables.records {
            record.direct = units.apply(&record.direct);
            record.unscattered = units.apply(&record.unscattered);
        }
        tables
    }

    fn collected(way: &Way) -> Self {
        let mut tables = Self { records: Vec::new(), entries: Vec::new(), scale: (0, 0.0) };
        let own = way.divisor.as_ref().map(|d| &d.own);
        for transfer in way.transfers.iter().chain(&way.farther).chain(own) {
            tables.add(transfer);
        }
        if let Some(divisor) = &way.divisor {
            tables.scale = tables.append(&divisor.scale);
        }
        tables
    }

    fn add(&mut self, transfer: &Transfer) {
        let (baseband, per_w) = self.append(&transfer.baseband);
        let (slope_correction, slope_correction_per_w) =
            transfer.slope_correction.as_ref().map_or((0, 0.0), |table| self.append(table));
        let aliases = self.entries.len() as u32;
        self.entries.extend(transfer.aliases.values().as_flattened());
        self.records.push(Record {
            baseband,
            per_w,
            slope_correction,
            slope_correction_per_w,
            aliases,
            padding: [0; 3],
            direct: transfer.direct,
            unscattered: transfer.unscattered,
        });
    }

    fn append(&mut self, table: &RadialTable) -> (u32, f32) {
        let begin = self.entries.len() as u32;
        self.entries.extend_from_slice(table.values());
        (begin, table.per_w() as f32)
    }
}

/// For each frequency across, then down: (w, what both pixels leave, -, -) and the 8 basis values of the aliases.
pub(super) fn axes(canvas: &Canvas) -> Vec<Lanes> {
    let frequency = |(&w, (&pixel, b)): (&f64, (&f32, &[f32; 8]))| {
        [[w as f32, pixel, 0.0, 0.0], [b[0], b[1], b[2], b[3]], [b[4], b[5], b[6], b[7]]]
    };
    let axis = |axis: &super::super::canvas::Axis| -> Vec<Lanes> {
        axis.w.iter().zip(axis.pixel.iter().zip(&axis.basis)).flat_map(frequency).collect()
    };
    canvas.axes.iter().flat_map(axis).collect()
}
