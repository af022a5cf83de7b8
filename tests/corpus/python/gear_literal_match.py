from typing import Final, Literal
Gear = Literal["P", "D", "R"]
MAX: Final[float] = 5 / 3.6
def gear(speed: float, brake: bool, wish: int) -> Gear:
    match wish:
        case 0: return "P"
        case 1 if speed < MAX and brake: return "R"
        case 1 | 2: return "D"
        case _: return "P"
