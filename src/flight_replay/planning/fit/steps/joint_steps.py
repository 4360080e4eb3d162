"""Steps of all speeds, places and waits of a draft together, by the derivatives of its flight in the model.

At the vehicle's own speed they are steps of the places alone.

A step is that of Levenberg and Marquardt: the least squares of the errors, each weighted by its share in the
objective, with a damping that grows as steps fail. Near a good draft most changes have a kink: a leg takes
longer with a place farther to one side, and longer to the other. Then steps go by the derivatives to both.
A leg that takes longer makes all after it late, so after the step the speeds are set anew, to leave each
place when the step meant it to be left.

A step that fails as a whole is taken where it leads to something better (``better_parts``), and what made
it late is reckoned with in the next (``delays``).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flight_replay.geometry.arrays import Floats
from flight_replay.planning.fit.draft import Draft, with_every_speed
from flight_replay.planning.fit.legs.flight_derivatives import (
    EAST,
    HOLD,
    NORTH,
    SPEED,
    ErrorVectors,
    FlightDerivatives,
    changes_of,
    flight_derivatives,
    planned_marks,
)
from flight_replay.planning.fit.objective import Evaluation
from flight_replay.planning.fit.place_moves import kept_in_corridor
from flight_replay.planning.fit.problem import Budget, FitProblem
from flight_replay.planning.fit.reference import LEAST_HOLD_S
from flight_replay.planning.fit.rounds import WORTH_GOING_ON, State, flown, flown_on_time
from flight_replay.planning.fit.speed_schedule import (
    FASTEST_M_S,
    Schedule,
    slowest_m_s,
    speed_caps_m_s,
)
from flight_replay.planning.fit.steps.better_parts import places_better
from flight_replay.planning.fit.steps.delays import Delays
from flight_replay.planning.fit.steps.linear_model import LinearModel, Sides

JOINT_FLIGHTS = 11
"""A step costs about as many flights, by changes to both sides half as many again."""
_COARSER = 2.0
"""Derivatives are as good in steps so many times longer, though never longer than those of the search."""
_SMOOTH_GAIN = 0.02
"""Steps by changes to one side that gain less of the objective are followed by such to both sides."""
_MORE, _MORE_KNOWING, _LESS, _MOST_DAMPING = 4.0, 1.5, 0.5, 0.3
"""After a step that failed damping is more, but not much where it is known what made it late."""
_SMALLER = 0.5
"""Where changes to both sides lead nowhere, smaller ones may."""
_TRIES = 3
_MANY_STEPS = 100
_PATIENCE_S = 60.0
"""A leg may take so much longer than the flight: the first comes after the climb of a take-off."""
_MOST_DERIVATIVES = 10_000_000
"""More would take too much memory; six copies of these take 480 MB."""
_USUAL_CHANGE = np.array([0.15, 0.4, 0.4, 0.5])  # Of a speed's logarithm, of a place, m, and of a wait, s.


def stepped(problem: FitProblem, state: State, budget: Budget, most: int = _MANY_STEPS) -> State:
    """After steps of all speeds and places together, while they gain and there is time.

    Args:
        problem: what to fit.
        state: the draft as it is flown in the exact steps of ``problem``.
        budget: is told how much was flown.
        most: how many times steps may be made.
    """
    for _ in range(most):
        before_m = state.objective_m
        if not budget.affords(JOINT_FLIGHTS):
            break
        state = stepped_jointly(problem, state, budget)
        if state.objective_m >= (1 - WORTH_GOING_ON) * before_m:
            break
    return state


def stepped_jointly(problem: FitProblem, state: State, budget: Budget) -> State:
    """The best after some steps by the same derivatives, and how the next are to be made."""
    if not 0 < _derivatives_count(state.best) <= _MOST_DERIVATIVES:
        return state
    steps = _JointSteps(problem, state, budget)
    if not steps.can_be_made:
        return state
    one = steps.derivatives(state.change_size)
    if not state.both_sides:
        after = steps.taken(state, Sides(one))
        if after.best is not state.best:
            gained = 1 - after.objective_m / state.objective_m
            return replace(after, both_sides=gained < _SMOOTH_GAIN)
        if not budget.affords(JOINT_FLIGHTS):
            return after
        state = replace(state, both_sides=True)
    after = steps.taken(state, Sides(one, steps.derivatives(-state.change_size)))
    if after.best is not state.best:
        return after
    return replace(after, change_size=_SMALLER * state.change_size)


class _JointSteps:
    """Steps from one draft by derivatives of its flight."""

    def __init__(self, problem: FitProblem, state: State, budget: Budget) -> None:
        self._recording, self._exact, self._budget = problem.recording, problem.exact, budget
        self._coarse = replace(self._exact, step_s=min(_COARSER * self._exact.step_s, problem.step_s))
        is_exact = self._coarse.step_s == self._exact.step_s
        self._base = state.best if is_exact else self._coarse.evaluate(state.best.draft)
        self._flight = state.best.flight
        self._kinds, self._places = changes_of(state.best.draft, timed=problem.timed)
        self._usual = _USUAL_CHANGE[self._kinds]
        planned, _ = state.best.planned
        self._caps_m_s = speed_caps_m_s(planned, len(state.best.draft), problem.recording)

    @property
    def can_be_made(self) -> bool:
        """Whether the vehicle stays up also in steps of the model that are longer."""
        return self._base.flight.stays_up

    def derivatives(self, size: float) -> FlightDerivatives:
        """Those of the draft's flight by changes of such a size; see ``flight_derivatives``."""
        longest_s = float(self._flight.time_s[-1]) + _PATIENCE_S
        found = flight_derivatives(self._coarse, self._base, longest_s, size)
        self._spend(found.steps)
        return found

    def taken(self, state: State, sides: Sides) -> State:
        """After a few steps, those that succeed with less damping after them, those that fail with more."""
        state = replace(state, damping=min(state.damping, _MOST_DAMPING))
        back_m = self._base.flown[1].off_m, planned_marks(self._base).off_m
        errors = _errors(state.best, back_m)
        delays = Delays.none(len(state.best.draft), len(self._places))
        for _ in range(_TRIES):
            foretold = delays.added_to(sides, state.best, self._recording)
            changes = LinearModel.of(foretold, errors, state.best).best_changes(state.damping, self._usual)
            trial, damping = self._flown(state, foretold, changes), _LESS * state.damping
            if trial.objective_m >= state.best.objective_m:
                delays = self._learned(
                    delays, changes, trial.passed_s - self._leave_s(state, foretold, changes)
                )
                changes = changes * places_better(state.best, trial)[self._places]
                trial, damping = self._flown(state, foretold, changes), state.damping
            if trial.objective_m >= state.best.objective_m:
                more = _MORE_KNOWING if delays.are_known else _MORE
                state = replace(state, damping=more * state.damping)
                continue
            errors = _errors(trial, errors.moved_back(foretold.errors(changes)))
            state = replace(state, best=trial, damping=damping)
        return state

    def _learned(self, delays: Delays, changes: Floats, late_s: Floats) -> Delays:
        """The delays known after a step that failed; a wait is as long as it is."""
        if not self._exact.timed:
            return delays
        to_blame = np.where(self._kinds == HOLD, 0.0, changes)
        return delays.learned(to_blame, self._usual, self._places, late_s)

    def _flown(self, state: State, sides: Sides, changes: Floats) -> Evaluation:
        """The draft with changes (p,), each place left when they lead there, if the speeds may be set."""
        if not changes.any():
            return state.best
        draft = self._changed(state.best.draft, changes)
        draft = kept_in_corridor(draft, state.hovers, self._recording)
        if not self._exact.timed:
            return flown(self._exact, draft, self._budget)
        schedule = Schedule(draft, np.maximum.accumulate(self._leave_s(state, sides, changes)))
        trial, steps = flown_on_time(self._exact, schedule, self._caps_m_s)
        self._spend(steps)
        return trial

    @staticmethod
    def _leave_s(state: State, sides: Sides, changes: Floats) -> Floats:
        """When each place (n,) is left after changes, as foretold."""
        return state.best.passed_s + sides.passed_s(changes)

    def _changed(self, draft: Draft, changes: Floats) -> Draft:
        """The draft with the logarithms of its speeds, its places and its waits changed."""
        by_place = np.zeros((len(draft), len(_USUAL_CHANGE)))
        by_place[self._places, self._kinds] = changes
        places = draft.places_m.copy()
        places[:, :2] += by_place[:, [NORTH, EAST]]
        moved = replace(draft, places_m=places)
        if not self._exact.timed:
            return moved
        wanted_m_s = with_every_speed(draft).speed_m_s * np.exp(by_place[:, SPEED])
        speeds = np.clip(wanted_m_s, slowest_m_s(draft), np.minimum(FASTEST_M_S, self._caps_m_s)).round(2)
        waits = draft.hold_s > 0
        hold_s = np.where(waits, np.maximum(LEAST_HOLD_S, _whole(draft.hold_s + by_place[:, HOLD])), 0.0)
        return replace(moved, speed_m_s=speeds, hold_s=hold_s)

    def _spend(self, steps: int) -> None:
        self._budget.spend(self._exact.flights_of(steps, self._flight))


def _whole(seconds: Floats) -> Floats:
    """Whole seconds, as items wait; the speeds on time make up for the rest."""
    return np.floor(seconds + 0.5)


def _derivatives_count(evaluation: Evaluation) -> int:
    """How many numbers the derivatives of all errors by all changes are."""
    vectors = len(evaluation.late_m) + sum(
        len(offsets.leg) for both_ways in (evaluation.flown, evaluation.planned) for offsets in both_ways
    )
    changes, _ = changes_of(evaluation.draft, timed=evaluation.timed)
    return 2 * vectors * len(changes)


def _errors(evaluation: Evaluation, back_m: tuple[Floats, Floats]) -> ErrorVectors:
    """The errors of a draft as it is flown, but for those of its paths' own points, which are given."""
    late_m = evaluation.late_off_m[:, :2]
    return ErrorVectors(late_m, evaluation.flown[0].off_m, evaluation.planned[0].off_m, *back_m)
