"""The layout of our JSON files: people read them, so short lists and objects stand on one line.

Does: writes plain data as text, the same for the same data.
Assumes: data that JSON has.
Does not: know what it means.
"""

import json
from typing import Any, cast

LINE_WIDTH = 140


def layout(value: Any, indent: int = 0) -> str:
    """JSON text in which whatever fits on a line stays on one: one node, one feature, one line."""
    flat = json.dumps(value, ensure_ascii=False, allow_nan=False)
    if len(flat) + indent <= LINE_WIDTH or not isinstance(value, (dict, list)):
        return flat
    inner = " " * (indent + 2)
    if isinstance(value, dict):
        mapping = cast(dict[str, Any], value)
        rows = [f"{inner}{json.dumps(key)}: {layout(item, indent + 2)}" for key, item in mapping.items()]
        return "{\n" + ",\n".join(rows) + "\n" + " " * indent + "}"
    items = cast(list[Any], value)
    if all(isinstance(item, (int, float)) for item in items):
        return flat
    return "[\n" + ",\n".join(f"{inner}{layout(item, indent + 2)}" for item in items) + "\n" + " " * indent + "]"
