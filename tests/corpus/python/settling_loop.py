def settle(level):
    """How many gates to open: keep opening until the level would be safe."""
    gates = 0
    while level > 2.0:
        level = level * 0.7
        gates += 1
    return gates
