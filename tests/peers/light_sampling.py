"""What learning gains in direct light: variance times time, adaptive against uniform.

    python3 tests/peers/light_sampling.py RUN [--rrf target/release/rrf]

RUN is any baked run of the Cornell box. A hundred point lights of very different strength stand
in it; the truth is one exact shadow ray a light (the default of `rrf render`). Both estimators
then get the same number of shadow rays; the gain is the ratio of (mean squared error) x
(processor time of `--json-stats`). The same for the scene's own area light, against 4,096 rays.
"""

import argparse
import json
import pathlib
import random
import subprocess
import tempfile


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("run")
    parser.add_argument("--rrf", default="target/release/rrf")
    parser.add_argument("--size", default="256x256")
    options = parser.parse_args()
    numbers = random.Random(1)
    lights = []
    for _ in range(100):
        place = [numbers.uniform(-0.9, 0.9), numbers.uniform(0.1, 1.9), numbers.uniform(-0.9, 0.9)]
        watts = 0.01 * 20 ** numbers.random()
        lights += ["--light=" + ",".join(f"{x:.4f}" for x in [*place, watts, watts, watts])]

    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)

        def frame(name, more):
            out, stats = folder / f"{name}.exr", folder / "stats.json"
            call = [options.rrf, "render", options.run, "--part", "direct", "--anyway"]
            call += ["--size", options.size, "--json-stats", stats, "--frames", "3", "-o", out]
            subprocess.run([*call, *more], check=True, capture_output=True)
            return out, json.loads(stats.read_text())["processor_ms"]

        def rel_mse(a, b):
            call = [options.rrf, "compare", a, b, "--layer", "direct", "--json"]
            done = subprocess.run(call, check=True, capture_output=True, text=True)
            measures = json.loads(done.stdout)["measures"]
            return next(m["value"] for m in measures if m["name"] == "relative_error") ** 2

        for name, shining, exact in (
            ("100 point lights", lights, []),
            ("the lamp", [], ["--shadow-rays", "4096"]),
        ):
            truth, _ = frame("truth", [*shining, *exact])
            for rays in (16, 64):
                cost = {}
                for way in ("uniform", "adaptive"):
                    more = ["--shadow-rays", str(rays), "--light-sampling", way]
                    out, ms = frame(way, [*shining, *more])
                    cost[way] = (rel_mse(out, truth), ms)
                (u, u_ms), (a, a_ms) = cost["uniform"], cost["adaptive"]
                print(
                    f"{name}, {rays} rays: squared error {u:.3g} against {a:.3g}, "
                    f"{u_ms:.0f} ms against {a_ms:.0f} ms: gain {u * u_ms / (a * a_ms):.2f}"
                )


if __name__ == "__main__":
    main()
