"""The Blender extension in Blender itself (bpy from PyPI, without a window): units, sky, bake, frame."""

import json
import math
import os
import pathlib
import subprocess
import sys
import tomllib

import numpy as np
import OpenEXR
import pytest

bpy = pytest.importorskip("bpy", reason="bpy 5.0 is there for Python 3.11 only")

import scenes  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "pipeline/blender"))
os.environ.setdefault("RRF", str(ROOT / "target/release/rrf"))
BINARY = os.environ["RRF"]

import rrf  # noqa: E402
from rrf import frames, scene_file  # noqa: E402


@pytest.fixture(scope="module", autouse=True)
def extension():
    rrf.register()
    yield
    rrf.unregister()


def call(*words):
    done = subprocess.run([BINARY, *map(str, words), "--quiet"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def pixels(path, layer=""):
    """Red, green and blue of a picture, shape [height, width, 3]."""
    channels = OpenEXR.File(str(path)).parts[0].channels
    prefix = f"{layer}." if layer else ""
    for joined in (f"{prefix}RGB", f"{prefix}RGBA"):
        if joined in channels:
            return channels[joined].pixels[..., :3].astype(float)
    return np.stack([channels[f"{prefix}{name}"].pixels for name in "RGB"], axis=-1).astype(float)


def cycles(path, samples):
    scene = bpy.context.scene
    scene.cycles.samples = samples
    scene.cycles.use_denoising = False
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    return pixels(path)


def traced(folder, spp, *more):
    """The open scene at its camera by `rrf trace`, through the export."""
    options = scene_file.export(bpy.context, folder)
    scene, sky = options[0], [word for word in options[1:] if word.startswith("--sky")]
    call("trace", scene, "-o", folder / "traced.exr", "--spp", spp, *sky, *frames.camera(bpy.context.scene), *more)
    return pixels(folder / "traced.exr")


LIGHTS = {
    "point": lambda: scenes.light("POINT", "lamp", (0.3, 0, 1.5), 100, shadow_soft_size=0.0),
    "coloured": lambda: scenes.light("POINT", "lamp", (0, 0, 2), 50, color=(1, 0.5, 0.2), shadow_soft_size=0.0),
    "spot": lambda: scenes.light("SPOT", "lamp", (0, 0, 2), 100, shadow_soft_size=0.0, spot_size=1.2, spot_blend=0.0),
    "sun": lambda: scenes.light("SUN", "lamp", (0, 0, 2), 3, ahead=(0.2, 0, -1), angle=0.0),
    "square": lambda: scenes.light("AREA", "lamp", (0.8, 0, 2), 100, shape="SQUARE", size=0.5),
    "rectangle": lambda: scenes.light("AREA", "lamp", (0.8, 0, 2), 100, shape="RECTANGLE", size=0.6, size_y=0.3),
    "disk": lambda: scenes.light("AREA", "lamp", (0.8, 0, 2), 100, shape="DISK", size=0.6),
}


@pytest.mark.parametrize("kind", LIGHTS)
def test_lights_have_blenders_own_brightness(kind, tmp_path):
    """Both programs' pictures of a floor under one light, by a z-test of the mean of their differences over pixels."""
    scenes.floor()
    LIGHTS[kind]()
    bpy.context.view_layer.update()
    theirs = cycles(tmp_path / "cycles.exr", 64)
    ours = traced(tmp_path, 64)
    difference = (ours / theirs.mean(axis=(0, 1)) - theirs / theirs.mean(axis=(0, 1))).mean(axis=2)
    error = difference.std() / math.sqrt(difference.size)
    # 0.3 %: the exporter writes five digits, and dielectrics mirror a little at normal incidence too
    assert abs(difference.mean()) < 4 * error + 0.003, (difference.mean(), error)


def test_the_world_is_seen_where_it_is(tmp_path):
    """A world whose red, green and blue are the direction's x, y and z, where positive."""
    scenes.empty()
    tree = bpy.context.scene.world.node_tree
    there = tree.nodes.new("ShaderNodeTexCoord")
    positive = tree.nodes.new("ShaderNodeVectorMath")
    positive.operation = "MAXIMUM"
    tree.links.new(there.outputs["Generated"], positive.inputs[0])
    tree.links.new(positive.outputs["Vector"], scenes.background())
    scenes.box("speck", (0, 0, -0.01), (0.01, 0.01, 0), scenes.material("grey", (0.5, 0.5, 0.5)))
    for axis, target in enumerate([(9, 0, 0), (0, 9, 0), (0, 0, 9)]):
        scenes.camera((0.5, 0.5, 0.5), [t + 0.5 for t in target], 2)
        if target[2]:
            bpy.context.scene.camera.rotation_euler = (math.pi, 0, 0)
            bpy.context.view_layer.update()
        seen = traced(tmp_path, 16).mean(axis=(0, 1))
        wanted = np.eye(3)[axis]
        # 512 columns: a texel is 0.7 degrees wide
        assert np.abs(seen - wanted).max() < math.radians(2.5), (target, seen)


def test_an_even_world_is_three_numbers_and_a_black_one_none(tmp_path):
    scenes.floor()
    assert not [word for word in scene_file.export(bpy.context, tmp_path) if word.startswith("--sky")]
    scenes.background().default_value = (0.25, 0.5, 1.0, 1)
    (sky,) = [word for word in scene_file.export(bpy.context, tmp_path) if word.startswith("--sky")]
    assert np.allclose([float(x) for x in sky.removeprefix("--sky=").split(",")], [0.25, 0.5, 1.0], atol=1e-6)
    assert not (tmp_path / "sky.exr").exists()


def test_the_export_leaves_the_scene_as_it_was(tmp_path):
    scenes.room()
    scenes.light("AREA", "lamp", (0, 0, 2.3), 40, shape="DISK", size=0.4)

    def everything():
        data = (bpy.data.objects, bpy.data.meshes, bpy.data.materials, bpy.data.scenes, bpy.data.images)
        # Blender keeps the last picture that it rendered
        return [sorted(thing.name for thing in kind if thing.name != "Render Result") for kind in data]

    before = everything()
    scene_file.export(bpy.context, tmp_path)
    assert everything() == before


@pytest.fixture(scope="module")
def baked(tmp_path_factory):
    """The furnished room, opened from a file, exported and baked by the panel's button."""
    folder = tmp_path_factory.mktemp("room")
    scenes.room()
    scenes.light("POINT", "bulb", (0.2, -0.2, 2.0), 60, shadow_soft_size=0.0)
    markers = scenes.box("lights", (-1.2, -1.0, 1.2), (1.2, 1.0, 2.2), scenes.material("box", (1, 1, 1)))
    bpy.context.scene.rrf.light_box = markers
    bpy.context.scene.rrf.folder = str(folder / "bake")
    bpy.context.scene.rrf.preset = "preview"
    bpy.context.scene.rrf.target = 10
    bpy.context.scene.render.resolution_x, bpy.context.scene.render.resolution_y = 96, 64
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "room.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(folder / "room.blend"))
    assert bpy.ops.rrf.bake() == {"FINISHED"}
    return folder / "bake"


def compared(folder):
    """Relative error of the frame's light against `rrf trace` of the exported scene at the same view and lights."""
    scene = bpy.context.scene
    options, _ = frames.changes(json.loads((folder / "lights.json").read_text()), frames.lights(scene))
    words = [folder / "scene.glb", "-o", folder / "traced.exr", "--spp", 512]
    call("trace", *words, *frames.camera(scene), *options)
    measures = json.loads(call("compare", folder / "frame.exr", folder / "traced.exr", "--json"))["measures"]
    (error,) = [measure["value"] for measure in measures if measure["name"] == "relative_error"]
    return error


def test_a_frame_is_what_the_path_tracer_sees(baked):
    assert bpy.ops.rrf.render() == {"FINISHED"}
    image = bpy.data.images["rrf frame"]
    assert pathlib.Path(image.filepath) == baked / "frame.exr"
    # a preview of a few seconds; the path tracer's own noise is in it
    assert compared(baked) < 0.3


def test_a_light_that_was_moved_and_dimmed_is_where_it_is_now(baked):
    lamp = bpy.data.objects["bulb"]
    lamp.location = (-0.6, 0.3, 1.7)
    lamp.data.color = (1, 0.8, 0.5)
    lamp.data.energy = 30
    bpy.context.view_layer.update()
    assert bpy.ops.rrf.render() == {"FINISHED"}
    assert compared(baked) < 0.3


def test_the_marker_of_the_light_box_is_no_part_of_the_scene(baked):
    listed = json.loads(call("scene", baked / "scene.glb", "--json"))
    assert "box" not in [material["name"] for material in listed["materials"]]


def test_a_folder_with_other_things_is_left_alone(tmp_path):
    scenes.room()
    bpy.context.scene.rrf.folder = str(tmp_path)
    (tmp_path / "run").mkdir()
    (tmp_path / "run/novel.txt").write_text("mine")
    with pytest.raises(RuntimeError, match="is not a bake"):
        bpy.ops.rrf.bake()
    assert (tmp_path / "run/novel.txt").read_text() == "mine"


def test_a_missing_program_is_named(tmp_path, monkeypatch):
    scenes.room()
    bpy.context.scene.rrf.folder = str(tmp_path)
    monkeypatch.setenv("RRF", "")
    monkeypatch.setenv("PATH", "")
    with pytest.raises(RuntimeError, match="rrf was not found"):
        bpy.ops.rrf.bake()


def test_the_manifest_is_whole():
    manifest = tomllib.loads((ROOT / "pipeline/blender/rrf/blender_manifest.toml").read_text())
    for key in ("schema_version", "id", "version", "name", "tagline", "maintainer", "type", "blender_version_min", "license"):
        assert manifest[key], key
    assert len(manifest["tagline"]) <= 64 and not manifest["tagline"].endswith(".")
