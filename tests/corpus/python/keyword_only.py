"""Docking decision of an underwater vehicle (called with keywords by the mission planner)."""
from typing import Optional


def dock(*, range_m: float, bearing_deg: float, battery: float, override: Optional[str] = None) -> str:
    if override is not None:
        return override
    if battery < 0.15:
        return "surface"
    if range_m <= 3 and -10 <= bearing_deg <= 10:
        return "dock"
    if bearing_deg < -10:
        return "yaw_left"
    if bearing_deg > 10:
        return "yaw_right"
    return "advance"
