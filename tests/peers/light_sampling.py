"""What learning gains in direct light: variance times time, adaptive against uniform.

    python3 tests/peers/light_sampling.py RUN [--rrf target/release/rrf]

RUN is any baked run of the Cornell box. Two scenes: a hundred point lights of very different
strength in that room, whose truth is one exact shadow ray a light; and a large lamp over a floor,
all but a slit of it behind a board (written and baked here, coarsely: nets have no part in direct
light), whose truth are 4,096 rays chosen uniformly.

Both estimators get the same number of shadow rays, in --seeds frames of seeds of their own. With
E the squared relative error of `rrf compare` and t the processor time of `--json-stats`, the gain of
a seed is E t of uniform over E t of adaptive, each with its own frame's t. Printed is the
geometric mean over the seeds and its 95 % interval by Student's t of the logarithms.
"""

import argparse
import json
import math
import pathlib
import random
import statistics
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "python"))
import rrf_truth  # noqa: E402

# floor, wall behind, lamp facing down, the board under it that leaves a slit of 0.7 m
SCENE = """
LookAt 0 0.9 -2.5  0 0 0  0 1 0
Camera "perspective" "float fov" [40]
WorldBegin
Material "matte" "rgb Kd" [0.6 0.6 0.6]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point P" [-5 0 -5  -5 0 5  5 0 5  5 0 -5]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point P" [-5 0 5  -5 4 5  5 4 5  5 0 5]
Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point P"
    [-2.5 1.2 -2.5  -2.5 1.2 2.5  1.3 1.2 2.5  1.3 1.2 -2.5]
AttributeBegin
AreaLightSource "diffuse" "rgb L" [2 2 2]
Shape "trianglemesh" "integer indices" [0 2 1 0 3 2] "point P" [-2 1.5 -2  -2 1.5 2  2 1.5 2  2 1.5 -2]
AttributeEnd
WorldEnd
"""
# two-sided 97.5 % quantiles of Student's t by degrees of freedom
STUDENT = {3: 3.182, 7: 2.365, 15: 2.131, 31: 2.040}


def hundred():
    """Options of a hundred point lights in the Cornell box."""
    numbers = random.Random(1)
    options = []
    for _ in range(100):
        place = [numbers.uniform(-0.9, 0.9), numbers.uniform(0.1, 1.9), numbers.uniform(-0.9, 0.9)]
        watts = 0.01 * 20 ** numbers.random()
        options.append("--light=" + ",".join(f"{x:.4f}" for x in [*place, watts, watts, watts]))
    return options


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("run")
    parser.add_argument("--rrf", default="target/release/rrf")
    parser.add_argument("--size", default="128x128")
    parser.add_argument("--seeds", type=int, default=8, choices=[k + 1 for k in STUDENT])
    options = parser.parse_args()

    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)

        def frame(run, name, more):
            out, stats = folder / f"{name}.exr", folder / "stats.json"
            call = [options.rrf, "render", run, "--part", "direct", "--anyway", "-o", out]
            call += ["--size", options.size, "--json-stats", stats, *more]
            subprocess.run(call, check=True, capture_output=True)
            return out, json.loads(stats.read_text())["processor_ms"]

        def square(a, b):
            call = [options.rrf, "compare", a, b, "--layer", "direct", "--json"]
            done = subprocess.run(call, check=True, capture_output=True, text=True)
            return rrf_truth.measures(done.stdout)["relative_error"] ** 2

        scene, slit = folder / "slit.pbrt", folder / "slit"
        scene.write_text(SCENE)
        bake = [options.rrf, "bake", scene, "-o", slit, "--light-box=-1,0.3,-1,1,1,1"]
        subprocess.run([*bake, "--preset", "preview"], check=True, capture_output=True)
        uniform = ["--light-sampling", "uniform"]
        many = ["--shadow-rays", "4096", "--seed", "1000"]
        for name, run, shining, exact in (
            ("100 point lights", options.run, hundred(), []),
            ("a hidden lamp", slit, [], [*many, *uniform]),
        ):
            truth, _ = frame(run, "truth", [*shining, *exact])
            for rays in (16, 64):
                costs, errors, times = {}, {}, {}
                for way in ("uniform", "adaptive"):
                    more = [*shining, "--shadow-rays", str(rays), "--light-sampling", way]
                    frames = []
                    for seed in range(1, options.seeds + 1):
                        out, ms = frame(run, way, [*more, "--seed", str(seed)])
                        frames.append((square(out, truth), ms))
                    costs[way] = [error * ms for error, ms in frames]
                    errors[way] = [error for error, _ in frames]
                    times[way] = statistics.median(ms for _, ms in frames)
                logs = [math.log(u / a) for u, a in zip(costs["uniform"], costs["adaptive"])]
                spread = statistics.stdev(logs) / len(logs) ** 0.5 * STUDENT[len(logs) - 1]
                low, gain, high = (
                    math.exp(statistics.mean(logs) + d) for d in (-spread, 0, spread)
                )
                print(
                    f"{name}, {rays} rays: squared error {statistics.mean(errors['uniform']):.3g} "
                    f"against {statistics.mean(errors['adaptive']):.3g}, "
                    f"{times['uniform']:.0f} ms against {times['adaptive']:.0f} ms: "
                    f"gain {gain:.2f} ({low:.2f} to {high:.2f})",
                    flush=True,
                )


if __name__ == "__main__":
    main()
