//! Images and their derivatives against those of the CPU.

use crate::common::{pixels, relative_l2};
use crate::{gpu, scenes};
use narrowbeam::filter::Optics;
use narrowbeam::filter::cpu::{CpuFilter, Rendering};
use narrowbeam::filter::gpu::GpuFilter;
use narrowbeam::medium::Medium;
use narrowbeam::phase::Gaussian;
use narrowbeam::spread::Model;

/// Distance of image and derivatives from those of the CPU.
fn distances(gpu: &Rendering, cpu: &Rendering) -> [f64; 4] {
    let planes = |r: &Rendering| {
        let [s, a, b] = r.gradient.clone().unwrap();
        [r.image.clone(), s, a, b]
    };
    let (gpu, cpu) = (planes(gpu), planes(cpu));
    std::array::from_fn(|i| relative_l2(pixels(&gpu[i]), pixels(&cpu[i])))
}

#[test]
fn images_and_derivatives_equal_those_of_the_cpu() {
    println!("scene                        image   d/dsigma_s  d/dsigma_a  d/dB");
    for scene in scenes::all() {
        let phase = Gaussian::new(0.003).unwrap();
        let optics =
            Optics { model: Model::SmallAngle, medium: Medium::new(0.8, 0.1).unwrap(), phase: &phase };
        let cpu = CpuFilter::new(scene.target(), &optics, 1.0).unwrap();
        let filter = GpuFilter::new(gpu(), scene.target(), &optics, 1.0).unwrap();
        let (ours, theirs) =
            (filter.render_with_gradient(&optics).unwrap(), cpu.render_with_gradient(&optics).unwrap());
        let d = distances(&ours, &theirs);
        println!("{:28} {:.1e} {:.1e} {:.1e} {:.1e}", scene.name, d[0], d[1], d[2], d[3]);
        let alone = filter.render(&optics).unwrap();
        let l = relative_l2(pixels(&alone), pixels(&theirs.image));
        println!("{l:.1e}");
    }
}
