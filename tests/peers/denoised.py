"""A baked frame against path tracing with Intel's Open Image Denoise (OIDN): the rival that users would pick.

    .venv-peers/bin/python tests/peers/denoised.py RUN [--light x,y,z,r,g,b] [--size WxH] [--paths 2,4,...] [--json OUT]

The rival is the stronger of two: exact direct light, and only the indirect light of N paths a pixel denoised, with
albedo and normals as guides. Its direct light is the baked frame's own, at no cost. OIDN runs on the CPU at its
highest quality.

The error is the relative error of the indirect light (rrf_truth.FORMULA) over pixels. Two references of --spp paths, with
seeds of their own, take their noise out. Times are processor seconds (user time) of frames of --time-size: they hold on
a machine with other work. The rival pays for its rays and for the filter, not for files; the baked frame for its
indirect light alone (`--json-stats`, part indirect).
"""

import argparse
import json
import pathlib
import resource
import subprocess
import sys
import tempfile

import numpy as np
import OpenEXR
import pyoidn

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "python"))
import rrf_truth  # noqa: E402

REPEATS = 5


def user_seconds():
    kinds = (resource.RUSAGE_CHILDREN, resource.RUSAGE_SELF)
    return sum(resource.getrusage(kind).ru_utime for kind in kinds)


def channels(path, layer, names="RGB"):
    """Three channels of a layer, shape [height, width, 3]."""
    found = OpenEXR.File(str(path), separate_channels=True).parts[0].channels
    prefix = f"{layer}." if layer else ""
    planes = [found[f"{prefix}{name}"].pixels for name in names]
    return np.ascontiguousarray(np.stack(planes, axis=-1), dtype=np.float32)


class Case:
    """One run, its view and light, and a folder for frames."""

    def __init__(self, options, folder):
        manifest = json.loads((pathlib.Path(options.run) / "run.json").read_text())
        self.rrf, self.run, self.folder = options.rrf, options.run, folder
        self.scene = options.scene or manifest["scene"]
        sky = manifest["config"].get("sky") or {}
        self.sky = ["--sky", sky["picture"]] if "picture" in sky else []
        self.light = ["--light", options.light] if options.light else []

    def call(self, *words):
        subprocess.run([self.rrf, *map(str, words), "-q"], check=True, capture_output=True)

    def traced(self, spp, size, seed, aov=True):
        """A path-traced frame of the indirect light; its user seconds."""
        out = self.folder / f"{spp}-{size}-{seed}.exr"
        before = user_seconds()
        words = ["trace", self.scene, *self.sky, *self.light, "--part", "indirect", "--size", size]
        words += ["--aov", "albedo,normal"] if aov else []
        self.call(*words, "--spp", spp, "--seed", seed, "-o", out)
        return out, user_seconds() - before

    def baked(self, size, frames=1):
        """A baked frame of the indirect light; its processor seconds."""
        out, stats = self.folder / f"baked-{size}.exr", self.folder / "stats.json"
        words = ["render", self.run, *self.light, "--part", "indirect", "--size", size]
        self.call(*words, "--frames", frames, "--json-stats", stats, "-o", out)
        return out, json.loads(stats.read_text())["processor_ms"] / 1e3


def denoised(path):
    """The denoised light of a path-traced frame; the filter's user seconds."""
    colour = channels(path, "indirect")
    albedo, normal = channels(path, "albedo"), channels(path, "normal", "XYZ")
    before = user_seconds()
    picture = pyoidn.denoise(colour, albedo=albedo, normal=normal, hdr=True, clean_aux=True, quality="high")
    return np.asarray(picture), user_seconds() - before


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("run")
    parser.add_argument("--rrf", default="target/release/rrf")
    parser.add_argument("--scene", help="if it is no longer where the run was baked from")
    parser.add_argument("--light", help="a point light in place of the scene's own lights")
    parser.add_argument("--size", default="256x256")
    parser.add_argument("--time-size", help="size of the frames whose time is taken; --size unless given")
    parser.add_argument("--paths", default="2,4,8,16,32,64,128,256")
    parser.add_argument("--spp", type=int, default=2048, help="paths a pixel of each reference")
    parser.add_argument("--json", type=pathlib.Path)
    options = parser.parse_args()
    timed = options.time_size or options.size

    rows = []
    with tempfile.TemporaryDirectory() as folder:
        case = Case(options, pathlib.Path(folder))
        halves = np.stack(
            [channels(case.traced(options.spp, options.size, seed)[0], "indirect").reshape(-1, 3) for seed in (98, 99)]
        ).astype(float)
        level = rrf_truth.level(halves.mean(0))

        def judged(name, picture, seconds):
            error, se = rrf_truth.error(rrf_truth.by_halves(picture.reshape(-1, 3).astype(float), halves, level))
            rows.append({"name": name, "error": error, "error_se": se, "processor_seconds": seconds})

        frame, _ = case.baked(options.size)
        _, seconds = case.baked(timed, frames=REPEATS)
        judged("baked", channels(frame, "indirect"), seconds)
        # what starting the program, reading the scene and writing the file take
        idle = min(case.traced(2, "2x2", seed)[1] for seed in range(3))
        for paths in map(int, options.paths.split(",")):
            picture, _ = case.traced(paths, options.size, 7)
            clean, _ = denoised(picture)
            frame, seconds = case.traced(paths, timed, 8)
            _, filtering = denoised(frame)
            seconds = max(seconds - idle, 0.0)
            judged(f"{paths} paths", channels(picture, "indirect"), seconds)
            judged(f"{paths} paths, denoised", clean, seconds + filtering)

    print(f"{'frame':24} {'error':>16} {'CPU s':>9}")
    for row in rows:
        print(f"{row['name']:24} {row['error']:8.2%} ± {row['error_se']:5.2%} {row['processor_seconds']:9.4f}")
    baked, rivals = rows[0], rows[1:]
    good = [row for row in rivals if row["error"] <= baked["error"]]
    if good:
        best = min(good, key=lambda row: row["processor_seconds"])
        factor = best["processor_seconds"] / baked["processor_seconds"]
        print(f"the cheapest rival of no more error, {best['name']}, takes {factor:.0f} times the processor time")
    else:
        print("no rival reached the baked frame's error; give more --paths")
    if options.json:
        options.json.write_text(json.dumps(rows, indent=1))


if __name__ == "__main__":
    main()
