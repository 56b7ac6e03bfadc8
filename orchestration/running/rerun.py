"""A run again, from its manifest: built, run, and compared with what is beside the manifest."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from math import inf
from pathlib import Path
from typing import Any

from fmus.errors import AdcsError, shown
from fmus.nearby import instead
from orchestration import expected
from orchestration.fmu.file import is_path, locate, open_fmu
from orchestration.process.temporary import temporary_folder
from orchestration.results.comparison import NAMES, deviation
from orchestration.results.manifest import FORMAT
from orchestration.results.result import Result, RunFailed
from orchestration.running.driver import Progress
from orchestration.running.hooks.changes import Changes
from orchestration.running.hooks.saves import Saves
from orchestration.running.parts import parts
from orchestration.running.run import run
from orchestration.system import System


@dataclass(frozen=True)
class Rerun:
    """What came of running a manifest again."""

    result: Result
    differences: tuple[str, ...]
    """What is not as it was: FMUs, files, versions, how it ended."""
    compared: Path | None
    """The file beside the manifest with which the result was compared."""
    deviation: str | None
    """Where the result differs from that first."""

    @property
    def same(self) -> bool | None:
        """Whether the result is the same to the last bit; None if there is nothing to compare it with."""
        return None if self.compared is None else self.deviation is None


_NEEDED = {"system", "settings"}


def rerun(
    manifest: str | Path | Mapping[str, Any],
    *,
    timeout: float = inf,
    progress: Progress | None = None,
    isolated: bool = False,
) -> Rerun:
    """Repeat a run from its manifest: `manifest.json`, the folder it is in, or `result.manifest`.

    The FMUs are those of the manifest, by name or path, or files of the same names beside it. What ground tools
    commanded is set at the same points; pace and checkpoints are left out. What is not as it was is named, and the
    result is compared with the file beside the manifest, bit by bit. `timeout`, `progress` and `isolated` are those of
    `run`. Raises AdcsError if it cannot be repeated at all.
    """
    if isinstance(manifest, Result):
        raise AdcsError("manifest: give result.manifest of this result, or the manifest.json of a run")
    beside, old = (None, manifest) if isinstance(manifest, Mapping) else _read(manifest)
    if not old.keys() >= _NEEDED:
        raise AdcsError("manifest: this dict is not that of a run: give result.manifest, or the manifest.json of one")
    try:
        _refuse(old)
        changed = list(_changed_fmus(old, beside))
        with temporary_folder("rerun") as folder:
            settings, left_out = _settings(old, beside, folder)
            try:
                settings["method"] = replace(settings["method"], timeout=timeout)
                result = run(_system(old, beside), **settings, progress=progress, isolated=isolated)
            except RunFailed as error:
                result = error.result
            except AdcsError as error:
                raise AdcsError("; ".join([str(error), *changed])) from error
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise AdcsError(f"the manifest is not as a run writes it ({error!r})") from error
    written = result.select(old["written"]) if "written" in old else result
    file = None if beside is None else next((beside / name for name in NAMES if (beside / name).is_file()), None)
    differences = (*changed, *left_out, *_differences(old, result.manifest))
    stopped = old.get("outcome", {}).get("status") == "interrupted"
    return Rerun(written, differences, file, None if file is None else deviation(written, file, may_go_on=stopped))


def _read(given: str | Path) -> tuple[Path, Mapping[str, Any]]:
    """Return the folder of a manifest, and what it says."""
    expected.path("manifest", given)
    path = Path(given) / "manifest.json" if Path(given).is_dir() else Path(given)
    try:
        manifest = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        why = f"{error.strerror}{instead(path)}"
        raise AdcsError(f"{path}: {why}: give the manifest.json of a run, or its folder") from error
    except ValueError as error:
        raise AdcsError(f"{path} is no manifest: give the manifest.json of a run, or its folder") from error
    if not isinstance(manifest, dict) or not manifest.keys() >= _NEEDED:
        raise AdcsError(f"{path} is not the manifest of a run: give the manifest.json of one, or its folder")
    return path.absolute().parent, manifest


def _refuse(old: Mapping[str, Any]) -> None:
    """Refuse what the manifest does not hold enough of."""
    if old.get("format", FORMAT) != FORMAT:
        raise AdcsError(
            f"the manifest is of the format {shown(str(old['format']))}, and {FORMAT} is what can be run again"
        )
    if "hil" in old["settings"]:
        raise AdcsError(
            "an autopilot flew this run, and what it answered is in no manifest: fly it again by `adcs hil`"
        )
    if missing := old.get("mavlink", {}).get("commands_not_kept"):
        raise AdcsError(f"ground tools commanded more than the manifest kept, {missing} commands are not in it")


def _settings(old: Mapping[str, Any], beside: Path | None, folder: Path) -> tuple[dict[str, Any], list[str]]:
    """Return what `run` is asked for, and what has to be left out."""
    files = {name: _found(Path(file["path"]), beside, name) for name, file in old.get("files", {}).items()}
    settings = dict(old["settings"])
    if "resume" in files:
        settings["resume"] = files.pop("resume")
    if files:
        settings["inputs"] = list(files.values())
    asked, unknown = parts(settings)
    commands = [command[:3] for command in old.get("commands", ())]
    if commands:
        asked["hooks"].append(Changes(commands))
    if "checkpoint" in old:
        asked["hooks"].append(Saves(folder / "checkpoint.npz"))
    left_out = [f"{name} = {shown(repr(value))} is left out" for name, value in unknown.items()]
    watchers = old.get("watchers", ())
    if len(watchers) > any(name in old for name in ("commands", "mavlink", "tlog")):  # ground tools are one of them
        left_out.append(f"{', '.join(watchers)} took part in the run, and what that did is not in the manifest")
    return asked, left_out


def _found(path: Path, beside: Path | None, what: str) -> Path:
    """Return the path of a file, or of one by this name beside the manifest."""
    for place in (path, *([] if beside is None else [beside / path.name])):
        if place.is_file():
            return place
    raise AdcsError(f"{what}: {path} is not there: put it back, or a file of this name beside the manifest")


def _source(name: str, component: Mapping[str, Any], beside: Path | None) -> str | Path:
    source = Path(component["fmu"])
    return _found(source, beside, f"component {name}") if is_path(source) else str(source)


def _system(old: Mapping[str, Any], beside: Path | None) -> System:
    described = old["system"]
    system = System(described["name"], described["description"])
    for name, component in described["components"].items():
        system.add(name, _source(name, component, beside), component["start"], component.get("every", 1))
    for source, target, *unusual in described["connections"]:
        how = dict(*unusual)
        given = how.pop("given", False) and not how.get("mapping")
        scale = {name: how.pop(name, usual) for name, usual in (("factor", 1.0), ("offset", 0.0))}
        system.connect(
            source, target, **(scale if given else {}), **how
        )  # units give it, as they did, where it was not
    return system


def _changed_fmus(old: Mapping[str, Any], beside: Path | None) -> Iterator[str]:
    version = old["settings"]["fmi_version"]
    for name, component in old["system"]["components"].items():
        found = open_fmu(locate(_source(name, component, beside), version))
        if found.sha256 != component["sha256"]:
            sums = f"sha256 {found.sha256[:12]} instead of {component['sha256'][:12]}"
            yield f"component {name}: {found.path.name} is another file than was run, {sums}"


_NEW_EVERY_TIME = ("fmu", "sha256")  # of a component; the second has been said
_OF_THE_RUN = ("inputs", "resume", "real_time", "changes", "record")


def _differences(old: Mapping[str, Any], new: Mapping[str, Any]) -> Iterator[str]:
    """Say what the two manifests have that is not the same, and should be."""
    new = json.loads(json.dumps(new))
    for name, file in old.get("files", {}).items():
        if file["sha256"] != new["files"][name]["sha256"]:
            yield f"{name}: {new['files'][name]['path']} is not as it was"
    for name, component in old["system"]["components"].items():
        yield from _each(f"component {name}: ", component, new["system"]["components"][name], _NEW_EVERY_TIME)
    for was, is_ in zip(old["system"]["connections"], new["system"]["connections"], strict=True):
        if was != is_:
            yield f"the connection to {was[1]} was {shown(repr(was))} and is {shown(repr(is_))}"
    yield from _each("", old["settings"], {**old["settings"], **new["settings"]}, _OF_THE_RUN)
    yield from _each("", old.get("versions", {}), new["versions"])
    yield from _each("outcome: ", old.get("outcome", {}), new["outcome"], ("rows", "pid"))


def _each(where: str, was: Mapping[str, Any], is_: Mapping[str, Any], besides: tuple[str, ...] = ()) -> Iterator[str]:
    for name in dict.fromkeys([*was, *is_]):
        if name not in besides and was.get(name) != is_.get(name):
            yield f"{where}{name} was {shown(repr(was.get(name)))} and is {shown(repr(is_.get(name)))}"
