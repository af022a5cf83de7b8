"""Guards for the trees of a team: `python repaired.py NETWORK PROFILE FOLDER` proves that everybody has green again.

Does: repairs each signal's tree by its claims; writes the team, the worlds and the certificates, which the checker
  accepts; prints guards and CPU seconds.
Assumes: the environment of `signals.py`; trees that test no sums.
Does not: measure delay, which `maviper evaluate` does.
"""

import sys
from pathlib import Path
from time import process_time

import plant
import signals

import maviper
from codegen.ir import PolicyProfile
from codegen.policy_json import dumps
from maviper.verification.guarding import repair_stated


def repair(network: str, profile: str, folder: str) -> None:
    """Writes the files of a network, and prints a line for each signal."""
    team: PolicyProfile = maviper.load(profile)
    place, begun = Path(folder), process_time()
    certificates = list[tuple[Path, Path]]()
    for agent, signal in signals.make(network).signals.items():
        world = place / f"{network}-{agent}.toml"
        world.write_text(plant.world(agent, signal, network, jumping=True), encoding="utf-8")
        done = repair_stated(team, world)
        if done.after is None:
            sys.exit(f"{agent}: {done.reason}")
        team = done.after
        for number, text in enumerate(done.certificates.values(), 1):
            certificates.append((place / f"{network}-{agent}-{number}.json", world))
            certificates[-1][0].write_text(text, encoding="utf-8")
        print("; ".join(guard.words for guard in done.guards) or f"{agent}: no guard", flush=True)
    Path(place, f"{network}.json").write_text(dumps(team), encoding="utf-8")
    for certificate, world in certificates:
        maviper.check(certificate, place / f"{network}.json", world=world)
    print(f"{len(certificates)} certificates accepted, {process_time() - begun:.1f} CPU s")


if __name__ == "__main__":
    repair(*sys.argv[1:])
