def act(s):
    # tolerance written with round, on purpose
    b = round(s[0])
    if b == 0: return 0
    return 1 if b > 0 else 2
