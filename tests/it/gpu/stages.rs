//! Each stage against its twin, on numbers drawn at random.

use super::gpu;
use super::twins::{C, collect, gather, pass, slope_correction, split, sums, total, weigh};
use bytemuck::{Pod, Zeroable};
use narrowbeam::filter::gpu::shaders::{self, ALL};
use narrowbeam::filter::gpu::{
    CanvasLayout, Collect, FftPlan, Gather, NOTHING, Pass, Record, Source, Store, Sums, Total, Weigh,
    products,
};
use narrowbeam::gpu::Shader;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rustfft::FftPlanner;
use rustfft::num_complex::Complex;
use std::collections::BTreeSet;
use wgpu::Buffer;
use wgpu::naga;

/// Both sides do the same operations in f32, though not always in the same order, and a shader may fuse a product and a
/// sum. So they differ by a few roundings of 6e-8 of the largest terms.
const SAME: f64 = 2e-6;

pub struct Draw(Xoshiro256PlusPlus);

impl Draw {
    pub fn new(seed: u64) -> Self {
        Self(Xoshiro256PlusPlus::seed_from_u64(seed))
    }

    /// Between -1 and 1.
    pub fn number(&mut self) -> f32 {
        (self.0.next_u32() >> 8) as f32 / (1 << 23) as f32 - 1.0
    }

    pub fn below(&mut self, n: u32) -> u32 {
        self.0.next_u32() % n
    }

    pub fn numbers(&mut self, count: usize) -> Vec<f32> {
        (0..count).map(|_| self.number()).collect()
    }

    pub fn complex(&mut self, count: usize) -> Vec<C> {
        (0..count).map(|_| C::new(self.number(), self.number())).collect()
    }

    /// Positive factors with any derivatives.
    pub fn lanes(&mut self, count: usize) -> Vec<[f32; 4]> {
        let mut lane = || [1.0 + 0.5 * self.number(), self.number(), self.number(), self.number()];
        (0..count).map(|_| lane()).collect()
    }

    pub fn sources(&mut self, count: usize, slices: u32) -> Vec<Source> {
        let mut source = || Source {
            light: self.number().max(0.0),
            along: [self.below(slices) as f32, self.number()],
            z: 2.0 + self.number(),
            cosine: 0.9 + 0.1 * self.number(),
            slope: [self.number(), self.number()],
            slab: [0, 1, NOTHING][self.below(3) as usize],
        };
        (0..count).map(|_| source()).collect()
    }
}

/// Largest difference relative to the largest value of the twin.
fn difference(device: &[f32], twin: &[f32]) -> f64 {
    assert_eq!(device.len(), twin.len());
    let largest = |values: &mut dyn Iterator<Item = f32>| values.fold(0.0, |a: f32, v| a.max(v.abs()));
    let apart = largest(&mut device.iter().zip(twin).map(|(a, b)| a - b));
    f64::from(apart) / f64::from(largest(&mut twin.iter().copied()))
}

pub fn floats(values: &[C]) -> Vec<f32> {
    values.iter().flat_map(|v| [v.re, v.im]).collect()
}

pub fn check(stage: &str, case: &str, device: &[f32], twin: &[f32]) {
    let off = difference(device, twin);
    println!("{stage:8} {case:36} {off:.1e}");
    assert!(off < SAME, "{stage}, {case}: {off}");
    // The comparison sees a single wrong number.
    let mut wrong = device.to_vec();
    wrong[device.len() / 2] += 0.01 * twin.iter().fold(0.0, |a: f32, v| a.max(v.abs()));
    assert!(difference(&wrong, twin) > SAME, "{stage}, {case}");
}

pub fn complex_buffer(values: &[C]) -> Buffer {
    gpu().upload("complex", &floats(values)).unwrap()
}

/// Runs `shader` and reads `count` floats of the buffer number `read` back.
pub fn run<P: Pod>(
    shader: &Shader,
    parameters: &P,
    buffers: &[&Buffer],
    groups: usize,
    read: &[(usize, usize)],
) -> Vec<Vec<f32>> {
    let mut recording = gpu().record();
    recording.dispatch_groups(&gpu().stage(shader), parameters, buffers, groups);
    gpu().submit(recording).unwrap();
    read.iter().map(|&(i, count)| gpu().read(buffers[i], count).unwrap()).collect()
}

