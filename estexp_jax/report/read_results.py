"""Results of `explain` read back: whatever else lies under their names is the user's to mend."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from estexp_jax.errors import InputError

_MOST_BYTES = 256 * 2**20
DAMAGE = (KeyError, TypeError, ValueError, AttributeError, IndexError, OverflowError)
"""What a document of the right schema and the wrong contents raises."""


def read_results(path: Path, schema: str, what: str) -> dict[str, Any]:
    """A document that `explain` wrote.

    Args:
        path: of it.
        schema: that it has to have.
        what: what it is, for messages.

    Raises:
        InputError: there is no such file, it is far too long, no JSON, or of another schema.
    """
    right = "give the --out of `estexp explain`"
    try:
        if not path.is_file():  # a link to a device is none, and reading one might never end
            raise InputError("cannot be read: no such file", where=str(path), right=right)
        if path.stat().st_size > _MOST_BYTES:
            raise InputError(f"is {path.stat().st_size:,} bytes long", where=str(path), right=right)
        kept = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise InputError(f"cannot be read: {error}", where=str(path), right=right) from None
    if not isinstance(kept, dict) or kept.get("schema") != schema:
        raise InputError(f"is not {what}", where=str(path), right=f"its schema is {schema}; {right}")
    return kept


def unreadable_result(path: Path, error: Exception) -> InputError:
    """What to tell of a document of the right schema that does not hold what it should."""
    return InputError(f"is damaged ({type(error).__name__}: {error})", where=str(path), right="explain again")
