"""The reference reader of policy profiles: reads the JSON and decides, with the standard library only.

    python reader.py profile.json agent_0 0.5 -1 0.25 ...        prints the action's number and name

    policies = load("profile.json")
    policies["agent_0"].act([0.5, -1, 0.25, ...])                the action's number

An observation has a number for each feature, in the profile's order, each rounded to double, then float32. From node 0 on, a split
leads to its `left` where the feature is at most the threshold, else (a NaN too) to its `right`; a leaf has an action.
"""
import json, math, numbers, struct, sys


def float32(value):
    """The nearest float32, ties to even; infinite beyond the largest."""
    try:
        return struct.unpack("<f", struct.pack("<f", value))[0]
    except OverflowError:
        return math.copysign(math.inf, value)


class Policy:
    """One agent's features and actions, by name, and the nodes of its tree."""

    def __init__(self, agent):
        self.agent, self.features = agent["agent"], [feature["name"] for feature in agent["features"]]
        self.actions = [action["name"] for action in agent["actions"]]
        self.nodes = [self._node(node) for node in agent["tree"]]

    def _node(self, node):
        if "action" in node:
            return self.actions.index(node["action"])
        return self.features.index(node["feature"]), float.fromhex(node["float32"]), node["left"], node["right"]

    def act(self, x):
        """The number of the action for an observation."""
        given = [kind.__name__ for kind in set(map(type, x)) if not issubclass(kind, numbers.Real)] or len(x)
        if given != len(self.features):
            raise ValueError("%s observes %d numbers, given %s" % (self.agent, len(self.features), given))
        node = self.nodes[0]
        while isinstance(node, tuple):
            feature, threshold, left, right = node
            node = self.nodes[left if float32(x[feature]) <= threshold else right]
        return node


def load(path):
    """The policies of a profile, by agent."""
    with open(path, encoding="utf-8") as file:
        profile = json.load(file)
    if profile["schema_version"] != 1:
        raise ValueError("a profile of schema version %s, 1 is read" % profile["schema_version"])
    return {agent["agent"]: Policy(agent) for agent in profile["agents"]}


if __name__ == "__main__":
    policies = load(sys.argv[1]) if len(sys.argv) > 2 else sys.exit(__doc__)
    policy = policies.get(sys.argv[2]) or sys.exit("no such agent; there are " + ", ".join(policies))
    action = policy.act([float(value) for value in sys.argv[3:]])
    print(action, policy.actions[action])
