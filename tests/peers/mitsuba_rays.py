"""Indirect radiance at points by Mitsuba 3's own `path` integrator, as fast as it can be driven.

The row's point and normal are known, so a path starts with the reflection at p: a direction by
cosine, the reflectance as its weight, and the integrator follows the ray from there on. What it
returns leaves the next surface toward p, so the direct light at p is never in it, and Mitsuba
spends neither a camera ray nor a shadow ray on p. Depth unlimited, Russian roulette as it comes.
"""

import drjit as dr
import mitsuba as mi
import numpy as np

from efficiency import Points
from pbrt_room import Room

mi.set_variant("llvm_ad_rgb")


class TableOfLights(mi.Emitter):
    """Isotropic point lights of 1 W/sr, one a row, the row carried in the rays' time.

    Mitsuba has no light whose position differs from path to path; with this one all rows fit one
    kernel launch, which is faster than moving a `point` light from launch to launch.
    """

    def __init__(self, properties):
        super().__init__(properties)
        self.m_flags = mi.EmitterFlags.DeltaPosition
        self.positions = mi.Point3f(0)

    def sample_direction(self, it, sample, active):
        ds = mi.DirectionSample3f()
        ds.p = dr.gather(mi.Point3f, self.positions, mi.UInt32(it.time + 0.5), active)
        ds.n, ds.uv, ds.time, ds.pdf, ds.delta = 0, 0, it.time, 1, True
        ds.emitter = mi.EmitterPtr(self)
        ds.d = ds.p - it.p
        squared = dr.squared_norm(ds.d)
        ds.dist = dr.sqrt(squared)
        ds.d /= ds.dist
        return ds, mi.Spectrum(dr.rcp(squared)) & active

    def eval(self, si, active=True):
        return mi.Spectrum(0)

    def pdf_direction(self, it, ds, active=True):
        return mi.Float(0)

    def eval_direction(self, it, ds, active=True):
        return mi.Spectrum(dr.rcp(dr.square(ds.dist))) & active

    def bbox(self):
        return mi.ScalarBoundingBox3f(0)

    def traverse(self, callback):
        pass


mi.register_emitter("table_of_lights", TableOfLights)


def scene_of(room: Room, light: dict):
    """The room with two-sided diffuse surfaces and flat normals, and one emitter."""
    parts = {"type": "scene", "light": light}
    for i, (material, triangles, positions) in enumerate(room.meshes):
        colour = {"type": "rgb", "value": list(room.reflectance[material])}
        bsdf = {"type": "twosided", "nested": {"type": "diffuse", "reflectance": colour}}
        properties = mi.Properties()
        properties["mesh_bsdf"] = mi.load_dict(bsdf)
        mesh = mi.Mesh(f"mesh{i}", len(positions), len(triangles), props=properties)
        buffers = mi.traverse(mesh)
        buffers["vertex_positions"] = positions.ravel()
        buffers["faces"] = triangles.ravel()
        buffers.update()
        parts[f"mesh{i}"] = mesh
    return mi.load_dict(parts)


class Paths:
    """Launches of `spp` paths from each of some rows."""

    def __init__(self, scene, points: Points, room: Room, rows, sampler: str, spp: int):
        unknown = set(points.material[rows]) - set(room.reflectance)
        if unknown:
            raise ValueError(f"{points.path}: materials {sorted(unknown)} are not in the scene")
        reflectance = np.array([room.reflectance[m] for m in points.material[rows]], np.float32)
        vectors = (points.position[rows], points.normal[rows], reflectance)
        self.p, self.n, self.a = (mi.Vector3f(np.ascontiguousarray(x.T)) for x in vectors)
        dr.eval(self.p, self.n, self.a)
        self.scene, self.rows, self.spp = scene, len(rows), spp
        self.sampler = mi.load_dict({"type": sampler, "sample_count": spp})
        if self.sampler.sample_count() != spp:
            raise ValueError(f"{sampler} cannot take {spp} samples")
        self.sampler.set_samples_per_wavefront(spp)
        self.integrator = mi.load_dict({"type": "path", "max_depth": -1})

    def launch(self, seed: int) -> list:
        """Starts one kernel; sums over each row's paths, a channel each, not waited for."""
        lanes = self.rows * self.spp
        self.sampler.seed(dr.opaque(mi.UInt32, seed), lanes)
        row = dr.arange(mi.UInt32, lanes) // self.spp
        p, n, a = (dr.gather(mi.Vector3f, x, row) for x in (self.p, self.n, self.a))
        local = mi.warp.square_to_cosine_hemisphere(self.sampler.next_2d())
        # far beyond the rounding of a position in a room of 2 m, as Mitsuba's own offset is
        ray = mi.Ray3f(p + n * 1e-5, mi.Frame3f(n).to_world(local))
        ray.time = mi.Float(row)
        radiance, _, _ = self.integrator.sample(self.scene, self.sampler, ray)
        radiance *= mi.Color3f(a)
        dr.eval(radiance)  # all three channels by one kernel; the sums would make it run thrice
        return [dr.block_sum(channel, self.spp) for channel in radiance]

    def mean(self, sums: list) -> np.ndarray:
        """Waits; shape [rows, 3]."""
        dr.eval(sums)
        dr.sync_thread()
        return np.stack([channel.numpy() for channel in sums], axis=1).astype(float) / self.spp


class WholeTable:
    """All rows, each with its own light, in one launch."""

    def __init__(self, room: Room, points: Points, sampler: str, spp: int):
        scene = scene_of(room, {"type": "table_of_lights"})
        lights = mi.Point3f(np.ascontiguousarray(points.light.T))
        dr.eval(lights)
        scene.emitters()[0].positions = lights
        self.paths = Paths(scene, points, room, np.arange(len(points.light)), sampler, spp)

    def run(self, seed: int) -> np.ndarray:
        return self.paths.mean(self.paths.launch(seed))


class MovedLight:
    """A launch for each distinct light, Mitsuba's `point` emitter moved in between."""

    def __init__(self, room: Room, points: Points, sampler: str, spp: int):
        light = {"type": "point", "position": [0, 1, 0], "intensity": {"type": "rgb", "value": 1.0}}
        self.scene = scene_of(room, light)
        self.parameters = mi.traverse(self.scene)
        lights, which = np.unique(points.light, axis=0, return_inverse=True)
        rows = [np.flatnonzero(which.ravel() == k) for k in range(len(lights))]
        make = lambda r: Paths(self.scene, points, room, r, sampler, spp)
        self.groups = [(light, r, make(r)) for light, r in zip(lights, rows)]
        self.shape = points.reference.shape

    def run(self, seed: int) -> np.ndarray:
        sums = []
        for k, (light, _, paths) in enumerate(self.groups):
            self.parameters["light.position"] = mi.Point3f([float(x) for x in light])
            self.parameters.update()
            sums.append(paths.launch(seed * len(self.groups) + k))
        out = np.empty(self.shape)
        for (_, rows, paths), channels in zip(self.groups, sums):
            out[rows] = paths.mean(channels)
        return out


class OneLight:
    """All points under the table's first light by the `point` emitter, in one launch: a rate."""

    def __init__(self, room: Room, points: Points, sampler: str, spp: int):
        position = [float(x) for x in points.light[0]]
        intensity = {"type": "rgb", "value": 1.0}
        scene = scene_of(room, {"type": "point", "position": position, "intensity": intensity})
        self.paths = Paths(scene, points, room, np.arange(len(points.light)), sampler, spp)

    def run(self, seed: int) -> np.ndarray:
        return self.paths.mean(self.paths.launch(seed))
