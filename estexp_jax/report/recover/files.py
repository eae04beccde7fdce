"""Files that a recovery leaves in its folder."""

from __future__ import annotations

from typing import Any

from estexp_jax.recovery.cycle import Job
from estexp_jax.recovery.state import RunState
from estexp_jax.report.drawing.film import can_film
from estexp_jax.report.drawing.gl import NoGlError
from estexp_jax.report.recover.film import Film, film_of
from estexp_jax.report.recover.page import recover_page
from estexp_jax.report.recover.run_data import run_record, write_history, write_traces
from estexp_jax.runs import ProgressDisplay, RunFolder, versions, write_json
from estexp_jax.runs.files import replacing


def write_recovery(
    folder: RunFolder, job: Job, state: RunState, config: dict[str, Any], progress: ProgressDisplay, *, pictures: bool
) -> None:
    """Write `run.json`, `history.parquet`, `traces.npz`, the report and, where asked for, the pictures."""
    axis, simulator = job.settings.axis, job.simulator
    with replacing(folder.file("history.parquet")) as stream:
        write_history(stream, state)
    with replacing(folder.file("traces.npz")) as stream:
        write_traces(stream, state, simulator.robot, simulator.closed_loop.interface)
    record = run_record(state, axis, job.planted, config, stands_in=job.stands_in)
    write_json(folder.file("run.json"), {**record, "versions": versions()})
    film = _film(folder, job, state, progress) if pictures else None
    title = f"{config['model']}: recovery, seed {job.settings.seed}"
    planted = None if config["robot"] == "hardware" else job.planted
    with replacing(folder.file("report.html")) as stream:
        stream.write(recover_page(title, planted, state, axis, config, film, stands_in=job.stands_in).encode())
    progress.say(f"Report: {folder.path / 'report.html'}")


def _film(folder: RunFolder, job: Job, state: RunState, progress: ProgressDisplay) -> Film | None:
    """Pictures of how it walks, written; None where they cannot be drawn, and the reason is printed."""
    progress.stage("pictures")
    try:
        film = film_of(job, state)
    except NoGlError as error:
        progress.say(f"No pictures: {error}")
        return None
    if film is None:
        return None
    for name, content in (("film.jpg", film.strip), ("film.mp4", film.video)):
        if content is not None:
            with replacing(folder.file(name)) as stream:
                stream.write(content)
    if not can_film():
        progress.say("Pictures, but no film: pip install 'estexp_jax[video]'")
    return film
