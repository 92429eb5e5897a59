#!/usr/bin/env python3
"""Files that others wrote, and what is right for each: see the README beside them.

Those in `tests/data/cases` are a part of a larger collection, whose folder may be given instead; what is
missing there is said and left out. `--bakes` adds rooms that have to be baked, a minute on two cores.

    python3 tests/cases.py
    python3 tests/cases.py --bakes FOLDER
"""

import argparse
import json
import re
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent / "runs"))
import runs  # noqa: E402

CASES = runs.ROOT / "tests/data/cases"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, nargs="?", default=CASES)
    parser.add_argument("--bakes", action="store_true", help="bake the rooms too")
    options = parser.parse_args()
    passed, failed, missing = 0, 0, []
    with tempfile.TemporaryDirectory(prefix="rrf-cases-") as scratch:
        for name, check in [*SCENES.items(), *FILES.items(), *(BAKES.items() if options.bakes else ())]:
            path = options.folder / name
            if not path.exists():
                missing.append(name)
                continue
            wrong = check(path, Path(scratch))
            print(f"{name}: {wrong or 'right'}", flush=True)
            passed, failed = passed + (not wrong), failed + bool(wrong)
    if missing:
        print(f"not in {options.folder}: {', '.join(missing)}")
    print(f"{passed} passed, {failed} failed")
    sys.exit(failed)


def said(*words, codes=(0,)):
    """Exit code, standard output and standard error of a command line."""
    import subprocess

    done = subprocess.run([str(runs.program()), *map(str, words)], capture_output=True, text=True, timeout=300)
    wrong = "" if done.returncode in codes else f"exit code {done.returncode}: {done.stderr.strip()}"
    return wrong, done.stdout, done.stderr


def scene(*patterns, absent=(), refused=False):
    """A scene that is read, or refused, with these in what is said about it."""

    def check(path, _):
        wrong, out, errors = said("scene", path, codes=(2,) if refused else (0,))
        text = out + errors
        for pattern in patterns:
            if not wrong and not re.search(pattern, text):
                wrong = f"no match of {pattern!r} in\n{text}"
        for pattern in absent:
            if not wrong and re.search(pattern, text):
                wrong = f"a match of {pattern!r} in\n{text}"
        return wrong

    return check


def compared(words, *more):
    """Two pictures that can be compared, or are refused for a reason."""

    def check(path, _):
        wrong, out, errors = said("compare", path, path.parent / "base.exr", *more)
        return wrong or ("" if re.search(words, out + errors) else f"no match of {words!r} in\n{out}{errors}")

    return check


def empty_table(path, scratch):
    run = scratch / "cornell"
    runs.call(*runs.bake(run))
    output = scratch / "empty-out.parquet"
    wrong, out, _ = said("query", run, "--points", path, "-o", output)
    return wrong or ("" if output.exists() and re.match("0 rows|0 points", out) else f"says: {out}")


def white(path, scratch):
    """A closed room that loses no energy is refused before anything starts."""
    for method in ("nets", "transfer"):
        run = scratch / f"{path.parent.name}-{method}"
        wrong, _, errors = said("bake", path, "-o", run, "--rows", "4000", "--method", method, codes=(2,))
        if wrong or "no surface absorbs light" not in errors or run.exists():
            return wrong or f"says {errors}"
    return ""


def room(path, scratch, *settings):
    """Relative error of a bake of nets, per cent."""
    run = scratch / f"{path.parent.name}-{path.stem}-{len(settings)}"
    wrong, out, _ = said("bake", "--quiet", path, "-o", run, "--method", "nets", *settings)
    if wrong:
        raise SystemExit(f"{path}: {wrong}")
    return float(re.search(r"relative error: ([\d.]+) %", out).group(1)), run


def overlapping(path, scratch):
    """Slabs that overlap or touch: within a half of each other's error with the preview's settings."""
    errors = [room(path.with_name(f"slab-{kind}.glb"), scratch, "--preset", "preview")[0] for kind in ("overlap", "touch")]
    return "" if max(errors) < 1.5 * min(errors) else f"relative errors {errors} %"


def inside_solid(path, scratch):
    """A light within boxes that interpenetrate is refused, and one beside them is not."""
    settings = "--rows 2000 --cells 2 --most-cells 2 --paths 8 --rounds 1".split()
    _, run = room(path, scratch, *settings, "--light-box=-1.5,-1.5,-1.5,1.5,1.5,1.5")
    for light, inside in (("0.01,0.02,0.03", True), ("1.5,1.5,1.5", False)):
        view = ["--eye=0,1,1.9", "--look-at=0,0,0", "--size=16x16", "-o", scratch / "sofa.png"]
        wrong, out, errors = said("render", run, *view, f"--light={light}", codes=(2,) if inside else (0,))
        if wrong or inside != ("inside a solid" in out + errors):
            return wrong or f"light {light}: {out}{errors}"
    return ""


