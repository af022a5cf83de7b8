pick = lambda soc, price: ("charge" if price < 0.12 else "idle") if soc < 0.9 else ("discharge" if price > 0.35 else "idle")


def battery(soc, price, grid_ok=True):
    """Home battery: state of charge in [0, 1], price in EUR/kWh."""
    return pick(soc, price) if grid_ok else "discharge"
