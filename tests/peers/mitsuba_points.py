"""Extraction against Mitsuba 3 (`llvm_ad_rgb`): variance x time at the rows of a points table.

    sh tests/peers/setup.sh
    cargo build --release
    .venv-peers/bin/python tests/peers/mitsuba_points.py

Runs of both programs alternate, on the same cores, with the same number of paths a row; what is
compared is defined in efficiency.py, what Mitsuba does in mitsuba_rays.py. Every program's mean is
held against the table: one that estimates something else fails the whole comparison.
"""

import argparse
import json
import os
import platform
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
ORACLE = ROOT / "tests/data/oracle"
sys.path.insert(0, str(HERE))

from efficiency import ERROR, RADIANCE, Points, columns  # noqa: E402
from efficiency import agreement, ratio_interval, relative_variance  # noqa: E402
from pbrt_room import read_room  # noqa: E402


@dataclass
class Program:
    """A way to make the estimates, and what its runs gave."""

    name: str
    run: object  # seed -> [n, 3]
    spp: int
    same_lights: bool = True  # whether it estimates the table, or only shows a rate
    seconds: list[float] = field(default_factory=list)
    core_seconds: list[float] = field(default_factory=list)  # of all threads and child processes
    estimates: list[np.ndarray] = field(default_factory=list)

    def measure(self, seed: int):
        start, work = time.perf_counter(), sum(os.times()[:4])
        estimate = self.run(seed)
        self.seconds.append(time.perf_counter() - start)
        self.core_seconds.append(sum(os.times()[:4]) - work)
        self.estimates.append(estimate)


def rrf_program(binary: Path, scene: Path, table: Path, estimator: str, scratch: Path):
    """`rrf trace --points` as a function of (spp, seed), and the standard errors it stated."""
    stated = []

    def run(spp: int, seed: int) -> np.ndarray:
        out = scratch / f"rrf-{spp}-{seed}.parquet"
        command = [binary, "trace", scene, "--points", table, "-o", out]
        command += ["--estimator", estimator, "--spp", str(spp), "--seed", str(seed), "--quiet"]
        subprocess.run(list(map(str, command)), check=True, stdout=subprocess.DEVNULL)
        result = pq.read_table(out)
        stated.append(columns(result, ERROR))
        return columns(result, RADIANCE)

    return run, stated


def summary(program: Program, points: Points) -> dict:
    """A row of the results."""
    seconds = float(np.median(program.seconds))
    row = {"program": program.name, "spp": program.spp, "seconds": program.seconds}
    row |= {"core_seconds": program.core_seconds, "median_seconds": seconds}
    row["median_core_seconds"] = float(np.median(program.core_seconds))
    row["paths_per_second"] = len(points.light) * program.spp / seconds
    if program.same_lights:
        runs = np.array(program.estimates)
        variance = relative_variance(runs, points.scale())
        row["relative_variance"] = float(variance.mean())
        row["efficiency_seconds"] = float(variance.mean()) * seconds
        row["median_row_efficiency_seconds"] = float(np.median(variance)) * seconds
        row["agreement"] = agreement(runs, points)
    return row


def machine() -> dict:
    """What the figures belong to."""
    lines = Path("/proc/cpuinfo").read_text().splitlines()
    fact = lambda key: next((l.split(":")[1].strip() for l in lines if l.startswith(key)), "")
    flags = fact("flags").split()
    simd = next((s for s in ("avx512f", "avx2", "avx") if s in flags), "")
    name = fact("model name") or platform.processor() or platform.machine()
    return {"cpu": name, "simd": simd, "cores": len(os.sched_getaffinity(0))}


def compared(ours: Program, theirs: Program, points: Points) -> dict:
    """E of ours over E of theirs: below 1, ours is better."""
    a, b = (relative_variance(np.array(p.estimates), points.scale()) for p in (ours, theirs))
    time_ratio = float(np.median(ours.seconds) / np.median(theirs.seconds))
    result = {"peer": theirs.name, "ratio": float(a.mean() / b.mean()) * time_ratio}
    result["interval_95"] = ratio_interval(a, b, (ours.seconds, theirs.seconds))
    result["variance_ratio"] = float(a.mean() / b.mean())
    result["time_ratio"] = time_ratio
    result["core_time_ratio"] = float(np.median(ours.core_seconds) / np.median(theirs.core_seconds))
    result["median_row_ratio"] = float(np.median(a) / np.median(b)) * time_ratio
    return result


def report(results: dict) -> str:
    """The table for people."""
    box = results["machine"]
    lines = [
        f"{box['cpu']} {box['simd']}, {box['cores']} cores; load average "
        f"{results['load'][0]:.1f} before, {results['load'][1]:.1f} after",
        f"Mitsuba {results['mitsuba']}, llvm_ad_rgb, {Path(results['llvm']).name}",
        f"{results['points']}: {results['rows']} rows; {results['runs']} alternating runs, medians",
        "",
    ]
    heads = ("spp", "s", "core s", "M paths/s", "E [ms]", "median row")
    lines.append(f"{'program':<34}" + "".join(f"{head:>12}" for head in heads) + "  largest z")
    for p in results["programs"]:
        figures = [p["median_seconds"], p["median_core_seconds"], p["paths_per_second"] / 1e6]
        verdict = ""
        if "agreement" in p:
            keys = ("efficiency_seconds", "median_row_efficiency_seconds")
            figures += [p[key] * 1e3 for key in keys]
            test = p["agreement"]
            verdict = f"{test['largest_z']:>6.2f} {'agrees' if test['passes'] else 'DIFFERS'}"
            verdict += "" if test["passes"] else f", bias {test['bias']:.4f}"
        line = f"{p['program']:<34}{p['spp']:>12}" + "".join(f"{x:>12.3f}" for x in figures)
        lines.append(line + verdict)
    for r in results["ratios"]:
        low, high = r["interval_95"]
        lines += [
            "", f"rrf over {r['peer']}: E {r['ratio']:.3f} [{low:.3f}, {high:.3f}]",
            f"  variance {r['variance_ratio']:.3f} x time {r['time_ratio']:.3f} "
            f"(core time {r['core_time_ratio']:.3f}); E of the median row "
            f"{r['median_row_ratio']:.3f}",
        ]
    if "rrf_start_up_seconds" in results:
        lines += [
            "", f"rrf with 16 paths a row: {results['rrf_start_up_seconds']:.3f} s, counted above; "
            f"its stated variance over its spread: {results['rrf_stated']:.3f}",
        ]
    return "\n".join(lines)


