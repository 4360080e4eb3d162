"""MAVLink's checksum: CRC-16/MCRF4XX, which is X.25 without the last inversion.

Defined at mavlink.io, "Packet Serialization": over everything between the start byte and the
checksum, then over the message's CRC extra. The checksum is sent low byte first.
"""

from __future__ import annotations

import binascii

import numpy as np

from flight_replay.geometry.arrays import Bytes, Flags, Words

_REVERSED_POLYNOMIAL = 0x8408  # x^16 + x^12 + x^5 + 1, lowest bit first
_INITIAL = 0xFFFF


def _byte_table() -> Words:
    """What a byte (256,) adds to an empty checksum."""
    table = np.arange(256, dtype=np.uint16)
    for _ in range(8):
        table = np.where(table & 1, (table >> 1) ^ np.uint16(_REVERSED_POLYNOMIAL), table >> 1)
    return table.astype(np.uint16)


def _pair_table() -> Words:
    """What two bytes (65536,), the first one low, add to an empty checksum."""
    pairs = np.arange(1 << 16, dtype=np.uint16)
    first = _OF_BYTE.take(pairs & 255)
    second = _OF_BYTE.take((first ^ (pairs >> 8)) & 255)
    return np.asarray((first >> 8) ^ second, np.uint16)


def _fours_table() -> Words:
    """What a byte adds that 0, 1, 2 or 3 others follow, shape (4, 256)."""
    rows = [_OF_BYTE]
    for _ in range(3):
        rows.append(np.asarray((rows[-1] >> 8) ^ _OF_BYTE.take(rows[-1] & 255), np.uint16))
    return np.array(rows, np.uint16)


_OF_BYTE = _byte_table()
OF_FOURS = _fours_table()
_OF_PAIR = _pair_table()
_BITS_REVERSED = bytes(int(f"{byte:08b}"[::-1], 2) for byte in range(256))


def are_crcs_valid(frames: Bytes, extra: int) -> Flags:
    """Whether the checksums of many frames fit, shape (n,): two bytes of all of them at a time.

    Args:
        frames: Whole ones of equal length without signature, start byte to checksum, shape (n, length).
        extra: CRC extra of the message that all of them hold.
    """
    pad = 1 - frames.shape[1] % 2  # an even row begins with the start byte, which is then blanked
    words = frames[:, 1 - pad :].view("<u2").T.copy()
    words[0] ^= _INITIAL
    if pad:
        words[0] &= 0xFF00
        words[1] ^= _INITIAL >> 8
    crc = _OF_PAIR.take(words[0])
    for word in words[1:-1]:
        crc = _OF_PAIR.take(crc ^ word)
    crc = (crc >> 8) ^ _OF_BYTE.take((crc ^ extra) & 255)
    return np.asarray(crc == words[-1])


def is_crc_valid(checked: bytes, extra: int) -> bool:
    """Whether the last two of the bytes behind a start byte are the checksum of the others.

    Python's own CRC of this polynomial takes the highest bit first, so it is given bytes
    reversed bit by bit, and compared with the checksum reversed.
    """
    mirrored = checked.translate(_BITS_REVERSED)
    crc = binascii.crc_hqx(mirrored[:-2] + _BITS_REVERSED[extra : extra + 1], _INITIAL)
    return crc == int.from_bytes(mirrored[-2:], "big")
