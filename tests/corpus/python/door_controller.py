class DoorController:
    open_cmd = 1
    close_cmd = -1
    hold_cmd = 0

    def __init__(self):
        self.last_log = []
        self.limit = self._limit()

    @classmethod
    def _limit(cls):
        return 0.3 + 0.2

    def step(self, obs):
        person, wind, obstruction = obs
        if obstruction == 1:
            return self.open_cmd
        if person >= self.limit:
            return self.open_cmd if wind < 12 else self.hold_cmd
        return self.close_cmd


door = DoorController()
