"""What several tests use of `verify.verdicts.test_steady`."""

from fractions import Fraction

from verify.claims.decisions import DistinctTargets

EPS = Fraction(1, 10)
CLAIM = DistinctTargets("defenders", eps=EPS)
