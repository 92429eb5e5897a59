"""The open scene as files that `rrf` reads: glTF, with area lights as lamps, and the world as a sky."""

import array
import contextlib
import json
import math

import bpy

from . import frames

SKY = (512, 256)
# an area light of P watts and area A is a Lambert emitter: radiance P / (pi A)
AREA_RADIANCE = 1 / math.pi


def export(context, folder):
    """Writes scene.glb, lights.json and, where the world shines, sky.exr; the options that a bake needs for them."""
    folder.mkdir(parents=True, exist_ok=True)
    settings = context.scene.rrf
    boxes = [thing for thing in (settings.light_box, settings.eye_box) if thing]
    with hidden(boxes), lamps(context):
        bpy.ops.export_scene.gltf(
            filepath=str(folder / "scene.glb"),
            export_format="GLB",
            export_cameras=True,
            export_lights=True,
            export_apply=True,
            export_yup=True,
            use_renderable=True,
            use_active_scene=True,
            export_import_convert_lighting_mode="SPEC",
        )
    (folder / "lights.json").write_text(json.dumps(frames.lights(context.scene), indent=1))
    sky = world(context, folder / "sky.exr")
    options = [str(folder / "scene.glb")]
    options += [f"--sky={sky}"] if sky else []
    options += [f"--light-box={frames.box(settings.light_box)}"] if settings.light_box else []
    options += [f"--eye-box={frames.box(settings.eye_box)}"] if settings.eye_box else []
    return options


@contextlib.contextmanager
def hidden(things):
    """Leaves objects out of the export that only mark a part of space."""
    before = [(thing, thing.hide_render) for thing in things]
    for thing in things:
        thing.hide_render = True
    try:
        yield
    finally:
        for thing, was in before:
            thing.hide_render = was


def outline(light):
    """Corners of an area light's surface, about its middle, and its area."""
    width = light.size
    height = light.size_y if light.shape in ("RECTANGLE", "ELLIPSE") else light.size
    if light.shape in ("SQUARE", "RECTANGLE"):
        x, y = width / 2, height / 2
        return [(-x, -y, 0), (-x, y, 0), (x, y, 0), (x, -y, 0)]
    sides = 48
    # a polygon of the ellipse's own area
    grown = math.sqrt(2 * math.pi / (sides * math.sin(2 * math.pi / sides)))
    angles = (-2 * math.pi * side / sides for side in range(sides))
    return [(grown * width / 2 * math.cos(a), grown * height / 2 * math.sin(a), 0) for a in angles]


@contextlib.contextmanager
def lamps(context):
    """Gives each area light, which glTF does not have, a lamp of its shape, power and colour for the time of the export."""
    made = []
    shown = (t for t in context.scene.objects if t.type == "LIGHT" and not t.hide_render)
    for thing in [t for t in shown if t.data.type == "AREA"]:
        light = thing.data
        mesh = bpy.data.meshes.new(thing.name)
        corners = outline(light)
        mesh.from_pydata(corners, [], [list(range(len(corners)))])
        material = bpy.data.materials.new(thing.name)
        material.use_nodes = True
        material.use_backface_culling = True
        surface = material.node_tree.nodes["Principled BSDF"].inputs
        surface["Base Color"].default_value = (0, 0, 0, 1)
        mesh.materials.append(material)
        lamp = bpy.data.objects.new(f"{thing.name} (lamp)", mesh)
        context.scene.collection.objects.link(lamp)
        lamp.matrix_world = thing.matrix_world
        context.view_layer.update()
        across = lamp.matrix_world.to_scale()
        area = sum(polygon.area for polygon in mesh.polygons) * abs(across[0] * across[1])
        surface["Emission Color"].default_value = (*light.color, 1)
        surface["Emission Strength"].default_value = AREA_RADIANCE * light.energy / area if area else 0.0
        made.append((lamp, mesh, material))
    try:
        yield
    finally:
        for lamp, mesh, material in made:
            bpy.data.objects.remove(lamp)
            bpy.data.meshes.remove(mesh)
            bpy.data.materials.remove(material)


def world(context, path):
    """The world as a lat-long picture, or as three numbers where it is even; none where it is black.

    A panoramic camera of Cycles looks at the world alone, so that every node tree will do. The picture's middle is
    Blender's -y, which is glTF's +z, as `rrf` wants it."""
    shone = context.scene.world
    if not shone:
        return None
    scene = bpy.data.scenes.new("rrf sky")
    eye = bpy.data.cameras.new("rrf sky")
    camera = bpy.data.objects.new("rrf sky", eye)
    try:
        scene.world = shone
        scene.collection.objects.link(camera)
        scene.camera = camera
        camera.rotation_euler = (math.pi / 2, 0, math.pi)
        eye.type = "PANO"
        (eye.cycles if hasattr(eye, "cycles") and hasattr(eye.cycles, "panorama_type") else eye).panorama_type = (
            "EQUIRECTANGULAR"
        )
        scene.render.engine = "CYCLES"
        scene.cycles.samples = 4
        scene.cycles.use_denoising = False
        scene.render.resolution_x, scene.render.resolution_y = SKY
        scene.render.resolution_percentage = 100
        scene.render.image_settings.file_format = "OPEN_EXR"
        scene.render.image_settings.color_depth = "32"
        scene.render.filepath = str(path)
        bpy.ops.render.render(write_still=True, scene=scene.name)
    finally:
        bpy.data.objects.remove(camera)
        bpy.data.cameras.remove(eye)
        bpy.data.scenes.remove(scene)
    image = bpy.data.images.load(str(path))
    pixels = array.array("f", [0.0]) * (4 * SKY[0] * SKY[1])
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    channels = [pixels[channel::4] for channel in range(3)]
    if all(max(channel) <= 0 for channel in channels):
        path.unlink()
        return None
    if all(max(channel) - min(channel) <= 1e-6 * max(channel) for channel in channels):
        path.unlink()
        return frames.words(channel[0] for channel in channels)
    return str(path)
