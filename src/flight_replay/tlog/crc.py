"""The CRC of many MAVLink frames at once: CRC-16/MCRF4XX (X.25 without the last inversion), two bytes a step.

Defined at mavlink.io, "Packet Serialization": over everything between the start mark and the
checksum, then over the message's CRC extra. The checksum is sent low byte first.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Bytes = NDArray[np.uint8]
_REVERSED_POLYNOMIAL = 0x8408  # x^16 + x^12 + x^5 + 1, lowest bit first


def _byte_table() -> NDArray[np.uint16]:
    """What a byte (256,) adds to an empty checksum."""
    table = np.arange(256, dtype=np.uint16)
    for _ in range(8):
        table = (table >> 1) ^ (_REVERSED_POLYNOMIAL * (table & 1)).astype(np.uint16)
    return table


def _pair_table() -> NDArray[np.uint16]:
    """What two bytes (65536,), the first one low, add to an empty checksum."""
    pairs = np.arange(1 << 16, dtype=np.uint16)
    first = _OF_BYTE[pairs & 255]
    return (first >> 8) ^ _OF_BYTE[(first ^ (pairs >> 8)) & 255]


_OF_BYTE = _byte_table()
_OF_PAIR = _pair_table()


def checked_rows(
    block: Bytes, starts: NDArray[np.intp], length: int, extras: int | NDArray[np.int16]
) -> tuple[Bytes, NDArray[np.bool_]]:
    """The ``length`` bytes after each start mark (n, length), and whether the checksum behind fits.

    Args:
        block: Bytes, at least one before the first start.
        starts: Where frames start in it.
        length: Header without the start mark, plus payload; at least 3.
        extras: CRC extra of the messages, one for all or one each.
    """
    pad = length % 2  # an odd row begins with the start mark, which is then blanked
    width = pad + length + 2
    anywhere = np.ndarray((len(block) - width + 1,), f"V{width}", block, strides=(1,))
    rows = anywhere[starts + (1 - pad)].view(np.uint8).reshape(-1, width)
    words = np.array(rows.view("<u2").T, order="C")
    words[0] ^= 0xFFFF  # the checksum's initial value meets the first two bytes
    if pad:
        words[0] &= 0xFF00
        words[1] ^= 0x00FF
    crc = _OF_PAIR.take(words[0])
    for word in words[1:-1]:
        crc = _OF_PAIR.take(crc ^ word)
    crc = (crc >> 8) ^ _OF_BYTE.take((crc ^ np.asarray(extras).astype(np.uint16)) & 255)
    return rows[:, pad:-2], crc == words[-1]
