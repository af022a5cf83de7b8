"""The built-in properties as a list that users read.

Does: names, sentences, and parameters with their defaults.
Assumes: nothing of a profile.
Does not: ask anything.
"""

from typing import Any

from maviper.verification.ask import format_parameter
from verify.claims.catalogue import NAMES, ZONES, in_general, readable, usual
from verify.question import Budgets


def list_properties() -> list[dict[str, Any]]:
    """The built-in properties as plain data: name, sentence, parameters with their defaults as texts.

    A text is empty where the default depends on the world.
    """
    properties: list[dict[str, Any]] = []
    for name in NAMES:
        values = usual(name) | ({ZONES: Budgets().max_zones} if ZONES in readable(name) else {})
        defaults = {key: "" if value is None else format_parameter(value) for key, value in values.items()}
        properties.append({"name": name, "sentence": in_general(name), "parameters": defaults})
    return properties
