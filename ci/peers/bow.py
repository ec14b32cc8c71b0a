"""The bow of a wire on tissue as a finite-difference beam, on wires from standard input.

In: a list of {diameter_m, length_m, modulus_pa, sag_m, ends, tissue_pa, contact_m}. Out: the gain of each, the
displacement of the wire's middle over its change of length.

A shallow arch on springs. The energies of bending, stretching (the mean of rest' w' less the strain) and springs stand
on a grid, so that nothing of the one-term formula is in here but its shape at rest.
"""

import json
import math
import sys

import numpy as np
import scipy.sparse as sparse
from scipy.sparse.linalg import spsolve
from scipy.special import ellipk

NODES = 4001


def gain(wire):
    d, length, sag, ends = wire["diameter_m"], wire["length_m"], wire["sag_m"], wire["ends"]
    stretch = wire["modulus_pa"] * math.pi * d**2 / 4
    bend = wire["modulus_pa"] * math.pi * d**4 / 64
    line = math.pi * wire["tissue_pa"] / 0.75 * length / 2 / ellipk(1 - (wire["contact_m"] / length) ** 2)
    x = np.linspace(0, length, NODES)
    h = x[1]
    rest = sag * np.sin(math.pi * x / length) if ends == "pinned" else sag / 2 * (1 - np.cos(2 * math.pi * x / length))
    first = sparse.diags([-1.0, 1.0], [0, 1], shape=(NODES - 1, NODES)) / h
    second = sparse.diags([1.0, -2.0, 1.0], [-1, 0, 1], shape=(NODES, NODES)).tolil()
    # Beyond an end the wire goes on as its mirror image: upright where it cannot turn, upside down where it can.
    mirror = -1 if ends == "pinned" else 1
    for end, inner in [(0, 1), (NODES - 1, NODES - 2)]:
        second[end, :] = 0
        second[end, inner] = 1 + mirror
    second = second.tocsr() / h**2
    part = np.full(NODES, h)
    part[[0, -1]] = h / 2
    stiffness = bend * (second.T @ sparse.diags(part) @ second) + line / length * sparse.diags(part)
    if ends == "buckled":
        stiffness = stiffness - bend * (2 * math.pi / length) ** 2 * h * (first.T @ first)
    inside = slice(1, -1)
    pull = (h * (first.T @ (first @ rest)))[inside]
    soft = spsolve(stiffness.tocsr()[inside, inside].tocsc(), pull)
    whole = stretch / length
    return (whole * soft / (1 + whole * (pull @ soft)))[NODES // 2 - 1]


json.dump([gain(wire) for wire in json.load(sys.stdin)], sys.stdout)
