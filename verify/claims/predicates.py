"""The predicates that claims are made of: closing on a target, being at it, being engaged with it.

Does: their formulas, for one agent and one target: a landmark, the goal, another agent; and
  comparisons of their offsets.
Assumes: action effects are unit directions.
Does not: quantify over teams or landmarks (decisions.py).

With u(a) the direction of the chosen action, agent i closes on target k iff u(a_i) . (l_k - p_i) > margin; it is at k
iff their L-infinity distance is at most the radius; engaged is either. Lengths are in the world's unit.
"""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import lru_cache
from itertools import product

from codegen.ir import AgentPolicy
from verify.claims.formula import Acts, Formula, below, conjunction, disjunction


def closes(policy: AgentPolicy, action: int, target: str, margin: Fraction) -> Formula:
    """The action takes the agent towards the target: u(action) . (l - p) > margin."""
    effect = policy.actions[action].effect or (0.0, 0.0)
    terms: dict[str, Fraction] = {}
    for axis, part in zip("xy", effect, strict=True):
        terms[f"{policy.agent}.{axis}"], terms[f"{target}.{axis}"] = _exact(part), _exact(-part)
    return below(terms, -margin, strict=True)


@lru_cache(maxsize=1 << 10)
def _exact(part: float) -> Fraction:
    return Fraction(part)


def closing(policy: AgentPolicy, target: str, margin: Fraction) -> Formula:
    """The agent's chosen action closes on the target."""
    return disjunction(
        *(
            conjunction(Acts(policy.agent, action), closes(policy, action, target, margin))
            for action in range(len(policy.actions))
        )
    )


def at(agent: str, target: str, radius: Fraction) -> Formula:
    """The L-infinity distance of agent and target is at most the radius."""
    gaps = [{f"{agent}.{axis}": sign, f"{target}.{axis}": -sign} for axis in "xy" for sign in (1, -1)]
    return conjunction(*(below(gap, radius) for gap in gaps))


def ahead(agent: str, landmark: str, direction: tuple[Fraction, Fraction]) -> Formula:
    """The direction's product with the landmark's offset is at most 0."""
    terms: dict[str, Fraction] = {}
    for axis, part in zip("xy", direction, strict=True):
        terms |= {f"{landmark}.{axis}": part, f"{agent}.{axis}": -part}
    return below(terms, 0)


def no_longer(matching: Sequence[tuple[AgentPolicy, str]], other: Sequence[tuple[AgentPolicy, str]]) -> Formula:
    """The summed L1 length of one matching is at most that of another: some signs of the other's offsets give a sum
    that no signs of the one's exceed.
    """

    def sums(pairs: Sequence[tuple[AgentPolicy, str]]) -> list[dict[str, int]]:
        all_terms: list[dict[str, int]] = []
        for signs in product((1, -1), repeat=2 * len(pairs)):
            terms: dict[str, int] = {}
            for sign, (policy, landmark, axis) in zip(
                signs, [(*pair, axis) for pair in pairs for axis in "xy"], strict=True
            ):
                terms[f"{landmark}.{axis}"] = terms.get(f"{landmark}.{axis}", 0) + sign
                terms[f"{policy.agent}.{axis}"] = terms.get(f"{policy.agent}.{axis}", 0) - sign
            all_terms.append(terms)
        return all_terms

    def difference(a: Mapping[str, int], b: Mapping[str, int]) -> dict[str, int]:
        return {name: a.get(name, 0) - b.get(name, 0) for name in {**a, **b}}

    return disjunction(
        *(conjunction(*(below(difference(own, bound), 0) for own in sums(matching))) for bound in sums(other))
    )
