"""The layout of our JSON files: people read them, so short lists and objects stand on one line.

Does: writes plain data as text, the same for the same data.
Assumes: data that JSON has.
Does not: know what it means.
"""

import json
from typing import Any, cast

LINE_WIDTH = 140
_flat = json.JSONEncoder(ensure_ascii=False, allow_nan=False).encode


def layout(value: Any, indent: int = 0) -> str:
    """JSON text in which whatever fits on a line stays on one: one node, one feature, one line."""
    if not isinstance(value, (dict, list)):
        return _flat(value)
    mapping = cast(dict[str, Any], value) if isinstance(value, dict) else None
    items = list(mapping.values()) if mapping is not None else cast(list[Any], value)
    if not any(isinstance(item, (dict, list)) for item in items):
        flat = _flat(value)
        if len(flat) + indent <= LINE_WIDTH or (mapping is None and all(isinstance(i, (int, float)) for i in items)):
            return flat
    rows = [layout(item, indent + 2) for item in items]
    if not any("\n" in row for row in rows):  # what holds something too long for a line is too long for one
        named = rows if mapping is None else [f"{_flat(key)}: {row}" for key, row in zip(mapping, rows, strict=True)]
        flat = ", ".join(named).join("[]" if mapping is None else "{}")
        if len(flat) + indent <= LINE_WIDTH:
            return flat
    if mapping is not None:
        rows = [f"{json.dumps(key)}: {row}" for key, row in zip(mapping, rows, strict=True)]
    inner = "\n" + " " * (indent + 2)
    return f"{inner}{f',{inner}'.join(rows)}\n{' ' * indent}".join("[]" if mapping is None else "{}")
