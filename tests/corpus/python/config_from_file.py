import json
from pathlib import Path

CONFIG = json.loads((Path(__file__).parent / "limits.json").read_text())


def controller(pressure):
    if pressure > CONFIG["max_pressure"]:
        return "release"
    if pressure < CONFIG["min_pressure"]:
        return "fill"
    return "hold"
