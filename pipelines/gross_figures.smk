# Rules of the figures from wavelet coefficients (gross-figures.yaml).
import gross_figures

FIGURES = gross_figures.figures(SWEEP, DATASETS)
PICTURES_OF = {name: gross_figures.pictures(SWEEP, name) for name in FIGURES}
TRUTH_OF = {picture.name: picture.truth.name for pictures in PICTURES_OF.values() for picture in pictures}
ALL_PICTURES = sorted(TRUTH_OF)
SHEETS = [f"{RESULTS}/{gross_figures.file_name(name)}.png" for name in FIGURES]
ENDS += [f"{RESULTS}/table.csv", f"{RESULTS}/table.md", f"{RESULTS}/dropped.md", *([*SHEETS, f"{RESULTS}/figure-3.png"] if PICTURES else [])]
GROSS_CODE = ["pipelines/gross_figures.py", SETTINGS]

ruleorder: voxelised > dataset

rule voxelised:
    input: "pipelines/gross_figures.py", f"{BIN}/vol-phantom"
    output: f"{OUT}/volumes/{{dataset}}.nrrd"
    wildcard_constraints: dataset="blocks|bust"
    shell: "{PYTHON} -B pipelines/gross_figures.py {SETTINGS} volume {wildcards.dataset} --bin {BIN} -o {output}"

rule surface_truth:
    input:
        GROSS_CODE, [f"{BIN}/{tool}" for tool in ("vol-dwt", "isosurf-ray", "isosurf-mc", "vol-raycast")],
        lambda w: volume(gross_figures.dataset_of(w.picture))
    output: f"{OUT}/truth/{{picture}}.exr"
    wildcard_constraints: picture="[^/]+"
    threads: ALL_CORES
    shell: "{PYTHON} -B pipelines/gross_figures.py {SETTINGS} truth {wildcards.picture} --bin {BIN} -o {output}"

rule surface_picture:
    input:
        GROSS_CODE, [f"{BIN}/{tool}" for tool in ("vol-dwt", "isosurf-ray", "isosurf-mc", "vol-raycast", "vol-compare", "img-compare")],
        lambda w: f"{OUT}/truth/{TRUTH_OF[w.picture]}.exr",
        lambda w: volume(gross_figures.dataset_of(w.picture))
    output: json=f"{OUT}/pictures/{{picture}}.json", png=f"{OUT}/pictures/{{picture}}.png"
    wildcard_constraints: picture="[^/]+"
    threads: ALL_CORES
    shell: "{PYTHON} -B pipelines/gross_figures.py {SETTINGS} picture {wildcards.picture} --bin {BIN} -o {output.json}"

rule gross_table:
    input: GROSS_CODE, [f"{OUT}/pictures/{name}.json" for name in ALL_PICTURES]
    output: csv=f"{RESULTS}/table.csv", md=f"{RESULTS}/table.md"
    shell: "{PYTHON} -B pipelines/gross_figures.py {SETTINGS} table all --bin {BIN} -o {output.csv}"

rule gross_sheets:
    input: GROSS_CODE, [f"{OUT}/pictures/{name}.json" for name in ALL_PICTURES]
    output: SHEETS
    shell: "{PYTHON} -B pipelines/gross_figures.py {SETTINGS} sheets all --bin {BIN} -o {RESULTS}/sheets"

rule gross_dropped:
    input: "pipelines/gross_dropped.py", SETTINGS, [f"{BIN}/{tool}" for tool in ("vol-phantom", "vol-dwt", "wavelet-raycast", "img-compare")]
    output: f"{RESULTS}/dropped.md"
    threads: ALL_CORES
    shell: "{PYTHON} -B pipelines/gross_dropped.py {SETTINGS} --bin {BIN} -o {output}"

rule gross_basis:
    input: "pipelines/gross_basis.py", SETTINGS, [f"{BIN}/{tool}" for tool in ("vol-phantom", "vol-dwt", "wavelet-raycast")]
    output: f"{RESULTS}/figure-3.png"
    shell: "{PYTHON} -B pipelines/gross_basis.py {SETTINGS} --bin {BIN} -o {output}"
