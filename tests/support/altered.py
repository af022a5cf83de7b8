"""Certificates and their parts with other members, as a forger would make them."""

import copy
import dataclasses
import json

import msgspec

from verify.checker import certificate, decisions
from verify.checker.certificate import Certificate
from verify.checker.episodes import certificates as episodes
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


def edited(document, path, value):
    """A copy of a document with another value at a path, or for KeyError without what stands there."""
    changed = copy.deepcopy(document)
    here = changed
    for key in path[:-1]:
        here = here.setdefault(key, {}) if isinstance(here, dict) else here[key]
    if value is KeyError:
        del here[path[-1]]
    else:
        here[path[-1]] = value
    return changed


def sealed(document):
    """The text of a file that holds an edited document, with its hash made again."""
    body = {key: value for key, value in document.items() if key != "content_hash"}
    return json.dumps({**body, "content_hash": certificate.body_hash(body)})


def resealed(text, change):
    """The text of a file after a change of its document, with its hash made again."""
    document = json.loads(text)
    change(document)
    return sealed(document)


def of_hashes(profile, system, claim, state, proof):
    """A certificate about a stated system, of whatever hashes."""
    (form,) = (name for name, kind in PROOFS.items() if kind is type(proof))
    return Certificate(SystemHeader(form, profile, state, system), claim, proof)


def of_goals(profile, named, formula, region, semantics, inhabitant, proofs, form=decisions.FORM):
    """A certificate about single decisions, of whatever hash; its proofs by goal."""
    header = decisions.DecisionHeader(form, profile, inhabitant, semantics, region)
    by_text = {goal or "": proof for goal, proof in proofs.items()}
    return Certificate(header, decisions.FormulaClaim(named, formula), decisions.GoalProofs(by_text))


def of_episodes(profile, claim, region, inhabitant, proof, form=episodes.FORM):
    """A certificate about episodes, of whatever hash."""
    return Certificate(decisions.GameHeader(form, profile, inhabitant, "machine", region), claim, proof)


def read_game(text, where="certificate"):
    """The certificate about a game in a text: about episodes, if it says so."""
    said = text.encode() if isinstance(text, str) else text
    forms = episodes.FORMS if b"maviper-episode-certificate" in said else decisions.FORMS
    return certificate.read(text, where, forms)
