GRENZEN = {"druck": 8.5, "temperatur": 95, "drehzahl": 3600}


def ampel(messwerte):
    """Prüfstand: grün, gelb oder rot, je nachdem wie viele Grenzen überschritten sind."""
    verletzt = sum(1 for name, grenze in GRENZEN.items() if messwerte[name] > grenze)
    if verletzt == 0:
        return "gruen"
    return "gelb" if verletzt == 1 else "rot"
