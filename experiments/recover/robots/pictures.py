"""What a recovery looks like, where robots can be drawn."""

from __future__ import annotations

from pathlib import Path

from estexp_jax.report.drawing.gl import NoGlError
from estexp_jax.report.recover.film import film_of
from experiments.recover.robots.cases import RobotCase, job, state_of


def show(case: RobotCase, store: Path, out: Path) -> None:
    """Write the strip of a run, and its film where the extra `video` is there."""
    try:
        film = film_of(job(case), state_of(case, store))
    except NoGlError as error:
        print(f"no pictures: {error}")
        return
    if film is not None:
        (out / f"{case.model}.jpg").write_bytes(film.strip)
        if film.video is not None:
            (out / f"{case.model}.mp4").write_bytes(film.video)
