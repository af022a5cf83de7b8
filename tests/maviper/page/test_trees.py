"""The trees as one SVG: nodes, edges and the shares of decisions at leaves."""

import re
import xml.etree.ElementTree as ElementTree
from dataclasses import replace

import pytest

from codegen import ir
from codegen.errors import ExitCode
from codegen.policy_json import dumps
from maviper.cli.main import run as command
from maviper.page.page import svg
from maviper.worlds.matching import matching_world
from tests.support.odd_pages import with_trees
from tests.support.pages import committed

SVG = "{http://www.w3.org/2000/svg}"


def nodes_of(text):
    """Of each tree: node -> its texts and its title."""
    trees = [tree for tree in ElementTree.fromstring(text).iter(f"{SVG}g") if "transform" in tree.attrib]
    return [
        {
            int(node.attrib["data-node"]): ([each.text for each in node.findall(f"{SVG}text")], node[0].text)
            for node in tree.findall(f"{SVG}g")
        }
        for tree in trees
    ]


def test_every_node_is_drawn_and_leaves_have_the_share_of_their_decisions():
    from maviper.page.page import visits_of

    profile = committed("physical_deception")
    visits = visits_of(profile, matching_world(profile))
    drawn = nodes_of(svg(profile, [policy.agent for policy in profile.agents]))
    for policy, nodes in zip(profile.agents, drawn, strict=True):
        assert set(nodes) == set(range(len(policy.tree.feature)))
        whole = sum(visits[policy.agent])
        for leaf in ir.leaves(policy.tree).tolist():
            action, share = nodes[leaf][0]
            assert action == policy.actions[policy.tree.action[leaf]].name
            assert float(share.split()[0]) == pytest.approx(100 * visits[policy.agent][leaf] / whole, rel=0.01)
        for node in ir.splits(policy.tree):
            assert nodes[node][0][0] == policy.features[policy.tree.feature[node]].name


def test_a_world_that_nobody_can_play_has_no_shares():
    profile = committed("physical_deception")
    strange = replace(profile, world=replace(profile.world, dt=0.2))
    text = svg(strange, ["agent_1"])
    (nodes,) = nodes_of(text)
    assert all(len(texts) == 1 for texts, title in nodes.values() if title.startswith("leaf"))
    assert "%" not in re.sub(r"<style>.*?</style>", "", text, flags=re.DOTALL)


def test_the_command_draws_one_agent_or_all(tmp_path, capsys):
    path = tmp_path / "profile.json"
    path.write_text(dumps(committed("physical_deception")))
    assert command(["show", str(path), "--format", "svg", "--agent", "agent_0"]) == ExitCode.DONE
    assert len(nodes_of(capsys.readouterr().out)) == 1
    out = tmp_path / "trees.svg"
    assert command(["show", str(path), "--format", "svg", "-o", str(out)]) == ExitCode.DONE
    text = out.read_text()
    assert len(nodes_of(text)) == 3 and "prefers-color-scheme: dark" in text
    assert command(["show", str(path), "--format", "svg", "--obs", "1"]) == ExitCode.INPUT
    path.write_text(dumps(with_trees(committed("physical_deception"), 12)))
    assert command(["show", str(path), "--format", "svg"]) == ExitCode.INPUT
    assert "at most 4096" in capsys.readouterr().err