pub fn canvas(border: u32) -> CanvasLayout {
    CanvasLayout { size: [18, 14], object: [9, 7], margin: [4, 3], border, layers: 2 }
}

pub const PIXELS: usize = 18 * 14;
pub const OBJECT: usize = 9 * 7;

#[test]
fn every_shader_is_valid() {
    for shader in ALL {
        let text = shader.text();
        let module = naga::front::wgsl::parse_str(&text)
            .unwrap_or_else(|e| panic!("{}: {}", shader.name, e.emit_to_string(&text)));
        let all = naga::valid::ValidationFlags::all();
        let mut validator = naga::valid::Validator::new(all, naga::valid::Capabilities::empty());
        validator.validate(&module).unwrap_or_else(|e| panic!("{}: {e:?}", shader.name));
        assert_eq!(module.entry_points.len(), 1, "{}", shader.name);
        let mut layouter = naga::proc::Layouter::default();
        layouter.update(module.to_ctx()).unwrap();
        let shared: u32 = module
            .global_variables
            .iter()
            .filter(|(_, v)| v.space == naga::AddressSpace::WorkGroup)
            .map(|(_, v)| layouter[v.ty].size)
            .sum();
        assert!(
            shared <= 16384,
            "{}: {shared} bytes of shared memory, adapters need have but 16384",
            shader.name
        );
    }
}

#[test]
fn weigh_equals_its_twin() {
    let mut draw = Draw::new(1);
    for border in 0..3 {
        for (exact, counts, sloping) in [(1, [3, 1], 0), (0, [4, 1], 0), (0, [3, 2], 0), (0, [3, 2], 1)] {
            let slices = counts[0] * counts[1];
            let mut sources = draw.sources(2 * OBJECT, slices);
            if exact == 0 {
                sources.iter_mut().for_each(|s| s.along[0] = draw.number());
            }
            let nodes: Vec<f32> = [-1.0, -0.5, 0.5, 1.0][..counts[0] as usize]
                .iter()
                .chain(&[-1.0, 1.0][..counts[1] as usize])
                .copied()
                .collect();
            let second = if sloping == 1 { NOTHING } else { slices - 1 };
            let parameters = Weigh {
                canvas: canvas(border),
                slab: 1,
                exact,
                counts,
                slices: [1, second],
                sloping,
                padding: 0,
            };
            let pair = gpu().empty::<C2>("pair", PIXELS).unwrap();
            let buffers =
                [&gpu().upload("sources", &sources).unwrap(), &gpu().upload("nodes", &nodes).unwrap(), &pair];
            let device = run(&shaders::WEIGH, &parameters, &buffers, PIXELS.div_ceil(64), &[(2, 2 * PIXELS)]);
            let twin = floats(&weigh::weigh(&parameters, &sources, &nodes));
            let case = format!("border {border}, exact {exact}, slices {counts:?}, sloping {sloping}");
            check("weigh", &case, &device[0], &twin);
        }
    }
}

/// Stands for a complex number in a buffer.
pub type C2 = [f32; 2];

#[test]
fn transforms_equal_those_of_rustfft() {
    let mut draw = Draw::new(2);
    for [width, height] in [[8, 6], [30, 50], [74, 46], [128, 1024], [1080, 12], [20, 2048], [2250, 4]] {
        let plan = FftPlan::new(gpu(), width, height).unwrap();
        let image = draw.complex(width * height);
        let spare = || gpu().empty::<C2>("image", width * height).unwrap();
        let mut buffers = [complex_buffer(&image), spare(), spare()];
        let mut transform = |inverse: bool| -> Vec<f32> {
            let mut recording = gpu().record();
            plan.record(&mut recording, &mut buffers, &[0], inverse);
            gpu().submit(recording).unwrap();
            gpu().read(&buffers[0], 2 * width * height).unwrap()
        };
        let spectrum = transform(false);
        let back = transform(true);
        let expected = transposed_fft(&image, width, height);
        check("fft", &format!("{width}x{height}"), &spectrum, &expected);
        check("fft", &format!("{width}x{height}, there and back"), &back, &floats(&image));
    }
}

