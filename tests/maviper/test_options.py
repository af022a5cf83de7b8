"""Tables of options: what is given to a verb, its command, its request and its manual come from one place."""

import inspect
import re
from dataclasses import fields
from fractions import Fraction
from pathlib import Path
from typing import get_type_hints

import numpy as np
import pytest

import maviper
from codegen.errors import InputError
from maviper import claims
from maviper.cli import main
from maviper.cli.make import SAID_OTHERWISE
from maviper.extraction import run as extraction
from maviper.extraction import settings
from maviper.extraction.settings import PRESETS, SELECTIONS, SPLITS, Settings, part_settings
from maviper.options import (
    CompileOptions,
    DiffOptions,
    EvaluateOptions,
    ExploitOptions,
    ExtractOptions,
    FileOptions,
    ImportOptions,
    RepairOptions,
    ReproduceOptions,
    SystemOptions,
    TrainOptions,
    VerifyOptions,
    complete_options,
    table_of,
)
from maviper.options.extraction import (
    FITTED_Q,
    PART_NAMES,
    REFUSALS,
    RELEASED,
    RGMDT,
    VIPER,
    VOTES,
)
from maviper.reproduction import run as reproduction
from maviper.verification.ask import VerifyOptions as Asked
from verify.claims.catalogue import NAMES, ZONES, readable
from verify.claims.parameters import PARAMETER_NAMES

PLAIN = {"margin", "radius", "kappa", "eps", "steps", "landmarks", "others", "order"}  # None: as usual
FOLDER = "maviper/manual"
TABLES = {
    "compile": CompileOptions,
    "diff": DiffOptions,
    "evaluate": EvaluateOptions,
    "exploit": ExploitOptions,
    "extract": ExtractOptions,
    "import": ImportOptions,
    "repair": RepairOptions,
    "reproduce": ReproduceOptions,
    "train": TrainOptions,
    "verify": VerifyOptions,
}
# that the command has beside its table: what is a parameter of the function, or printed and written
OWN = {
    "compile": {"targets"},
    "diff": {"region", "as_json"},
    "evaluate": {"exploit", "networks", "refinement_episodes", "steps", "seed"},
    "import": {"agents"},
    "repair": {"claim", "region"},
}
WITHIN_A_CLAIM = {"team", *PARAMETER_NAMES}  # on the command line; of Python they are options of the function too
REQUESTS = {
    ReproduceOptions: reproduction.Request,
}
VERBS = {name: maviper.from_file if name == "import" else getattr(maviper, name) for name in TABLES}
CLAIMS = {each.name: each for each in vars(claims).values() if isinstance(each, type) and hasattr(each, "name")}
WHOLE = {"break_on_hyphens": False, "break_long_words": False}


def table_of_command(name):
    apart = WITHIN_A_CLAIM if name in ("verify", "repair") else SAID_OTHERWISE if name == "compile" else ()
    return {key: option for key, option in table_of(TABLES[name]).items() if key not in apart}


COMMANDS = sorted(TABLES.keys() & main.cli.commands.keys())


@pytest.mark.parametrize("name", COMMANDS)
def test_a_command_has_the_options_of_the_table_and_no_other(name):
    table = table_of_command(name)
    command = {each.name: each for each in main.cli.commands[name].params if each.param_type_name == "option"}
    if name == "verify":  # whose command asks several claims, of files and of stated systems too, and prints
        assert table.keys() <= command.keys()
    else:
        assert list(table) == [key for key in command if key not in OWN.get(name, set()) | {"output", "set"}]
    for key, option in table.items():
        assert command[key].opts == [option.flag] and (command[key].section, command[key].help) == (
            option.section,
            option.help,
        )


@pytest.mark.parametrize("name", COMMANDS)
def test_a_command_has_the_defaults_of_the_table(name):
    command, table = main.cli.commands[name], TABLES[name]
    subjects = ["x" for each in command.params if each.param_type_name == "argument"]
    output = ["-o", "y"] if any(each.name == "output" for each in command.params) else []
    given = command.make_context(name, [*subjects, *output], obj={"quiet": True}).params
    assert complete_options(table, {key: given[key] for key in table_of_command(name)}) == complete_options(table, {})


@pytest.mark.parametrize("name", TABLES)
def test_a_verb_says_every_option_with_its_type_and_default(name):
    verb, table = VERBS[name], table_of(TABLES[name])
    given = inspect.signature(verb).parameters
    assert {key: given[key].default for key in table} == {key: option.default for key, option in table.items()}
    assert {key: given[key].annotation for key in table} == get_type_hints(TABLES[name])
    for key, option in table.items():
        assert f"`{key}`: {option.help}" in verb.__doc__


@pytest.mark.parametrize(
    ("verb", "options"), [(maviper.verify_system, SystemOptions), (maviper.verify_file, FileOptions)]
)
def test_what_verify_asks_of_systems_and_files_are_options_of_the_command(verb, options):
    command = {each.name: each for each in main.cli.commands["verify"].params}
    given, text = inspect.signature(verb), verb.__doc__
    for key, option in table_of(options).items():
        assert command[key].help == option.help and f"`{key}`: {option.help}" in text
        assert given.parameters[key].default == option.default and command[key].opts == [option.flag]


def test_an_option_of_extraction_is_a_setting_or_a_field_of_the_request():
    """And there is no setting that a user cannot give."""
    asked, settings = part_settings(complete_options(ExtractOptions, {}))
    assert {*asked, "settings", "command"} == {field.name for field in fields(extraction.Request)}
    assert {field.name for field in fields(Settings)} == set(settings)
    for table, kind in REQUESTS.items():
        assert {field.name for field in fields(kind)} == set(complete_options(table, {}))


