"""Writes textured-room.glb: a small room for comparisons of textures and interpolated normals.

Floor: base colour texture (tiles of 16 x 16 texels, repeated 3 x 2), roughness 0.6. Back wall:
roughness-metallic texture over a constant base colour. Side walls: a base colour factor over a
texture. A quarter column with smooth normals. One camera, one point light of 4 W/sr.

    python3 make.py          # needs numpy and Pillow; the file in the repository is its output
"""

import io
import json
import math
import struct
from pathlib import Path

import numpy as np
from PIL import Image

rng = np.random.default_rng(3)


def png(texels) -> bytes:
    out = io.BytesIO()
    Image.fromarray(texels.astype(np.uint8), "RGB").save(out, "PNG", optimize=True)
    return out.getvalue()


def tiles():
    """An asymmetric pattern: swapped or mirrored axes show."""
    y, x = np.mgrid[0:16, 0:16]
    texels = np.zeros((16, 16, 3))
    texels[...] = np.where(((x // 4 + y // 8) % 2)[..., None], [205, 190, 160], [90, 60, 45])
    texels[:5, :3] = [180, 30, 30]
    return np.clip(texels + rng.integers(-12, 13, (16, 16, 1)), 0, 255)


def plaster():
    y, x = np.mgrid[0:8, 0:8]
    return np.stack([120 + 15 * x, 170 + 8 * y, 210 - 10 * x], -1)


def worn():
    """Green roughness, blue metalness: a metal band in a rough wall."""
    y, x = np.mgrid[0:16, 0:16]
    metal = (y >= 4) & (y < 9)
    return np.stack([0 * x, np.where(metal, 90, 230) + x, np.where(metal, 255, 0)], -1)


def quad(origin, u, v, times=(1, 1)):
    """Corners counter-clockwise seen from u x v; texture once along u and v, v of glTF downwards."""
    origin, u, v = (np.array(a, float) for a in (origin, u, v))
    corners = np.array([origin, origin + u, origin + u + v, origin + v])
    n = np.cross(u, v) / np.linalg.norm(np.cross(u, v))
    a, b = times
    uv = np.array([[0, b], [a, b], [a, 0], [0, 0]], float)
    return corners, np.tile(n, (4, 1)), uv, np.array([0, 1, 2, 0, 2, 3])


def column(centre, radius, height, segments=12):
    """Half a cylinder that faces +z, smooth normals."""
    angle = np.linspace(0, math.pi, segments + 1)
    n = np.stack([np.cos(angle), 0 * angle, np.sin(angle)], 1)
    foot = np.array(centre) + radius * n
    corners = np.concatenate([foot, foot + [0, height, 0]])
    s = angle / math.pi
    uv = np.concatenate([np.stack([s, 0 * s + 1], 1), np.stack([s, 0 * s], 1)])
    faces = []
    for i in range(segments):
        j = i + segments + 1
        faces += [i, j, i + 1, i + 1, j, j + 1]
    return corners, np.concatenate([n, n]), uv, np.array(faces)


# (mesh, material)
MESHES = [
    (quad((-1, 0, 1), (2, 0, 0), (0, 0, -2), (3, 2)), 0),
    (quad((-1, 0, -1), (2, 0, 0), (0, 1.5, 0)), 1),
    (quad((-1, 0, 1), (0, 0, -2), (0, 1.5, 0)), 2),
    (quad((1, 0, -1), (0, 0, 2), (0, 1.5, 0)), 3),
    (quad((-1, 1.5, -1), (2, 0, 0), (0, 0, 2)), 4),
    (column((0.35, 0, -0.5), 0.25, 1.0), 0),
]
pbr = lambda **values: {"doubleSided": True, "pbrMetallicRoughness": values}
MATERIALS = [
    pbr(baseColorTexture={"index": 0}, metallicFactor=0, roughnessFactor=0.6) | {"name": "tiles"},
    pbr(baseColorFactor=[0.8, 0.75, 0.6, 1], metallicRoughnessTexture={"index": 2}) | {"name": "worn"},
    pbr(baseColorFactor=[0.9, 0.3, 0.25, 1], baseColorTexture={"index": 1}, metallicFactor=0,
        roughnessFactor=0.9) | {"name": "red plaster"},
    pbr(baseColorFactor=[0.3, 0.85, 0.35, 1], baseColorTexture={"index": 1}, metallicFactor=0,
        roughnessFactor=0.9) | {"name": "green plaster"},
    pbr(baseColorFactor=[0.7, 0.7, 0.7, 1], metallicFactor=0, roughnessFactor=1) | {"name": "ceiling"},
]


def build() -> bytes:
    blob, views, accessors, meshes = b"", [], [], []

    def view(data: bytes) -> int:
        nonlocal blob
        blob += b"\0" * (-len(blob) % 4)
        views.append({"buffer": 0, "byteOffset": len(blob), "byteLength": len(data)})
        blob += data
        return len(views) - 1

    def accessor(array, kind: str, component: int) -> int:
        entry = {"bufferView": view(array.tobytes()), "componentType": component, "type": kind}
        entry["count"] = len(array)
        if kind == "VEC3":
            entry |= {"min": array.min(0).tolist(), "max": array.max(0).tolist()}
        accessors.append(entry)
        return len(accessors) - 1

    for (corners, normals, uv, faces), material in MESHES:
        attributes = {
            "POSITION": accessor(corners.astype("<f4"), "VEC3", 5126),
            "NORMAL": accessor(normals.astype("<f4"), "VEC3", 5126),
            "TEXCOORD_0": accessor(uv.astype("<f4"), "VEC2", 5126),
        }
        primitive = {"attributes": attributes, "indices": accessor(faces.astype("<u2"), "SCALAR", 5123)}
        meshes.append({"primitives": [primitive | {"material": material}]})
    images = [{"mimeType": "image/png", "bufferView": view(png(t()))} for t in (tiles, plaster, worn)]
    nodes = [{"mesh": i} for i in range(len(meshes))]
    nodes.append({"name": "camera", "camera": 0, "translation": [0, 0.75, 2.6]})
    nodes.append({"name": "lamp", "translation": [-0.3, 1.1, 0.3],
                  "extensions": {"KHR_lights_punctual": {"light": 0}}})
    document = {
        "asset": {"version": "2.0", "generator": "tests/data/textured/make.py"},
        "extensionsUsed": ["KHR_lights_punctual"],
        # candela: 683 lm/W
        "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 4 * 683.0}]}},
        "scene": 0, "scenes": [{"nodes": list(range(len(nodes)))}], "nodes": nodes, "meshes": meshes,
        "cameras": [{"type": "perspective",
                     "perspective": {"yfov": math.radians(45), "aspectRatio": 1, "znear": 0.01}}],
        "materials": MATERIALS, "images": images, "samplers": [{"wrapS": 10497, "wrapT": 10497}],
        "textures": [{"source": i, "sampler": 0} for i in range(3)],
        "accessors": accessors, "bufferViews": views, "buffers": [{"byteLength": len(blob)}],
    }
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    blob += b"\0" * (-len(blob) % 4)
    total = 12 + 8 + len(text) + 8 + len(blob)
    head = struct.pack("<III", 0x46546C67, 2, total)
    return head + struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(blob), 0x004E4942) + blob


if __name__ == "__main__":
    path = Path(__file__).with_name("textured-room.glb")
    path.write_bytes(build())
    print(path, path.stat().st_size)
