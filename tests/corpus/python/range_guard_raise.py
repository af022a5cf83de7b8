def valve(opening_percent, flow):
    if not 0 <= opening_percent <= 100:
        raise ValueError("opening out of range: %r" % opening_percent)
    if flow > 12.5:
        return "close"
    if flow < 8:
        return "open"
    return "keep"
