"""Environments that get in the way of whoever plays them: `tests.support.hostile:make,mode=MODE`."""

import os
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
from gymnasium.spaces import Box, Discrete
from pettingzoo import ParallelEnv

from tests.support.environments import Scripted

LOCK = threading.Lock()  # one simulation a process
CLOCK = [0]
COUNTED = "COUNTED_RESETS"  # the environment variable that names a file with a byte for each reset


class Hostile(ParallelEnv):
    """Two agents that should match the time's parity; `mode`: what is wrong with it."""

    metadata = {"name": "hostile"}  # noqa: RUF012
    possible_agents = ["a_0", "a_1"]  # noqa: RUF012

    def __init__(self, mode, length):
        self.mode, self.length, self.time, self.held = mode, length, 0, False
        if mode != "endless":
            self.max_cycles = length
        self.say("made")

    def say(self, what):
        if self.mode == "prints":
            print(f"python: {what}")
            os.write(1, b"\0\xff descriptor 1\n")
            subprocess.run([sys.executable, "-S", "-c", "print('a child')"], check=True)

    def observation_space(self, agent):
        return Box(-1, 1e6, (2,), np.float32)

    def action_space(self, agent):
        return Discrete(2)

    def seen(self):
        number = np.nan if self.mode == "nan" and self.time == 2 else self.time
        shape = 3 if self.mode == "shape" and self.time == 2 else 2
        return {agent: np.array([self.time % 2, number, 0], np.float32)[:shape] for agent in self.possible_agents}

    def reset(self, seed=None, options=None):
        if self.mode == "hangs in reset":
            time.sleep(1_000)
        if self.mode == "lock" and not self.held:
            self.held = LOCK.acquire()
        if COUNTED in os.environ:
            with Path(os.environ[COUNTED]).open("a") as file:
                file.write("r")
        self.say("reset")
        self.agents, self.time, CLOCK[0] = list(self.possible_agents), 0, 0
        return self.seen(), {agent: {} for agent in self.agents}

    def step(self, actions):
        self.time += 1
        if self.mode == "clock":
            CLOCK[0] += 1
            while CLOCK[0] != self.time:
                CLOCK[0] += 1
        if self.time == 3:
            self.misbehave()
        paid = float(np.mean([action == self.time % 2 for action in actions.values()]))
        paid = np.nan if self.mode == "nan reward" else paid
        names, over = self.agents, self.time >= self.length
        self.agents = [] if over else names
        ends = dict.fromkeys(names, over), dict.fromkeys(names, False)
        return self.seen(), dict.fromkeys(names, paid), *ends, {agent: {} for agent in names}

    def misbehave(self):
        self.say("step")
        if self.mode == "exits":
            sys.exit("done")
        if self.mode == "dies":
            os._exit(9)
        if self.mode == "hangs":
            time.sleep(1_000)
        if self.mode == "forks" and not os.fork():
            os._exit(0)
        if self.mode == "raises":
            np.linalg.solve(np.zeros((2, 2)), np.ones(2))

    def close(self):
        self.say("closed")
        if self.held:
            LOCK.release()
        self.held = False
        if self.mode == "raises in close":
            raise RuntimeError("it does not close")


def make(mode="sound", length=6):
    return Hostile(mode.replace("_", " "), length)


def expert(mode="sound", length=6):
    """It matches the parity."""
    return Scripted(f"tests.support.hostile:make,length={length},mode={mode}", lambda seen: 1 - seen[:, 0].astype(int))
