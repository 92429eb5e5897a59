"""How much a model jumps from cell to cell: python3 tests/seams.py RUN [ROWS_A_CELL]

The seam columns of model/metrics.arrow once more, with numpy alone, beside the program
(tests/python/nets.py), as schemas/metrics.toml says; and what they come to over the whole run, rows of each cell
weighed by its share of it, all relative to max(channel mean, ε):

- jump: root mean square and median of the difference between the two nets, where they meet;
- change: the same of how much the cell's own net changes from the face to a tenth of the cell inwards;
- error of the model at the rows near a face and at all rows (free of Monte Carlo noise);
- the same of rows near a face if the net beyond it is blended in, everywhere or where the two agree.

Two nets with independent errors of the size near a face differ by sqrt(2) times that error.
"""

import json
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE / "python"))
import nets  # noqa: E402
import rrf_truth  # noqa: E402
from split import held_out  # noqa: E402

RAW = [a + b for a in "pnvl" for b in "xyz"]
RAW += ["base_r", "base_g", "base_b", "roughness", "metallic", "specular"]
AXES = [RAW.index(a + b) for a in "pvl" for b in "xyz"]
NEAR = 0.1
# relative difference of two nets up to which a neighbour counts in full when blended, as in field/src/borders.rs
AGREED = 0.25
ROWS = 400
RGB = "rgb"


@dataclass
class Seams:
    """Rows of a run: all that were looked at, and those of them (`at`) that meet another cell."""

    x: np.ndarray  # raw columns, [rows, 18]
    y: np.ndarray  # both halves, [2, rows, 3]
    own: np.ndarray  # cell, [rows]
    at: np.ndarray  # rows near a face that count, [near]
    away: np.ndarray  # how far from it, in sizes of the cell, [near]
    beyond: np.ndarray  # the neighbour, [near]
    mine: np.ndarray  # the own net's answer at the face, [near, 3]
    other: np.ndarray  # the neighbour's there
    inside: np.ndarray  # the own net's a tenth of the cell inwards
    divisor: np.ndarray  # [near]
    epsilon: float
    weights: dict  # the net of each cell


def read(path):
    with pa.memory_map(str(path)) as source:
        return pa.ipc.open_file(source).read_all()


def boxes(tree):
    """Low and high corner of each cell's box, infinite where nothing bounds it: cell -> [2, 18]."""
    found = {}
    waiting = [(0, np.array([[-np.inf] * 18, [np.inf] * 18]))]
    while waiting:
        at, box = waiting.pop()
        node = tree[at]
        if node["axis"] < 0:
            found[node["cell_id"]] = box
            continue
        below, above = box.copy(), box.copy()
        below[1, node["axis"]] = above[0, node["axis"]] = node["threshold"]
        waiting += [(node["left"], below), (node["right"], above)]
    return found


def named(x):
    return pa.table({name: x[:, k] for k, name in enumerate(RAW)})


def answers(weights, cells, x):
    out = np.zeros((len(x), 3))
    for cell in np.unique(cells):
        here = cells == cell
        out[here] = nets.evaluate(weights[cell], named(x[here]))
    return out


def first_held_out(folder, seed, count):
    """The cell's first rows held out, its last part first: [rows, 18] and [2, rows, 3]."""
    found, rows = [], 0
    for part in sorted(folder.glob("*.parquet"), reverse=True):
        if rows < count:
            table = pq.ParquetFile(part).read()
            raw = np.stack([table[n].to_numpy() for n in RAW], 1)
            halves = np.stack([[table[f"y{h}_{c}"].to_numpy() for c in RGB] for h in (0, 1)])
            some = held_out(seed, table["sample_index"].to_numpy()) & np.isfinite(raw).all(1)
            found.append((raw[some], np.moveaxis(halves, 1, 2)[:, some].astype(float)))
            rows += some.sum()
    x, y = np.concatenate([x for x, _ in found]), np.concatenate([y for _, y in found], 1)
    return x[:count], y[:, :count]


def moved(x, faces, span):
    """Rows near a face; how far away; they moved to their side of it, beyond it, and inwards."""
    size = (span[:, 1] - span[:, 0]).astype(float)
    with np.errstate(divide="ignore", invalid="ignore"):
        away = abs(x[:, None].astype(float) - faces) / size[:, None]
    away[:, :, [k for k in range(18) if k not in AXES]] = np.inf
    away[(size[:, None] <= 0).repeat(2, 1)] = np.inf
    flat = away.reshape(len(x), -1)
    nearest = flat.argmin(1)
    at = np.flatnonzero(flat.min(1) < NEAR)
    low, axis = nearest[at] < 18, nearest[at] % 18
    above = faces.reshape(len(x), -1)[at, nearest[at]].astype(np.float32)
    below = np.nextafter(above, np.float32(-np.inf))
    own, beyond = np.where(low, above, below), np.where(low, below, above)
    within = own + np.where(low, NEAR, -NEAR) * size[at, axis]
    rows = [x[at].copy() for _ in range(3)]
    for row, place in zip(rows, (own, beyond, within.astype(np.float32))):
        row[np.arange(len(at)), axis] = place
    return at, flat[at, nearest[at]], rows


