# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Effects: volumes compressed, rendered, filmed and converted back to .vdb; fog and fire in a valley."""
import errors
import fire_in_fog
from plan import Build, Chapter, Choice, Command, Drawn, Fact, Picture, Section, Step, Wipe
from words import NBSP, bytes_of, percent, ratio

BUILD_SECONDS = 420  # of CPU time, with an empty cache
# The default, whose haze is invisible three stops up; the chapter measures that, and two coarser ones, in every run.
USUAL = "look"
COARSER = ("draft", "3e-3")
EXPOSURE = 2.4  # before the tone curve
BRIGHT = 6.4  # three stops above what a display shows, without one
LOOK = "--eye 0,-4.2,1.25 --target 0,0,1 --fov 30 --basis trilinear"
FIRE, BACK = "effects/fire/fire_%04d.vdb", "effects/back/fire_%04d.vdb"
SIGMA, PROFILE = 0.05, "exponential:2,9"


def volute(quality):
    return "effects/fire.volute" if quality == USUAL else f"effects/fire_{quality}.volute"


def option(quality):
    return f"--quality {quality}" if quality in ("look", "draft") else f"--rms {quality}"


def bright(quality):
    return f"effects/bright_{quality}.png"


def fire(scale):
    """The sequence and its way through Volute, one frame of it three stops up."""
    voxels, frames, pixels = scale.pick((64, 64, 512), (48, 24, 384))
    time = frames / 2 / 25
    look = f"{LOOK} --size {pixels}x{pixels}"
    at = f"{look} --time {time:g}"

    def picture(volume, out, read, exposure=None):
        shown = f" --exposure {exposure:g}{' --tone none' if exposure == BRIGHT else ''}" if exposure else " --measured"
        return Step((out,), f"volute render {volume} -o {out} {at}{shown}", reads=(read,))

    steps = [
        Step(("effects/fire/",), f"volute synthesize fire -o {FIRE} --size {voxels} --frames {frames}"),
        picture(FIRE, "effects/original.png", "effects/fire/", EXPOSURE),
        Step((volute(USUAL),), f"volute compress {FIRE} -o {volute(USUAL)} --fast", reads=("effects/fire/",)),
        picture(volute(USUAL), "effects/fire.png", volute(USUAL), EXPOSURE),
        Step(("effects/fire.mp4",), f"volute render {volute(USUAL)} -o effects/fire.mp4 {look} --exposure {EXPOSURE}",
             reads=(volute(USUAL),)),
        Step(("effects/back/",), f"volute extract {volute(USUAL)} -o {BACK}", reads=(volute(USUAL),)),
        picture(FIRE, "effects/original.exr", "effects/fire/"),
        picture(BACK, "effects/back.exr", "effects/back/"),
        Step(("effects/difference.png",), work=errors.difference, arguments=("effects/original.exr", "effects/back.exr", "effects/difference.png"),
             reads=("effects/original.exr", "effects/back.exr")),
        picture(FIRE, "effects/bright_original.png", "effects/fire/", BRIGHT)]
    for rms in COARSER:
        steps.append(Step((volute(rms),), f"volute compress {FIRE} -o {volute(rms)} {option(rms)} --fast", reads=("effects/fire/",)))
    exrs = []
    for rms in (USUAL, *COARSER):
        exrs.append(f"effects/fire_{rms}.exr")
        steps += [picture(volute(rms), bright(rms), volute(rms), BRIGHT), picture(volute(rms), exrs[-1], volute(rms))]
    steps.append(Step(("effects/haze.json",), work=errors.haze, arguments=("effects/original.exr", tuple(exrs), BRIGHT, "effects/haze.json"),
                      reads=("effects/original.exr", *exrs)))
    return steps


