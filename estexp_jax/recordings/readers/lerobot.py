"""Read LeRobot data sets: folders of Parquet files, many episodes in them, described by `meta/info.json`.

Layout of version 3: `data/chunk-000/file-000.parquet`, several episodes a file, and `meta/episodes/` saying which file
holds which episode; of version 2: `data/chunk-000/episode_000000.parquet`. `data_path` in info.json is the template of
both (https://huggingface.co/docs/lerobot/lerobot-dataset-v3).
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np

from estexp_jax.errors import InputError
from estexp_jax.recordings.readers.arrow import table_of
from estexp_jax.recordings.readers.parquet import EPISODE, episodes, part_names, read_columns, read_info
from estexp_jax.recordings.readers.stamps import is_stamp
from estexp_jax.recordings.table import Selection, Table

_PLACEHOLDER = re.compile(r"\{(chunk_index|file_index|episode_chunk|episode_index)(?::0?(\d{1,2})d)?\}")
_CHUNK, _FILE = "data/chunk_index", "data/file_index"
_MOST_FILES = 100_000


def read_lerobot(folder: Path, selection: Selection) -> Table:
    """Read one episode of a LeRobot data set, version 2 or 3; images and videos are not read.

    Raises:
        InputError: the folder is not a data set, its description is damaged or points outside the folder, a file is
            missing or damaged, or the episode does not exist or was not chosen among several.
    """
    if not (folder / "meta" / "info.json").is_file():
        right = "a log, or the folder of a LeRobot data set, which has meta/info.json in it"
        raise InputError("is a folder, not a recording", where=str(folder), right=right)
    info = read_info(folder)
    episode = _chosen_episode(info, selection.episode, folder)
    source = f"{folder}, episode {episode}"
    arrays, columns = read_columns(_data_files(folder, info, episode), episode, source, selection.asks_for)
    label = f"{folder.resolve().name}_episode_{episode}.parquet"
    notes = _clock_notes(info, arrays.get("timestamp", np.empty(0)))
    return table_of(arrays, columns, source, label=label, parts=part_names(info, arrays), notes=notes)


def _clock_notes(info: Mapping[str, Any], times: np.ndarray) -> tuple[str, ...]:
    """A remark on time stamps that were counted, not measured."""
    fps = info.get("fps")
    if not isinstance(fps, int | float) or not fps > 0 or len(times) < 3 or is_stamp(times):
        return ()
    if np.abs(times - times[0] - np.arange(len(times)) / fps).max() > 1e-3 / fps:
        return ()
    what = f"its time stamps are the frames' numbers over {fps:g} Hz, not measured: delays and lags cannot be trusted"
    return (f"{what}; log when each reading was taken",)


def _chosen_episode(info: Mapping[str, Any], episode: int | None, folder: Path) -> int:
    version, total = info.get("codebase_version"), _whole_number(info, "total_episodes", folder)
    if not isinstance(version, str) or not re.match(r"v[23]\.", version):
        where = f"{folder / 'meta' / 'info.json'}, codebase_version"
        raise InputError(f"is {version!r}", where=where, right="versions v2.x and v3.x are read")
    if episode is None and total != 1:
        raise InputError(f"has {total} episodes", where=str(folder), right=episodes(np.arange(min(total, 21))))
    if not 0 <= (episode or 0) < total:
        raise InputError(f"has no episode {episode}", where=str(folder), right=episodes(np.arange(min(total, 21))))
    return episode or 0


def _whole_number(info: Mapping[str, Any], key: str, folder: Path) -> int:
    value = info.get(key)
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < 2**40:
        where = f"{folder / 'meta' / 'info.json'}, {key}"
        raise InputError(f"is {str(value)[:80]!r}", where=where, right="a whole number of at least 0")
    return value


def _data_files(folder: Path, info: Mapping[str, Any], episode: int) -> list[Path]:
    """The Parquet files that may hold an episode."""
    template = _template(info, folder)
    used = {match[1] for match in _PLACEHOLDER.finditer(template)}
    if used & {"episode_chunk", "episode_index"}:
        size = max(_whole_number(info, "chunks_size", folder), 1)
        files = [folder / _fill_template(template, {"episode_chunk": episode // size, "episode_index": episode})]
    elif (place := _file_indices(folder, episode)) is not None:
        files = [folder / _fill_template(template, place)]
    else:
        files = sorted(folder.glob(_PLACEHOLDER.sub("*", template)))[: _MOST_FILES + 1]
    missing = [path for path in files if not path.is_file()]
    if missing or not files or len(files) > _MOST_FILES:
        what = f"no such data file '{missing[0]}'" if missing else f"{len(files)} data files at '{template}'"
        raise InputError(what, where=f"{folder}, episode {episode}", right="a complete copy of the data set")
    return files


def _template(info: Mapping[str, Any], folder: Path) -> str:
    """The template of the data files' paths; it must be relative and stay inside the folder, as it is not trusted."""
    template, where = info.get("data_path"), f"{folder / 'meta' / 'info.json'}, data_path"
    right = "a path in the data set such as data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
    if not isinstance(template, str) or not template.endswith(".parquet") or len(template) > 500:
        raise InputError(f"is {str(template)[:80]!r}", where=where, right=right)
    rest = _PLACEHOLDER.sub("0", template)
    path = PurePosixPath(rest)
    if path.is_absolute() or ".." in path.parts or re.search(r"[{}*?\[\]\\:\0]", rest):
        raise InputError(f"'{template}' may lead out of the data set", where=where, right=right)
    return template


def _fill_template(template: str, indices: Mapping[str, int]) -> str:
    return _PLACEHOLDER.sub(lambda match: f"{indices[match[1]]:0{int(match[2] or 1)}d}", template)


def _file_indices(folder: Path, episode: int) -> dict[str, int] | None:
    """Chunk and file of an episode from `meta/episodes`; None if it is not listed there."""
    for path in sorted((folder / "meta" / "episodes").glob("*/*.parquet"))[:_MOST_FILES]:
        try:
            columns, _ = read_columns([path], episode, str(path), (EPISODE, _CHUNK, _FILE).__contains__)
        except InputError:  # a damaged or incomplete index: the data files are searched instead
            continue
        indices = [columns.get(name, np.empty(0)) for name in (_CHUNK, _FILE)]
        if all(len(values) == 1 and 0 <= values[0] < 2**40 for values in indices):
            return {"chunk_index": int(indices[0][0]), "file_index": int(indices[1][0])}
    return None
