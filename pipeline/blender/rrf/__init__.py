"""Bakes the open scene's indirect light by `rrf`, and shows frames and the live page of the bake."""

import bpy

from . import operators, panel, settings

CLASSES = (*settings.CLASSES, *operators.CLASSES, *panel.CLASSES)


def register():
    for one in CLASSES:
        bpy.utils.register_class(one)
    bpy.types.Scene.rrf = bpy.props.PointerProperty(type=settings.RrfSettings)


def unregister():
    operators.stop_view()
    del bpy.types.Scene.rrf
    for one in reversed(CLASSES):
        bpy.utils.unregister_class(one)
