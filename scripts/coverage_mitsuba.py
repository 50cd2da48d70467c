"""Render many random scenes with Mitsuba 3, fit them, and count how many intervals hold the truth.

    python scripts/coverage_mitsuba.py --out DIR [--count 40] [--fit PROGRAM]

Scene number i and its medium follow from --seed and i alone, so a run that was stopped goes on
where it was: scenes whose observation is there are not rendered again. They are planes seen by
parallel rays: scattering depth 0.05 to 10, spread angle 4 to 45 degrees or g 0.8 to 0.98, albedo
0.7 to 1, textures coarser than, as fine as and finer than a pixel, of low contrast, mostly black
or of a high dynamic range, with a known or a free gain, at one depth or two. With --fit each is
fitted with all defaults, and DIR/coverage.csv and a summary on stdout say what came of it.
"""

import argparse
import csv
import json
import math
import subprocess
import sys
from pathlib import Path

from mitsuba_render import render, set_variant  # before exr_io
import numpy as np

from exr_io import write_exr
from mitsuba_world import mitsuba_scene
from scene_file import read_media, read_scene
from textures import checker, dead_leaves, natural_checker, power_noise

Z = 2.0
TEXTURES = ("coarse", "leaves", "pixel", "fine", "faint", "black", "hdr")


def texture(rng, name, side):
    """Return the radiance of the object, `side` px square, and how many texels a pixel has."""
    if name == "coarse":
        return natural_checker(rng, side), 1
    if name == "leaves":
        return dead_leaves(rng, np.array([0.1, 0.3, 0.6, 1.0]), side), 1
    if name == "pixel":
        return rng.uniform(0.1, 1.0, (side, side)), 1
    if name == "fine":
        return np.clip(0.5 + 0.2 * power_noise(rng, 0.5, 2 * side), 0.02, None), 2
    if name == "faint":
        return 0.5 * (1 + 0.03 * np.clip(power_noise(rng, 1, side), -3, 3)), 1
    if name == "black":
        return np.where(rng.random((side, side)) < 0.03, rng.uniform(0.3, 1, (side, side)), 0.0), 1
    return np.exp(1.2 * power_noise(rng, 1, side)) * (0.3 + checker(rng, side)), 1


def drawn(seed, i):
    """Return what scene number `i` is."""
    rng = np.random.default_rng([seed, i])
    tau = 0.05 * 200 ** rng.random()
    albedo = 1 - 0.3 * rng.random() ** 2
    is_gaussian = rng.random() < 0.6
    angle = math.radians(4 * (45 / 4) ** rng.random())
    g = float(rng.uniform(0.8, 0.98))
    width = angle / 2 if is_gaussian else math.sqrt(1 - g)
    return {
        "rng": rng,
        "side": int(rng.choice([64, 80, 96])),
        "texture": TEXTURES[i % len(TEXTURES)],
        "sigma_s": tau / Z,
        "sigma_a": tau / Z * (1 - albedo) / albedo,
        "phase": ("b", angle**2 / 4) if is_gaussian else ("g", g),
        # Kernels of 0.5 to 12 px.
        "pitch": Z * width / (0.5 * 24 ** rng.random()),
        "free_gain": bool(rng.random() < 0.3),
        "depths": (Z, 0.5 * Z) if rng.random() < 0.3 else (Z,),
    }


def scene_text(scene, depth, texels, plain):
    """Return the scene file; `plain` is that which Mitsuba sees, with all texels."""
    gain = "free" if scene["free_gain"] and not plain else None
    pitch = scene["pitch"] / (texels if plain else 1)
    prefix = "fine-" if plain and texels > 1 else ""
    lines = [
        "[object]",
        f'radiance = "{prefix}object.exr"',
        f"depth = {depth}",
        "[camera]",
        f"pixel_pitch = {pitch!r}",
    ]
    if not plain:
        lines += ["[observation]", f'image = "observed-{depth}.exr"']
        lines += [f'gain = "{gain}"'] if gain else []
        lines += ["[fit]", 'phase = "hg"'] if scene["phase"][0] == "g" else []
    return "\n".join(lines) + "\n"


