"""The cheapest chain of legs, against all the chains that there are."""

from itertools import pairwise, product

import numpy as np
import pytest

from flight_replay.geometry.arrays import Floats, Indices
from flight_replay.planning.fit.chains.cheapest_chain import Links, cheapest_chain

NO_LINKS = Links(np.empty(0, np.intp), np.empty(0, np.intp), np.empty(0))


def places(*lengths: int) -> Indices:
    return np.concatenate([np.arange(length) for length in lengths])


def cost_of(chain: list[int], cost: Floats, links: Links) -> float:
    """What a chain costs; infinitely much if it is none."""
    prices = {
        (here, there): price
        for here, there, price in zip(
            links.here.tolist(), links.there.tolist(), links.price.tolist(), strict=True
        )
    }
    total = 0.0
    for before, leg in pairwise(chain):
        total += float(cost[leg]) + (0.0 if leg == before + 1 else prices.get((before, leg - 1), np.inf))
    return total


def test_one_draft_is_its_own_chain() -> None:
    """With enough legs allowed it is all there is, with fewer there is none."""
    cost, passing_s = np.array([0.0, 1.0, 2.0]), np.array([0.0, 5.0, 9.0])
    assert cheapest_chain(places(3), cost, passing_s, NO_LINKS, 3).tolist() == [0, 1, 2]
    assert cheapest_chain(places(3), cost, passing_s, NO_LINKS, 2).tolist() == []


def test_a_chain_changes_where_that_is_cheaper() -> None:
    """It begins as the first draft, which is dear later, and goes on as the second."""
    cost = np.array([0.0, 1.0, 9.0, 0.0, 7.0, 1.0])
    passing_s = np.array([0.0, 5.0, 10.0, 0.0, 5.0, 10.0])
    links = Links(np.array([1, 4]), np.array([4, 1]), np.array([0.5, 0.5]))
    assert cheapest_chain(places(3, 3), cost, passing_s, links, 6).tolist() == [0, 1, 5]
    dear = Links(links.here, links.there, np.array([8.0, 8.0]))
    assert cheapest_chain(places(3, 3), cost, passing_s, dear, 6).tolist() == [3, 4, 5]


@pytest.mark.parametrize("seed", range(20))
def test_no_chain_is_cheaper(seed: int) -> None:
    """Drafts that meet at places in order, and every limit of legs."""
    rng = np.random.default_rng(seed)
    here, there = np.array([1, 2, 6, 7]), np.array([6, 7, 1, 2])
    links = Links(here, there, rng.uniform(0.0, 0.5, 4))
    cost = rng.uniform(0.0, 1.0, 10) * ~np.isin(np.arange(10), (0, 5))
    passing_s = np.tile([0.0, 2.0, 4.0, 6.0, 8.0], 2) + np.repeat([0.0, 0.5], 5)
    chains = [list(chain) for chain in product(*[(row, row + 5) for row in range(5)])]
    least = min(cost_of(chain, cost, links) for chain in chains)
    found = cheapest_chain(places(5, 5), cost, passing_s, links, 5).tolist()
    assert cost_of(found, cost, links) == pytest.approx(least)


def test_a_chain_has_no_more_legs_than_are_allowed() -> None:
    """The second draft has more in its first half, the first in its second."""
    place = places(5, 5)
    cost = np.array([0.0, 4.0, 0.1, 0.1, 0.1, 0.0, 0.1, 0.1, 0.1, 4.0])
    passing_s = np.array([0.0, 6.0, 8.0, 10.0, 12.0, 0.0, 2.0, 4.0, 6.0, 12.0])
    links = Links(np.array([1, 8]), np.array([8, 1]), np.array([0.0, 0.0]))
    assert cheapest_chain(place, cost, passing_s, links, 7).tolist() == [5, 6, 7, 8, 2, 3, 4]
    assert len(cheapest_chain(place, cost, passing_s, links, 5)) == 5
