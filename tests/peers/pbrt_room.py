"""The part of pbrt's text format that a room of triangles needs, for use by other renderers.

Not a general reader: `trianglemesh` and named `matte` materials with a constant `Kd`; anything
else inside the world is an error, so that two programs cannot silently see different rooms.
"""

import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

TOKEN = re.compile(r'"(?P<string>[^"]*)"|(?P<bracket>[\[\]])|(?P<word>[^\s\[\]"]+)')


@dataclass
class Room:
    """Diffuse triangle meshes; lamps (shapes with an area light) are left out."""

    reflectance: dict[str, tuple[float, float, float]] = field(default_factory=dict)
    # (material's name, triangles [m, 3] uint32, positions [n, 3] float32) a mesh
    meshes: list[tuple[str, np.ndarray, np.ndarray]] = field(default_factory=list)


def directives(text: str):
    """Yields (directive, name, parameters): parameters map "type name" to a list of strings."""
    text = re.sub(r"#.*", "", text)
    word, name, parameters, key, inside = None, None, {}, None, False
    for token in TOKEN.finditer(text):
        if token["bracket"]:
            inside = token["bracket"] == "["
        elif token["word"] and not inside:
            if word:
                yield word, name, parameters
            word, name, parameters, key = token["word"], None, {}, None
        elif token["string"] is not None and not inside:
            if name is None:
                name = token["string"]
            else:
                key = " ".join(token["string"].split())
                parameters[key] = []
        elif key is not None:
            parameters[key].append(token["word"] if token["word"] else token["string"])
    if word:
        yield word, name, parameters


def read_room(path: Path) -> Room:
    """Reads what stands between WorldBegin and WorldEnd, world frame, metres as written."""
    room, material, lamp, stack, in_world = Room(), None, False, [], False
    for word, name, parameters in directives(path.read_text()):
        if word == "WorldBegin":
            in_world = True
        elif not in_world or word == "WorldEnd":
            continue
        elif word == "AttributeBegin":
            stack.append((material, lamp))
        elif word == "AttributeEnd":
            material, lamp = stack.pop()
        elif word == "MakeNamedMaterial" and parameters["string type"] == ["matte"]:
            r, g, b = map(float, parameters["rgb Kd"])
            room.reflectance[name] = (r, g, b)
        elif word == "NamedMaterial" and name in room.reflectance:
            material = name
        elif word == "AreaLightSource":
            lamp = True
        elif word == "Shape" and name == "trianglemesh":
            if not lamp:
                triangles = np.array(parameters["integer indices"], np.uint32).reshape(-1, 3)
                positions = np.array(parameters["point P"], np.float32).reshape(-1, 3)
                room.meshes.append((material, triangles, positions))
        else:
            raise ValueError(f"{path}: {word} {name!r} is beyond this reader")
    return room
