"""Certificates and their parts with other members, as a forger would make them."""

import dataclasses

import msgspec

from verify.checker.certificate import Certificate
from verify.checker.systems.proofs import PROOFS, SystemHeader


def altered(thing, **members):
    """A certificate, or a part of one, with these members others, wherever in its header, claim or proof they are."""
    if isinstance(thing, msgspec.Struct):
        return msgspec.structs.replace(thing, **members)
    own = {field.name for field in dataclasses.fields(thing)}
    given = {name: members[name] for name in members if name in own}
    for part in ("proof", "header", "claim") if "header" in own else ():
        held = getattr(thing, part)
        names = held.__struct_fields__ if isinstance(held, msgspec.Struct) else vars(held) if held else ()
        inner = {name: members.pop(name) for name in [*members] if name not in own and name in names}
        if inner:
            given[part] = altered(held, **inner)
    assert members.keys() <= given.keys(), members.keys() - given.keys()
    return dataclasses.replace(thing, **given)


def of_hashes(profile, system, claim, state, proof):
    """A certificate about a stated system, of whatever hashes."""
    (form,) = (name for name, kind in PROOFS.items() if kind is type(proof))
    return Certificate(SystemHeader(form, profile, state, system), claim, proof)
