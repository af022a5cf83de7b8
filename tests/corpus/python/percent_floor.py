def dim_level(lux, presence):
    '''Street lamp: five dimming levels over ambient light'''
    if presence == True:
        return 100
    missing = 50 - lux
    if missing <= 0: return 0
    if missing / 50 < 0.2: return 20
    if missing / 50 < .6: return 50
    return 80
