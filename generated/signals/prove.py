"""Proofs about the rule of `actuated.py`: `python prove.py [NETWORK ...]` writes `worlds/` and `proofs/`.

Does: imports the rules of a network as a team of trees; writes the world file of each signal, and a certificate of each
  claim, which the checker accepts; prints verdicts and CPU seconds.
Assumes: the environment of `signals.py`.
Does not: ask about trees with shuffled leaves, which takes `maviper verify` minutes here: most of them keep the claims.
"""

import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time

import actuated
import plant
import signals

import maviper
from maviper.verification.ask import VerifyOptions
from maviper.verification.run import pose_questions
from verify.certificates.games import to_json

HERE, MOST_RED = Path(__file__).parent, 62.5  # seconds of red after which the rule gives green
FEW = 16  # random episodes that may refute a claim first
NAMED = "{}-{}-{}.json"  # a certificate: network, signal, number of the claim


def prove(network: str) -> None:
    """Writes the files of a network, and prints a line for each signal."""
    team = HERE / "proofs" / f"{network}.json"
    with TemporaryDirectory() as folder:
        rules = Path(folder, "rules.py")
        actuated.main(network, str(rules), str(MOST_RED))
        profile = maviper.from_file(rules, arrays="float32")
        profile.save(team)
    for agent, signal in signals.make(network).signals.items():
        begun, world = process_time(), HERE / "worlds" / f"{network}-{agent}.toml"
        world.write_text(plant.world(agent, signal, network), encoding="utf-8")
        asked, stated = pose_questions(profile, team.name, VerifyOptions(world=world))
        verdicts = []
        for number, one in enumerate(asked, 1):
            answer = stated.answer(one.question.spending(samples=FEW), beside=False)
            verdicts.append(str(answer.verdict))
            if answer.proved:
                certificate = team.with_name(NAMED.format(network, agent, number))
                certificate.write_text(to_json(answer.evidence.certificate), encoding="utf-8")
                maviper.check(certificate, team, world=world)
        print(f"{network:<13} {agent:<10} {' '.join(verdicts)} {process_time() - begun:5.1f} CPU s", flush=True)


if __name__ == "__main__":
    for each in sys.argv[1:] or signals.NETWORKS:
        prove(each)
