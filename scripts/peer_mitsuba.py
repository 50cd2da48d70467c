"""Recover a medium with Mitsuba 3 by differentiable path tracing: the peer of `narrowbeam fit`.

    python scripts/peer_mitsuba.py datasets/NAME --output trajectory.csv

prbvolpath renders and differentiates, Adam descends in (ln sigma_s, ln sigma_a, ln sigma_s B). The scene is
that of observe_mitsuba.py. The CSV file begins with lines that say how it came about; then, an iteration a line,
seconds since the first began (with Mitsuba's compilation, without its import), seconds of all cores together that the
process had by then, the medium, the loss. The truth is read only to place the start.
"""

import argparse
import csv
import os
import platform
import shlex
import sys
import time
from pathlib import Path

from mitsuba_render import set_variant  # before mitsuba
import drjit as dr
import mitsuba as mi
import numpy as np

from exr_io import read_exr
from mitsuba_parts import phase_nodes
from mitsuba_world import MEDIUM_BEHIND, mitsuba_scene
from scene_file import InputError, Medium, read_media, read_scene

# Errors of the start: sigma_s, sigma_a, B by these factors.
START = (0.5, 2.0, 2.0)
# Adam's step, in logarithms, at the beginning and at the end.
STEPS = (0.08, 0.01)


class Medium3:
    """The three numbers as Mitsuba's medium takes them, with derivatives."""

    def __init__(self, world, start, length):
        self.parameters = mi.traverse(world)
        find = lambda end: next(k for k in self.parameters.keys() if k.endswith(end))
        self.keys = [find(end) for end in ("sigma_t.value.value", "albedo.value.value", "phase_function.values")]
        self.length = length
        cos_theta = phase_nodes(start.b / 2)
        self.squared_angle = mi.Float(np.arccos(cos_theta) ** 2)
        self.spacing = float(cos_theta[1] - cos_theta[0])
        logarithms = np.log([start.sigma_s, start.sigma_a, start.sigma_s * start.b])
        self.optimiser = mi.ad.Adam(lr=STEPS[0])
        for name, value in zip(("s", "a", "w"), logarithms):
            self.optimiser[name] = mi.Float(value)

    def values(self):
        """sigma_s, sigma_a, B as they are, differentiable."""
        s, a, w = (dr.exp(self.optimiser[name]) for name in ("s", "a", "w"))
        return s, a, w / s

    def apply(self):
        """Hand the medium to Mitsuba."""
        s, a, b = self.values()
        lobe = dr.maximum(dr.exp(-self.squared_angle / (4 * b)), 1e-30)
        # Mitsuba normalises as well, but does not differentiate that.
        lobe /= dr.sum(lobe) * self.spacing
        for key, value in zip(self.keys, ((s + a) * self.length, s / (s + a), lobe)):
            self.parameters[key] = value
        self.parameters.update()


def descend(scene, observed, start, truth_b, arguments):
    """Yield seconds, seconds of all cores, sigma_s, sigma_a, B and loss of every iteration."""
    channel = next(iter(scene.radiance))
    world = mitsuba_scene(scene, channel, Medium(start.sigma_s, start.sigma_a, min(start.b, truth_b)), arguments.behind)
    integrator = mi.load_dict({"type": "prbvolpath", "max_depth": -1, "rr_depth": 2**31 - 1})
    medium = Medium3(world, start, scene.deepest)
    target = mi.TensorXf(np.ascontiguousarray(observed[..., None], dtype=np.float32))
    scale = float(np.mean(observed**2))
    begin, begin_cpu = time.perf_counter(), time.process_time()
    for i in range(arguments.iterations):
        medium.optimiser.set_learning_rate(STEPS[0] * (STEPS[1] / STEPS[0]) ** (i / arguments.iterations))
        medium.apply()
        image = mi.render(world, medium.parameters, integrator=integrator, spp=arguments.samples, seed=2 * i, seed_grad=2 * i + 1)
        loss = dr.mean(dr.square(image - target), axis=None) / scale
        dr.backward(loss)
        medium.optimiser.step()
        values = [float(v[0]) for v in medium.values()]
        loss = float(loss.array[0])
        yield time.perf_counter() - begin, time.process_time() - begin_cpu, *values, loss
        print(f"{i + 1} of {arguments.iterations}: " + " ".join(f"{v:.5g}" for v in values), file=sys.stderr, flush=True)


def processor():
    """Return the name of the processor, as far as the system tells."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    return next((line.partition(": ")[2] for line in lines if line.startswith("model name")), platform.machine())


def record(variant):
    """Return what a reader must know to make the trajectory again."""
    return [
        "command: " + shlex.join(["python", *sys.argv]),
        f"program: Mitsuba {mi.__version__}, prbvolpath, {variant}; Dr.Jit {dr.__version__}",
        f"machine: {os.cpu_count()} cores, {processor()}",
        "start: sigma_s, sigma_a, b of the truth times " + ", ".join(f"{f:g}" for f in START),
    ]


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    add = parser.add_argument
    add("dataset", type=Path, metavar="datasets/NAME")
    add("--output", required=True, type=Path, metavar="FILE.csv")
    add("--samples", type=int, default=16, help="paths per pixel and iteration (%(default)s)")
    add("--iterations", type=int, default=120, help="(%(default)s)")
    add("--behind", type=float, default=MEDIUM_BEHIND, metavar="X", help="as for observe_mitsuba.py (%(default)s)")
    add("--variant", help="Mitsuba variant, one that differentiates (llvm_ad_mono)")
    arguments = parser.parse_args()
    try:
        variant = set_variant(arguments.variant or "llvm_ad_mono")
        scene = read_scene(arguments.dataset / "scene.toml")
        truth = read_media(arguments.dataset / "truth.toml", scene.radiance)[0]
        if truth.g is not None:
            raise InputError(f"{arguments.dataset}: medium.g is not supported: Gaussian phase functions only")
        channel = next(iter(scene.radiance))
        observed = read_exr(arguments.dataset / "observed.exr")[channel]
    except InputError as error:
        sys.exit(f"error: {error}")
    start = Medium(truth.sigma_s * START[0], truth.sigma_a * START[1], truth.b * START[2])
    rows = list(descend(scene, observed, start, truth.b, arguments))
    with arguments.output.open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file, lineterminator="\n")
        file.writelines(f"# {line}\n" for line in record(variant))
        table.writerow(["seconds", "cpu_seconds", "sigma_s", "sigma_a", "b", "loss"])
        table.writerows([f"{v:.6g}" for v in row] for row in rows)


if __name__ == "__main__":
    main()
