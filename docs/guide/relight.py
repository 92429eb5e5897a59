"""Relights a transfer in numpy, from the file that `rrf export RUN --safetensors FILE` writes and nothing else.

    tensors, names = load("room.safetensors")
    lamp, sky = (tensors["light.irradiance"][names.index(name)] for name in ("lamp", "sky"))
    evening = 0.5 * lamp + sky * (0.1, 0.1, 0.3)            # dimmed and tinted: light is linear
    colours = radiance(tensors, evening, surface, position, geometric, shading, viewer, base_color)

Points are arrays of a row each: `surface` has object, material and whether it is the back; normals are unit vectors on the viewer's
side; `viewer` is the unit direction to the eye. Another light needs its irradiance on every column [W/m²], by shadow rays to
`column.position`.
"""

import json
import pathlib

import numpy as np

TYPES = {"F32": np.float32, "U32": np.uint32, "I32": np.int32, "U8": np.uint8}
# points blended between local fits, and the cosine between normals below which a fit says nothing
BLENDED, ALIKE = 6, 0.5


def load(path):
    """The tensors by name, and the names of the lights."""
    data = pathlib.Path(path).read_bytes()
    start = 8 + int.from_bytes(data[:8], "little")
    header = json.loads(data[8:start])
    names = json.loads(header.pop("__metadata__")["lights"])

    def tensor(entry):
        first, last = entry["data_offsets"]
        return np.frombuffer(data[start + first : start + last], TYPES[entry["dtype"]]).reshape(entry["shape"])

    return {name: tensor(entry) for name, entry in header.items()}, names


def fluxes(tensors, irradiance):
    """Power [W] that arrives at every node of the column tree, a channel each."""
    columns = tensors["node.columns"]
    power = tensors["column.area"][columns, None].astype(float) * irradiance[columns]
    sums = np.concatenate([np.zeros((1, 3)), np.cumsum(power, axis=0)])
    first, last = tensors["node.range"].T
    return sums[last] - sums[first]


def find_cells(tensors, surface, position, geometric):
    """The cell of each point; -1 where no row of the bake lay on its surface."""
    roots = {tuple(row[:3]): row[3] for row in tensors["tree.surface"].tolist()}
    axis, threshold, children = (tensors[f"tree.{name}"] for name in ("axis", "threshold", "children"))
    places = np.concatenate([position, geometric], axis=1).astype(np.float32)
    cells = np.full(len(places), -1)
    for row, (key, place) in enumerate(zip(surface.tolist(), places)):
        node = roots.get(tuple(map(int, key)))
        while node is not None and axis[node] >= 0:
            node = children[node, 0 if place[axis[node]] < threshold[node] else 1]
        if node is not None:
            cells[row] = children[node, 0]
    return cells


def of_net(tensors, name, coefficients, inputs):
    """Outputs of a net under a light, a channel each."""
    mean, scale, low, high, hidden, output = (
        tensors[f"{name}.{what}"].astype(float) for what in ("mean", "scale", "low", "high", "hidden", "output")
    )
    x = np.clip((inputs[:, tensors[f"{name}.inputs"]] - mean) * scale, low, high)
    units = np.tanh(x @ hidden[:, :-1].T + hidden[:, -1])
    features = np.concatenate([np.ones((len(x), 1)), x, units], axis=1)
    return features @ np.einsum("fkc,kc->fc", output, coefficients)


def tangents(normals):
    """Both tangents of unit normals (Duff et al. 2017)."""
    x, y, z = normals.T
    sign = np.copysign(1.0, z)
    a = -1.0 / (sign + z)
    b = x * y * a
    return np.stack([1 + sign * x * x * a, sign * b, -sign * x], 1), np.stack([b, sign + y * y * a, -y], 1)


def of_fits(tensors, name, coefficients, inputs, geometric):
    """Blends of the nearest local fits under a light, a channel each."""
    turns, places, normals, values = (tensors[f"{name}.{what}"].astype(float) for what in ("turns", "places", "normals", "values"))
    values = np.einsum("nskc,kc->nsc", values, coefficients)
    first, second = tangents(normals)
    by = np.repeat([1.0, turns[0], turns[1]], 3) ** 2
    result = np.zeros((len(inputs), 3))
    for row, (point, normal) in enumerate(zip(inputs, geometric)):
        squared = ((point - places) ** 2) @ by
        squared[normals @ normal < ALIKE] = np.inf
        near = np.argsort(squared, kind="stable")[: BLENDED + 1]
        distance = np.sqrt(squared[near])
        # the last says how far they reach and takes no part
        reach = distance[BLENDED] if len(near) > BLENDED else np.inf
        near, distance = near[:BLENDED], np.maximum(distance[:BLENDED], 1e-6)
        near, distance = near[np.isfinite(distance)], distance[np.isfinite(distance)]
        if len(near) == 0:
            continue
        weight = np.maximum(1 / distance - 1 / reach, 0) ** 2 + np.finfo(np.float32).tiny
        way = point[:3] - places[near, :3]
        along = [(way * tangent[near]).sum(1)[:, None] for tangent in (first, second)]
        own = values[near, 0] + values[near, 1] * along[0] + values[near, 2] * along[1]
        result[row] = weight @ own / weight.sum()
    return result


def radiance(tensors, irradiance, surface, position, geometric, shading, viewer, base_color):
    """Indirect radiance of points toward their viewers [W/(sr m²)], by the irradiance of every column."""
    flux = fluxes(tensors, irradiance)
    facing = (shading * viewer).sum(1, keepdims=True)
    inputs = np.concatenate([position, shading, 2 * facing * shading - viewer], axis=1)
    # directional albedos, linear between their cosines
    place = np.clip(facing[:, 0], 0, 1) * (tensors["albedo"].shape[1] - 1)
    low = np.minimum(place.astype(int), tensors["albedo"].shape[1] - 2)
    own = tensors["albedo"][surface[:, 1].astype(int)].astype(float)
    rows = np.arange(len(place))
    share = (place - low)[:, None]
    albedo = own[rows, low] * (1 - share) + own[rows, low + 1] * share
    result = np.zeros((len(position), 3))
    cells = find_cells(tensors, surface, position, geometric)
    for cell in np.unique(cells[cells >= 0]):
        here = cells == cell
        nodes = tensors[f"cell.{cell}.nodes"]
        coefficients = tensors[f"cell.{cell}.read"].astype(float).T @ flux[nodes]
        for part, name in enumerate((f"cell.{cell}.base", f"cell.{cell}.constant")):
            if f"{name}.output" in tensors:
                made = of_net(tensors, name, coefficients, inputs[here])
            elif f"{name}.values" in tensors:
                made = of_fits(tensors, name, coefficients, inputs[here], geometric[here])
            else:
                continue
            colour = base_color[here] if part == 0 else 1.0
            result[here] += colour * albedo[here, part, None] * made
    return result
