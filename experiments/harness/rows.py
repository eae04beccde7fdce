"""Rows of results as Parquet files: one row a case or run, and in the file's metadata what they were got with."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import pyarrow as pa
from pyarrow import parquet

from estexp_jax.runs.files import replacing

Rows = list[dict[str, Any]]
_ABOUT, _AS_JSON = b"about", b"columns_in_json"


def write_rows(path: Path, rows: Iterable[Mapping[str, Any]], **about: Any) -> None:
    """Write rows, whole or not at all.

    A column that Parquet would not give back exactly, such as dictionaries with different keys, is kept as JSON text.

    Args:
        path: ends in .parquet.
        rows: JSON values by column; a column that a row lacks is None there.
        **about: seed, versions and the like, JSON values.
    """
    every = [dict(row) for row in rows]
    names = list(dict.fromkeys(name for row in every for name in row))
    columns = {name: [row.get(name) for row in every] for name in names}
    as_json = [name for name, values in columns.items() if not _returns(values)]
    arrays = [pa.array(_texts(v) if n in as_json else v) for n, v in columns.items()]
    metadata = {_ABOUT: json.dumps(about), _AS_JSON: json.dumps(as_json)}
    table = pa.table(dict(zip(names, arrays, strict=True))).replace_schema_metadata(metadata)
    with replacing(path) as stream:
        parquet.write_table(table, stream, compression="zstd", compression_level=19, use_dictionary=False)


def read_rows(path: Path) -> Rows:
    """Rows as they were written; none without a file."""
    if not path.is_file():
        return []
    table = parquet.read_table(path)
    as_json = set(json.loads((table.schema.metadata or {}).get(_AS_JSON, b"[]")))
    return [
        {name: json.loads(value) if name in as_json and value is not None else value for name, value in row.items()}
        for row in table.to_pylist()
    ]


def read_about(path: Path) -> dict[str, Any]:
    """What rows were got with; empty without a file."""
    if not path.is_file():
        return {}
    return json.loads((parquet.read_schema(path).metadata or {}).get(_ABOUT, b"{}"))


def _returns(values: Sequence[Any]) -> bool:
    """Whether Parquet gives a column back exactly: types, missing keys and empty dictionaries."""
    try:
        column = pa.array(values)
        return _storable(column.type) and json.dumps(column.to_pylist()) == json.dumps(values)
    except (pa.ArrowInvalid, pa.ArrowTypeError, pa.ArrowNotImplementedError, OverflowError):
        return False


def _storable(kind: pa.DataType) -> bool:
    """Parquet has no dictionaries without keys."""
    inner = [kind.field(i).type for i in range(kind.num_fields)]
    return not (pa.types.is_struct(kind) and not inner) and all(map(_storable, inner))


def _texts(values: Sequence[Any]) -> list[str | None]:
    return [None if value is None else json.dumps(value) for value in values]
