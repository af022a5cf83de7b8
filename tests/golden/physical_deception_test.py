"""Replays physical_deception.vectors.txt: python physical_deception_test.py"""
import struct, sys, physical_deception as policy
wrong = n = 0
for line in open("physical_deception.vectors.txt"):
    if not line.startswith("#"):
        agent, action, *bits = line.split()
        x = [struct.unpack("<f", struct.pack("<I", int(value, 16)))[0] for value in bits]
        n, wrong = n + 1, wrong + (policy.ACT[policy.AGENTS[int(agent)]](x) != int(action))
print(f"{n} vectors, {wrong} wrong")
sys.exit(wrong != 0 or n == 0)
