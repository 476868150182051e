"""A manoeuvre in motion: the ship along her path, and from above with rudder and forces."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from functools import partial
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from pmmkit.base import DataError, Progress
from pmmkit.files import atomic_path
from pmmkit.numerics import Array
from pmmkit.plotting import style
from pmmkit.plotting.axes import Axes
from pmmkit.plotting.figure import Figure
from pmmkit.plotting.layout import laid_out
from pmmkit.plotting.marks import INK
from pmmkit.plotting.turns import WATERLINE, open_mark, oriented, path_axes
from pmmkit.presentation import figure_text, number

if TYPE_CHECKING:
    from matplotlib.axes import Axes as Ground
    from PIL.Image import Image

    from pmmkit.plotting.bands import TrackLike


DOTS: Final = 100
"""Dots per inch: with the figure's size even numbers of dots, as MP4 asks for."""
_LONGEST: Final = 0.8
"""Length of the longest arrow of a manoeuvre [L]: from the bow it stays inside the axes."""
_SMALL: Final = 0.02
"""Side force over the largest force of a manoeuvre below which its place N/Y fades to midship: of
next to nothing it jumps along the ship."""
_BLADE: Final = 0.09
"""Chord of the rudder [L]: longer than a ship's (0.02 to 0.03), to be seen."""
_ABOUT: Final = 0.8
"""What is shown of the water about the path [L]: more than half a ship."""
_UP: Final = 7.4
"""From the axes to the foot of their title [pt], as of titles that stand still."""

Panel = tuple[list[Any], Callable[[int], None]]
"""What moves in it, and what moves it to a frame."""


def animate(
    track: TrackLike,
    path: str | Path,
    *,
    frames: int = 100,
    fps: int = 10,
    called: Callable[[str], str] = str,
    progress: Progress | None = None,
) -> Path:
    """Write a manoeuvre as an animation, all or nothing: `Track.animate`.

    Parameters
    ----------
    track : TrackLike
        Of the manoeuvre, with the forces that it keeps.
    path : path
        A file ``.gif`` or ``.mp4``.
    frames : int
        Pictures, at equal steps of time.
    fps : int
        Pictures in a second.
    called : callable, optional
        From the name of an effect to what the legend calls it.
    progress : Progress, optional
        Told how many pictures are drawn.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    DataError
        If the name has another ending, ffmpeg is not found, or there are no two frames.
    """
    target = Path(path)
    if frames < 2 or not 1 <= fps <= 50:
        raise DataError(
            f"An animation has 2 frames or more and 1 to 50 in a second: frames = {frames}, "
            f"fps = {fps}."
        )
    write = _writer(target)

    def told() -> Iterator[Image]:
        for place, picture in enumerate(_pictures(track, frames, called), 1):
            yield picture
            if progress is not None:
                progress(place, frames, f"frames of {target.name}")

    from pmmkit.plotting.raster import plain

    with plain(), atomic_path(target) as part:
        write(told(), part, fps)
    return target


def _writer(target: Path) -> Callable[[Iterator[Image], Path, int], None]:
    """What writes pictures to a file of that name."""
    ending = target.suffix.lower()
    if ending not in (".gif", ".mp4"):
        raise DataError(f"{target.name}: an animation is a file .gif or .mp4.")
    if ending == ".gif":
        return _gif
    coder = shutil.which("ffmpeg")
    # Windows looks into the folder of the data first: nothing that lies there is run.
    if coder is None or Path(coder).resolve().parent == Path.cwd():
        raise DataError(
            f"{target.name}: MP4 is written by the program ffmpeg, which is not found. Install it "
            f"(ffmpeg.org; apt, brew, winget or conda install ffmpeg), or name a file .gif."
        )
    return partial(_mp4, coder)


def _gif(pictures: Iterator[Image], path: Path, fps: int) -> None:
    from PIL.Image import Dither

    first = next(pictures)
    palette = first.quantize()  # one for all pictures: with one for each the colours flicker
    drawn = (
        item.quantize(palette=palette, dither=Dither.NONE) for item in chain([first], pictures)
    )
    next(drawn).save(path, save_all=True, append_images=drawn, duration=1000 / fps, loop=0)


