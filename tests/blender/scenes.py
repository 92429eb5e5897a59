"""Scenes for the tests of the Blender extension, made by bpy."""

import math

import bpy


def empty():
    """A file with nothing in it, whose world is black and whose pictures are as small as tests need."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.world = bpy.data.worlds.new("world")
    scene.world.use_nodes = True
    background().default_value = (0, 0, 0, 1)
    scene.render.engine = "CYCLES"
    scene.render.resolution_x = scene.render.resolution_y = 32
    return scene


def background():
    return bpy.context.scene.world.node_tree.nodes["Background"].inputs["Color"]


def material(name, colour, roughness=1.0):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    inputs = made.node_tree.nodes["Principled BSDF"].inputs
    inputs["Base Color"].default_value = (*colour, 1)
    inputs["Roughness"].default_value = roughness
    # nothing but diffuse reflection: programs differ in their sheen of dielectrics
    inputs["Specular IOR Level"].default_value = 0
    return made


def box(name, least, most, paint):
    """An axis-aligned box."""
    middle = [(a + b) / 2 for a, b in zip(least, most)]
    bpy.ops.mesh.primitive_cube_add(size=1, location=middle)
    thing = bpy.context.object
    thing.name = name
    thing.scale = [b - a for a, b in zip(least, most)]
    thing.data.materials.append(paint)
    return thing


def light(kind, name, position, power, ahead=(0, 0, -1), **settings):
    data = bpy.data.lights.new(name, kind)
    data.energy = power
    for key, value in settings.items():
        setattr(data, key, value)
    thing = bpy.data.objects.new(name, data)
    thing.location = position
    from mathutils import Vector

    thing.rotation_euler = Vector(ahead).to_track_quat("-Z", "Y").to_euler()
    bpy.context.scene.collection.objects.link(thing)
    return thing


def camera(position, target, angle=50):
    from mathutils import Vector

    data = bpy.data.cameras.new("camera")
    data.angle = math.radians(angle)
    thing = bpy.data.objects.new("camera", data)
    thing.location = position
    thing.rotation_euler = (Vector(target) - Vector(position)).to_track_quat("-Z", "Y").to_euler()
    bpy.context.scene.collection.objects.link(thing)
    bpy.context.scene.camera = thing
    bpy.context.view_layer.update()
    return thing


def floor():
    """A large grey floor, looked at from straight above: glTF's dielectrics mirror more at grazing angles."""
    scene = empty()
    box("floor", (-20, -20, -0.2), (20, 20, 0), material("grey", (0.5, 0.5, 0.5)))
    camera((0, -0.01, 6), (0, 0, 0), 4)
    return scene


def room():
    """A furnished room, 4 x 3 x 2.4 m: a table, a sofa, a shelf with books, a rug."""
    scene = empty()
    white = material("white", (0.75, 0.75, 0.72))
    red = material("red", (0.6, 0.12, 0.1))
    wood = material("wood", (0.45, 0.28, 0.15))
    cloth = material("cloth", (0.2, 0.3, 0.5))
    t = 0.1
    box("floor", (-2, -1.5, -t), (2, 1.5, 0), wood)
    box("ceiling", (-2, -1.5, 2.4), (2, 1.5, 2.4 + t), white)
    box("back", (-2 - t, 1.5, -t), (2 + t, 1.5 + t, 2.4 + t), white)
    box("front", (-2 - t, -1.5 - t, -t), (2 + t, -1.5, 2.4 + t), white)
    box("left", (-2 - t, -1.5, -t), (-2, 1.5, 2.4 + t), red)
    box("right", (2, -1.5, -t), (2 + t, 1.5, 2.4 + t), white)
    box("table top", (-0.5, 0.0, 0.7), (0.6, 0.7, 0.75), wood)
    for x in (-0.45, 0.5):
        for y in (0.05, 0.6):
            box("leg", (x, y, 0.0), (x + 0.05, y + 0.05, 0.7), wood)
    box("sofa seat", (1.2, -1.0, 0.1), (1.9, 0.8, 0.45), cloth)
    box("sofa back", (1.8, -1.0, 0.45), (1.98, 0.8, 0.9), cloth)
    box("shelf", (-1.9, 1.2, 1.2), (-0.8, 1.48, 1.24), wood)
    for i in range(6):
        box("book", (-1.85 + 0.12 * i, 1.25, 1.24), (-1.77 + 0.12 * i, 1.45, 1.45 + 0.02 * i), red if i % 2 else cloth)
    box("rug", (-1.2, -1.1, 0.0), (0.9, 0.9, 0.01), cloth)
    camera((-1.6, -1.3, 1.5), (0.4, 0.5, 0.8), 65)
    return scene
