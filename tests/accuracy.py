"""How accurate baked models are: .venv/bin/python tests/accuracy.py [SCENE ...] [--rrf F] [--work DIR] [--spp N]

For each scene: bakes it (seed 1, --preset standard), queries the table of another renderer where
there is one, renders held-out frames at random viewpoints and lights by the model and by `rrf
trace`, and prints one row of the table in docs/science/report.md. A run that lies in DIR already is
judged as it is. Nothing here is used for training or for choosing a setting.

The noise of the reference frames: each is traced once more from another seed with a quarter of the
paths. The difference of the two has five times the variance of the reference, whose own noise in
each measure it is, over sqrt(5).
"""

import argparse
import json
import random
import subprocess
import sys
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE / "python"))
import rrf_truth  # noqa: E402

ROOM = [(-0.9, 0.9), (0.1, 1.9), (-0.9, 0.9)]
MIDDLE = [(-0.5, 0.5), (0.5, 1.5), (-0.9, 0.0)]
# footprint corner, its two edges (x, z) and height of the Cornell box's two solids
SOLIDS = [
    ((-0.0460751, 0.573007), (0.5790841, 0.173072), (0.1703281, -0.56990235), 0.6),
    ((-0.720444, -0.473882), (0.573552, -0.199597), (0.196458, 0.5645313), 1.2),
]
CORNELL = "scenes/cornell-box/scene.pbrt"
GLOSSY = "scenes/cornell-glossy/cornell-glossy.glb"
OVERHEAD, FREE = "-0.6,1.3,-0.6,0.6,1.8,0.6", "-0.8,0.2,-0.8,0.8,1.8,0.8"
# one of the level's rooms, some 8 x 4.4 x 6.4 m
ZDM2, HALL = "scenes/zdm2/zdm2.glb", "17.5,-3,-19.3,24,0.5,-14"
IN_HALL = [(17.5, 24.0), (-3.0, 0.5), (-19.3, -14.0)]
# scene file, light box, target and further options of the bake, limit of the colour differences,
# where eyes and what they look at are, table of the other renderer
SCENES = {
    "overhead": (CORNELL, OVERHEAD, 0.05, [], 1.0, ROOM, MIDDLE, "cornell_overhead"),
    "free": (CORNELL, FREE, 0.055, ["--time-limit", 475], 1.0, ROOM, MIDDLE, "cornell_free"),
    "glossy": (GLOSSY, OVERHEAD, 0.072, ["--time-limit", 354, "--most-cells", 340], 1.5, ROOM, MIDDLE, "cornell_glossy"),
    "zdm2": (ZDM2, HALL, 0.05, [f"--eye-box={HALL}", "--time-limit", 1180], 2.0, IN_HALL, IN_HALL, None),
}
FRAMES, SEED = 8, 20130701


def run(command):
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{' '.join(map(str, command))}\n{done.stderr[-2000:]}")
    return done.stdout


def inside_solid(p):
    for (cx, cz), a, b, height in SOLIDS:
        x, z, det = p[0] - cx, p[2] - cz, a[0] * b[1] - a[1] * b[0]
        s, t = (x * b[1] - z * b[0]) / det, (a[0] * z - a[1] * x) / det
        if -0.02 < s < 1.02 and -0.02 < t < 1.02 and p[1] < height + 0.02:
            return True
    return False


def place(rng, box):
    """Uniform in a box, outside of the Cornell box's solids (which no other scene reaches)."""
    while True:
        p = [rng.uniform(*side) for side in box]
        if not inside_solid(p):
            return p


def measures(rrf, a, b):
    text = run([rrf, "compare", a, b, "--json"])
    found = json.loads(text)
    return rrf_truth.measures(text), found["exposure"]["ev"]


def views(light_box, eyes, targets):
    """Options of the held-out frames: camera and light."""
    rng = random.Random(SEED)
    low, high = light_box[:3], light_box[3:]
    for _ in range(FRAMES):
        light = place(rng, list(zip(low, high)))
        eye, target = place(rng, eyes), place(rng, targets)
        view = [f"--eye={','.join(map(str, eye))}", f"--look-at={','.join(map(str, target))}"]
        yield view + ["--fov=60", "--size=128x128", f"--light={','.join(map(str, light))}"]