def haze_table(results):
    lit = results.report("effects/haze.json")["lit"]
    rows = [[f"`{option(rms)}`", bytes_of(results.size(volute(rms))), ratio(results, "effects/fire/", volute(rms)),
             percent(lit[f"effects/fire_{rms}.exr"]["share"]), lit[f"effects/fire_{rms}.exr"]["brightest"]] for rms in (USUAL, *COARSER)]
    return {"caption": "Black pixels are those that the original's picture, three stops up, stores as 0 in all channels. One frame of this run's "
                       "fire, compressed with `--fast`.",
            "columns": ["setting", "file on disk", "ratio to the .vdb files", "black pixels lit", "brightest of them, of 255"], "rows": rows}


def fire_section(scale):
    voxels, frames = scale.pick((64, 64), (48, 24))

    def disk(results):
        return (f"{bytes_of(results.size('effects/fire/'))} of .vdb files become {bytes_of(results.size(volute(USUAL)))}; raw float32 "
                f"would take {bytes_of(frames * voxels ** 3 * 3 * 4)}")

    return Section(
        "Fire: from .vdb to a film and back",
        (f"{frames} frames of {voxels}³ RGB voxels at 25 frames per second, one .vdb file per frame, as a simulation writes them. `volute compress` "
         "turns them into one .volute file with random access to every frame; the film is rendered from that file.",
         "In Blender: Add, Volume, Import OpenVDB, and select all files of [effects/back](effects/back/); the grid is called `emission`."),
        (Fact(lambda r: ratio(r, "effects/fire/", volute(USUAL)), ".vdb files to .volute, on disk", ("effects/fire/", volute(USUAL))),
         Fact(lambda r: percent(r.report("effects/difference.png")["relative_l2"]), "relative L2 error of a picture of the restored files",
              ("effects/difference.png",)),
         Wipe(("effects/original.png", ".vdb"), ("effects/fire.png", ".volute"), "Before and after", disk),
         Picture("effects/fire.mp4", "The film", f"Emission only, trilinear between voxel centres; perspective 30°, exposure {EXPOSURE}, filmic tone curve",
                 poster="effects/fire.png"),
         Picture("effects/difference.png", "Difference between pictures of the original and the restored files",
                 lambda r: "Length of the RGB difference in linear light; viridis, from violet (0) to yellow "
                           f"({percent(r.report('effects/difference.png')['largest'])} of the brightest channel)"),
         Command(volute(USUAL), "The compressed file"),
         Command("effects/back/", "Back to .vdb files, for Blender, Houdini or Nuke")), columns=3)


def haze_section():
    return Section(
        "Which error to choose",
        ("When compositors raise the exposure, coding errors appear as haze where nothing burns. Here is one frame three stops up (eight times as "
         "bright), at three settings: the default, a draft, and an error that is the same for all values.",),
        (Choice((("effects/bright_original.png", "original"), *((bright(rms), option(rms)) for rms in (USUAL, *COARSER))),
                "Three stops up", "Move the slider and look at the black around the flame"),
         Command("effects/haze.json", "Measures the share of black pixels that are lit, from the linear values of the frame", wide=False),
         Drawn("table", haze_table, ("effects/haze.json", *map(volute, (USUAL, *COARSER))))), columns=2)


def smoke(scale):
    voxels, frames, pixels = scale.pick((64, 48, 512), (48, 16, 384))
    look = f"--eye 0,-4.2,1.25 --target 0,0,1 --fov 26 --size {pixels}x{pixels}"
    at = f"{look} --time {frames / 2 / 25:g}"
    return [
        Step(("effects/smoke/",), f"volute synthesize smoke -o effects/smoke/smoke_%04d.vdb --scalar --size {voxels} --frames {frames}"),
        Step(("effects/smoke.volute",), f"volute compress effects/smoke/smoke_%04d.vdb -o effects/smoke.volute --fast",
             reads=("effects/smoke/",)),
        Step(("effects/smoke_plain.png",), f"volute render effects/smoke.volute -o effects/smoke_plain.png {at} --preset none",
             reads=("effects/smoke.volute",)),
        Step(("effects/smoke.png",), f"volute render effects/smoke.volute -o effects/smoke.png {at}", reads=("effects/smoke.volute",)),
        Step(("effects/smoke.mp4",), f"volute render effects/smoke.volute -o effects/smoke.mp4 {look}", reads=("effects/smoke.volute",))]


