"""A fitted scikit-learn tree, dumped as arrays (clf.tree_.*) so that the robot needs no scikit-learn."""

CHILDREN_LEFT = [1, 2, -1, -1, 5, -1, -1]
CHILDREN_RIGHT = [4, 3, -1, -1, 6, -1, -1]
FEATURE = [1, 0, -2, -2, 2, -2, -2]
THRESHOLD = [0.25, -1.3050000071525574, -2.0, -2.0, 14.5, -2.0, -2.0]
VALUE = [
    [30, 30, 30],
    [20, 25, 5],
    [18, 1, 0],
    [2, 24, 5],
    [10, 5, 25],
    [9, 2, 1],
    [1, 3, 24],
]
CLASSES = ["slow", "cruise", "dash"]


def predict(x):
    node = 0
    while CHILDREN_LEFT[node] != -1:
        if x[FEATURE[node]] <= THRESHOLD[node]:
            node = CHILDREN_LEFT[node]
        else:
            node = CHILDREN_RIGHT[node]
    counts = VALUE[node]
    return CLASSES[counts.index(max(counts))]
