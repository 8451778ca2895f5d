"""The search for crack paths: grown segment by segment, then judged by runs along the whole of them."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import count

import numpy as np

from meshing.paths import Line, Point, as_text, distance_to

from ..errors import SceneError
from ..scenes.scene import Scene
from .body import FACE, Body
from .crack import Crack, other_lines, trial_lines, unit
from .found import FoundPath, Vertex
from .onset import onset
from .path_trial import PathTrial, run_trial

#: no segment turns by more than this, radians
LARGEST_TURN = math.radians(75.0)

#: default averaging radius: this part of E Gf/ft^2, at most this part of the shortest ligament; the segment over it, and how
#: many elements along the crack both have at least
_OF_LENGTH, _OF_LIGAMENT, _SEGMENT, _ELEMENTS = 0.07, 0.25, 2.0 / 3.0, 3.0

#: passes over the whole path, and the part of a segment by which the last one may move it, straight ends left out
_MOST_PASSES, _SETTLED = 8, 0.1

#: turn between two trials for the direction without sliding, radians
_PROBING = math.radians(10.0)

#: part of a change of direction that a pass makes: the whole of it overshoots, for a crack that is off its way turns back by
#: about twice the angle between them
_RELAXATION = 0.5

#: a pass that moves the path by more than this part of what the one before did oscillates
_DAMPED = 0.7

#: a crack that is nearer to the face ahead than so many radii goes on straight, for the compression there turns the field
_LAST_RADII, _LAST = 1.5, "it is near the face ahead"

#: no segment before it is shorter than this part of the others, nor longer than that
_SLIVER, _LONGEST = 0.25, 1.5

#: why else its direction is fixed
_UNCLEAR = "the stresses ahead favour no direction"

#: more segments than any path needs
_MOST_SEGMENTS = 500


def find_path(scene: Scene) -> FoundPath:
    """The crack paths of a scene whose cracks grow.

    Raises
    ------
    SceneError, MeshError
        For bad input, or if no tip is ever critical.
    """
    return Search(scene.in_plane() if scene.is_solid else scene).find()


def found_scene(scene: Scene, path: FoundPath) -> Scene:
    """The scene with the found paths, which runs without the search."""
    lines = [[list(point) for point in line] for line in path.lines]
    return scene.without_search(lines[0] if len(lines) == 1 else lines)


@dataclass
class Search:
    """A search.

    Attributes
    ----------
    scene : Scene
    body, starts : the body, and the cracks before they grow
    trials : what was run
    unseen : tips of which criterion "symmetry" saw no sliding, so that they followed the stress
    """

    scene: Scene
    trials: list[PathTrial] = field(default_factory=list)
    unseen: list[Point] = field(default_factory=list)

    def __post_init__(self) -> None:
        assert self.scene.grow is not None and self.scene.sizes is not None
        self.options, size = self.scene.grow, self.scene.sizes.crack_size
        self.body = Body.from_outline(self.scene.specimen.outline())  # type: ignore[attr-defined]
        self.starts, m = self._starts(), self.scene.material
        ways = [self.body.first_hit(crack.tip, unit(crack.heading)) for crack in self.starts]
        ligament = min((hit.distance for hit in ways if hit is not None), default=self.body.size)
        radius = min(_OF_LENGTH * m.E * m.Gf / m.ft**2, _OF_LIGAMENT * ligament)
        self.radius = self.options.radius or max(radius, _ELEMENTS * size)
        self.segment = self.options.segment or max(_SEGMENT * self.radius, _ELEMENTS * size)

    def _starts(self) -> list[Crack]:
        """The cracks before they grow."""
        given = [(tuple(entry["at"]), entry["direction"]) for entry in self.options.starts]
        for i, (at, _) in enumerate(given):
            lines = [*([*face, face[0]] for face in self.body.faces), *self.body.slits]
            if not any(self.body.is_on(at, line) for line in lines):
                key = f"grow.starts.{i}.at"
                raise SceneError.at(key, f" = {list(at)}: expected a point of a face or of a notch")
        starts = [*self.scene.specimen.starts, *given] or [onset(self.scene, self.body)]
        return [Crack(((float(x), float(y)),), (math.atan2(dy, dx),)) for (x, y), (dx, dy) in starts]

    def find(self) -> FoundPath:
        """Grow all cracks, then judge them."""
        clock = time.perf_counter()
        if self.scene.specimen.symmetry() is not None and not self.options.starts:
            lines = list(self.scene.specimen.paths)
            return self._found(lines, [], ["path: straight, the specimen is symmetric about it"], clock)
        cracks = self._grow(list(self.starts))
        cracks, last, passes, moved = self._judge(cracks)
        vertices = _vertices(cracks, last)
        return self._found([list(c.points) for c in cracks], vertices, self._notes(cracks, vertices, passes, moved), clock)

    def _grow(self, cracks: list[Crack]) -> list[Crack]:
        """Segment by segment, until each crack has met something."""
        before: float | None = None
        for _ in range(_MOST_SEGMENTS):
            for i, crack in enumerate(cracks):
                if not crack.end and len(crack.points) > 1 and self._is_last(crack.tip, crack.heading):
                    cracks[i] = crack.with_fixed_direction(_LAST, self.segment, self.body, other_lines(cracks, i))
            growing = [i for i, crack in enumerate(cracks) if not crack.end]
            if not growing:
                return cracks
            trial = self._try(trial_lines(cracks, self.body), [(cracks[i].tip, cracks[i].heading) for i in growing], before)
            if not any(trial.critical):
                return self._stopped(cracks, growing, trial)
            for i, probe, critical in zip(growing, trial.probes, trial.critical, strict=True):
                if critical is None:
                    continue
                before, others = critical.control, other_lines(cracks, i)
                turn, stress = probe.strongest(critical.reading, LARGEST_TURN)
                if probe.is_clear(critical.reading, turn, stress):
                    if self.options.criterion == "symmetry":
                        turn = self._without_sliding(cracks, i, turn, before)
                    cracks[i] = self._grown(cracks[i], cracks[i].heading + turn, others)
                else:
                    cracks[i] = cracks[i].with_fixed_direction(_UNCLEAR, self.segment, self.body, others)
        says = f" = {self.segment:g}: {_MOST_SEGMENTS} segments meet no face; expected longer ones"
        raise SceneError.at("grow.segment", says)

    def _is_last(self, tip: Point, heading: float) -> bool:
        """Whether a crack is so near to the face ahead that it goes on straight."""
        return self._way(tip, heading) < _SLIVER * self.segment

    def _way(self, tip: Point, heading: float) -> float:
        """How far it is to the stretch before a face on which a crack goes on straight, mm; infinite without a face."""
        hit = self.body.first_hit(tip, unit(heading))
        return math.inf if hit is None or hit.what != FACE else hit.distance - _LAST_RADII * self.radius

    def _grown(self, crack: Crack, heading: float, others: Sequence[Line]) -> Crack:
        """A crack with one more segment, which ends where the last stretch begins if it would come near."""
        way = self._way(crack.tip, heading)
        segment = way if _SLIVER * self.segment < way < _LONGEST * self.segment else self.segment
        return crack.grown(heading, segment, self.body, others)

    def _without_sliding(self, cracks: list[Crack], i: int, turn: float, before: float) -> float:
        """The turn, radians, with which a crack does not slide at the tip of its next segment: by two trials, the first with
        the turn that the stress tells, and the line through them."""
        turns = turn, turn - math.copysign(_PROBING, turn)
        slides = [self.slide(cracks, i, each, before) for each in turns]
        slope = (slides[1] - slides[0]) / (turns[1] - turns[0])
        if not math.isfinite(slope) or slope == 0.0:
            self.unseen.append(cracks[i].tip)
            return turn
        return float(np.clip(turn - slides[0] / slope, turn - 2 * _PROBING, turn + 2 * _PROBING))

    def slide(self, cracks: list[Crack], i: int, turn: float, before: float | None = None) -> float:
        """Sliding over opening behind the tip of the next segment of a crack, with a turn (radians); `before` as of
        `run_trial`."""
        tried = list(cracks)
        tried[i] = cracks[i].grown(cracks[i].heading + turn, self.segment, self.body, other_lines(cracks, i))
        (critical,) = self._try(trial_lines(tried, self.body), [(tried[i].tip, tried[i].heading)], before).critical
        return math.nan if critical is None else critical.slide

    def _stopped(self, cracks: list[Crack], growing: Sequence[int], trial: PathTrial) -> list[Crack]:
        """All cracks with fixed directions, for no tip is critical any more."""
        if all(len(crack.points) == 1 for crack in cracks):
            why = trial.ended or "the stress ahead stays below the strength"
            raise SceneError.at("specimen.crack", f" = 'grow': no crack starts before the last stage ends, {why}")
        for i in growing:
            cracks[i] = cracks[i].with_fixed_direction("the run ends first", self.segment, self.body, other_lines(cracks, i))
        return cracks

    def _try(
        self, lines: list[Line], tips: list[tuple[Point, float]], before: float | None = None, whole: bool = False
    ) -> PathTrial:
        trial = run_trial(self.scene, lines, tips, self.radius, LARGEST_TURN, not whole, before)
        self.trials.append(trial)
        return trial

    def _judge(self, cracks: list[Crack]) -> tuple[list[Crack], PathTrial, int, float]:
        """Passes over the whole path, until one moves it by little: the cracks, the last pass, their number, and by how much
        it would move the path, mm."""
        part, before = _RELAXATION, math.inf
        for number in count(1):
            tips = [tip for crack in cracks for tip in zip(crack.points[:-1], crack.headings[:-1], strict=True)]
            trial = self._try([list(crack.points) for crack in cracks], tips, whole=True)
            if self.options.criterion == "symmetry":  # its directions were tried one by one
                return cracks, trial, number, 0.0
            judged = self._redirected(cracks, trial, _RELAXATION)
            moved = max(_movement(new, old) for new, old in zip(judged, cracks, strict=True))
            if moved < _SETTLED * self.segment or number == _MOST_PASSES:
                return cracks, trial, number, moved
            part = 0.5 * part if moved > _DAMPED * before else part  # it oscillates: halfway between
            before = moved
            cracks = judged if part == _RELAXATION else self._redirected(cracks, trial, part)
        raise AssertionError  # counting does not end

    def _redirected(self, cracks: list[Crack], trial: PathTrial, part: float) -> list[Crack]:
        """The cracks whose directions change by a part of what a run along the whole of them tells. Those that end at another
        one come last."""
        verdicts = iter(zip(trial.probes, trial.critical, strict=True))
        headings: list[list[float | None]] = []
        for crack in cracks:
            headings.append([])
            for _ in crack.points[:-1]:
                probe, critical = next(verdicts)
                turn, stress = (0.0, 0.0) if critical is None else probe.strongest(critical.reading, LARGEST_TURN)
                is_clear = critical is not None and probe.is_clear(critical.reading, turn, stress)
                is_clear &= not headings[-1] or not self._is_last(probe.tip, probe.heading)
                old = crack.headings[len(headings[-1]) + 1]
                headings[-1].append(old + part * (probe.heading + turn - old) if is_clear else None)
        regrown: dict[int, Crack] = {}
        for i in sorted(range(len(cracks)), key=lambda i: cracks[i].end == "another crack"):
            others: list[Line] = [list(other.points) for other in regrown.values()]
            regrown[i] = self._regrown(cracks[i], headings[i], others)
        return [regrown[i] for i in range(len(cracks))]

    def _regrown(self, crack: Crack, headings: Sequence[float | None], others: list[Line]) -> Crack:
        """A crack from its start with other headings; one that is None stays as it was, the last keep their directions."""
        new = Crack(crack.points[:1], crack.headings[:1])
        known = [i for i, heading in enumerate(headings) if heading is not None]
        for i in count():
            if i > max(known, default=-1):
                why = _LAST if self._is_last(new.tip, new.heading) else crack.why or _UNCLEAR
                return new.with_fixed_direction(why, self.segment, self.body, others)
            heading = headings[i]
            new = self._grown(new, crack.headings[i + 1] if heading is None else heading, others)
            if new.end:
                return new
        raise AssertionError  # counting does not end

    def _notes(self, cracks: Sequence[Crack], vertices: Sequence[Vertex], passes: int, moved: float) -> list[str]:
        """What was found, in words."""
        notes = []
        if not self.scene.specimen.starts and not self.options.starts:
            notes.append("path: nothing is notched; it starts where the faces of the elastic body are pulled most")
        for number, crack in enumerate(cracks, start=1):
            name = f"path {number}" if len(cracks) > 1 else "path"
            text = f"{name}: {len(crack.points) - 1} segments of {self.segment:.3g} mm from {as_text(crack.points[0])}"
            text += f" to {crack.end} at {as_text(np.round(crack.tip, 3))}"
            if crack.fixed_from is not None:
                text += f", straight from {as_text(np.round(crack.points[crack.fixed_from], 2))} on: {crack.why}"
            notes.append(text)
        closing = self.trials[-1].closing()
        notes += [f"path {i + 1}: this one closes from an opening of {at:.3g} mm on" for i, at in closing.items()]
        critical = [v for v in vertices if not v.fixed_direction and not math.isnan(v.criterion)]
        apart = np.array([abs(_difference(v.criterion, v.principal)) for v in critical])
        if len(apart):
            notes.append(
                f"path: criterion and principal stresses of the run disagree by {apart.mean():.1f} degrees in the mean, "
                f"{apart.max():.1f} at most"
            )
        early = np.array([abs(_difference(v.criterion, v.at_peak)) for v in critical if not math.isnan(v.at_peak)])
        if len(early):
            notes.append(f"path: the stresses at the peak tell directions that differ by up to {early.max():.1f} degrees")
        if self.unseen:
            where = ", ".join(as_text(np.round(tip, 2)) for tip in self.unseen)
            notes.append(f"warning: the path follows the stress at {where}, for no trial opens ahead of it")
        if moved >= _SETTLED * self.segment:
            ends = [
                f"{' and '.join(as_text(np.round(line[-1], 2)) for line in trial.lines)} with a peak of {trial.peak:.5g} N"
                for trial in [trial for trial in self.trials if trial.is_whole][-2:]
            ]
            notes.append(
                f"warning: after {passes} passes the path still moves by {moved:.2g} mm; the last two end at "
                + ", at ".join(ends)
            )
        return notes

    def _found(self, lines: list[Line], vertices: list[Vertex], notes: list[str], clock: float) -> FoundPath:
        seconds = time.perf_counter() - clock
        passes = sum(trial.is_whole for trial in self.trials)
        if self.trials:
            parts = {name: sum(trial.timings[name] for trial in self.trials) for name in self.trials[0].timings}
            parts["stepping"] = seconds - sum(parts.values())
            told = ", ".join(f"{100 * part / seconds:.0f} % {name}" for name, part in parts.items())
            notes = [*notes, f"path: {len(self.trials) - passes} trials and {passes} passes in {seconds:.2g} s: {told}"]
        return FoundPath(
            lines,
            [trial.lines for trial in self.trials],
            vertices,
            list(self.body.faces),
            list(self.body.slits),
            notes,
            seconds,
        )


def _movement(new: Crack, old: Crack) -> float:
    """By how much a path moves at most where its direction is not fixed, mm."""
    judged = new.points[: None if new.fixed_from is None else new.fixed_from + 1]
    return max(distance_to(point, [old.points]) for point in judged)


def _vertices(cracks: Sequence[Crack], trial: PathTrial) -> list[Vertex]:
    """The points of the paths as the last run saw them."""
    vertices = []
    readings = iter(zip(trial.probes, trial.critical, trial.at_peak, strict=True))
    for number, crack in enumerate(cracks, start=1):
        for i, (x, y) in enumerate(crack.points[:-1]):
            probe, critical, at_peak = next(readings)
            nan = math.nan
            criterion = principal = opening = load = nan
            if critical is not None:
                criterion = probe.heading + probe.strongest(critical.reading, LARGEST_TURN)[0]
                principal = probe.heading + probe.principal_turn(critical.reading)
                opening, load = critical.opening, critical.load
            turn, stress = probe.strongest(at_peak, LARGEST_TURN)
            early = probe.heading + turn if probe.is_clear(at_peak, turn, stress) else nan
            is_fixed = crack.fixed_from is not None and i >= crack.fixed_from
            path, *others = (math.degrees(angle) for angle in (crack.headings[i + 1], criterion, principal, early))
            vertices.append(Vertex(number, x, y, path, others[0], others[1], others[2], opening, load, is_fixed))
    return vertices


def _difference(a: float, b: float) -> float:
    """Of two directions of lines, degrees, within 90."""
    return (a - b + 90.0) % 180.0 - 90.0
