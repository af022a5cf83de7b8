import enum
import typing as t


@enum.unique
class Mode(str, enum.Enum):
    NOMINAL = "nominal"
    SAFE = "safe"
    DETUMBLE = "detumble"


def next_mode(bus_voltage: float, wheel_rpm: float, temps: t.Tuple[float, float] = (20.0, 20.0)) -> Mode:
    t_min, t_max = -20, 60
    if bus_voltage < 26.4:
        return Mode.SAFE
    for temp in temps:
        if not t_min <= temp <= t_max:
            return Mode.SAFE
    if wheel_rpm > 5500 or wheel_rpm < -5500:
        return Mode.DETUMBLE
    return Mode.NOMINAL
