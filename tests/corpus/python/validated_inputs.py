"""pH dosing, with checks of the inputs as our coding guideline asks for."""

ACID_DOSE = 1
BASE_DOSE = 2
NO_DOSE = 0


def dose(obs):
    if len(obs) != 2:
        raise ValueError(f"expected [pH, flow], got {len(obs)} values")
    ph, flow = obs
    assert ACID_DOSE != BASE_DOSE
    if flow < 0.5:
        return NO_DOSE
    if ph > 7.6:
        return ACID_DOSE
    if ph < 6.8:
        return BASE_DOSE
    return NO_DOSE