def write_page(page: Path, text: str):
    """Puts the figures between the page's two markers."""
    begin, end = "<!-- figures: begin -->\n", "<!-- figures: end -->"
    before, rest = page.read_text().split(begin)
    after = rest.split(end)[1]
    page.write_text(f"{before}{begin}```text\n{text}\n```\n{end}{after}")


def options():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rrf", type=Path, default=ROOT / "target/release/rrf")
    parser.add_argument("--estimator", default="connected", help="of rrf: connected, as extraction, or next-event")
    parser.add_argument("--no-rrf", action="store_true", help="Mitsuba alone")
    parser.add_argument("--scene", type=Path, default=ROOT / "scenes/cornell-box/scene.pbrt")
    parser.add_argument("--points", type=Path, default=ORACLE / "cornell_overhead.parquet")
    paths = "paths a row in one run: a multiple of 16, a square suits multijitter"
    parser.add_argument("--spp", type=int, default=1024, help=paths)
    parser.add_argument("--runs", type=int, default=8, help="at least 5")
    parser.add_argument("--json", type=Path, help="results, machine-readable")
    parser.add_argument("--page", type=Path, help="put the figures into this page: docs/science/peers.md")
    args = parser.parse_args()
    if args.runs < 5 or args.spp < 16:
        parser.error("--runs has to be at least 5, --spp at least 16")
    if not args.no_rrf and not args.rrf.is_file():
        parser.error(f"{args.rrf}: no such program; cargo build --release, or --rrf, or --no-rrf")
    return args


def main() -> int:
    args = options()
    library = ROOT / ".venv-peers/libllvm"
    if "DRJIT_LIBLLVM_PATH" not in os.environ and library.is_file():
        os.environ["DRJIT_LIBLLVM_PATH"] = library.read_text().strip()
    import mitsuba_rays as peer  # after the library is named

    if args.page and os.getloadavg()[0] > 0.25 * len(os.sched_getaffinity(0)):
        print(f"load average {os.getloadavg()[0]:.1f}: no figures for a page from a busy machine; "
              "wait, or leave out --page", file=sys.stderr)
        return 1
    points, room, spp = Points.read(args.points), read_room(args.scene), args.spp
    load = [os.getloadavg()[0]]
    with tempfile.TemporaryDirectory() as folder:
        scratch = Path(folder)
        best, plain = "multijitter", "independent"
        programs = [
            Program(f"Mitsuba, {best}", peer.WholeTable(room, points, best, spp).run, spp),
            Program(f"Mitsuba, {plain}", peer.WholeTable(room, points, plain, spp).run, spp),
            Program(f"Mitsuba, {plain}, moved light",
                    peer.MovedLight(room, points, plain, spp).run, spp),
            Program(f"Mitsuba, {plain}, one light",
                    peer.OneLight(room, points, plain, spp).run, spp, same_lights=False),
        ]
        stated = []
        if not args.no_rrf:
            trace, stated = rrf_program(args.rrf, args.scene, args.points, args.estimator, scratch)
            programs.insert(0, Program("rrf trace --points", lambda seed: trace(spp, seed), spp))
        for program in programs:
            program.run(0)  # kernels compiled, files in the cache
        stated.clear()
        for seed in range(1, args.runs + 1):
            for program in programs:
                program.measure(seed)
        load.append(os.getloadavg()[0])
        results = {
            "machine": machine(), "mitsuba": peer.mi.__version__,
            "llvm": os.environ.get("DRJIT_LIBLLVM_PATH", "found by Dr.Jit"), "load": load,
            "points": args.points.name, "rows": len(points.light), "runs": args.runs,
            "programs": [summary(p, points) for p in programs], "ratios": [],
        }
        if not args.no_rrf:
            ours = programs[0]
            results["ratios"] = [compared(ours, p, points) for p in programs[1:] if p.same_lights]
            spread = np.array(ours.estimates).var(axis=0, ddof=1) / points.scale() ** 2
            said = np.mean(np.square(stated), axis=0) / points.scale() ** 2
            results["rrf_stated"] = float(said.mean() / spread.mean())
            starts = []
            for seed in range(5):
                begin = time.perf_counter()
                trace(16, seed)
                starts.append(time.perf_counter() - begin)
            results["rrf_start_up_seconds"] = float(np.median(starts))
    text = report(results)
    print(text)
    if args.page:
        write_page(args.page, text)
    if args.json:
        args.json.write_text(json.dumps(results, indent=1) + "\n")
    tests = [p["agreement"] for p in results["programs"] if "agreement" in p]
    return 0 if all(test["passes"] for test in tests) else 1


if __name__ == "__main__":
    sys.exit(main())
