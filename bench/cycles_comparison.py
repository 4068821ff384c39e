#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Renders one lit smoke by Volute and by Blender's Cycles, and says by how much the pictures differ.

    bench/cycles_comparison.py build/release/bin/volute --samples 1024 -o cycles.png

Both read the same .vdb: 64^3 voxels, trilinear, absorption and single scattering (Cycles with 0 bounces), one sun, one camera, and
black behind. The picture shows Volute, Cycles, and their difference, ten times as bright. Needs Blender 3.4 (Debian 12: apt-get install
--no-install-recommends blender); its CPU renderer takes about a minute.
"""
import argparse
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import time

EXTINCTION = 7.0  # [1/m] of a density of 1
VOXEL = 2 / 64  # [m]
ALBEDO = 0.9
ASYMMETRY = 0.3
SUN = {"direction": [0.55, 0.5, -0.67], "radiance": [3.0, 2.8, 2.4]}
CAMERA = {"eye": [-1.2, -4.4, 1.9], "target": [0, 0, 0.9], "fov": 27}


def render_in_blender(job):
    """Inside Blender. Spectra: the sun's colour and strength make its irradiance, one shader each scatters and absorbs."""
    import bpy
    from mathutils import Vector

    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    data = bpy.data.volumes.new("smoke")
    data.filepath = job["vdb"]
    smoke = bpy.data.objects.new("smoke", data)
    # OpenVDB has the value of voxel i at index i, Cycles at i + 1/2.
    smoke.location = [-0.5 * job["voxel"]] * 3
    scene.collection.objects.link(smoke)

    material = bpy.data.materials.new("smoke")
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    density, times, add = nodes.new("ShaderNodeAttribute"), nodes.new("ShaderNodeMath"), nodes.new("ShaderNodeAddShader")
    scatter, absorb = nodes.new("ShaderNodeVolumeScatter"), nodes.new("ShaderNodeVolumeAbsorption")
    density.attribute_name = job["grid"]
    times.operation = "MULTIPLY"
    times.inputs[1].default_value = job["extinction"]
    links.new(density.outputs["Fac"], times.inputs[0])
    for shader in (scatter, absorb):
        shader.inputs["Color"].default_value = [job["albedo"]] * 3 + [1]
        links.new(times.outputs[0], shader.inputs["Density"])
    scatter.inputs["Anisotropy"].default_value = job["asymmetry"]
    links.new(scatter.outputs[0], add.inputs[0])
    links.new(absorb.outputs[0], add.inputs[1])
    links.new(add.outputs[0], nodes.new("ShaderNodeOutputMaterial").inputs["Volume"])
    material.cycles.volume_interpolation = "LINEAR"
    data.materials.append(material)

    light = bpy.data.lights.new("sun", "SUN")
    light.angle = 0
    light.energy = max(job["sun"]["radiance"])
    light.color = [value / light.energy for value in job["sun"]["radiance"]]
    sun = bpy.data.objects.new("sun", light)
    sun.rotation_euler = Vector(job["sun"]["direction"]).to_track_quat("-Z", "Y").to_euler()
    scene.collection.objects.link(sun)

    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.sensor_fit = "VERTICAL"
    camera.data.angle = math.radians(job["camera"]["fov"])
    camera.location = job["camera"]["eye"]
    way = Vector(job["camera"]["target"]) - camera.location
    camera.rotation_euler = way.to_track_quat("-Z", "Y").to_euler()
    scene.collection.objects.link(camera)
    scene.camera = camera

    scene.render.engine = "CYCLES"
    scene.cycles.device = "CPU"
    scene.cycles.samples = job["samples"]
    scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
    scene.cycles.max_bounces = scene.cycles.volume_bounces = 0
    scene.cycles.volume_step_rate = job["step_rate"]
    scene.cycles.volume_max_steps = 4096
    scene.cycles.pixel_filter_type = "BOX"
    scene.cycles.sample_clamp_direct = scene.cycles.sample_clamp_indirect = 0
    scene.render.resolution_x = scene.render.resolution_y = job["pixels"]
    scene.render.resolution_percentage = 100
    scene.render.threads_mode, scene.render.threads = "FIXED", job["threads"]
    scene.view_settings.view_transform = "Raw"
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_mode = "RGB"
    scene.render.image_settings.color_depth = "32"
    scene.render.image_settings.exr_codec = "NONE"
    scene.render.filepath = job["out"]
    bpy.ops.render.render(write_still=True)


