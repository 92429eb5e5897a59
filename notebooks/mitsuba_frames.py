"""Frames of an exported scene by Mitsuba 3, through pixel centres as `rrf trace` renders them."""

import os
import pathlib

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parent.parent
LIBRARY = ROOT / ".venv-notebooks/libllvm"
if "DRJIT_LIBLLVM_PATH" not in os.environ and LIBRARY.is_file():
    os.environ["DRJIT_LIBLLVM_PATH"] = LIBRARY.read_text().strip()

import drjit as dr  # noqa: E402
import mitsuba as mi  # noqa: E402

mi.set_variant("llvm_ad_rgb")


def render(folder, runs: int, paths: int, first_seed: int = 0) -> np.ndarray:
    """Independent estimates of every pixel's radiance, shape [runs, h, w, 3]."""
    scene = mi.load_file(str(pathlib.Path(folder) / "scene.xml"))
    sensor, integrator = scene.sensors()[0], scene.integrator()
    width, height = (int(n) for n in sensor.film().size())
    pixels = width * height
    sampler = mi.load_dict({"type": "independent", "sample_count": paths})
    sampler.set_samples_per_wavefront(paths)
    frames = []
    for run in range(runs):
        sampler.seed(first_seed + run, pixels * paths)
        pixel = dr.arange(mi.UInt32, pixels * paths) // paths
        x, y = pixel % width, pixel // width
        at = mi.Point2f((mi.Float(x) + 0.5) / width, (mi.Float(y) + 0.5) / height)
        ray, _ = sensor.sample_ray(0.0, 0.5, at, mi.Point2f(0.5))
        radiance, _, _ = integrator.sample(scene, sampler, mi.RayDifferential3f(ray))
        dr.eval(radiance)
        sums = [dr.block_sum(channel, paths).numpy() for channel in radiance]
        frames.append(np.stack(sums, -1).astype(float).reshape(height, width, 3) / paths)
    return np.array(frames)
