"""Whether a bake has more model than its target asks for:
python3 tests/parsimony.py [SCENE ...] [--parts TEXT ...] [--rrf F] [--work DIR]

Bakes a scene to its target (seed 1, --preset standard), then does without one part at a time, in as many
rounds of splits, untrimmed and without a time limit: without the last round's splits, with smaller layers, without a group of
inputs; and with what the bake does without: nets as they were before trimming, direction and distance to the light
in Lambertian cells. A part earns its keep where the error without it, with its standard error, is above the target, which is
what ends a bake. Prints a table; --parts bakes only those
whose names have one of the texts in them.
"""

import argparse
import json
import subprocess
import sys
from pathlib import Path

from accuracy import SCENES

HERE = Path(__file__).resolve().parent
PLACE, NORMAL, VIEWER = ["px", "py", "pz"], ["nx", "ny", "nz"], ["vx", "vy", "vz"]
LIGHT, TOWARD, DISTANCE = ["lx", "ly", "lz"], ["dx", "dy", "dz"], ["inv_distance"]
MATERIAL = ["base_r", "base_g", "base_b", "roughness", "metallic", "specular"]
ALL = PLACE + NORMAL + VIEWER + LIGHT + MATERIAL + TOWARD + DISTANCE


def without(group):
    return ["--inputs", ",".join(name for name in ALL if name not in group)]


WAY = TOWARD + DISTANCE
LAYERS = {
    "layers of 16 and 8 units": ["--hidden", "16,8"],
    "layers of 12 and 8 units": ["--hidden", "12,8"],
}
LAMBERTIAN = LAYERS | {
    "no normal": without(WAY + NORMAL),
    "no position": without(WAY + PLACE),
    "no light": without(WAY + LIGHT),
    "direction and distance to the light as well": without([]),
}
# as many inputs as cells with glossy rows have
GLOSSY = LAYERS | {
    "no normal": without(NORMAL),
    "no viewer": without(VIEWER),
    "no direction and distance to the light": without(WAY),
}
PARTS = {"glossy": GLOSSY}


def bake(args, name, scene, box, target, options):
    """Error on test rows, its standard error, cells and weights after each round of splits, and of the finished model."""
    folder = args.work / name
    if not (folder / "model" / "weights.arrow").exists():
        command = [args.rrf, "bake", HERE.parent / scene, "-o", folder, f"--light-box={box}", "-q"]
        command += ["--target", target, "--seed", 1, "--preset", "standard", *options]
        done = subprocess.run([str(c) for c in command], capture_output=True, text=True)
        if done.returncode:
            sys.exit(done.stderr[-2000:])
    rounds = sorted((folder / "rounds").glob("*/judged.json"))
    trims = ["trims" in json.loads(path.with_name("plan.json").read_text()) for path in rounds]
    found = [json.loads(path.read_text())["judgement"] for path in rounds]
    weights = [sum(cell["weights"] for cell in judged["cells"]) for judged in found]
    each = [
        (judged["test"]["relative_error"], judged["test"]["relative_error_se"], len(judged["cells"]), count)
        for judged, count in zip(found, weights)
    ]
    return [row for row, trimmed in zip(each, trims) if not trimmed], each[-1]


def row(what, found, target):
    error, se, cells, weights = found
    met = "met" if error + se <= target else "missed"
    print(f"| {what} | {error:.2%} ± {se:.2%} | {cells} | {weights:,} | {met} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("scenes", nargs="*", default=["overhead"])
    parser.add_argument("--parts", nargs="*", help="texts in the names of the parts to do without")
    parser.add_argument("--rrf", default=HERE.parent / "target" / "release" / "rrf")
    parser.add_argument("--work", type=Path, default=HERE.parent / "target" / "parsimony")
    args = parser.parse_args()
    for scene in args.scenes:
        file, box, target, always = SCENES[scene][:4]
        whole, last = bake(args, scene, file, box, target, always)
        print(f"{scene}, target {target:.1%}, {len(whole)} rounds of splits\n")
        print("| | error on test rows | cells | weights | target |\n|---|---|---|---|---|")
        row("the bake", last, target)
        row("before trimming", whole[-1], target)
        if len(whole) > 1:
            row("without the last round of splits", whole[-2], target)
        patient = always[: always.index("--time-limit")] if "--time-limit" in always else always
        for what, options in PARTS.get(scene, LAMBERTIAN).items():
            if args.parts and not any(text in what for text in args.parts):
                continue
            name = scene + "-" + what.replace(" ", "-")
            same = ["--rounds", len(whole), "--no-trim"]
            fewer, _ = bake(args, name, file, box, target, [*patient, *same, *options])
            row(what, fewer[-1], target)


if __name__ == "__main__":
    main()
