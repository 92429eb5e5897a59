"""The panel in the sidebar of the 3D view."""

import bpy

from . import operators, settings


class RRF_PT_panel(bpy.types.Panel):
    bl_idname = "RRF_PT_panel"
    bl_label = "Baked indirect light"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "rrf"

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        own = context.scene.rrf
        if not settings.program():
            layout.label(text="The program rrf was not found", icon="ERROR")
            layout.label(text="Name its place in the preferences")
        column = layout.column()
        for name in ("folder", "preset", "target", "light_box", "eye_box"):
            column.prop(own, name)
        layout.operator("rrf.bake", icon="LIGHT")
        row = layout.row(align=True)
        row.operator("rrf.render", icon="RENDER_STILL")
        running = operators.view_runs()
        row.operator("rrf.stop_view" if running else "rrf.view", icon="CANCEL" if running else "HIDE_OFF")
        if own.status:
            layout.label(text=own.status)


CLASSES = (RRF_PT_panel,)
