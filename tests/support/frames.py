"""Frames of turned sets in the plane, by exact arithmetic."""

from fractions import Fraction


def is_in_frame(x, centre, matrix, rest, turned):
    """Whether a point is in c + A z + B r, exactly: in the plane, each edge is along a column of A or B."""
    off = [Fraction(a) - Fraction(b) for a, b in zip(x.tolist(), centre.tolist(), strict=True)]
    edges = [tuple(map(Fraction, column)) for column in matrix.T.tolist()]
    edges += [tuple(Fraction(each) * Fraction(size) for each in column)
              for column, size in zip(turned.T.tolist(), rest.tolist(), strict=True)]  # fmt: skip
    for along in edges:
        normal = -along[1], along[0]
        width = sum(abs(normal[0] * edge[0] + normal[1] * edge[1]) for edge in edges)
        if abs(normal[0] * off[0] + normal[1] * off[1]) > width:
            return False
    return True