def smoke_section(scale):
    voxels, frames = scale.pick((64, 48), (48, 16))
    return Section(
        "Lit smoke",
        (f"Smoke is slow and dense, while the fire was fast and mostly empty: {frames} frames of {voxels}³ voxels with a density only. "
         "`volute render` shows a grid of that name as smoke, prints a remark, and lights it by a sun and the sky, scattered once and shadowed "
         "by the smoke itself, by exact optical depths.",),
        (Wipe(("effects/smoke_plain.png", "values"), ("effects/smoke.png", "lit"), "Values and smoke",
              "Left: the density shown as light. Right: the default, with albedo 0.9 and asymmetry 0.3"),
         Picture("effects/smoke.mp4", "The film", "Trilinear between voxel centres; exposure set once, filmic tone curve", poster="effects/smoke.png"),
         Fact(lambda r: ratio(r, "effects/smoke/", "effects/smoke.volute"), ".vdb files to .volute, on disk",
              ("effects/smoke/", "effects/smoke.volute")),
         Command("effects/smoke.volute", lambda r: f"The compressed file, {bytes_of(r.size('effects/smoke.volute'))}", wide=False)))


def puffs(scale):
    """A cache that is large and nearly empty."""
    voxels, frames, pixels = scale.pick((512, 4, 512), (256, 2, 384))
    return [
        Step(("effects/puffs/",), f"volute synthesize puffs -o effects/puffs/puffs_%04d.vdb --size {voxels} --frames {frames}"),
        Step(("effects/puffs.volute",), "volute compress effects/puffs/puffs_%04d.vdb -o effects/puffs.volute --fast", reads=("effects/puffs/",)),
        Step(("effects/puffs.png",), f"volute render effects/puffs.volute -o effects/puffs.png --size {pixels}x{pixels}",
             reads=("effects/puffs.volute",))]


def puffs_section(scale):
    voxels, frames = scale.pick((512, 4), (256, 2))
    return Section(
        "A large cache, nearly empty",
        (f"{frames} frames of {voxels}³ voxels, of which one per cent hold smoke, as production caches are. Reading, compressing, lighting and "
         "rendering take what is in them, not the box around it; which voxels are active comes back without loss.",),
        (Picture("effects/puffs.png", "Twelve puffs", "The default look of a density: lit by a sun and the sky"),
         Fact(lambda r: ratio(r, "effects/puffs/", "effects/puffs.volute"), ".vdb files to .volute, on disk", ("effects/puffs/", "effects/puffs.volute")),
         Command("effects/puffs.volute",
                 lambda r: f"The compressed file, {bytes_of(r.size('effects/puffs.volute'))}; raw float32 would take {bytes_of(frames * voxels ** 3 * 4)}",
                 wide=False)))


def put_fog(out, *more, folder="effects/valley", cell=8, degree=2, frames="", makes=None, reads=()):
    """A step that adds the fog of a painted map to frames of the valley."""
    words = (f"volute fog {folder}/fogmap.png --color {folder}/color{frames}.{'png' if frames else 'exr'} --depth {folder}/depth{frames}.exr "
             f"--camera {folder}/camera{frames}.json -o {out} --degree {degree} --cell {cell} --sigma-max {SIGMA} "
             f"--profile {PROFILE}")
    return Step((out,), " ".join((words, *more)), reads=(f"{folder}/", *reads))