def seams(run, count=ROWS):
    run = Path(run)
    table, manifest = read(run / "model/tree.arrow"), json.loads((run / "run.json").read_text())
    plan = json.loads(sorted((run / "rounds").glob("*/judged.json"))[-1].with_name("plan.json").read_text())
    mean = float(np.float32(plan["mean_luminance"]))
    epsilon = manifest["config"]["train"]["epsilon"] * mean if mean > 0 else 1.0
    weights = {net["cell_id"]: net for net in read(run / "model/weights.arrow").to_pylist()}
    tree = table.to_pylist()
    box = boxes(tree)
    spans = {n["cell_id"]: np.array([n["domain_min"], n["domain_max"]]) for n in tree if n["axis"] < 0}
    rows = [first_held_out(run / f"samples/cell={cell:06d}", manifest["seed"], count) for cell in weights]
    x, y = np.concatenate([x for x, _ in rows]), np.concatenate([y for _, y in rows], 1)
    own = np.repeat(list(weights), [len(x) for x, _ in rows])
    each = lambda of, cells: np.array([of[cell] for cell in cells]).reshape(-1, 2, 18)
    at, away, (here, over, within) = moved(x, each(box, own), each(spans, own))
    # a face may be where one object ends and another begins: no seam, the nets never meet there
    beyond = nets.leaf(table, named(over))
    low, high = np.moveaxis(each(spans, beyond), 1, 0)
    slack = 0.05 * (high - low) + 1e-4 * abs(high + low)
    meet = ((low - slack <= over) & (over <= high + slack)).all(1)
    at, away, here, over, within, beyond = (a[meet] for a in (at, away, here, over, within, beyond))
    mine, inside = (answers(weights, own[at], rows.astype(float)) for rows in (here, within))
    other = answers(weights, beyond, over.astype(float))
    divisor = rrf_truth.level((mine + other) / 2, epsilon)
    x = x.astype(float)
    return Seams(x, y, own, at, away, beyond, mine, other, inside, divisor, epsilon, weights)


def sizes(found):
    """Of each row that counts, root mean square over the channels of its jump and of its change."""
    of = lambda other: (((found.mine - other) / found.divisor[:, None]) ** 2).mean(1) ** 0.5
    return of(found.other), of(found.inside)


def columns(found):
    """The seam columns of every cell."""
    both = dict(zip(("jump", "change"), sizes(found)))
    for cell in found.weights:
        here = found.own[found.at] == cell
        row = {"cell_id": cell, "seam_rows": int(here.sum())}
        for name, of in both.items():
            some = here.any()
            row[f"seam_{name}"] = float((of[here] ** 2).mean() ** 0.5) if some else None
            row[f"seam_{name}_median"] = float(np.median(of[here])) if some else None
        yield row


def main(run, rows_a_cell=ROWS):
    found = seams(run, int(rows_a_cell))
    x, y, own, at = found.x, found.y, found.own, found.at
    last = sorted((Path(run) / "rounds").glob("*/judged.json"))[-1]
    judged = {c["cell"]: c["measure"] for c in json.loads(last.read_text())["judgement"]["cells"]}
    weight = np.array([judged[cell] for cell in own]) / np.bincount(own)[own]
    print(f"{len(found.weights)} cells, {len(x)} rows, {len(at) / len(x):.0%} of them within a tenth of a cell of a face")
    for name, of in zip(("jump across faces", "change over a tenth of a cell"), sizes(found)):
        rms = (weight[at] @ of**2 / weight[at].sum()) ** 0.5
        print(f"{name:30} {rms:.2%}, median {np.median(of):.2%}")
    p = answers(found.weights, own, x)
    level = rrf_truth.level(y.mean(0), found.epsilon)
    square = rrf_truth.by_halves(p, y, level)
    error = lambda s, w: rrf_truth.error(s, w)[0]
    print(f"error near faces               {error(square[at], weight[at]):.2%}  (all rows {error(square, weight):.2%})")
    # the neighbour's net counts for half at the face and nothing a margin inwards
    other = answers(found.weights, found.beyond, x[at])
    mean = rrf_truth.level((p[at] + other) / 2, found.epsilon)
    apart = (((p[at] - other) / mean[:, None]) ** 2).mean(1) ** 0.5
    everywhere, agreed = np.ones(len(at)), np.clip(2 - apart / AGREED, 0, 1)
    for margin in (0.05, 0.1):
        for name, trust in (("", everywhere), (", where they agree", agreed)):
            share = (np.maximum(0.5 * (1 - found.away / margin), 0) * trust)[:, None]
            q, rows = (1 - share) * p[at] + share * other, found.away < margin
            blended = rrf_truth.by_halves(q, y[:, at], level[at])
            before, after = (error(s[rows], weight[at][rows]) for s in (square[at], blended))
            print(f"blended within {margin:.0%} of a cell{name}: {before:.2%} -> {after:.2%}")


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    main(*sys.argv[1:])
