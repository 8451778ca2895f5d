"""Settings for an accuracy: from the trade of a scene if there is one, else from that of the nearest built-in scene."""

from __future__ import annotations

import math
from dataclasses import dataclass
from importlib import resources
from pathlib import Path

import numpy as np

from ..errors import SceneError
from ..model.estimate import Estimate, estimate
from ..scenes.scene import Scene
from .parameters import Changes, changes, distance, label, problem
from .trade import Trade
from .trials import SweepSetting

#: no setting is chosen that is expected to take longer, s, if another one does not
_LONGEST = 3600.0

_TABLES = resources.files("cohesive.studies") / "trades"


@dataclass(frozen=True)
class Choice:
    """Settings for an accuracy.

    Attributes
    ----------
    changes : keys of the scene, for `Scene.with_`
    promised : relative error that they promise; above the accuracy if no setting reaches it within an hour
    promised_place : relative error of the place of the peak that they promise
    seconds : CPU time that a run with them is expected to take, within a factor of 3
    text : where they come from, and their price
    """

    changes: Changes
    promised: float
    promised_place: float
    seconds: float
    text: str


def stored() -> dict[str, Trade]:
    """The trades of the built-in scenes by name, NAME or NAME-smeared.

    They are renewed by `cohesive trade NAME [--set model.kind=smeared]`, whose trade.csv becomes studies/trades/NAME.csv.
    """
    files = sorted((entry for entry in _TABLES.iterdir() if entry.name.endswith(".csv")), key=lambda entry: entry.name)
    return {entry.name[:-4]: Trade.load(Path(str(entry))) for entry in files}


def settings_for(scene: Scene, accuracy: float | str, table: str | Path | None = None) -> Choice:
    """The cheapest settings that promise an accuracy.

    From the user's own trade of the scene, or the stored one of a built-in scene, the settings are taken as they were
    measured. A scene without one borrows from the built-in scene of the same model that is nearest: of the same kind of
    specimen before others (in 3D of no other), of the same kind of loading before others, then nearest in crack length
    and E Gf / ft^2. `parameters.changes` says how settings are carried over, and `Trade.promise` what they promise there.

    Parameters
    ----------
    scene : Scene of a built-in specimen.
    accuracy : above 0 and below 1, or a text like "1%".
    table : trade.csv of the user's; if it is of another problem, the text says so and it is left aside.

    Raises
    ------
    SceneError
        For another accuracy, a user mesh, a model of which there is no trade, or a table that cannot be read.

    Examples
    --------
    >>> from cohesive import Scene, settings_for
    >>> choice = settings_for(Scene.load("notched-beam"), "5%")
    >>> choice.promised <= 0.05
    True
    """
    wanted = parse(accuracy)
    if scene.sizes is None:
        raise SceneError(
            "accuracy: a user mesh has no sizes to choose, and they matter most; expected a built-in specimen, or "
            "`cohesive run` with files of two sizes, whose difference tells the error of the mesh"
        )
    said = ""
    own = {str(table): Trade.load(table)} if table is not None and Path(table).is_file() else {}
    for name, trade in own.items():
        there, here = problem(trade.scene), problem(scene)
        if differing := [part for part in here if here[part] != there[part]]:
            said = f"{name} is of another version of this scene (other {', '.join(differing)}) and left aside; "
    tables = stored()
    for name, trade in [*own.items(), *tables.items()]:
        if problem(trade.scene) == problem(scene):
            return _choice(scene, wanted, trade, f"{said}measured on this scene, {_source(name)}", elsewhere=False)
    alike = [name for name in tables if _kind(tables[name].scene) == _kind(scene)]
    if not alike:
        raise SceneError(f"accuracy: no stored trade is of a {', '.join(_kind(scene))} model; `cohesive trade` measures one")

    def farness(name: str) -> tuple[bool, bool, float]:
        like = tables[name].scene
        return scene.kind != like.kind, _turns(scene) != _turns(like), distance(scene, like)

    name = min(alike, key=farness)
    where = f"{said}carried over from {_source(name)}, not measured on this scene: `cohesive trade` would"
    return _choice(scene, wanted, tables[name], where, elsewhere=True)


def parse(accuracy: float | str) -> float:
    """A fraction above 0 and below 1, or a percentage, as a number; SceneError for anything else."""
    text = str(accuracy).strip()
    try:
        value = float(text.removesuffix("%")) / (100.0 if text.endswith("%") else 1.0)
    except ValueError:
        value = math.nan
    if not 0.0 < value < 1.0:
        raise SceneError(f"accuracy {accuracy}: expected a percentage or a part of 1, above 0 and below 100 %, as 1% or 0.01")
    return value


def _choice(scene: Scene, wanted: float, trade: Trade, where: str, elsewhere: bool) -> Choice:
    """The settings of a trade that promise an accuracy; `where` says where the trade is from."""
    prices = [(each, _price(scene, each, trade.scene)) for each in trade.trials if each.is_same_problem and each.cost]
    affordable = [each for each, price in prices if price.seconds <= _LONGEST] or [min(prices, key=lambda e: e[1].seconds)[0]]
    best, missed = trade.cheapest(wanted, elsewhere, affordable), ""
    if best is None:
        best = min(affordable, key=lambda trial: trade.promise(trial, elsewhere))
        missed = "no setting reaches it, the most accurate one is taken: "
        if (longer := trade.cheapest(wanted, elsewhere, [each for each, _ in prices])) is not None:
            time = _price(scene, longer, trade.scene).time
            missed = f"{label(longer.settings)} would take {time}, the most accurate one within an hour is taken: "
    changed = changes(scene, best.settings, trade.scene)
    price = _price(scene, best, trade.scene)
    keys = ", ".join(
        f"{key} = {value:.4g}" if isinstance(value, float) else f"{key} = {value}" for key, value in changed.items()
    )
    promised, place = trade.promise(best, elsewhere), trade.promised_place(best, elsewhere)
    text = (
        f"accuracy {100 * wanted:.3g} %: {missed}{label(best.settings)}, which promises {100 * promised:.2g} % ({where}): "
        f"{keys or 'nothing changes'}; the place of the peak to {100 * place:.2g} %; it takes about {price.time}"
    )
    return Choice(changed, promised, place, price.seconds, text)


def _price(scene: Scene, trial: SweepSetting, like: Scene) -> Estimate:
    """What a scene takes with the settings of a trial that was measured on another one."""
    expected = estimate(scene.with_(**changes(scene, trial.settings, like)))
    assert expected is not None  # a scene with sizes
    return expected


def _source(name: str) -> str:
    """A table in words."""
    return name if name.endswith(".csv") else f"the stored trade of {name}"


def _kind(scene: Scene) -> tuple[str, ...]:
    """What scenes have in common that borrow from one another: the model, and in 3D the specimen, because settings of
    another one may cost hours there."""
    model = ("discrete",) if scene.model.kind == "discrete" else ("smeared", scene.band.where)
    return (f"{scene.kind} in 3D", *model) if scene.is_solid else model


def _turns(scene: Scene) -> bool:
    """Whether the loading turns back."""
    return any(stage.unload is not None or any(np.diff(stage.targets) < 0) for stage in scene.stages)