def _mp4(coder: str, pictures: Iterator[Image], path: Path, fps: int) -> None:
    first = next(pictures)
    size = f"{first.width}x{first.height}"
    come = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", size, "-r", str(fps), "-i", "-"]
    order = [coder, "-y", "-loglevel", "error", *come, "-pix_fmt", "yuv420p", str(path)]
    with subprocess.Popen(order, stdin=subprocess.PIPE, stderr=subprocess.PIPE) as running:
        assert running.stdin is not None
        with suppress(BrokenPipeError):  # it has ended, and says why
            for item in chain([first], pictures):
                running.stdin.write(item.tobytes())
        _, said = running.communicate()
    if running.returncode:
        raise DataError(f"ffmpeg cannot write MP4: {said.decode(errors='replace').strip()}")


def _pictures(track: TrackLike, frames: int, called: Callable[[str], str]) -> Iterator[Image]:
    """The frames; what stands still is drawn once."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from PIL.Image import frombuffer

    from pmmkit.plotting.raster import drawn, moving_axes

    t = np.linspace(track.t[0], track.t[-1], frames)
    at = {
        name: np.interp(t, track.t, getattr(track, name))
        for name in ("x", "y", "psi", "u", "v", "delta")
    }
    pushing = {
        called(name): np.array([np.interp(t, track.t, x) for x in own])
        for name, own in track.forces.items()
    }
    unit = _unit(pushing)
    figure = Figure(height=5.6)
    axes = figure.subplots(1, 2, width_ratios=[3, 2])
    _water(axes[0], track)
    _looked_on(axes[1], pushing, unit)
    for axis in axes:
        axis.set_title(" ")  # room for the title that changes
    figure.suptitle(figure_text(f"{track.name}, L = {track.L:.4g} m, Fn {track.Fn:.3f}"))
    figure.legend_below(list(axes), columns=5)
    scene = laid_out(figure)
    drawing = drawn(scene)
    drawing.set_dpi(DOTS)
    over = moving_axes(drawing, scene)
    panels = [
        _sailing(over[0], track, t, at),
        _from_above(over[1], track.L, at["delta"], pushing, unit),
    ]
    canvas: Any = FigureCanvasAgg(drawing)
    for items, _ in panels:
        for item in items:
            item.set_animated(True)
    canvas.draw()
    still = canvas.copy_from_bbox(drawing.bbox)
    for place in range(frames):
        canvas.restore_region(still)
        for items, move in panels:
            move(place)
            for item in items:
                item.axes.draw_artist(item)
        size = canvas.get_width_height(physical=True)
        yield frombuffer("RGBA", size, bytes(canvas.buffer_rgba()), "raw", "RGBA", 0, 1).convert(
            "RGB"
        )


# What stands still.


def _water(axis: Axes, track: TrackLike) -> None:
    """The path of the ship, and where was ordered what."""
    ahead, aside = track.x / track.L, track.y / track.L
    axis.plot(aside, ahead, color=style.REFERENCE, lw=0.8, ls=":")
    axis.plot([], [], color=style.colour(0), label="path of midship")
    if len(track.orders) <= style.FEW:
        given = np.asarray(track.orders)
        x, y = np.interp(given, track.t, aside), np.interp(given, track.t, ahead)
        open_mark(axis, x, y, "orders", zorder=3)
    path_axes(axis)
    axis.set_xlim(np.nanmin(aside) - _ABOUT, np.nanmax(aside) + _ABOUT)
    axis.set_ylim(np.nanmin(ahead) - _ABOUT, np.nanmax(ahead) + _ABOUT)


def _looked_on(axis: Axes, forces: Mapping[str, Array], unit: float) -> None:
    """Her own axes, with what the marks stand for."""
    axis.set_aspect_equal()
    axis.set_xlim(-0.9, 0.9)
    axis.set_ylim(-1.4, 1.4)
    axis.set_xlabel("to starboard of midship / L [-]")
    axis.set_ylabel("ahead of midship / L [-]")
    for i, name in enumerate(forces):
        axis.plot([], [], ls="", label=figure_text(name), **_mark(i))
    if forces:
        long = f"{number(unit / 1e3)} kN" if unit >= 1e3 else f"{number(unit)} N"
        axis.text(0.02, 0.99, f"forces by effect, 1 L: {long}", fraction=True, va="top")


def _unit(forces: Mapping[str, Array]) -> float:
    """Force whose arrow is a ship length long [N]."""
    largest = max((float(np.hypot(X, Y).max()) for X, Y, _ in forces.values()), default=0.0)
    return largest / _LONGEST or 1.0


def _mark(effect: int) -> dict[str, Any]:
    """How the place of a force looks, by the number of its effect."""
    return {"marker": style.marker(effect), "ms": 3.5, "color": style.colour(1 + effect)}


# What moves over it.


def _sailing(axis: Ground, track: TrackLike, t: Array, at: Mapping[str, Array]) -> Panel:
    """The ship along her path, with what the time is."""
    ahead, aside = track.x / track.L, track.y / track.L
    (sailed,) = axis.plot([], [], color=style.colour(0), lw=1.6)
    hull, blade = _ship(axis)
    speed = np.hypot(at["u"], at["v"])
    title = _title(axis)

    def show(place: int) -> None:
        heading, here = at["psi"][place], np.array([at["y"][place], at["x"][place]]) / track.L
        before = track.t < t[place]
        sailed.set_data(np.append(aside[before], here[0]), np.append(ahead[before], here[1]))
        hull.set_xy(here + oriented(WATERLINE, heading))
        blade.set_data(*(here + oriented(_blade(at["delta"][place]), heading)).T)
        title.set_text(
            f"t = {t[place]:.1f} s, U = {speed[place]:.2f} m/s, ψ = {np.degrees(heading):.0f}°"
        )

    return [sailed, hull, blade, title], show


def _from_above(
    axis: Ground, L: float, delta: Array, forces: Mapping[str, Array], unit: float
) -> Panel:
    """The ship in her own axes, with her rudder and the forces of each effect."""
    hull, blade = _ship(axis)
    hull.set_xy(oriented(WATERLINE, 0.0))
    X, Y, N = np.array(list(forces.values())).reshape(-1, 3, len(delta)).transpose(1, 0, 2)
    from_midship = np.clip(N * Y / (Y**2 + (_SMALL * unit) ** 2) / L, -0.5, 0.5)
    marks = [axis.plot([0.0], [0.0], ls="", **_mark(i))[0] for i in range(len(forces))]
    arrows: Any = axis.quiver(
        *np.zeros((4, len(forces))),
        color=[style.colour(1 + i) for i in range(len(forces))],
        angles="xy",
        scale_units="xy",
        scale=1.0,
        width=0.01,
    )
    title = _title(axis)

    def show(place: int) -> None:
        blade.set_data(*oriented(_blade(delta[place]), 0.0).T)
        angle = np.degrees(delta[place])
        title.set_text("" if np.isnan(angle) else f"rudder δ = {angle:.1f}°")
        arrows.set_offsets(np.stack([0.0 * X[:, place], from_midship[:, place]], axis=1))
        arrows.set_UVC(Y[:, place] / unit, X[:, place] / unit)
        for mark, begin in zip(marks, from_midship[:, place], strict=True):
            mark.set_data([0.0], [begin])

    return [hull, blade, arrows, title, *marks], show


def _title(axis: Ground) -> Any:
    """The title that changes."""
    return axis.annotate(
        "", (0.0, 1.0), (0.0, _UP), xycoords="axes fraction", textcoords="offset points",
        color=INK, fontsize=10,
    )  # fmt: skip


def _ship(axis: Ground) -> tuple[Any, Any]:
    """Hull and rudder, which a frame puts in their places."""
    (hull,) = axis.fill([0.0], [0.0], facecolor=style.colour(0), edgecolor="none", alpha=0.35)
    (blade,) = axis.plot([], [], color=INK, lw=2.0)
    return hull, blade


def _blade(delta: float) -> Array:
    """Ends of a rudder at the stern: the trailing edge goes to the side to which the ship turns."""
    stock = WATERLINE[:, 0].min()
    return np.array([(stock, 0.0), (stock - _BLADE * np.cos(delta), _BLADE * np.sin(delta))])
