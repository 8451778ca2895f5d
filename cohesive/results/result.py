"""What a run leaves behind: history, fields, summary and files."""

from __future__ import annotations

import copy
import json
import platform
import shutil
import time
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import meshio
import numpy as np

from ..arrays import Array
from ..elements.rotations import PAIRS, major_stress
from ..scenes.reference import Reference
from ..scenes.scene import Scene, dump_toml
from ..solver.problem import Problem, State
from .columns import COLUMNS
from .files import format_value, make_folder, package_version, write_file, write_text
from .frames import Frame

if TYPE_CHECKING:
    from ..model.build import Model


class Result:
    """The outcome of a run.

    Attributes
    ----------
    scene : Scene
    model : Model, with mesh and integration points
    history : dict of 1-D arrays, one row for each converged step
    notes : list of remarks on how the stages ended
    reference : Reference or None
    timings : seconds: mesh, assemble, condense, newton and, after `save`, output
    """

    def __init__(
        self,
        scene: Scene,
        model: Model,
        rows: list[dict[str, float]],
        states: list[State],
        notes: list[str],
        reference: Reference | None,
    ) -> None:
        self.scene, self.model, self.notes, self.reference = scene, model, notes, reference
        self.history: dict[str, Array] = {name: np.array([row[name] for row in rows]) for name in COLUMNS}
        self.timings = model.timings | {"output": 0.0}
        self._states = states

    @property
    def peak_load(self) -> float:
        """Largest load, N (negative where all loads are)."""
        return float(self.history["load"][self._peak]) if len(self._states) else 0.0

    @property
    def opening_at_peak(self) -> float:
        """Opening at the largest load, mm."""
        return float(self.history["opening"][self._peak]) if len(self._states) else 0.0

    @property
    def dissipated_energy(self) -> float:
        """Damage dissipation at the end, N mm."""
        return float(self.history["dissipated"][-1]) if len(self._states) else 0.0

    @property
    def iterations(self) -> int:
        """Newton iterations in all converged steps."""
        return int(self.history["iterations"].sum())

    @property
    def solution_time(self) -> float:
        """Seconds from the scene to the last step, without files."""
        return sum(seconds for name, seconds in self.timings.items() if name != "output")

    @property
    def active_dofs(self) -> int:
        """Unknowns that Newton's method works on."""
        return self.model.active_dofs

    @property
    def total_dofs(self) -> int:
        """Unknowns of the whole body."""
        return self.model.total_dofs

    @property
    def _peak(self) -> int:
        return int(self.history["load"].argmax())

    @property
    def problem(self) -> Problem:
        """The equations that were solved."""
        return self.model.problem

    @property
    def drives_both_ways(self) -> bool:
        """Whether a platen moves along two directions, so that the load is not always that of the opening."""
        return len(self.problem.drives) == 2

    @property
    def platen_path(self) -> Array:
        """Length of the way that the drives have gone, (rows,), mm."""
        places = np.array([state.v[self.problem.drives] for state in self._states]).reshape(len(self._states), -1)
        return np.cumsum(np.linalg.norm(np.diff(places, axis=0, prepend=0.0), axis=1))

    @property
    def last(self) -> State:
        """The state at the last row."""
        return self._states[-1]

    @property
    def full_energy(self) -> float | None:
        """(Gf + ft^2 w / 2E) times the crack area, N mm: the dissipation of mode I separation. In a band w is l_ch.
        None where the area is not known: a crack anywhere in a mesh of the user's."""
        material, cracks = self.scene.material, self.model.cracks
        if cracks.area is None:
            return None
        return (material.Gf + material.ft**2 * cracks.width / (2 * material.E)) * cracks.area

    @property
    def energy_error(self) -> float:
        """Largest difference between external work and energies, each integrated on its own, over the largest work."""
        h = self.history
        if not len(self._states):
            return 0.0
        error = h["work"] - h["elastic"] - h["stored"] - h["dissipated"] - h["contact_work"]
        return float(abs(error).max() / max(abs(h["work"]).max(), 1e-300))

    def added_compliance(self) -> float:
        """What the interface's width adds to the elastic compliance of opening under load, as a part of it.

        With the mean jump as gauge, which has no elastic part, the driven motion stands for the opening. A band
        adds none: its elements are part of the body.
        """
        if self.model.is_smeared:
            return 0.0
        problem = self.problem
        # 1e6 times stiffer: a crack plane without width
        with_width, without = (problem.response(factor * problem.point_law.elastic()) for factor in (1.0, 1e6))
        if self.gauge_is_elastic:
            row = problem.measures["opening"]
            return float(row @ with_width) / float(row @ without) - 1.0
        return float(problem.drive @ with_width) / float(problem.drive @ without) - 1.0

    @property
    def gauge_is_elastic(self) -> bool:
        """Whether the opening is measured over a length of the body, not as the mean jump."""
        return getattr(self.scene.specimen, "gauge", 0.0) > 0 or getattr(self.scene.specimen, "gauge_plus", None) is not None

    def frame(self, row: int) -> Frame:
        """Fields of a row of the history (0 is the first), recovered from the unknowns."""
        state, model = self._states[row], self.model
        displacement = model.condensation.recover(state.v)
        stress = [block.stress(displacement) for block in model.blocks]
        stress += model.cracks.cell_stresses(state, [len(block.cells) for block in model.band])
        return Frame(int(self.history["step"][row]), displacement, stress, model.cracks.cell_values(state))

    def opening_profile(self, row: int) -> tuple[Array, Array]:
        """Positions (p, d) and openings (p,) of the points with cracks in a row of the history, mm; of a band l_ch
        times the fracture strain."""
        values = self.model.cracks.point_values(self._states[row])
        return self.model.cracks.where, values["opening"]

    def frame_rows(self) -> list[int]:
        """Rows that are written as frames: evenly spread, the peak and the last one."""
        n, wanted = len(self._states), self.scene.output.frames
        if not n or not wanted:
            return []
        return sorted({*np.linspace(0, n - 1, wanted + 1).round().astype(int)[1:].tolist(), self._peak})

    def frame_mesh(self, frame: Frame) -> meshio.Mesh:
        """Bulk and crack cells with the fields of a frame; warp by `displacement` to see the crack open."""
        mesh, n = self.model.mesh, sum(len(block.cells) for block in self.model.blocks)
        m, d = mesh.points.shape
        points, displacement = (np.column_stack([x, np.zeros((m, 3 - d))]) for x in (mesh.points, frame.displacement))
        total = sum(len(block.data) for block in mesh.cells)
        # cells that a field does not belong to carry 0: NaN would break readers of the ASCII format
        flat = {name: np.r_[np.zeros(n), values] for name, values in frame.cracks.items()}
        flat["is_crack"] = np.r_[np.zeros(n), np.ones(total - n)]
        stress = np.concatenate(frame.stress)
        stress = np.concatenate([stress, np.zeros((total - len(stress), stress.shape[1]))])
        flat |= {f"stress_{'xyz'[i]}{'xyz'[j]}": stress[:, k] for k, (i, j) in enumerate(PAIRS[d])}
        flat["stress_max"] = major_stress(stress)
        ends = np.cumsum([len(block.data) for block in mesh.cells])[:-1]
        data = {name: np.split(values, ends) for name, values in flat.items()}
        return meshio.Mesh(points, [(b.type, b.data) for b in mesh.cells], {"displacement": displacement}, data)

    def summary(self) -> str:
        """The printed summary."""
        from .report import summary

        return summary(self)

    def save(self, folder: str | Path) -> None:
        """Write history.csv, curve.png, deformed.png, frames as VTU with one PVD, scene.toml and run.json.

        Each file is written under a temporary name and then renamed.

        Raises
        ------
        SceneError
            If the folder cannot be written.
        """
        from . import figures as plots

        clock = time.perf_counter()
        folder = Path(folder)
        make_folder(folder)
        write_file(folder / "history.csv", self._write_history)
        self._write_scene(folder)
        if len(self._states):
            write_file(folder / "curve.png", lambda path: plots.save_curve(self, path))
            write_file(folder / "deformed.png", lambda path: plots.save_deformed(self, path))
        pictures = () if len(self._states) else ("curve.png", "deformed.png")
        for old in (*folder.glob("frame_*.vtu"), folder / "frames.pvd", *(folder / name for name in pictures)):
            old.unlink(missing_ok=True)  # of an earlier run into the same folder
        collection = []
        for row in self.frame_rows():
            frame = self.frame(row)
            name = f"frame_{frame.step:04d}.vtu"
            mesh = self.frame_mesh(frame)
            # compressing takes ten times as long as writing, for a third of the size
            write_file(folder / name, partial(meshio.write, mesh=mesh, compression=None))
            collection.append(f'    <DataSet timestep="{frame.step}" part="0" file="{name}"/>')
        if collection:
            pvd = '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1">\n  <Collection>\n'
            pvd += "\n".join(collection) + "\n  </Collection>\n</VTKFile>\n"
            write_file(folder / "frames.pvd", lambda path: write_text(path, pvd))
        self.timings["output"] = time.perf_counter() - clock
        write_file(folder / "run.json", lambda path: write_text(path, json.dumps(self._facts(), indent=2) + "\n"))

    def _write_scene(self, folder: Path) -> None:
        """scene.toml, with the files that it names beside it, so that it runs from there."""
        data = copy.deepcopy(self.scene.data)
        for table in ("reference", "specimen"):
            name = data.get(table, {}).get("file")
            if name is not None:
                source = self.scene.file(name)
                data[table]["file"] = source.name
                if source.resolve() != (folder / source.name).resolve():
                    write_file(folder / source.name, partial(shutil.copyfile, source))
        write_file(folder / "scene.toml", lambda path: write_text(path, dump_toml(data)))

    def _write_history(self, path: Path) -> None:
        rows = zip(*(self.history[name].tolist() for name in COLUMNS), strict=True)
        write_text(path, "".join(",".join(row) + "\n" for row in (COLUMNS, *(map(format_value, row) for row in rows))))

    def _facts(self) -> dict[str, Any]:
        packages = ("cohesive-cracks", "numpy", "scipy", "gmsh", "meshio", "matplotlib")
        return {
            "scene": self.scene.data,
            "notes": self.notes,
            "peak_load": self.peak_load,
            "opening_at_peak": self.opening_at_peak,
            "dissipated_energy": self.dissipated_energy,
            "full_energy": self.full_energy,
            "energy_error": self.energy_error,
            "model": self.scene.model.kind,
            "width": self.model.cracks.width,
            "reduction": self.model.condensation.kind,
            "library": self.model.library,
            "total_dofs": self.total_dofs,
            "active_dofs": self.active_dofs,
            "steps": len(self._states),
            "iterations": self.iterations,
            "timings": self.timings,
            "versions": {"python": platform.python_version()} | {name: package_version(name) for name in packages},
        }
