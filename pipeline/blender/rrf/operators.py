"""Bake, render, look: what the panel's buttons do."""

import json
import shutil

import bpy

from . import frames, program, scene_file

_view = None


def stop_view():
    """Ends the live page, if it runs."""
    global _view
    if _view:
        _view.stop()
    _view = None


def view_runs():
    return _view is not None and _view.done() is None


def bake_words(context):
    """The scene's files, and the command that bakes them."""
    settings = context.scene.rrf
    options = scene_file.export(context, settings.path())
    run = settings.run()
    if (run / "run.json").is_file():
        # the scene may have changed, so that the old run may not go on
        shutil.rmtree(run)
    elif run.exists() and any(run.iterdir()):
        raise FileExistsError(f"{run} is not a bake. Choose another folder")
    return ["bake", *options, "-o", str(run), f"--preset={settings.preset}", f"--target={settings.target / 100:.6g}"]


class RRF_OT_bake(bpy.types.Operator):
    bl_idname = "rrf.bake"
    bl_label = "Bake"
    bl_description = "Export the scene and bake its indirect light. Escape stops it"

    _running = None
    _timer = None

    def execute(self, context):
        """Bakes and waits: what scripts and background processes get."""
        try:
            context.scene.rrf.status = program.call(*bake_words(context)).strip().splitlines()[-1]
        except (program.ProgramMissing, program.ProgramFailed, OSError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}

    def invoke(self, context, _event):
        try:
            self._running = program.Running(*bake_words(context))
        except (program.ProgramMissing, OSError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        context.scene.rrf.status = "Baking"
        self._timer = context.window_manager.event_timer_add(0.25, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC":
            self._running.stop()
            return self._end(context, "Stopped", {"CANCELLED"})
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        code = self._running.done()
        if line := self._running.news():
            context.scene.rrf.status = line
            redraw(context)
        if code is None:
            return {"PASS_THROUGH"}
        if code:
            self.report({"ERROR"}, self._running.last or f"rrf ended with exit code {code}")
            return self._end(context, self._running.last, {"CANCELLED"})
        return self._end(context, self._running.last, {"FINISHED"})

    def _end(self, context, status, result):
        context.window_manager.event_timer_remove(self._timer)
        context.scene.rrf.status = status
        redraw(context)
        return result


def redraw(context):
    for area in context.screen.areas if context.screen else ():
        area.tag_redraw()


class OnRun:
    """What needs a finished bake."""

    @classmethod
    def poll(cls, context):
        return (context.scene.rrf.run() / "run.json").is_file()

    def light_options(self, context):
        """The lights as they are now; what no option can say is reported."""
        baked = json.loads((context.scene.rrf.path() / "lights.json").read_text())
        options, refused = frames.changes(baked, frames.lights(context.scene))
        if refused:
            self.report({"WARNING"}, f"Bake again to see this: {'; '.join(refused)}")
        return options


class RRF_OT_render(OnRun, bpy.types.Operator):
    bl_idname = "rrf.render"
    bl_label = "Render"
    bl_description = "Render the active camera's view by the bake, with the lights where they are now"

    def execute(self, context):
        if not context.scene.camera:
            self.report({"ERROR"}, "The scene has no active camera")
            return {"CANCELLED"}
        settings = context.scene.rrf
        path = settings.path() / "frame.exr"
        words = [*frames.camera(context.scene), *self.light_options(context)]
        try:
            program.call("render", str(settings.run()), "-o", str(path), *words)
        except (program.ProgramMissing, program.ProgramFailed, OSError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        image = bpy.data.images.get("rrf frame")
        if image is None:
            image = bpy.data.images.load(str(path))
            image.name = "rrf frame"
        image.filepath = str(path)
        image.reload()
        for area in context.screen.areas if context.screen else ():
            if area.type == "IMAGE_EDITOR":
                area.spaces.active.image = image
        settings.status = f"Rendered: image 'rrf frame', {path}"
        return {"FINISHED"}


class RRF_OT_view(OnRun, bpy.types.Operator):
    bl_idname = "rrf.view"
    bl_label = "Look through it"
    bl_description = "Open the live page of the bake in the browser"

    def execute(self, context):
        global _view
        stop_view()
        words = ["view", str(context.scene.rrf.run()), "--open", *self.light_options(context)]
        if context.scene.camera:
            words += frames.camera(context.scene)
        try:
            _view = program.Running(*words)
        except (program.ProgramMissing, OSError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        context.scene.rrf.status = "The page is open in the browser"
        return {"FINISHED"}


class RRF_OT_stop_view(bpy.types.Operator):
    bl_idname = "rrf.stop_view"
    bl_label = "Stop the page"
    bl_description = "End the live page"

    @classmethod
    def poll(cls, _context):
        return view_runs()

    def execute(self, context):
        stop_view()
        context.scene.rrf.status = ""
        return {"FINISHED"}


CLASSES = (RRF_OT_bake, RRF_OT_render, RRF_OT_view, RRF_OT_stop_view)
