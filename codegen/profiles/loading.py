"""Policy profiles from their JSON text.

Does: reads and checks a text; tells where it is damaged, and whether it was edited; the schema that texts keep.
Assumes: UTF-8 text in the shape of form/schema.py.
Does not: touch files.
"""

import re
from typing import Any

import msgspec

from codegen.errors import ProfileError, escape_text
from codegen.form.breaks import place
from codegen.form.fault import make_fault
from codegen.form.schema import ProfileJson
from codegen.ir import PolicyProfile
from codegen.policy_json import content_hash, decode
from codegen.profiles.rules import find_besides

MAX_BYTES = 256 * 2**20  # a profile beyond this is not one of ours
RESTORE = "the file is truncated or not a profile; restore it or extract it again"


def loads(text: str | bytes, where: str = "profile") -> PolicyProfile:
    """The profile in a JSON text. ProfileError with the path of the fault when it is damaged or breaks a rule."""
    if len(text) > MAX_BYTES:
        raise ProfileError(
            "the file is too large for a policy profile", where, f"profiles have at most {MAX_BYTES} bytes"
        )
    try:
        raw = msgspec.json.decode(text, type=ProfileJson)
    except msgspec.ValidationError as error:
        message, _, path = str(error).partition(" - at `")
        raise make_fault(f"{where}: {escape_text(path.rstrip('`') or '$')}: {escape_text(message)}") from None
    except (msgspec.DecodeError, RecursionError, UnicodeDecodeError) as error:
        raise ProfileError("not readable as JSON", f"{where}: {_locate_break(text, error)}", RESTORE) from None
    profile = decode(raw, where, find_besides)
    expected = content_hash(profile)
    if raw.content_hash is not None and raw.content_hash != expected:
        raise ProfileError(
            "the profile was edited after it was written",
            f"{where}: $.content_hash: states {escape_text(raw.content_hash[:16])}..., "
            f"but the content hashes to {expected[:16]}...",
            "restore the file; if the edit was on purpose, delete the content_hash line",
        )
    return profile


def schema() -> dict[str, Any]:
    """The JSON schema (draft 2020-12) of a profile."""
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **msgspec.json.schema(ProfileJson)}


def _locate_break(text: str | bytes, error: Exception) -> str:
    """The path at which a JSON text breaks, and the decoder's words."""
    data = text.encode() if isinstance(text, str) else text
    offset = re.search(r"\(byte (\d+)\)", str(error))
    readable = data[: int(offset[1])] if offset else data
    return escape_text(f"{place(readable.decode(errors='replace'))}: {error}")
