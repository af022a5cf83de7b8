from enum import Enum


class Phase(Enum):
    SEARCH = 0
    APPROACH = 1
    GRASP = 2

    @property
    def label(self):
        return self.name.lower()


TABLE = {
    (True, True): Phase.GRASP,
    (True, False): Phase.APPROACH,
    (False, True): Phase.SEARCH,
    (False, False): Phase.SEARCH,
}


def phase(confidence, distance):
    seen = confidence > 0.8
    reachable = distance < 0.55
    return TABLE[(seen, reachable)].label
