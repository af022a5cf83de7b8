"""Thermostat with a hysteresis band, so that the relay does not chatter."""


class Thermostat:
    def __init__(self, setpoint=21.0, band=0.5):
        self.setpoint = setpoint
        self.band = band
        self.heating = False

    def update(self, temperature):
        if temperature < self.setpoint - self.band:
            self.heating = True
        elif temperature > self.setpoint + self.band:
            self.heating = False
        return "on" if self.heating else "off"
