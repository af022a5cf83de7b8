from abc import ABC, abstractmethod


class Agent(ABC):
    def __init__(self, n_actions):
        self.n_actions = n_actions

    @abstractmethod
    def get_action(self, observation):
        ...


class HeuristicAgent(Agent):
    """Blackjack (Sutton & Barto): stick on 17 or more, or when the dealer shows a weak card."""

    HIT, STICK = 1, 0

    def __init__(self):
        super().__init__(n_actions=2)

    def get_action(self, observation):
        player_sum, dealer_card, usable_ace = observation
        if usable_ace and player_sum <= 17:
            return self.HIT
        if player_sum >= 17:
            return self.STICK
        if player_sum >= 13 and 2 <= dealer_card <= 6:
            return self.STICK
        return self.HIT
