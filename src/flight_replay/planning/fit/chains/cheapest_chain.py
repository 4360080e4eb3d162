"""The cheapest chain of legs along several drafts, with a limited number of legs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flight_replay.geometry.arrays import Floats, Indices


@dataclass(frozen=True, slots=True, eq=False)
class Links:
    """After each of k legs ``here`` a chain can go on as after leg ``there`` of another draft, at a price."""

    here: Indices
    there: Indices
    price: Floats


def cheapest_chain(place: Indices, cost: Floats, passing_s: Floats, links: Links, most: int) -> Indices:
    """The legs, in order, of the cheapest chain from the first leg of a draft to the last of one.

    It is a shortest path with a limit (Joksch, 1966): what it costs to come to each leg's end, for every
    number of legs up to there.

    Args:
        place: the place in its draft to which each leg (n,) leads, the legs of a draft one after another.
        cost: of each leg (n,); the first of a draft costs nothing.
        passing_s: when each leg (n,) ends, never falling within a draft.
        links: where a chain may change from one draft to another.
        most: how many legs a chain may have.

    Returns:
        the legs; none if there is no chain.
    """
    search = _Search(place, links, most)
    for leg in np.lexsort((np.arange(len(cost)), passing_s)).tolist():
        search.visit(leg, float(cost[leg]))
    return search.chain()


class _Search:
    """What it costs to come to the end of each leg, by how many legs there are up to it.

    ``_come`` (n, most + 1) is the cost of coming by the leg itself, ``_leave`` that of going on from there to
    the next leg, and ``_after`` the leg by which the chain then has come: this one or one of another draft.
    """

    def __init__(self, place: Indices, links: Links, most: int) -> None:
        count = len(place)
        first = np.flatnonzero(place == 0)
        self._first, self._last = set(first.tolist()), (np.append(first[1:], count) - 1).tolist()
        self._come = np.full((count, most + 1), np.inf)
        self._leave = np.full((count, most + 1), np.inf)
        self._after = np.zeros((count, most + 1), np.intp)
        self._visited = np.zeros(count + 1, np.bool_)
        self._links: list[list[tuple[int, float]]] = [[] for _ in range(count)]
        columns = (links.here.tolist(), links.there.tolist(), links.price.tolist())
        for here, there, price in zip(*columns, strict=True):
            self._links[here].append((there, price))

    def visit(self, leg: int, cost: float) -> None:
        """Come to the end of a leg, and from there to those that are linked to it, unless they are left."""
        if leg in self._first:
            self._come[leg, 1] = 0.0
        else:
            self._come[leg, 1:] = self._leave[leg - 1, :-1] + cost
        self._visited[leg] = True
        self._go_on(leg, leg, 0.0)
        for there, price in self._links[leg]:
            if not self._visited[there + 1]:
                self._go_on(leg, there, price)

    def _go_on(self, here: int, there: int, price: float) -> None:
        """Let chains that have come by one leg go on as after another, where that is cheaper."""
        cost = self._come[here] + price
        cheaper = cost < self._leave[there]
        self._leave[there][cheaper] = cost[cheaper]
        self._after[there][cheaper] = here

    def chain(self) -> Indices:
        """The legs of the cheapest chain to an end."""
        cost, leg = min((float(self._come[last].min()), last) for last in self._last)
        if not np.isfinite(cost):
            return np.empty(0, np.intp)
        count = int(self._come[leg].argmin())
        chain = [leg]
        while leg not in self._first:
            leg, count = int(self._after[leg - 1, count - 1]), count - 1
            chain.append(leg)
        return np.array(chain[::-1], np.intp)
