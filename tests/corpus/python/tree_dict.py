TREE = {
    "feature": "speed", "threshold": 4.5,
    "left": {"feature": "angle", "threshold": 0.0, "left": {"action": 0}, "right": {"action": 2}},
    "right": {"action": 1},
}


def run(obs, node=TREE):
    if "action" in node:
        return node["action"]
    if obs[node["feature"]] <= node["threshold"]:
        return run(obs, node["left"])
    return run(obs, node["right"])