VALUES = {
    "algorithm": settings.KNOWN,
    "preset": PRESETS,
    "selection": SELECTIONS,
    "labels": settings.LABELS,
    "rollouts_by": settings.ROLLOUTS_BY,
    "weights": settings.WEIGHTS,
    "selection_by": settings.SELECTION_BY,
    "least_right": ("0", "N", "N-1"),
    "refinement": (0, 50_000),
    "splits": SPLITS,
}


@pytest.mark.parametrize("refusal", REFUSALS, ids=lambda refusal: refusal.reason[:40])
def test_a_refusal_is_made_beside_the_values_that_it_names_and_no_others(refusal):
    asked = dict.fromkeys(refusal.settings, "asked")
    asked |= {name: next(each for each in VALUES[name] if each in refusal.values) for name in asked if refusal.values}
    for name, values in refusal.beside.items():
        assert set(values) <= set(VALUES[name])
        said = {
            other: next(each for each in VALUES[other] if each not in refusal.beside[other]) for other in refusal.beside
        }
        for value in VALUES[name]:
            found = refusal.find_refused({**asked, **said, name: value}, refusal.settings)
            assert found == (list(refusal.settings) if value in values else []), (name, value)


def test_the_names_in_the_table_of_refusals_are_those_of_the_algorithms():
    assert {VIPER, FITTED_Q, RGMDT} < set(settings.KNOWN) and RELEASED in PRESETS
    assert PART_NAMES == settings.PARTS and VOTES == (settings.NO_VOTES,)
    assert {name for refusal in REFUSALS for name in refusal.settings} < {field.name for field in fields(Settings)}


def test_what_is_not_given_or_none_is_as_usual():
    assert complete_options(ExtractOptions, {"max_depth": None, "jobs": 2})["max_depth"] == 4
    asked = extraction.request({"features_file": "a.toml", "counterexamples": ["b"], "max_episodes": np.int64(9)})
    assert asked.features_file == Path("a.toml") and asked.counterexamples == (Path("b"),)
    assert asked.settings["budget"] == 9 and type(asked.settings["budget"]) is int
    assert asked.command == "maviper.extract"


@pytest.mark.parametrize(
    ("given", "what"),
    [
        ({"max_depth": "5"}, "max_depth is a whole number, not '5'"),
        ({"max_depth": 4.5}, "max_depth is a whole number, not 4.5"),
        ({"max_depth": True}, "max_depth is a whole number, not True"),
        ({"explore": "much"}, "explore is a number, not 'much'"),
        ({"algorithm": 3}, "algorithm is a text, not 3"),
        ({"features_file": 3}, "features_file is a path, not 3"),
        ({"counterexamples": "failed"}, "counterexamples takes several values, not 'failed'"),
        ({"counterexamples": [3]}, "counterexamples is a path, not 3"),
        ({"resume": "yes"}, "resume is yes or no, not 'yes'"),
    ],
)
def test_a_value_of_another_type_is_told(given, what):
    with pytest.raises(InputError, match=re.escape(what)) as caught:
        maviper.extract("physical-deception", **given)
    assert caught.value.where == next(iter(given))


def test_an_option_that_there_is_not_is_told_with_the_closest():
    with pytest.raises(TypeError, match=r"no option max_depht; did you mean 'max_depth'\?"):
        maviper.extract("physical-deception", max_depht=3)


def test_every_built_in_claim_has_a_class_with_what_it_reads():
    assert set(CLAIMS) == set(NAMES)
    for name, each in CLAIMS.items():
        own = {field.name for field in fields(each)} - {"team"}
        assert own == set(readable(name)) - {ZONES} - ({"margin", "radius"} if name == "steady" else set())
        assert get_type_hints(each).items() >= {key: get_type_hints(VerifyOptions)[key] for key in own & PLAIN}.items()


def test_every_parameter_of_a_claim_is_an_option_of_verify():
    assert [name for name in table_of(VerifyOptions) if name in PARAMETER_NAMES] == list(PARAMETER_NAMES)


@pytest.mark.parametrize(
    ("claim", "said"),
    [
        (claims.Reaches(steps=25, team="defenders"), {"steps": 25}),
        (claims.OwnTarget(margin=0.025, landmarks=["a"]), {"margin": Fraction(1, 40), "landmarks": ("a",)}),
        (
            claims.Steady(of=claims.Aligned(kappa="1/3"), eps="1/40"),
            {"kappa": Fraction(1, 3), "eps": Fraction(1, 40), "of": "aligned"},
        ),
        (claims.AliveLeaves(), {}),
    ],
)
def test_a_claim_is_asked_as_an_object(claim, said):
    asked = Asked.about(claim, "start", {"where": True, "max_zones": 9})
    assert asked.parameters == said and asked.names == (claim.name,) and asked.team == claim.team
    named = {**said, "team": claim.team, "where": True, "max_zones": 9}
    assert asked == Asked.about(claim.name, "start", named)


def test_a_claim_that_is_an_object_has_its_parameters_itself():
    with pytest.raises(InputError, match="the claim is an object, which has steps, team itself") as caught:
        Asked.about(claims.Reaches(), "start", {"steps": 3, "team": "defenders"})
    assert caught.value.next_step == "write it among the parameters of Reaches"
    with pytest.raises(InputError, match="margin is a number, not True"):
        Asked.about(claims.NoDouble(margin=True), "start", {})