def two_rooms(path, scratch):
    """The room without light is dark, or not trusted, up to the wall at x = 1."""
    try:
        import pyarrow as pa
        import pyarrow.parquet as pq
    except ImportError:
        return "pyarrow is needed: run it with .venv/bin/python"
    _, run = room(path, scratch, "--light-box=-0.8,0.2,-0.8,0.8,1.8,0.8", "--preset", "preview")
    # the floor and the ceiling of the dark room, from its wall on, seen from its middle
    places = [(1 + d, y, 0.1 * k) for d in (0.002, 0.01, 0.03, 0.1, 0.5) for y in (0, 2) for k in range(-8, 9)]
    rows = [(x, y, z, 0, 1 - y, 0, 1.5 - x, 1 - y, -z, 0.1, 1.0, 0.2, 0.7, 0.7, 0.7) for x, y, z in places]
    names = "px py pz nx ny nz vx vy vz lx ly lz base_r base_g base_b".split()
    table = {name: pa.array([float(row[k]) for row in rows], pa.float32()) for k, name in enumerate(names)}
    for name, value in (("roughness", 1.0), ("metallic", 0.0), ("specular", 0.0)):
        table[name] = pa.array([value] * len(rows), pa.float32())
    pq.write_table(pa.table(table), scratch / "dark.parquet")
    wrong, _, _ = said("query", run, "--points", scratch / "dark.parquet", "-o", scratch / "dark-out.parquet")
    if wrong:
        return wrong
    found = pq.read_table(scratch / "dark-out.parquet").to_pydict()
    trusted = found.get("trusted", [True] * len(rows))
    lit = [p for p, r, g, b, t in zip(places, *(found[c] for c in "rgb"), trusted) if t and r + g + b > 1e-3]
    return f"{len(lit)} of {len(rows)} places are lit, as {lit[0]}" if lit else ""


AREA = r"area {:.6f}"
SCENES = {
    "obj/cp1251/a.obj": scene(r"materials +3\b"),
    "obj/dart/a.obj": scene(AREA.format(1.8)),
    "obj/bom/a.obj": scene(r"0\.800 0\.100 0\.100"),
    "obj/twolibs/a.obj": scene(r"0\.800 0\.100 0\.100"),
    "obj/libback/a.obj": scene(r"0\.800 0\.100 0\.100"),
    "obj/texcase/a.obj": scene("colour texture 0"),
    "obj/kd0.obj": scene("colour texture 0", r"kd0\.mtl:1"),
    "obj/tga.obj": scene("colour texture 0"),
    "obj/mir.obj": scene(r"principled +1\.000 1\.000 1\.000|mirror|conductor", absent=["read as Lambert"]),
    "gltf/bom/a.gltf": scene(r"triangles +2\b"),
    "gltf/matrix_rounded/a.gltf": scene(r"triangles +2\b"),
    "gltf/uri_rawpct20/a.gltf": scene(r"triangles +2\b"),
    "gltf/tex_nosource/a.gltf": scene(r"triangles +2\b"),
    "gltf/BoxDraco.gltf": scene("Draco", "export without it", refused=True),
    "pbrt/undefined_named/a.pbrt": scene("lambert +0.500", "Sun_Light"),
    "pbrt/gz/s.pbrt": scene(r"triangles +1\b"),
    "pbrt/inc/s.pbrt": scene(r"triangles +1\b"),
    "pbrt/nest.pbrt": scene(r"triangles +1\b", r"nest\.pbrt:8"),
    "bake/t5e6/a.obj": scene("from the origin", refused=True),
    "bake/lost_textures/a.obj": scene("colour texture 0", r"wall\.png is read from"),
    "bake/coplanar_lamp/a.obj": scene(r"in the plane of .*\"ceil\""),
    "bake/white/a.obj": scene("no surface absorbs light"),
    "bake/gltfwhite_gloss/a.gltf": scene("no surface absorbs light"),
    "rooms/slab-touch.glb": scene(r"triangles +72\b"),
}
FILES = {
    "exr/crop.exr": compared("relative"),
    "exr/overscan.exr": compared("relative"),
    "exr/multi2.exr": compared("relative"),
    "data/empty.parquet": empty_table,
}
BAKES = {
    "rooms/sofa3.glb": inside_solid,
    "bake/white/a.obj": white,
    "bake/gltfwhite_gloss/a.gltf": white,
    "rooms/slab-overlap.glb": overlapping,
    "bake/tworooms/a.obj": two_rooms,
}


if __name__ == "__main__":
    main()
