"""How much faster a frame by the nets is than a path-traced one of equal error.

    python3 tests/peers/frame_speed.py RUN [--rrf target/release/rrf] [--light x,y,z,r,g,b]

Renders the run's own camera under one point light, by the nets (steady state, processor time of
`--json-stats`) and by path tracing with 2, 8 and 32 paths a pixel (user time of the process, its
start-up taken off by a second size). The reference has --spp paths. The error of a path-traced frame
falls as one over the square root of its paths: the number of paths with the nets' error is read
off that law, anchored at each of the three counts, and so is their time. Processor seconds,
because wall time is not one's own on a machine with other work.
"""

import argparse
import json
import pathlib
import resource
import subprocess
import tempfile


def run(command):
    """Output of a command, and the user seconds that it used."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    return done.stdout, resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("run")
    parser.add_argument("--rrf", default="target/release/rrf")
    parser.add_argument("--light", default="0.1,1.6,0.2,4,4,4")
    parser.add_argument("--size", default="512x512")
    parser.add_argument("--spp", type=int, default=1024)
    options = parser.parse_args()
    scene = json.loads((pathlib.Path(options.run) / "run.json").read_text())["scene"]
    rrf, light = options.rrf, ["--light", options.light]

    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)

        def error(frame):
            compare = [rrf, "compare", frame, folder / "reference.exr", "--json"]
            measures = json.loads(run(compare)[0])["measures"]
            return next(m["value"] for m in measures if m["name"] == "relative_error")

        def trace(name, spp, size=options.size, seed=1):
            out = folder / f"{name}.exr"
            paths = ["--spp", str(spp), "--seed", str(seed), "--size", size]
            return out, run([rrf, "trace", "-q", scene, *light, *paths, "-o", out])[1]

        trace("reference", options.spp, seed=99)
        nets, stats = folder / "nets.exr", folder / "stats.json"
        measure = ["--frames", "40", "--json-stats", stats]
        run([rrf, "render", options.run, *light, "--size", options.size, *measure, "-o", nets])
        stats = json.loads(stats.read_text())
        ours, ours_error = stats["processor_ms"] / 1e3, error(nets)
        print(f"nets: {1e3 * ours:.1f} ms of processor, relative error {ours_error:.4f}")

        start_up = trace("start", 2, "1x1")[1]
        for spp in (2, 8, 32):
            frame, seconds = trace("traced", spp)
            seconds = max(seconds - start_up, 0.0)
            # the reference's own variance is in the measured one
            square = error(frame) ** 2 / (1 + spp / options.spp)
            paths = spp * square / ours_error**2
            equal = seconds * paths / spp
            print(
                f"{spp} paths: {seconds:.2f} s of processor, relative error {square**0.5:.4f}; "
                f"the nets' error at {paths:.0f} paths, {equal:.1f} s: {equal / ours:.0f} times"
            )


if __name__ == "__main__":
    main()
