"""How much a model jumps from cell to cell: python3 tests/seams.py RUN [ROWS_A_CELL]

Of each cell some of its held-out samples, moved along one column onto the face of the cell's box that is
nearest (in shares of the cell's own size; faces within a tenth of it, columns of p, v and l). There
the nets of both sides answer, where the cell beyond was trained on such rows too. Told are, all relative to max(luminance, ε), ε = 5 % of the mean:

- jump: root mean square and median of the difference between the two nets, where they meet;
- change: the same of how much the cell's own net changes from the face to a tenth of the cell inwards;
- error of the model at the rows near a face and at all rows (free of Monte Carlo noise);
- the same of rows near a face if the net beyond it were blended in.

Two nets with independent errors of the size near a face differ by sqrt(2) times that error. With numpy
alone, beside the program (tests/python/nets.py).
"""

import json
import sys
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE / "python"))
import nets  # noqa: E402
from split import held_out  # noqa: E402

RAW = [a + b for a in "pnvl" for b in "xyz"]
RAW += ["base_r", "base_g", "base_b", "roughness", "metallic", "specular"]
AXES = [RAW.index(a + b) for a in "pvl" for b in "xyz"]
NEAR = 0.1
RGB = "rgb"


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


def main(run, rows_a_cell="400"):
    run, count = Path(run), int(rows_a_cell)
    table = read(run / "model/tree.arrow")
    tree = table.to_pylist()
    leaf = lambda x: nets.leaf(table, named(x))
    weights = {net["cell_id"]: net for net in read(run / "model/weights.arrow").to_pylist()}
    last = sorted((run / "rounds").glob("*/judged.json"))[-1]
    judged = {c["cell"]: c["measure"] for c in json.loads(last.read_text())["judgement"]["cells"]}
    seed = json.loads((run / "run.json").read_text())["seed"]
    x, y, own, weight, size = [], [], [], [], []
    for cell in weights:
        parts = sorted((run / f"samples/cell={cell:06d}").glob("*.parquet"))
        rows = pa.concat_tables([pq.ParquetFile(part).read() for part in parts])
        raw = np.stack([rows[n].to_numpy() for n in RAW], 1).astype(float)
        halves = [np.stack([rows[f"y{h}_{c}"].to_numpy() for c in RGB], 1).astype(float) for h in (0, 1)]
        some = np.flatnonzero(held_out(seed, rows["sample_index"].to_numpy()))
        some = some[:: max(1, len(some) // count)][:count]
        x.append(raw[some])
        y.append(np.stack([half[some] for half in halves]))
        own += [cell] * len(some)
        weight += [judged[cell] / len(some)] * len(some)
        size += [raw.max(0) - raw.min(0)] * len(some)
    x, y, size = np.concatenate(x), np.concatenate(y, 1), np.array(size)
    own, weight = np.array(own), np.array(weight)
    mean = y.mean((0, 2))
    epsilon = 0.05 * (weight * mean).sum() / weight.sum()
    divisor = np.maximum(mean, epsilon)
    box = boxes(tree)
    faces = np.stack([box[cell] for cell in own])
    # shares of the cell's size to each face of the columns that vary
    with np.errstate(divide="ignore", invalid="ignore"):
        away = abs(x[:, None, :] - faces) / size[:, None, :]
    away[:, :, [k for k in range(18) if k not in AXES]] = np.inf
    away[np.isnan(away) | (size[:, None, :] <= 0).repeat(2, 1)] = np.inf
    flat = away.reshape(len(x), -1)
    nearest = flat.argmin(1)
    near = flat[np.arange(len(x)), nearest] < NEAR
    side, axis = nearest // 18, nearest % 18
    at = np.arange(len(x))[near]
    face = faces[at, side[at], axis[at]]
    here, over, within = x[at].copy(), x[at].copy(), x[at].copy()
    inwards = np.where(side[at] == 0, 1.0, -1.0)
    f32 = face.astype(np.float32)
    here[np.arange(len(at)), axis[at]] = face
    over[np.arange(len(at)), axis[at]] = np.where(side[at] == 0, np.nextafter(f32, np.float32(-np.inf)), f32)
    within[np.arange(len(at)), axis[at]] = face + inwards * NEAR * size[at, axis[at]]
    # a face may be where one object ends and another begins: no seam, the nets never meet there
    beyond = leaf(over)
    domains = {n["cell_id"]: (n["domain_min"], n["domain_max"]) for n in tree if n["axis"] < 0}
    low, high = (np.array([domains[cell][k] for cell in beyond], float) for k in (0, 1))
    slack = 0.05 * (high - low) + 1e-4 * abs(high + low)
    meet = ((low - slack <= over) & (over <= high + slack)).all(1)
    at, here, over, within, beyond = (a[meet] for a in (at, here, over, within, beyond))
    near = np.isin(np.arange(len(x)), at)
    mine = answers(weights, own[at], here)
    other = answers(weights, beyond, over)
    inside = answers(weights, own[at], within)
    d = np.maximum((mine + other).mean(1) / 2, epsilon)[:, None]
    w = weight[at] / weight[at].sum()
    rms = lambda e: float((w * (e**2).mean(1)).sum() ** 0.5)
    p = answers(weights, own, x)
    square = ((p - y[0]) * (p - y[1])).mean(1) / divisor**2
    error = lambda rows: max(float((weight[rows] * square[rows]).sum() / weight[rows].sum()), 0) ** 0.5
    # the neighbour's net counts for half at the face and nothing a margin inwards
    other_p, away_near = answers(weights, beyond, x[at]), flat[at, nearest[at]]
    jump, change = rms((mine - other) / d), rms((mine - inside) / d)
    print(f"{len(weights)} cells, {len(x)} rows, {near.mean():.0%} of them within a tenth of a cell of a face")
    median = lambda e: float(np.median((e**2).mean(1) ** 0.5))
    jumps, changes = median((mine - other) / d), median((mine - inside) / d)
    print(f"jump across faces              {jump:.2%}, median {jumps:.2%}")
    print(f"change over a tenth of a cell  {change:.2%}, median {changes:.2%}")
    print(f"error near faces               {error(near):.2%}  (all rows {error(np.ones_like(near)):.2%})")
    for margin in (0.05, 0.1):
        share = np.maximum(0.5 * (1 - away_near / margin), 0)[:, None]
        blended = (1 - share) * p[at] + share * other_p
        rows, w = share[:, 0] > 0, weight[at]
        squares = [((q - y[0, at]) * (q - y[1, at])).mean(1) / divisor[at] ** 2 for q in (p[at], blended)]
        before, after = (max((w * s)[rows].sum() / w[rows].sum(), 0) ** 0.5 for s in squares)
        print(f"blended within {margin:.0%} of a cell     {before:.2%} -> {after:.2%}")


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    main(*sys.argv[1:])
