"""Stated systems played in numpy, many episodes at once: what the file says, operation by operation.

It shares the reader of files with the rest, and nothing else: no pieces, no engine, no checker, no simulator.
"""

import numpy as np

from codegen.ir import act
from maviper.worlds.stated.systems import PARTS
from tests.support.system_cases import ends_of
from verify.systems.expressions import Call, Name, Number, Pi, Power, Product, Quotient, Sum, names
from verify.systems.system import Measure


def value(expression, at, library=np, number=float):
    """Of an expression, the values where variables and inputs are `at`, by name: arrays, or numbers of a `library`
    whose numbers `number` makes.
    """

    def of(part):
        return value(part, at, library, number)

    match expression:
        case Number(constant):
            return number(constant)
        case Name(name):
            return at[name]
        case Power(base, exponent):
            return of(base) ** exponent
        case Call(_, argument, bounds) if bounds is not None:
            return np.clip(of(argument), *map(float, bounds))
        case Call(called, argument, _):
            return getattr(library, called)(of(argument))
        case Pi():
            return +library.pi
        case Sum(left, right):
            return of(left) + of(right)
        case Product(left, right):
            return of(left) * of(right)
        case Quotient(left, right):
            return of(left) / of(right)
    raise AssertionError(expression)


class Played:
    """Episodes of a statement with the trees of a profile. A state is a row of `names`, [n, variables]."""

    def __init__(self, statement, profile):
        self.statement, self.profile, self.system = statement, profile, statement.system
        self.names = [one.name for one in self.system.variables]

    def at(self, w):
        """Its columns by name."""
        return dict(zip(self.names, w.T, strict=True))

    def starts(self, rng, count):
        """Starts, uniform in the box of the start region; conditions of several variables are met by rejection."""
        low, high = np.array([[float(end) for end in ends] for ends in ends_of(self.system).values()]).T
        further = [half for half in self.system.start if len(half.form.terms) > 1]
        w = low + rng.random((count, len(low))) * (high - low)
        return w[self.meets(w, further)] if further else w

    def meets(self, w, halves):
        """Which states lie in half spaces."""
        at, found = self.at(w), np.ones(len(w), dtype=bool)
        for half in halves:
            total = sum(float(factor) * at[name] for name, factor in half.form.terms) + float(half.form.constant)
            found &= total < 0 if half.strict else total <= 0
        return found

    def inside(self, w, regions):
        """Which states lie in one of some regions."""
        return np.logical_or.reduce([self.meets(w, region) for region in regions])

    def observed(self, w, policy):
        """What an agent observes, [n, features]."""
        at, columns = self.at(w), []
        for spec in policy.features:
            feature = self.system.features[policy.agent][spec.name]
            form = sum(float(factor) * at[name] for name, factor in feature.form.terms) + float(feature.form.constant)
            match feature.measure:
                case Measure.SIGN:
                    form = np.sign(form)
                case Measure.POSITIVE:
                    form = form > 0
                case Measure.EQUALS:
                    form = form == 0
                case Measure.CLIP:
                    form = np.clip(form, *map(float, feature.bounds))
                case Measure.VALUE:
                    pass
            columns.append(np.broadcast_to(form, len(w)))
        return np.column_stack(columns).astype(policy.numbers)

    def moved(self, w, rng):
        """The states one step on, errors drawn at random; a flow by Runge and Kutta's method."""
        acted = {policy.agent: act(policy, self.observed(w, policy)) for policy in self.profile.agents}
        return self._flowed(w, acted, rng) if self.system.flow else self._stepped(w, acted, rng)

    def _stepped(self, w, acted, rng):
        after, done, at = np.full_like(w, np.nan), np.zeros(len(w), dtype=bool), self.at(w)
        for rule in self.statement.rules:
            held = ~done & self.meets(w, rule.when)
            for name, (low, high) in rule.where.items():
                held &= (at[name] >= float(low)) & (at[name] <= float(high))
            now = {name: column[held] for name, column in at.items()}
            for column, name in enumerate(self.names):
                if name not in rule.move:
                    after[held, column] = 0.0
                    continue
                total = np.broadcast_to(value(rule.move[name], now), held.sum()).copy()
                for policy in self.profile.agents:
                    for number, action in enumerate(policy.actions):
                        added = rule.effect.get((policy.agent, action.name), {}).get(name)
                        if added is not None:
                            total += np.where(acted[policy.agent][held] == number, value(added, now), 0.0)
                if name in rule.error:
                    total += rng.uniform(*map(float, rule.error[name]), len(total))
                after[held, column] = total
            done |= held
        return after

    def _flowed(self, w, acted, rng):
        flow = self.system.flow
        held, h, now = {}, float(flow.period) / PARTS, self.at(w)
        for policy in self.profile.agents:
            for number, action in enumerate(policy.actions):
                for name, given in flow.held[policy.agent, action.name].items():
                    held.setdefault(name, np.zeros(len(w)))[acted[policy.agent] == number] = float(given)
        now = now | {name: value(jump, now | held) for name, jump in flow.jumps.items()}
        begun = now
        off = {name: rng.uniform(*map(float, bounds), len(w)) for name, bounds in flow.error.items()}

        def rates(at):
            known = {**at, **held}
            return {name: value(rate, known) + off.get(name, 0.0) for name, rate in flow.rates.items()}

        def along(rate, time):
            return {name: column + time * rate[name] for name, column in now.items()}

        for _ in range(PARTS):
            first = rates(now)
            second = rates(along(first, h / 2))
            third = rates(along(second, h / 2))
            last = rates(along(third, h))
            now = {
                name: column + h / 6 * (first[name] + 2 * second[name] + 2 * third[name] + last[name])
                for name, column in now.items()
            }
        for name, rate in flow.rates.items():  # what goes at a held rate, in one step: roundings would add up
            if not names(rate) & begun.keys():
                now[name] = begun[name] + float(flow.period) * rates(begun)[name]
        return np.column_stack(list(now.values()))
