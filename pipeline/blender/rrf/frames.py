"""Blender's space and options in `rrf`'s: +y up as glTF has it, words of the command line."""

import math

import mathutils


def to_gltf(v):
    """A vector of Blender's (+z up) as glTF has it (+y up)."""
    return mathutils.Vector((v[0], v[2], -v[1]))


def words(values):
    return ",".join(f"{value:.7g}" for value in values)


def box(thing):
    """The bounds of an object as two opposite corners."""
    corners = [to_gltf(thing.matrix_world @ mathutils.Vector(corner)) for corner in thing.bound_box]
    least = [min(corner[axis] for corner in corners) for axis in range(3)]
    most = [max(corner[axis] for corner in corners) for axis in range(3)]
    return words(least + most)


def camera(scene):
    """The active camera's view and the picture's size, as options."""
    thing = scene.camera
    matrix = thing.matrix_world
    eye = matrix.translation
    ahead = matrix.to_3x3() @ mathutils.Vector((0, 0, -1))
    up = matrix.to_3x3() @ mathutils.Vector((0, 1, 0))
    corners = thing.data.view_frame(scene=scene)
    extent = min(max(abs(corner[axis]) for corner in corners) for axis in range(2))
    fov = 2 * math.degrees(math.atan(extent / abs(corners[0][2])))
    share = scene.render.resolution_percentage / 100
    size = [max(1, round(side * share)) for side in (scene.render.resolution_x, scene.render.resolution_y)]
    return [
        f"--eye={words(to_gltf(eye))}",
        f"--look-at={words(to_gltf(eye + ahead))}",
        f"--up={words(to_gltf(up))}",
        f"--fov={fov:.7g}",
        f"--size={size[0]}x{size[1]}",
    ]


def light_state(thing):
    """What of a light can change after the bake."""
    light = thing.data
    matrix = thing.matrix_world
    return {
        "type": light.type,
        "position": list(to_gltf(matrix.translation)),
        "ahead": list(to_gltf(matrix.to_3x3() @ mathutils.Vector((0, 0, -1))).copy().normalized()),
        "power": [light.energy * channel for channel in light.color],
        "shown": not thing.hide_render,
    }


def lights(scene):
    """The state of each light by name."""
    return {thing.name: light_state(thing) for thing in scene.objects if thing.type == "LIGHT"}


def changes(baked, present):
    """Options that take the lights from how they were baked to how they are, and what no option can do."""
    options, refused = [], []
    for name, old in baked.items():
        new = present.get(name)
        if new is None or not new["shown"]:
            options.append(f"--dim={name}=0,0,0")
            continue
        if new["power"] != old["power"]:
            if any(o == 0 and n != 0 for o, n in zip(old["power"], new["power"])):
                refused.append(f"{name} had no light in a channel when it was baked")
            else:
                ratio = [n / o if o else 0.0 for o, n in zip(old["power"], new["power"])]
                options.append(f"--dim={name}={words(ratio)}")
        far = (mathutils.Vector(new["position"]) - mathutils.Vector(old["position"])).length
        turned = (mathutils.Vector(new["ahead"]) - mathutils.Vector(old["ahead"])).length
        if far > 1e-5 and old["type"] != "SUN":
            options.append(f"--move={name}:{words(new['position'])}")
        if turned > 1e-4 and old["type"] != "POINT":
            refused.append(f"{name} was turned")
    refused += [f"{name} is new" for name in present if name not in baked]
    return options, refused
