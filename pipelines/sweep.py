"""What a sweep file (pipelines/NAME.yaml) asks for, spelled out as single runs.

Nothing of the algorithms lives here: a run is a name and the command-line options that the file gives for it.
"""

import dataclasses
import os
import pathlib
import statistics

import yaml

ROOT = pathlib.Path(__file__).resolve().parent.parent


@dataclasses.dataclass(frozen=True)
class Run:
    """One picture: uniform sampling (no wavelet), or guided by an index."""

    dataset: str
    scene: str
    method: str
    quadrature: str
    step: str
    wavelet: str = ""
    epsilon: str = ""

    @property
    def name(self):
        parts = [self.method, self.wavelet, self.epsilon and f"e{self.epsilon}", self.quadrature, self.step]
        return "_".join(part for part in parts if part)

    @property
    def series(self):
        return "_".join(part for part in [self.method, self.wavelet] if part)

    @property
    def group(self):
        return f"{self.dataset}/{self.scene}"


def shortened(config):
    """The short form: the same file with the values under `short:` in place of the long ones."""
    return {**{key: value for key, value in config.items() if key != "short"}, **config.get("short", {})}


def with_datasets(config):
    """The same with its data sets spelled out: `datasets: NAME` are those of pipelines/NAME.yaml."""
    if not isinstance(config["datasets"], str):
        return config
    other = yaml.safe_load((ROOT / "pipelines" / f"{config['datasets']}.yaml").read_text())
    return {**config, "datasets": other["datasets"]}


def locate(entry):
    """Path of a volume of configs/data.yaml: absolute, or below $PRECIS_DATA; None where it is not at hand."""
    path = pathlib.Path(entry["file"])
    if not path.is_absolute():
        data = os.environ.get("PRECIS_DATA")
        if not data:
            return None
        path = pathlib.Path(data) / path
    return str(path) if path.exists() else None


def datasets_at_hand(config, volumes):
    """{name: (files it is made from, command)} of the data sets whose sources are there, and of those made from them."""
    found = {}
    chosen = config.get("only", list(config["datasets"]))
    for name, entry in config["datasets"].items():
        if name not in chosen and not any(name in config["datasets"][other].get("after", []) for other in chosen):
            continue
        files = {source: locate(volumes[source]) for source in entry.get("sources", [])}
        if all(files.values()) and all(before in found for before in entry.get("after", [])):
            found[name] = (files, entry["make"])
    return found


def runs(config, datasets):
    """Every run of the sweep over the data sets at hand, in a fixed order."""
    listed = []
    for dataset in datasets:
        if dataset not in config.get("only", list(config["datasets"])):
            continue
        for scene in config["datasets"][dataset]["scenes"]:
            if scene not in config.get("scenes", [scene]):
                continue
            for method, entry in config["methods"].items():
                for quadrature in entry["quadratures"]:
                    steps = entry["steps"]
                    for step in steps[quadrature] if isinstance(steps, dict) else steps:
                        if step not in config.get("steps", [step]):
                            continue
                        if not entry.get("index"):
                            listed.append(Run(dataset, scene, method, quadrature, step))
                            continue
                        for wavelet in config["wavelets"]:
                            for epsilon in config["epsilons"]:
                                listed.append(Run(dataset, scene, method, quadrature, step, wavelet, str(epsilon)))
    return listed


def groups(config, datasets):
    """DATASET/SCENE of every picture that has a truth, in the order of the file; behind them DATASET/SCENE@SIZE of `at_sizes`."""
    chosen = config.get("only", list(config["datasets"]))
    found = [f"{dataset}/{scene}" for dataset in datasets if dataset in chosen
             for scene in config["datasets"][dataset]["scenes"] if scene in config.get("scenes", [scene])]
    def asked(entry, dataset, scene):
        return dataset in entry.get("only", [dataset]) and scene in entry.get("scenes", [scene])
    return found + [f"{group}@{size}" for size, entry in config.get("at_sizes", {}).items() for group in found
                    if asked(entry, *group.split("/"))]


def of_group(config, group):
    """What is asked of a group: `config`, with what stands under its size in `at_sizes`, and that as `size`."""
    _, _, size = group.partition("@")
    return {**config, **config["at_sizes"][size], "size": size} if size else config


def volume(dataset, out):
    return f"{out}/volumes/{dataset}.nrrd"


def scene(group):
    return f"configs/scenes/{group.partition('@')[0].split('/')[1]}.yaml"


def raycast(run, config, out):
    """The command that renders a run, but for its output."""
    index = f" --index {out}/runs/{run.group}/{run.series}/{run.name}.nrrd" if run.wavelet else ""
    return (f"vol-raycast {volume(run.dataset, out)} --scene {scene(run.group)} --size {config['size']}"
            f" --quadrature {run.quadrature} --step {run.step}{index} {config['methods'][run.method].get('render', '')}")


def reference(group, config, out):
    """The command that renders a group's truth, but for its output."""
    return (f"vol-raycast {volume(group.split('/')[0], out)} --scene {scene(group)} --size {config['size']}"
            f" --quadrature reference --tolerance {config['tolerance']}")


def render_seconds(stats):
    """Median time of the rendering alone, of a stats record of vol-raycast: what is made once a volume is not in it."""
    return statistics.median(stats["time_s"]["phases"]["render"])