def references(rrf, scene, light_box, eyes, targets, folder, spp):
    """The traced frames, those that are not there yet."""
    folder.mkdir(parents=True, exist_ok=True)
    for k, view in enumerate(views(light_box, eyes, targets)):
        for seed, name, paths in ((1, "one", spp), (2, "two", spp // 4)):
            file = folder / f"{k}-{name}-{spp}.exr"
            if not file.exists():
                run([rrf, "trace", scene, "-o", file, "--spp", paths, "--seed", seed, *view])


def frames(rrf, baked, light_box, eyes, targets, folder, spp, options):
    """Colour differences of the model and of the second tracing, frame by frame."""
    found = []
    for k, view in enumerate(views(light_box, eyes, targets)):
        model = folder / f"{k}-model.exr"
        one, two = (folder / f"{k}-{name}-{spp}.exr" for name in ("one", "two"))
        run([rrf, "render", baked, "-o", model, *view, *options])
        (error, ev), (noise, _) = measures(rrf, model, one), measures(rrf, two, one)
        found.append((error, noise, ev))
    return found


def bytes_of(folder):
    return sum(f.stat().st_size for f in folder.rglob("*") if f.is_file())


def judge(name, args):
    file, box, target, options, limit, eyes, targets, oracle = SCENES[name]
    scene, baked = HERE.parent / file, args.work / name
    args.work.mkdir(parents=True, exist_ok=True)
    corners = [float(x) for x in box.split(",")]
    folder = args.work / f"{name}-frames"
    if args.spp:
        references(args.rrf, scene, corners, eyes, targets, folder, args.spp)
    if args.references:
        return
    seconds = float("nan")
    if not (baked / "model" / "weights.arrow").exists():
        start = time.time()
        command = [args.rrf, "bake", scene, "-o", baked, "--method", "nets", f"--light-box={box}", "--target", target]
        print(run([*command, "--seed", 1, "--preset", "standard", "-q", *options]).strip())
        seconds = time.time() - start
    rounds = sorted((baked / "rounds").glob("*/judged.json"))
    judged = json.loads(rounds[-1].read_text())
    held_out = judged["judgement"]
    print(f"\n{name}: {file}, light box {box}, target {target:.1%}")
    print(f"  stopped: {judged['stop']} after {len(rounds)} rounds, {len(held_out['cells'])} cells")
    for what, found in (("test rows", held_out["test"]), ("held-out error", held_out)):
        print(f"  {what:<15} {found['relative_error']:.2%} ± {found['relative_error_se']:.2%}")
    print(f"  bake            {seconds:.0f} s,  model {bytes_of(baked / 'model') / 1000:.0f} kB")
    if oracle:
        table = HERE / "data" / "oracle" / f"{oracle}.parquet"
        answers = args.work / f"{name}.parquet"
        run([args.rrf, "query", baked, "--points", table, "-o", answers])
        judge_points = HERE / "data/oracle/judge_points.py"
        verdict = [sys.executable, judge_points, "err", table, answers, target]
        done = subprocess.run([str(c) for c in verdict], capture_output=True, text=True)
        if not done.stdout:
            sys.exit(f"{done.stderr}judging needs numpy and pyarrow: make python, then .venv/bin/python {sys.argv[0]}")
        print(f"  other renderer  {done.stdout.strip()}")
    if args.spp == 0:
        return
    found = frames(args.rrf, baked, corners, eyes, targets, folder, args.spp, args.render.split())
    for measure in [m for m in found[0][0] if m.startswith("delta_e")]:
        errors, noises = ([f[i][measure] for f in found] for i in (0, 1))
        rms = (sum(e * e for e in errors) / FRAMES) ** 0.5
        noise = (sum(e * e for e in noises) / FRAMES / 5) ** 0.5
        each = " ".join(f"{e:.2f}" for e in errors)
        print(f"  {measure:<15} {rms:.2f} (limit {limit}, reference noise {noise:.2f}); frames {each}")
    print("  exposure [stops] " + " ".join(f"{f[2]:+.1f}" for f in found) + ", sRGB, clipped")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("scenes", nargs="*", default=list(SCENES))
    parser.add_argument("--rrf", default=HERE.parent / "target" / "release" / "rrf")
    parser.add_argument("--work", type=Path, default=HERE.parent / "target" / "accuracy")
    parser.add_argument("--spp", type=int, default=2048, help="paths a pixel of references; 0: none")
    parser.add_argument("--render", default="", help="further options of rrf render, one text")
    parser.add_argument("--references", action="store_true", help="trace the references, no more")
    args = parser.parse_args()
    for name in args.scenes:
        judge(name, args)


if __name__ == "__main__":
    main()
