"""Ways to damage a log: each takes its bytes, a source of chance, and other logs to take pieces of."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

Mutation = Callable[[bytes, np.random.Generator, list[bytes]], bytes]


def flipped(data: bytes, chance: np.random.Generator, _: list[bytes]) -> bytes:
    """Flip up to forty bits."""
    bits = np.unpackbits(np.frombuffer(data, np.uint8))
    bits[chance.integers(0, len(bits), chance.integers(1, 40))] ^= 1
    return np.packbits(bits).tobytes()


def cut(data: bytes, chance: np.random.Generator, _: list[bytes]) -> bytes:
    """Leave out what is between two places, or keep just that."""
    first, last = sorted(chance.integers(0, len(data) + 1, 2).tolist())
    return data[first:last] if chance.random() < 0.5 else data[:first] + data[last:]


def spliced(data: bytes, chance: np.random.Generator, others: list[bytes]) -> bytes:
    """Put a piece of another log into this one, over what is there or beside it."""
    other = others[chance.integers(len(others))]
    first, last = sorted(chance.integers(0, len(other) + 1, 2).tolist())
    at = int(chance.integers(0, len(data)))
    return data[:at] + other[first:last] + data[at + (last - first) * int(chance.integers(2)) :]


def repeated(data: bytes, chance: np.random.Generator, _: list[bytes]) -> bytes:
    """Say a piece several times."""
    first, last = sorted(chance.integers(0, len(data) + 1, 2).tolist())
    return data[:last] + data[first:last] * int(chance.integers(1, 4)) + data[last:]


def shuffled(data: bytes, chance: np.random.Generator, _: list[bytes]) -> bytes:
    """Cut into pieces of some length, and put those together in any order."""
    length = int(chance.integers(8, 600))
    pieces = [data[at : at + length] for at in range(0, len(data), length)]
    return b"".join(pieces[index] for index in chance.permutation(len(pieces)))


def overwritten(data: bytes, chance: np.random.Generator, _: list[bytes]) -> bytes:
    """Replace up to twenty bytes by others of the same file."""
    values = np.frombuffer(data, np.uint8).copy()
    count = chance.integers(1, 20)
    values[chance.integers(0, len(values), count)] = values[chance.integers(0, len(values), count)]
    return bytes(values)


def zeroed(data: bytes, chance: np.random.Generator, _: list[bytes]) -> bytes:
    """Leave a piece unwritten, as zeros."""
    first, last = sorted(chance.integers(0, len(data) + 1, 2).tolist())
    return data[:first] + bytes(last - first) + data[last:]


def mutated(originals: list[bytes], chance: np.random.Generator, ways: tuple[Mutation, ...]) -> bytes:
    """One of the originals, mutated up to three times in some of these ways."""
    data = originals[chance.integers(len(originals))]
    for _ in range(chance.integers(1, 4)):
        if data:
            data = ways[chance.integers(len(ways))](data, chance, originals)
    return data


MOVES = (cut, spliced, repeated, shuffled)
"""Those that keep all bytes as they are, and only put them elsewhere."""

MUTATIONS = (flipped, *MOVES)
ALL_MUTATIONS = (*MUTATIONS, overwritten, zeroed)
