import random


class EnemyAI:
    """State-less guard: looks at the world once per tick."""

    AGGRO_RANGE = 12.0
    MELEE_RANGE = 1.5

    def __init__(self, name="guard", brave=True):
        self.name = name
        self.brave = brave
        self.flee_at = 15 if brave else 40

    def choose_action(self, health, distance, ammo, player_visible):
        hurt = health < self.flee_at
        can_shoot = ammo > 0
        in_range = distance <= self.AGGRO_RANGE

        if hurt and in_range:
            return "flee"
        elif player_visible and in_range:
            if distance <= self.MELEE_RANGE:
                return "stab"
            elif can_shoot:
                return "shoot"
            else:
                return "charge"
        elif player_visible:
            return "approach"
        else:
            return "patrol"

    def taunt(self):
        return random.choice(["Hey!", "Over here!"])
