"""The predicates that claims are made of: closing on a target, being at it, being engaged with it.

Does: their formulas, for one agent and one target: a landmark, the goal, another agent.
Assumes: action effects are unit directions.
Does not: quantify over teams or landmarks (decisions.py).

With u(a) the direction of the chosen action, agent i closes on target k iff u(a_i) . (l_k - p_i) > margin; it is at k
iff their L-infinity distance is at most the radius; engaged is either. Lengths are in the world's unit.
"""

from fractions import Fraction

from codegen.ir import AgentPolicy
from verify.claims.formula import Acts, Formula, below, conjunction, disjunction


def closes(policy: AgentPolicy, action: int, target: str, margin: Fraction) -> Formula:
    """The action takes the agent towards the target: u(action) . (l - p) > margin."""
    effect = policy.actions[action].effect or (0.0, 0.0)
    terms: dict[str, Fraction] = {}
    for axis, part in zip("xy", effect, strict=True):
        terms |= {f"{policy.agent}.{axis}": Fraction(part), f"{target}.{axis}": -Fraction(part)}
    return below(terms, -margin, strict=True)


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