def valley(scale):
    frames, pixels = scale.pick((40, "480x270"), (16, "240x136"))
    return [
        Step(("effects/valley/",), "volute synthesize valley -o effects/valley --pixels 640x360 --size 64 --geometry"),
        put_fog("effects/fog.png"),
        put_fog("effects/fog_sun.png", "--sun=-0.45,-0.85,-0.42 --sun-radiance 3,2.3,1.5 --asymmetry 0.6 --fog-color 0.28,0.33,0.40",
                "--geometry effects/valley/valley.glb"),
        Step(("effects/fog_none.png",), "volute fog effects/valley/fogmap.png --color effects/valley/color.exr --depth effects/valley/depth.exr "
             "--camera effects/valley/camera.json -o effects/fog_none.png --sigma-max 0", reads=("effects/valley/",)),
        Step(("effects/flight/",), f"volute synthesize valley -o effects/flight --pixels {pixels} --size 64 --frames {frames}"),
        put_fog("effects/flight.mp4", "--wind 3,-1,0 --rate 16", folder="effects/flight", frames="_%04d")]


def evening(scale):
    """All media in one scene."""
    scene, out = "effects/fire_in_fog.json", "effects/fire_in_fog.png"
    time, pixels = scale.pick((1.28, (640, 360)), (0.48, (320, 180)))
    return [
        Step((scene,), work=fire_in_fog.write_scene, arguments=("effects/valley/", volute(USUAL), scene, pixels, SIGMA), reads=("effects/valley/",)),
        Step((out,), f"volute render {scene} -o {out} --time {time} --exposure 2", reads=(scene, "effects/valley/", volute(USUAL)))]


def evening_section():
    return Section(
        "Everything in one scene",
        ("[fire_in_fog.json](effects/fire_in_fog.json) combines the valley's surfaces, a weak sun, the painted fog, and the compressed fire, "
         f"{fire_in_fog.FIRE_METRES}{NBSP}m high. `volute view effects/fire_in_fog.json` opens it in a window, where fog can be painted with a "
         "brush (the demo compiles the viewer last; `./dev view demo/effects/fire_in_fog.json` does at any time).",),
        (Picture("effects/fire_in_fog.png", "A bonfire in the fog at dusk", "Fire and fog add up along each ray and end at surfaces; "
                                                                            "a lamp in the fire, ten times its power, lights surfaces and "
                                                                            "fog; linear light, exposure 2, sRGB"),), columns=1)


def valley_section(scale):
    frames = scale.pick(40, 16)
    look = "perspective 50°, linear light, shown as sRGB"
    return Section(
        "Fog over a valley",
        ("Fog is painted: a map gives its density at each place, a profile its decrease with height. The valley is a picture with "
         "depths, as any renderer can write it; `volute fog` integrates the fog from the eye to each pixel's depth, exactly in every cell of "
         "the map.",),
        (Fact(lambda r: f"{r.report('effects/flight.mp4')['milliseconds'] / frames:.0f}{NBSP}ms", "per frame of the flight, including reading "
                                                                                                  "and encoding",
              ("effects/flight.mp4",)),
         Wipe(("effects/fog_none.png", "frame"), ("effects/fog_sun.png", "fog"), "A low sun in the fog",
              f"Its light is scattered once, with shadows from the fog itself and from hills, trees and houses; {look}"),
         Picture("effects/fog.png", "Painted fog", f"Splines of degree 2 on a map with cells of 8{NBSP}m; white is {SIGMA}{NBSP}/m; {look}"),
         Picture("effects/flight.mp4", "A flight", f"{frames} frames, 16 per second; constant fog colour, a wind of 3{NBSP}m/s", poster="effects/fog.png")),
        columns=3)


def chapter(scale):
    return Chapter(
        "effects", "Effects", "A sequence of volumes is compressed, rendered, filmed, and converted back to .vdb for Blender; fog is painted over a valley.",
        # The first picture needs only the command and the .vdb reader; the other readers are built after it.
        (Build("volute", BUILD_SECONDS), Build("volute_io_vdb", 35), *fire(scale)[:2], Build("volute-plugins", 55), *fire(scale)[2:],
         *valley(scale), *evening(scale), *smoke(scale), *puffs(scale)),
        (fire_section(scale), haze_section(), valley_section(scale), evening_section(), smoke_section(scale), puffs_section(scale)),
        door=("effects/fire_in_fog.png", "effects/fire.png", "effects/original.png"))
