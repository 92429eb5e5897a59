"""Whether a bake has more model than its target asks for:
.venv/bin/python tests/parsimony.py [SCENE ...] [--bakes TEXT ...] [--rrf F] [--work DIR]

Bakes a scene to its target (seed 1, --preset standard; a run that lies in DIR/SCENE is taken as it is), then does without one
part at a time: without the last round's splits; and, of the finished model, with all nets fitted anew to the same rows, each net
of the next smaller size or without a group of inputs, beside nets fitted anew with nothing missing. A part earns its keep where the
error on test rows without it, with its standard error, is above the target, which is what ends a bake.

--bakes makes whole bakes with other parts, those of whose names have one of the texts in them, in as many rounds of splits, untrimmed,
within the row's time limit: smaller layers, fewer inputs, and what bakes do without (the normal where the place tells it, direction and
distance to the light). Prints a table. Needs pyarrow.
"""

import argparse
import json
import shutil
import subprocess
import sys
from pathlib import Path

import pyarrow as pa

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
GLOSSY = LAYERS | {
    "no normal": without(WAY + NORMAL),
    "no viewer": without(WAY + VIEWER),
    "direction and distance to the light as well": without([]),
}
PARTS = {"glossy": GLOSSY}
# inputs that cells have, without glossy rows and with them
GROUPS = [
    {"place": PLACE, "light": LIGHT},
    {"place": PLACE, "light": LIGHT, "viewer": VIEWER, "normal and material": NORMAL + MATERIAL},
]


# hidden layers that cells may get, from small to large (`train/src/config.rs`)
LADDER = [[], [4], [8, 4], [12, 8], [20, 10], [32, 16]]


def weights_of(sizes):
    return sum((below + 1) * above for below, above in zip(sizes, sizes[1:]))


def next_smaller(sizes):
    smaller = [h for h in LADDER if weights_of([sizes[0], *h, 3]) < weights_of(sizes)]
    return smaller[-1] if smaller else sizes[1:-1]


def fitted_anew(args, finished, name, hidden, group):
    """The finished run with one round more, which fits all nets anew: hidden layers by their sizes, without a group of inputs."""
    folder = args.work / name
    if not folder.exists():
        shutil.copytree(finished, folder)
        last = sorted((folder / "rounds").iterdir())[-1]
        judged, plan, run = (
            json.loads(path.read_text()) for path in (last / "judged.json", last / "plan.json", folder / "run.json")
        )
        (last / "judged.json").write_text(json.dumps(judged | {"stop": None}))
        train = run["config"]["train"]
        train["inputs"] = [name for name in train["inputs"] if name not in group]
        (folder / "run.json").write_text(json.dumps(run))
        with pa.OSFile(str(finished / "model/weights.arrow")) as file:
            layers = pa.ipc.open_file(file).read_all()["layers"].to_pylist()
        number = plan["round"] + 1
        for cell, sizes in zip(plan["cells"], layers):
            cell.update({"size": {"Hidden": hidden(sizes)}, "fitted": number}, earlier=None, prune=None)
        (folder / f"rounds/{number:03d}").mkdir()
        (folder / f"rounds/{number:03d}/plan.json").write_text(json.dumps(plan | {"round": number, "trims": None}))
        done = subprocess.run([str(args.rrf), "train", folder, "-q"], capture_output=True, text=True)
        if done.returncode:
            sys.exit(done.stderr[-2000:])
    return rounds_of(folder)[-1]


def rounds_of(folder):
    """Error on test rows, its standard error, cells and weights after each round that is committed."""
    rounds = sorted((folder / "rounds").glob("*/judged.json"))
    found = [json.loads(path.read_text())["judgement"] for path in rounds]
    weights = [sum(cell["weights"] for cell in judged["cells"]) for judged in found]
    return [
        (judged["test"]["relative_error"], judged["test"]["relative_error_se"], len(judged["cells"]), count)
        for judged, count in zip(found, weights)
    ]


def bake(args, name, scene, box, target, options):
    """What `rounds_of` says of each round of splits, and of the finished model."""
    folder = args.work / name
    if not (folder / "model" / "weights.arrow").exists():
        command = [args.rrf, "bake", HERE.parent / scene, "-o", folder, "--method", "nets", f"--light-box={box}", "-q"]
        command += ["--target", target, "--seed", 1, "--preset", "standard", *options]
        done = subprocess.run([str(c) for c in command], capture_output=True, text=True)
        if done.returncode:
            sys.exit(done.stderr[-2000:])
    rounds = sorted((folder / "rounds").glob("*/judged.json"))
    trims = ["trims" in json.loads(path.with_name("plan.json").read_text()) for path in rounds]
    each = rounds_of(folder)
    return [row for row, trimmed in zip(each, trims) if not trimmed], each[-1]


def before_last(rounds):
    """The last round that had fewer cells."""
    return [found for found in rounds if found[2] < rounds[-1][2]][-1]


def row(what, found, target):
    error, se, cells, weights = found
    met = "met" if error + se <= target else "missed"
    print(f"| {what} | {error:.2%} ± {se:.2%} | {cells} | {weights:,} | {met} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("scenes", nargs="*", default=["overhead"])
    parser.add_argument("--bakes", nargs="*", help="texts in the names of the whole bakes to make")
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
        if whole[0][2] < whole[-1][2]:
            row("without the last round of splits", before_last(whole), target)
        finished = args.work / scene
        anew = [("fitted anew", lambda sizes: sizes[1:-1], []), ("each net a size smaller", next_smaller, [])]
        anew += [(f"without {what}", lambda sizes: sizes[1:-1], group) for what, group in GROUPS[scene == "glossy"].items()]
        for what, hidden, group in anew:
            name = f"{scene}-{what.replace(' ', '-')}"
            row(what, fitted_anew(args, finished, name, hidden, group), target)
        for what, options in PARTS.get(scene, LAMBERTIAN).items():
            if not any(text in what for text in args.bakes or []):
                continue
            name = f"{scene}-bake-{what.replace(' ', '-')}"
            same = ["--rounds", len(whole), "--no-trim"]
            fewer, _ = bake(args, name, file, box, target, [*always, *same, *options])
            row(f"bake: {what}", fewer[-1], target)


if __name__ == "__main__":
    main()