/// The 2-D transform in f64, column by column.
fn transposed_fft(image: &[C], width: usize, height: usize) -> Vec<f32> {
    let mut planner = FftPlanner::<f64>::new();
    let mut rows: Vec<Complex<f64>> =
        image.iter().map(|v| Complex::new(f64::from(v.re), f64::from(v.im))).collect();
    planner.plan_fft_forward(width).process(&mut rows);
    let mut columns: Vec<Complex<f64>> =
        (0..width * height).map(|i| rows[(i % height) * width + i / height]).collect();
    planner.plan_fft_forward(height).process(&mut columns);
    columns.iter().flat_map(|v| [v.re as f32, v.im as f32]).collect()
}

#[test]
fn split_and_slope_correction_equal_their_twins() {
    let mut draw = Draw::new(3);
    let [width, height] = [18, 14];
    for (begin, columns) in [(0, 10), (4, 6)] {
        for places in [[0, 2], [1, NOTHING]] {
            let parameters = Store { size: [width, height], begin, columns, planes: 3, places, padding: 0 };
            let pair = draw.complex(PIXELS);
            let count = (columns * 3 * height) as usize;
            type Twin = fn(&Store, &[C], &mut [C]);
            let twins: [(&Shader, Twin); 2] = [
                (&shaders::SPLIT, split::split),
                (&shaders::SLOPE_CORRECTION, slope_correction::slope_correction),
            ];
            for (shader, twin) in twins {
                let mut expected = vec![C::default(); count];
                twin(&parameters, &pair, &mut expected);
                let spectra = gpu().empty::<C2>("spectra", count).unwrap();
                let groups = (columns * height).div_ceil(64) as usize;
                let device =
                    run(shader, &parameters, &[&complex_buffer(&pair), &spectra], groups, &[(1, 2 * count)]);
                let case = format!("columns {begin}+{columns}, places {places:?}");
                check(shader.name, &case, &device[0], &floats(&expected));
            }
        }
    }
}

#[test]
fn gather_equals_its_twin() {
    let mut draw = Draw::new(4);
    let [width, height] = [18u32, 140];
    let count = (width * height) as usize;
    // More slices than are held at a time, columns in two parts, and all that may be there or not.
    for flags in 0..16u32 {
        let [sloping, carried, occluded, derivatives] = [0, 1, 2, 3].map(|bit| flags >> bit & 1);
        let (slices, begin, columns) = (18, 3, 7);
        let records = slices + carried + occluded;
        let per_w = 40.0;
        let entries = (4.5 * per_w) as u32 + 4;
        let tables = draw.lanes((2 * records * entries + records * 64 + entries) as usize);
        let record = |i: u32| Record {
            baseband: 2 * i * entries,
            per_w,
            slope_correction: (2 * i + 1) * entries,
            slope_correction_per_w: per_w,
            aliases: 2 * records * entries + i * 64,
            direct: [0.5, 0.1, -0.2, 0.0],
            unscattered: [0.3, -0.1, 0.2, 0.1],
            ..Record::zeroed()
        };
        let records: Vec<Record> = (0..records).map(record).collect();
        let frequencies = width / 2 + 1 + height / 2 + 1;
        let mut axes = draw.lanes(3 * frequencies as usize);
        axes.iter_mut().step_by(3).for_each(|entry| entry[0] = 3.1 * entry[1].abs());
        let spectra = draw.complex((columns * slices * (1 + sloping) * height) as usize);
        let mut pairs = [draw.complex(count), draw.complex(count)];
        let parameters = Gather {
            size: [width, height],
            begin,
            columns,
            slices,
            sloping,
            carried,
            occluded,
            derivatives,
            scale: tables.len() as u32 - entries,
            scale_per_w: per_w,
            padding: 0,
        };
        let upload = |values: &[[f32; 4]]| gpu().upload("tables", values).unwrap();
        let buffers = [
            &gpu().upload("records", &records).unwrap(),
            &upload(&tables),
            &upload(&axes),
            &complex_buffer(&spectra),
            &complex_buffer(&pairs[0]),
            &complex_buffer(&pairs[1]),
        ];
        let groups = (columns * (height / 2 + 1).div_ceil(64)) as usize;
        let device = run(&shaders::GATHER, &parameters, &buffers, groups, &[(4, 2 * count), (5, 2 * count)]);
        gather::Input {
            gather: parameters,
            records: &records,
            tables: &tables,
            axes: &axes,
            spectra: &spectra,
        }
        .run(&mut pairs);
        let case = format!("slope {sloping}, carried {carried}, occluded {occluded}, gradient {derivatives}");
        check("gather", &case, &device[0], &floats(&pairs[0]));
        check("gather", &case, &device[1], &floats(&pairs[1]));
    }
}