def render_by_volute(volute, job, out):
    scene = {
        "format": "volute-scene-1",
        "camera": {**job["camera"], "size": [job["pixels"]] * 2},
        "lights": [{"kind": "sun", **job["sun"]}],
        "media": [{"kind": "volume", "file": job["vdb"], "emission": 0, "extinction": job["extinction"],
                   "albedo": [job["albedo"]] * 3, "asymmetry": job["asymmetry"], "basis": "trilinear"}],
    }
    path = out.with_suffix(".json")
    path.write_text(json.dumps(scene), encoding="utf-8")
    subprocess.run([volute, "render", path, "-o", out, "--samples", "1", "-q"], check=True)


def compare(a, b):
    """RMS and largest difference, and the mean of b over that of a, all of where a is not black, as shares of a's largest."""
    largest = max(a.values)
    lit = [(x, y) for x, y in zip(a.values, b.values) if x > 1e-3 * largest]
    squares = sum((x - y) ** 2 for x, y in lit) / len(lit)
    return {"rms": math.sqrt(squares) / largest, "largest": max(abs(x - y) for x, y in lit) / largest,
            "mean_ratio": sum(y for _, y in lit) / sum(x for x, _ in lit)}


def side_by_side(pictures, a, b, out):
    largest = max(a.values)
    wide = pictures.Picture(3 * a.width, a.height, 3)
    for y in range(a.height):
        for x in range(a.width):
            first, second = ([p.at(x, y, c) / largest for c in range(3)] for p in (a, b))
            for panel, value in enumerate((first, second, [10 * abs(p - q) for p, q in zip(first, second)])):
                at = (y * wide.width + panel * a.width + x) * 3
                wide.values[at:at + 3] = value
    pictures.write_png(out, wide)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("volute")
    parser.add_argument("-o", "--output", type=pathlib.Path, default=pathlib.Path("cycles.png"))
    parser.add_argument("--pixels", type=int, default=256)
    parser.add_argument("--samples", type=int, default=256, help="of Cycles, for each pixel")
    parser.add_argument("--step-rate", type=float, default=0.25, help="Cycles' steps, in its steps of a voxel")
    parser.add_argument("--threads", type=int, default=os.cpu_count())
    parser.add_argument("--blender", default="blender")
    parser.add_argument("--keep", type=pathlib.Path, help="a folder for the smoke and both pictures as .exr")
    options = parser.parse_args()
    sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "tests/cli"))
    import pictures

    with tempfile.TemporaryDirectory() as folder:
        folder = (options.keep or pathlib.Path(folder)).resolve()
        folder.mkdir(parents=True, exist_ok=True)
        subprocess.run([options.volute, "synthesize", "smoke", "--scalar", "--size", "64", "--frames", "2", "--seed", "3", "-q", 
                        "-o", folder / "smoke_%04d.vdb"], check=True)
        vdb = sorted(folder.glob("smoke_*.vdb"))[-1]
        info = json.loads(subprocess.run([options.volute, "info", vdb, "--json"], check=True, stdout=subprocess.PIPE).stdout)
        job = {"vdb": str(vdb), "grid": info["grids"][0]["name"], "voxel": VOXEL, "extinction": EXTINCTION, "albedo": ALBEDO, "asymmetry": ASYMMETRY,
               "sun": SUN, "camera": CAMERA, "pixels": options.pixels, "samples": options.samples, "step_rate": options.step_rate,
               "threads": options.threads, "out": str(folder / "cycles.exr")}
        begin = time.monotonic()
        render_by_volute(options.volute, job, folder / "volute.exr")
        own = time.monotonic() - begin
        (folder / "job.json").write_text(json.dumps(job), encoding="utf-8")
        begin = time.monotonic()
        subprocess.run([options.blender, "--background", "--factory-startup", "--python-exit-code", "1", "--python", __file__, "--",
                        folder / "job.json"], check=True, stdout=subprocess.DEVNULL)
        theirs = time.monotonic() - begin
        a, b = (pictures.read_exr(folder / f"{name}.exr") for name in ("volute", "cycles"))
        side_by_side(pictures, a, b, options.output)
        print(json.dumps({**compare(a, b), "volute_seconds": own, "cycles_seconds": theirs, "samples": options.samples}))


if __name__ == "__main__":
    try:
        import bpy  # noqa: F401
    except ImportError:
        main()
    else:
        render_in_blender(json.loads(pathlib.Path(sys.argv[-1]).read_text(encoding="utf-8")))
