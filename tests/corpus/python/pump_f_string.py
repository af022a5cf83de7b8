STAGES = ["idle", "low", "mid", "high"]


def pump_stage(level_cm: float, inflow: float) -> str:
    stage = 0
    if level_cm > 40:
        stage = 1
    if level_cm > 80:
        stage = 2
    if level_cm > 120 or inflow > 9.5:
        stage = 3
    if inflow < 0 and stage > 0:
        stage -= 1
    return f"pump_{STAGES[stage]}"
