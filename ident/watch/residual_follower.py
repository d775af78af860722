"""The residual of a model along a recording that comes in pieces, second by second.

Each second is computed as `ident compare` would: from a window of samples that reaches back to where effects with a
memory begin, and ahead by what the filters need. The zero-phase filters are finite, so the residual is the same, and
comes with the fixed delay of their half-width.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ident.basics import filters, slicing
from ident.data.prepared_recording import PreparedRecording, prepare
from ident.estimation import chunks
from ident.identification.model import Model
from ident.identification.prediction import check_model_rig, structure_of
from ident.watch.blocks import Rows, rows_of
from ident.watch.tracking import tracked_entries
from recordings.errors import BadInput
from recordings.recording import Floats, Recording

LONGEST_DELAY = 0.25
"""[s]"""
_STENCIL = 10
"""Samples beyond it: of the derivatives, and of measurements that are interpolated."""


@dataclass(frozen=True, eq=False)
class Second:
    """What became known of one second of the recording."""

    time: float
    """Its end [s]."""
    rows: Rows | None
    """None: nothing of it is usable, as at rest."""
    terms: Mapping[str, Floats]
    """(m, dof) torque of each cause at the rows [N m or N]; empty if not asked for."""
    columns: Floats | None
    """(m, dof, k) derivatives of the torque by the parameters that are followed; None: none is."""


class ResidualFollower:
    """Computes the residual of one recording."""

    def __init__(
        self,
        model: Model,
        with_terms: bool = False,
        track: Sequence[str] = (),
    ) -> None:
        """`with_terms`: the torque of each cause as well; `track`: names of parameters that are followed.

        Raises:
            BadInput: the filters of the model need to look further ahead than LONGEST_DELAY.
        """
        self._model, self._settings = model, model.file.preprocessing
        self._with_terms, self._track = with_terms, track
        self._window: Recording | None = None
        self._starts: dict[int, float] = {}
        """Time at which each cycle began [s]: a window may begin within one."""
        self._next = 1.0
        self._usable, self.problem = False, "it holds no whole second"
        bandwidth, method = self._settings.bandwidth, self._settings.name
        self.delay = filters.REACH / bandwidth * (1 + 1 / 3)
        """Between a sample and its residual [s]; once the rate is known, with the stencils of the derivatives."""
        if method not in ("parallel", "savgol") or self.delay > LONGEST_DELAY:
            least = filters.REACH * (1 + 1 / 3) / LONGEST_DELAY
            raise BadInput(
                f"a model whose filter looks at most {LONGEST_DELAY:g} s ahead expected (parallel, at least "
                f"{least:g} Hz), {method} with {bandwidth:g} Hz found; fit it with "
                f"--preprocess parallel --cutoff {np.ceil(least):g}"
            )

    def seconds(self, piece: Recording) -> Iterator[Second]:
        """Yield the seconds that the next `piece` completes.

        Raises:
            BadInput: the recording is of another rig than the model.
        """
        if self._window is None:
            check_model_rig(self._model.file, piece)
            self._structure, self._x = structure_of(self._model.file, piece.rig, self._model.library)
            self._entries = tracked_entries(self._structure, self._track)
            bandwidth = self._settings.bandwidth
            ahead = filters.REACH / bandwidth + filters.REACH / min(3 * bandwidth, piece.run.rate / 4)
            self.delay = min(ahead + _STENCIL / piece.run.rate, LONGEST_DELAY)
        self._window = piece if self._window is None else slicing.concatenated([self._window, piece])
        for number in np.unique(piece.repeat[piece.repeat >= 0]).tolist():
            self._starts.setdefault(number, float(piece.time[piece.repeat == number][0]))
        while self._window.time[-1] >= self._next + self.delay:
            yield self._second(self._next)
            self._next += 1.0

    def last(self) -> Iterator[Second]:
        """Yield what is left at the end of the recording."""
        if self._window is not None and self._window.time[-1] > self._next - 1.0:
            yield self._second(float(self._window.time[-1]) + 0.5 / self._window.run.rate)
        if not self._usable:
            raise BadInput(f"a recording in which the robot moves expected, nothing usable found: {self.problem}")

    def _second(self, end: float) -> Second:
        assert self._window is not None
        begin = self._next - 1.0
        before = begin - chunks.RUN_IN - 2 * self.delay
        self._window = slicing.along_time(self._window, self._window.time >= before)
        self._starts = {number: start for number, start in self._starts.items() if number >= max(self._starts) - 3}
        used = slicing.along_time(self._window, self._window.time <= end + 2 * self.delay)
        try:
            if not (used.repeat >= 0).any():
                raise BadInput("the motion has not begun")
            prepared, rows, columns = self._rows(used)
        except BadInput as error:
            self.problem = str(error)
            return Second(end, None, {}, None)
        self._usable = True
        inside = (rows.time >= begin) & (rows.time < end)
        terms = self._terms(prepared) if self._with_terms else {}
        return Second(
            end,
            slicing.along_time(rows, inside),
            {name: values[inside] for name, values in terms.items()},
            None if columns is None else columns[inside],
        )

    def _rows(self, used: Recording) -> tuple[PreparedRecording, Rows, Floats | None]:
        start = float(used.time[0])
        shifted = replace(used, time=used.time - start)
        settings, end = self._settings, float(used.time[-1])
        prepared = prepare(shifted, settings.name, settings.bandwidth, start, end, self._model.file.form)
        columns = None
        if self._track:
            computed, derivatives = chunks.linearized(prepared, self._structure, self._x)
            columns = derivatives[:, :, self._entries]
        else:
            computed = chunks.torque(prepared, self._structure, self._x)
        rows = rows_of(prepared, computed)
        begun = np.array([self._starts.get(number, np.nan) for number in rows.cycle.tolist()])
        return prepared, replace(rows, phase=rows.time - begun), columns

    def _terms(self, prepared: PreparedRecording) -> dict[str, Floats]:
        """(m, dof) torque of each cause, conditioned as the measured one."""
        motion = prepared.preprocessed.motion
        known = np.isfinite(motion.acceleration).all(axis=1)
        terms = self._model.terms(
            motion.position[known],
            motion.velocity[known],
            motion.acceleration[known],
            motion.sample_time,
            prepared.instant_time[known],
            np.nan_to_num(prepared.temperature[known]),
        )
        result = {}
        for name, values in terms.items():
            whole = np.full_like(motion.position, np.nan)
            whole[known] = values
            result[name] = prepared.condition(whole)
        return result