#[test]
fn pass_and_collect_equal_their_twins() {
    let mut draw = Draw::new(5);
    for (border, derivatives) in [(0, 1), (1, 1), (2, 1), (0, 0)] {
        let sources = draw.sources(2 * OBJECT, 1);
        let opaque: Vec<u32> = (0..OBJECT).map(|_| draw.below(4)).collect();
        let mut pairs = [draw.complex(PIXELS), draw.complex(PIXELS)];
        let on_device = gpu().upload("sources", &sources).unwrap();
        let parameters = Pass {
            canvas: canvas(border),
            slab: 1,
            bit: 2,
            z: 0.7,
            sigma_t: 0.8,
            unit: 3.0,
            derivatives,
            padding: [0; 2],
        };
        let buffers = [
            &on_device,
            &gpu().upload("opaque", &opaque).unwrap(),
            &complex_buffer(&pairs[0]),
            &complex_buffer(&pairs[1]),
        ];
        let read = [(2, 2 * PIXELS), (3, 2 * PIXELS)];
        let device = run(&shaders::PASS, &parameters, &buffers, PIXELS.div_ceil(64), &read);
        pass::pass(&parameters, &sources, &opaque, &mut pairs);
        let case = format!("border {border}, gradient {derivatives}");
        check("pass", &case, &device[0], &floats(&pairs[0]));
        check("pass", &case, &device[1], &floats(&pairs[1]));

        let view = [6, 5];
        let pixels = 30;
        let weights = draw.numbers(2 * pixels);
        for (before, direct, weights) in [(0, 1, &weights[..]), (1, 0, &weights[..]), (0, 1, &[1.0])] {
            let parameters = Collect {
                canvas: canvas(border),
                view: [2, 1],
                view_size: view,
                sigma_t: 0.8,
                unit: 3.0,
                derivatives,
                before,
                direct,
                padding: [0; 3],
            };
            let mut planes = draw.numbers(4 * pixels);
            let buffers = [
                &on_device,
                &gpu().upload("weights", weights).unwrap(),
                &complex_buffer(&pairs[0]),
                &complex_buffer(&pairs[1]),
                &gpu().upload("planes", &planes).unwrap(),
            ];
            let device = run(&shaders::COLLECT, &parameters, &buffers, 1, &[(4, 4 * pixels)]);
            collect::collect(&parameters, &sources, weights, &pairs, &mut planes);
            check("collect", &format!("{case}, before {before}"), &device[0], &planes);
        }
    }
}