def make(folder, seed, i, samples):
    """Render scene number `i` into `folder` if it is not there, and return what it is."""
    scene = drawn(seed, i)
    folder.mkdir(parents=True, exist_ok=True)
    radiance, texels = texture(scene["rng"], scene["texture"], scene["side"])
    binned = bin_texels(radiance, texels)
    write_exr(folder / "object.exr", {"Y": binned.astype(np.float32)})
    if texels > 1:
        write_exr(folder / "fine-object.exr", {"Y": radiance.astype(np.float32)})
    name, value = scene["phase"]
    truth = f"[medium]\nsigma_s = {scene['sigma_s']!r}\nsigma_a = {scene['sigma_a']!r}\n{name} = {value!r}\n"
    (folder / "truth.toml").write_text(truth)
    for depth in scene["depths"]:
        (folder / f"scene-{depth}.toml").write_text(scene_text(scene, depth, texels, plain=False))
        observed = folder / f"observed-{depth}.exr"
        if observed.exists():
            continue
        plain = folder / f"mitsuba-{depth}.toml"
        plain.write_text(scene_text(scene, depth, texels, plain=True))
        seen = read_scene(plain)
        [(channel, medium)] = zip(seen.radiance, read_media(folder / "truth.toml", seen.radiance))
        world = mitsuba_scene(seen, channel, medium)
        each = max(16, samples // texels**2)
        mean, _, _ = render(world, each, radiance.size, [seed, i, int(1000 * depth)], str(i))
        write_exr(observed, {"Y": bin_texels(mean, texels).astype(np.float32)})
    return scene


def bin_texels(image, texels):
    """Return the mean of every `texels` by `texels` of `image`."""
    side = image.shape[0] // texels
    return image.reshape(side, texels, side, texels).mean(axis=(1, 3))


def fitted(program, folder, scene):
    """Return a row for each parameter: name, truth, value, interval, status, severity."""
    files = [str(folder / f"scene-{depth}.toml") for depth in scene["depths"]]
    command = [program, "fit", *files, "--json", "--out", str(folder / "fit")]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    if not run.stdout:
        raise SystemExit(f"{folder}: {run.stderr}")
    report = json.loads(run.stdout)
    severity = {warning["severity"] for warning in report["warnings"]}
    name, value = scene["phase"]
    truths = {"sigma_s": scene["sigma_s"], "sigma_a": scene["sigma_a"], name: value}
    for parameter, truth in truths.items():
        found = report["parameters"][parameter]
        low, high = found["ci95"] or (None, None)
        yield {
            "scene": folder.name,
            "texture": scene["texture"],
            "tau": scene["sigma_s"] * Z,
            "phase": f"{name} {value:.4g}",
            "gain": "free" if scene["free_gain"] else "known",
            "depths": len(scene["depths"]),
            "parameter": parameter,
            "truth": truth,
            "value": found["value"],
            "std_error": found["std_error"],
            "model_error": found["model_error"],
            "low": low,
            "high": high,
            "status": found["status"],
            "held": None if low is None else low <= truth <= high,
            "severity": " ".join(sorted(severity)),
            "causes": " ".join(entry["cause"] for entry in report["diagnosis"]),
            "model": report["model"],
        }


def summary(rows):
    """Return what came of it, in words."""
    stated = [row for row in rows if row["held"] is not None]
    held = sum(row["held"] for row in stated)
    share = held / len(stated)
    error = math.sqrt(max(share * (1 - share), 1 / len(stated)) / len(stated))
    silent = [
        row
        for row in stated
        if not {"caution", "invalid"} & set(row["severity"].split())
        and abs(row["value"] - row["truth"]) > 4 * row["std_error"] + (row["model_error"] or 0)
    ]
    scenes = {row["scene"]: row["severity"] for row in rows}
    warned = sum("caution" in s or "invalid" in s for s in scenes.values())
    return (
        f"{len(scenes)} scenes: {held} of {len(stated)} stated 95 % intervals hold the truth, "
        f"{100 * share:.1f} ± {100 * error:.1f} %; {len(rows) - len(stated)} parameters are undetermined or "
        f"doubtful; {warned} scenes carry a caution; silent failures: "
        + (", ".join(f"{row['scene']} {row['parameter']}" for row in silent) or "none")
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    add = parser.add_argument
    add("--out", required=True, type=Path, metavar="DIR")
    add("--count", type=int, default=40)
    add("--first", type=int, default=0, help="number of the first scene (%(default)s)")
    add("--seed", type=int, default=1)
    add("--samples", type=int, default=1024, help="paths per pixel (%(default)s)")
    add("--fit", metavar="PROGRAM", help="narrowbeam, to fit what was rendered")
    arguments = parser.parse_args()
    set_variant(None)
    rows = []
    for i in range(arguments.first, arguments.first + arguments.count):
        folder = arguments.out / f"{i:03}"
        scene = make(folder, arguments.seed, i, arguments.samples)
        print(f"scene {i}: {scene['texture']}, tau {scene['sigma_s'] * Z:.2f}", file=sys.stderr)
        if arguments.fit:
            rows.extend(fitted(arguments.fit, folder, scene))
    if rows:
        with open(arguments.out / "coverage.csv", "w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, rows[0].keys())
            writer.writeheader()
            writer.writerows(rows)
        print(summary(rows))


if __name__ == "__main__":
    main()
