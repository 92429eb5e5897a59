"""What a user sets: the program's place once, the bake's settings with each scene."""

import os
import pathlib
import shutil

import bpy
from bpy.props import EnumProperty, FloatProperty, PointerProperty, StringProperty

PRESETS = [
    ("preview", "Preview", "Seconds: to check the scene"),
    ("standard", "Standard", "Minutes"),
    ("fine", "Fine", "Hours: for the smallest error"),
]


class RrfPreferences(bpy.types.AddonPreferences):
    bl_idname = __package__

    program: StringProperty(
        name="Program",
        subtype="FILE_PATH",
        description="The program rrf; empty to find it on the path",
    )

    def draw(self, context):
        self.layout.prop(self, "program")


class RrfSettings(bpy.types.PropertyGroup):
    folder: StringProperty(
        name="Folder", subtype="DIR_PATH", default="//rrf", description="Where the scene and its bake are kept"
    )
    preset: EnumProperty(name="Preset", items=PRESETS, default="standard", description="Amount of work")
    target: FloatProperty(
        name="Target", default=5.0, min=0.1, max=100.0, subtype="PERCENTAGE", description="Relative error to reach"
    )
    light_box: PointerProperty(
        name="Lights in", type=bpy.types.Object, description="Object whose bounds lights may move in"
    )
    eye_box: PointerProperty(
        name="Cameras in", type=bpy.types.Object, description="Object whose bounds cameras will be in"
    )
    status: StringProperty(name="Status", options={"SKIP_SAVE"})

    def path(self):
        """The folder, from the file's own folder where it begins with //."""
        return pathlib.Path(bpy.path.abspath(self.folder)).resolve()

    def run(self):
        return self.path() / "run"


def program():
    """The program as the preferences, the environment variable RRF or the path have it; none if nowhere."""
    addon = bpy.context.preferences.addons.get(__package__)
    named = addon.preferences.program if addon else ""
    named = bpy.path.abspath(named) if named else os.environ.get("RRF", "")
    return named if named and os.path.isfile(named) else shutil.which("rrf")


CLASSES = (RrfPreferences, RrfSettings)
