"""How much faster a frame by the nets is than a path-traced one of equal error.

    python3 tests/peers/frame_speed.py RUN [--rrf target/release/rrf] [--light x,y,z,r,g,b]

The error is that of `rrf compare` (relative_error, full light) from the run's own camera under one
point light, at --size. Two references of --spp paths with seeds of their own take their noise out:
with V the squared relative error of one reference, half of that between the two, the nets' squared
error is their mean squared error against either less V. Frames of 16, 64 and 256 paths tell how the
path tracer's squared error falls with its paths; where it meets the nets' is the equal count.

Times are processor seconds at --time-size, because wall time is not one's own on a machine with
other work: of the nets `processor_ms` of `--json-stats`, of the path tracer the user time of a frame
with 16 paths less that of one with 2, per path.
"""

import argparse
import json
import pathlib
import resource
import statistics
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "python"))
import rrf_truth  # noqa: E402


def run(command):
    """Output of a command, and the user seconds that it used."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    return done.stdout, resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


class Case:
    """One run, light and folder of frames."""

    def __init__(self, options, folder):
        run_json = json.loads((pathlib.Path(options.run) / "run.json").read_text())
        self.rrf, self.folder, self.run = options.rrf, folder, options.run
        self.scene = options.scene or run_json["scene"]
        self.light = ["--light", options.light]

    def trace(self, spp, size, seed):
        """A path-traced frame and its user seconds."""
        out = self.folder / f"{spp}-{size}-{seed}.exr"
        paths = ["--spp", str(spp), "--seed", str(seed), "--size", size]
        return out, run([self.rrf, "trace", "-q", self.scene, *self.light, *paths, "-o", out])[1]

    def nets(self, size, frames):
        """A frame by the nets and its processor seconds."""
        out, stats = self.folder / f"nets-{size}.exr", self.folder / "stats.json"
        measure = ["--frames", str(frames), "--json-stats", stats]
        run([self.rrf, "render", self.run, *self.light, "--size", size, *measure, "-o", out])
        return out, json.loads(stats.read_text())["processor_ms"] / 1e3

    def square(self, frame, reference):
        """Squared relative error."""
        compared = run([self.rrf, "compare", frame, reference, "--json"])[0]
        return rrf_truth.measures(compared)["relative_error"] ** 2


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("run")
    parser.add_argument("--rrf", default="target/release/rrf")
    parser.add_argument("--scene", help="if it is no longer where the run was baked from")
    parser.add_argument("--light", default="0.1,1.6,0.2,4,4,4")
    parser.add_argument("--size", default="128x128")
    parser.add_argument("--time-size", default="512x512")
    parser.add_argument("--spp", type=int, default=4096)
    options = parser.parse_args()

    with tempfile.TemporaryDirectory() as folder:
        case = Case(options, pathlib.Path(folder))
        references = [case.trace(options.spp, options.size, seed)[0] for seed in (98, 99)]
        noise = case.square(*references) / 2

        def against_both(frame):
            return statistics.mean(case.square(frame, r) for r in references) - noise

        nets = against_both(case.nets(options.size, 1)[0])
        print(f"references: {options.spp} paths, relative error {noise**0.5:.4f} each")
        if nets <= 0:
            sys.exit("the nets' error is below the references' noise: give more --spp")
        print(f"nets: relative error {nets**0.5:.4f}, the references' noise taken out")

        ours = case.nets(options.time_size, 60)[1]
        few, many = (
            statistics.median(case.trace(spp, options.time_size, seed)[1] for seed in (1, 2, 3))
            for spp in (2, 16)
        )
        a_path = (many - few) / 14
        print(f"{options.time_size}: nets {1e3 * ours:.1f} ms, one path a pixel {1e3 * a_path:.1f} ms")
        for spp in (16, 64, 256):
            square = against_both(case.trace(spp, options.size, 7)[0])
            paths = spp * square / nets
            print(
                f"{spp} paths: relative error {max(square, 0) ** 0.5:.4f}; the nets' at {paths:.0f} paths, "
                f"{paths * a_path:.1f} s of processor: {paths * a_path / ours:.0f} times"
            )


if __name__ == "__main__":
    main()
