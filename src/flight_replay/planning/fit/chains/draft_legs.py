"""The legs of several drafts together, of which chains are made, and what they cost."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from flight_replay.geometry.arrays import Floats, Indices
from flight_replay.planning.fit.chains.cheapest_chain import Links, cheapest_chain
from flight_replay.planning.fit.chains.meetings import links_between, recorded_s
from flight_replay.planning.fit.objective import Evaluation, leg_costs_m, scales_of, seconds_cost_m_s
from flight_replay.planning.fit.problem import FitProblem
from flight_replay.planning.fit.rounds import State

_COST_DECIMALS = 9


class LegCosts:
    """What legs cost of the objective, linear about that of the best of some drafts.

    At the vehicle's own speed each second that a leg takes costs, too, as all that follows is later. How much
    depends on where that is late, so it is the mean of what it would be for all drafts ``learn`` is told of.
    """

    def __init__(self, problem: FitProblem, best: Evaluation) -> None:
        self._recording, self._timed = problem.recording, problem.timed
        self.scales_m = scales_of(best)
        self._second_m_s: Floats = np.zeros(len(problem.recording))
        self._drafts = 0
        self.learn(best)

    def costs_m(self, evaluation: Evaluation) -> Floats:
        """What the legs of a draft (n,) cost."""
        costs = leg_costs_m(evaluation, self.scales_m, whole=self._timed)
        if self._timed:
            return costs
        second_m_s = np.interp(evaluation.passed_s, self._recording.time_s, self._second_m_s)
        return np.asarray(costs + second_m_s * np.diff(evaluation.passed_s, prepend=0.0))

    def learn(self, flown: Evaluation) -> None:
        """Take into account where a draft is late, at the vehicle's own speed."""
        if self._timed:
            return
        self._drafts += 1
        self._second_m_s += (seconds_cost_m_s(flown, self._recording) - self._second_m_s) / self._drafts


@dataclass(frozen=True, slots=True, eq=False)
class DraftLegs:
    """The legs of some drafts, n together, and where one draft can go on as another."""

    drafts: list[Evaluation]
    draft: Indices
    place: Indices
    passing_s: Floats
    links: Links
    costs: LegCosts

    @classmethod
    def of(cls, problem: FitProblem, states: Sequence[State]) -> DraftLegs:
        """Those of drafts as they are flown."""
        lengths = [len(state.best.draft) for state in states]
        best = min(states, key=lambda state: state.objective_m).best
        costs = LegCosts(problem, best)
        path_share = sum(best.path_shares) / (8 * costs.scales_m[1] ** 3)
        return cls(
            [state.best for state in states],
            np.repeat(np.arange(len(states)), lengths),
            np.concatenate([np.arange(length) for length in lengths]),
            np.concatenate([recorded_s(problem, state.best) for state in states]),
            links_between(problem, states, path_share),
            costs,
        )

    @property
    def cost_m(self) -> Floats:
        """What each leg (n,) costs, without the last bits that would tell chains of one cost apart."""
        costs_m = np.concatenate([self.costs.costs_m(draft) for draft in self.drafts])
        return np.asarray(costs_m.round(_COST_DECIMALS))

    def cheapest_chain(self, most: int) -> Indices:
        """The legs of the chain of at most ``most`` places that is expected to be the cheapest."""
        return cheapest_chain(self.place, self.cost_m, self.passing_s, self.links, most)

    def rows(self, chain: Indices) -> list[tuple[int, int]]:
        """The draft of each leg of a chain, and the place that it leads to."""
        return list(zip(self.draft[chain].tolist(), self.place[chain].tolist(), strict=True))

    def is_one_draft(self, chain: Indices) -> bool:
        """Whether a chain is a draft as it is."""
        return not self._changes(chain)

    def expected_m(self, chain: Indices) -> float:
        """What a chain is expected to cost."""
        links = [link for _, link in self._changes(chain)]
        return float(self.cost_m[chain].sum() + self.links.price[links].sum())

    def learn(self, chain: Indices, flown: Evaluation) -> None:
        """Take what a chain costs more, as it is flown, for the prices of its links; and where it is late."""
        more_m = self.costs.costs_m(flown) - self.cost_m[chain]
        changes = self._changes(chain)
        begins = [0, *(at - 1 for at, _ in changes[1:]), len(chain)]
        for (begin, end), (_, link) in zip(pairwise(begins), changes, strict=True):
            self.links.price[link] = max(0.0, round(float(more_m[begin:end].sum()), _COST_DECIMALS))
        self.costs.learn(flown)

    def _changes(self, chain: Indices) -> list[tuple[int, int]]:
        """After which legs of a chain it goes on as another draft, and by which link."""
        return [
            (at, int(np.flatnonzero((self.links.here == here) & (self.links.there == next_leg - 1))[0]))
            for at, (here, next_leg) in enumerate(pairwise(chain.tolist()))
            if next_leg != here + 1
        ]
