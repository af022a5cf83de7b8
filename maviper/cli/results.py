"""Results of verification as lines: verdicts, where claims hold, what a repair changed.

Does: prints results through a console; gives verdicts as an exit code.
Assumes: results of `maviper.verification`; this module is heavy, so commands import it when they run.
Does not: decide, write files or print what belongs on standard output.
"""

from collections.abc import Mapping, Sequence

from codegen.errors import ExitCode
from codegen.ir import PolicyProfile
from maviper.console import Console
from maviper.evaluation.comparison import say_sizes
from maviper.verification.repair import Repaired
from verify.claims.region import REAL, Kind, Verdict, called, plain
from verify.states.real import shown
from verify.states.state import State
from verify.verdicts.decisions import Result
from verify.verdicts.episodes import EpisodeResult


def say_results(profile: PolicyProfile, results: Sequence[Result | EpisodeResult], console: Console) -> None:
    """One block of lines a result."""
    for result in results:
        claim = result.claim
        named = claim.label or f"{claim.name} of the {claim.team}"
        named += f", region {called(profile, result.region) or 'given'}"
        real = ", real arithmetic" if result.semantics == REAL else ""
        console.line(result.verdict.value, named + real)
        if result.kind is Kind.EPISODES:
            _say_episodes(result, console)
        elif result.kind is Kind.LEAVES:
            _say_leaves(result, console)
        else:
            _say_decisions(result, console)
        if result.where is not None:
            say_where(result, console)


def _say_decisions(result: Result, console: Console) -> None:
    """What a claim about single decisions rests on, or fails by."""
    conflict = result.shares.conflict or "not measured (too many joint actions)"
    shares = f"conflict share {conflict}, violating {result.shares.violating}"
    console.line("", f"{shares}, shuffled control {result.control.value}")
    if result.reason:
        console.line("", result.reason)
    if result.shares.changing is not None:
        console.line("", f"errors can change an action in {result.shares.changing}")
    if result.largest is not None:
        console.line("", f"stays proved up to margin {plain(result.largest.proved)}")
    if result.steady_up_to is not None:
        console.line("", f"stays proved up to eps {plain(result.steady_up_to.proved)}")
    if result.counterexample is not None:
        found = result.counterexample
        acts = "; ".join(
            f"{view.agent} goes {view.action}, engaged with {', '.join(view.engaged_with) or 'no landmark'}"
            for view in found.agents
        )
        console.line("", f"counterexample: {acts}")
        console.line("", _place(found.state))
        for view in found.agents:
            if view.errors:
                errors = ", ".join(f"{name} by {shown(error)}" for name, error in view.errors)
                console.line("", f"{view.agent} measures wrongly: {errors}")
        console.line("", found.says)
    if result.explanation is not None:
        _say_why(result.explanation.says(), console)


def _say_episodes(result: EpisodeResult, console: Console) -> None:
    """What a claim about episodes rests on, or fails by."""
    console.line("", f"violating {result.violating} of sampled starts, shuffled control {result.control.value}")
    if result.reason:
        console.line("", result.reason)
    if result.verdict is Verdict.PROVED:
        followed = "; ".join(" with ".join(agents) for agents in result.followed)
        console.line("", f"{result.zones:,} zones; followed: {followed}; {result.whatever}")
        if result.left_out:
            console.line("", result.left_out)
    if result.uncertified:
        console.line("", f"one reading, no certificate: {result.uncertified}")
    if result.contacts:
        console.line("", f"contacts: {result.contacts}")
    if result.state is not None:
        console.line("", f"counterexample: {'; '.join(map(str, result.ways))}")
        console.line("", _place(result.state))
        console.line("", f"replayed by {', '.join(('reference', *result.replays))}")
    if result.explanation is not None:
        _say_why(result.explanation.says(), console)


def _say_why(said: Mapping[str, str], console: Console) -> None:
    """What else is known about a counterexample."""
    console.line("", said["unique"])
    console.line("", f"fails by {said['fails by']}")
    console.line("", said["free"])


def _place(state: State) -> str:
    place = ", ".join(f"{name} {shown(value)}" for name, value in state.position.items())
    return f"at {place}, goal {state.goal or 'none'}"


def _say_leaves(result: Result, console: Console) -> None:
    """How many leaves are reached, and which are not."""
    for verdict, said in ((Verdict.PROVED, "reached"), (Verdict.VIOLATED, "dead"), (Verdict.UNKNOWN, "open")):
        found = [finding for finding in result.leaves if finding.verdict is verdict]
        named = "" if verdict is Verdict.PROVED else ": " + ", ".join(f"{one.agent} leaf {one.leaf}" for one in found)
        if found:
            console.line("", f"{len(found)} of {len(result.leaves)} leaves {said}{named}")
    if result.reason:
        console.line("", result.reason)


def exit_code(results: Sequence[Result | EpisodeResult]) -> int:
    """The worst verdict as an exit code: violated before inconclusive before proved."""
    verdicts = {result.verdict for result in results}
    if Verdict.VIOLATED in verdicts:
        return ExitCode.VIOLATED
    return ExitCode.DONE if verdicts == {Verdict.PROVED} else ExitCode.INCONCLUSIVE


def say_where(result: Result, console: Console) -> None:
    """Zones, exact share and the largest region found, in lines."""
    found, inner = result.where, result.within
    assert found is not None
    if found.everywhere or found.reason:
        said = (
            "holds everywhere in the region" if found.everywhere else f"where it holds: not available: {found.reason}"
        )
        console.line("", said)
        return
    zones = f"{found.count} violating {'zone' if found.count == 1 else 'zones'}"
    exact = f"share not exact: {found.share_reason}" if found.share is None else _percent(float(found.share.value))
    console.line("", f"{zones}, {exact}{' of the region exactly' if found.share else ''}")
    if found.part is None or inner is None:
        if found.complete:
            console.line("", f"no region to name: {found.part_reason}")
        return
    share = found.part.share.value if found.part.exact is None else float(found.part.exact)
    line = f"{inner.verdict.value} in {_percent(share)} of the region, conflict share there {inner.shares.conflict}"
    if inner.visited is not None:
        line += f", {_percent(inner.visited.inside / inner.visited.states)} of on-policy states inside"
    console.line("", line)


def _percent(share: float) -> str:
    return f"{100 * share:.3g} %"


def say_repair(done: Repaired, console: Console) -> None:
    """What a repair changed, and what it costs."""
    before, found = done.before, done.repair
    if not found.guards:
        console.line("repaired", "nothing: no state of the region violates the property")
        return
    leaves = "leaf" if len(found.guards) == 1 else "leaves"
    roles = ", ".join(f"{agent} for {landmark}" for agent, landmark in found.roles.items())
    console.line("repaired", f"{len(found.guards)} {leaves} guarded, {roles}")
    console.line("", say_sizes(before, found.profile, list(found.roles)))
    if done.cost is not None:
        done.cost.say(console)