#[test]
fn sums_and_their_total_equal_their_twins_and_lose_nothing() {
    let mut draw = Draw::new(6);
    let pixels = 30_000;
    let groups = 8;
    for (images, derivatives) in [(6, 0), (6, 1), (8, 0), (8, 1)] {
        let shader = if images == 6 { &shaders::SUMS } else { &shaders::SUMS_OF_EIGHT };
        let case = format!("{images} images, gradient {derivatives}");
        let planes: Vec<f32> =
            draw.numbers((images - 2) * pixels).into_iter().map(|v| 1.0 + 0.5 * v).collect();
        // The residual is a thousandth of the image.
        let observe =
            |draw: &mut Draw, m: f32| [1.5 * m + 0.1 + 1e-3 * draw.number(), draw.below(4).min(1) as f32];
        let observed: Vec<C2> = planes[..pixels].iter().map(|&m| observe(&mut draw, m)).collect();
        let parameters =
            Sums { pixels: pixels as u32, gain: 1.5, veil: 0.1, derivatives, zero: 0, padding: [0; 3] };
        let partial = gpu().empty::<C2>("partial", groups * products(images)).unwrap();
        let buffers = [
            &gpu().upload("planes", &planes).unwrap(),
            &gpu().upload("observed", &observed).unwrap(),
            &partial,
        ];
        let count = 2 * groups * products(images);
        let device = run(shader, &parameters, &buffers, groups, &[(2, count)]);
        let twin = sums::sums(&parameters, images, &planes, &observed, groups);
        check("sums", &case, &device[0], twin.as_flattened());

        let parameters =
            Total { groups: groups as u32, products: products(images) as u32, zero: 0, padding: 0 };
        let whole = gpu().empty::<C2>("whole", products(images)).unwrap();
        let device = run(&shaders::TOTAL, &parameters, &[&partial, &whole], 1, &[(1, 2 * products(images))]);
        let twin = total::total(&parameters, &twin);
        check("total", &case, &device[0], twin.as_flattened());

        let exact = exact_sums(images, &planes, &observed, derivatives == 1);
        let place = |i: usize, j: usize| i * (i + 1) / 2 + j;
        let mut worst: f64 = 0.0;
        for (i, j) in (0..images).flat_map(|i| (0..=i).map(move |j| (i, j))) {
            let [high, low] = [0, 1].map(|k| f64::from(device[0][2 * place(i, j) + k]));
            let size = (exact[place(i, i)] * exact[place(j, j)]).sqrt().max(1.0);
            worst = worst.max((high + low - exact[place(i, j)]).abs() / size);
        }
        println!("sums against f64, relative to the norms of the two images: {worst:.1e}");
        // What is left: each residual is good to some 2e-7 of its image, and is but 4e-4 of it.
        assert!(worst < 5e-4, "{worst}");
        // Adding up loses none of the f32 products; a plain f32 sum does.
        let squares = || planes[..pixels].iter().zip(&observed).map(|(m, o)| m * m * o[1]);
        let all: f64 = squares().map(f64::from).sum();
        let lost = |sum: f64| (sum / all - 1.0).abs();
        let ours = lost(f64::from(device[0][0]) + f64::from(device[0][1]));
        let plain = lost(f64::from(squares().sum::<f32>()));
        println!("sum of squares off by {ours:.1e}, a plain f32 sum by {plain:.1e}");
        assert!(ours < 2e-9 && plain > 1e-8, "{ours}, {plain}");
    }
}

/// The same products in f64, of the same f32 images.
fn exact_sums(images: usize, planes: &[f32], observed: &[C2], derivatives: bool) -> Vec<f64> {
    let pixels = observed.len();
    let mut sums = vec![0.0; products(images)];
    for (at, here) in observed.iter().enumerate().filter(|(_, here)| here[1] > 0.0) {
        let m = f64::from(planes[at]);
        let d = |c: usize| if derivatives { f64::from(planes[c * pixels + at]) } else { 0.0 };
        let residual = f64::from(1.5f32) * m + f64::from(0.1f32) - f64::from(here[0]);
        let rendered = std::iter::once(m).chain((1..images - 2).map(d));
        let all: Vec<f64> = rendered.chain([residual, 1.0]).collect();
        let products = (0..images).flat_map(|i| (0..=i).map(move |j| (i, j)));
        sums.iter_mut().zip(products).for_each(|(sum, (i, j))| *sum += all[i] * all[j]);
    }
    sums
}

/// The file that a shader is in: its name, before what it is made for.
fn file(shader: &Shader) -> &'static str {
    shader.name.split(' ').next().unwrap()
}

#[test]
fn twins_have_the_names_of_the_shaders() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    for shader in ALL.iter().filter(|shader| shader.name != "fft") {
        let twin = folder.join("tests/it/gpu/twins").join(file(shader)).with_extension("rs");
        assert!(twin.is_file(), "{}", twin.display());
    }
    let files = std::fs::read_dir(folder.join("shaders")).unwrap();
    let count = files.filter(|f| f.as_ref().unwrap().path().extension().is_some()).count();
    let checked: BTreeSet<&str> = ALL.iter().map(file).collect();
    assert_eq!(count, checked.len(), "a shader file is not among those checked");
}
