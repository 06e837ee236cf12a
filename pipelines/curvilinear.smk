# Rules of the pictures of curvilinear grids (curvilinear.yaml).

_at_hand = yaml.safe_load(open("configs/data.yaml"))["grids"]
GRIDS = [name for name, grid in SWEEP["grids"].items() if "source" not in grid or sweep.locate(_at_hand[grid["source"]])]
ENDS += [f"{RESULTS}/table.csv", f"{RESULTS}/table.md", f"{RESULTS}/pictures.png"]

rule grid:
    input:
        "pipelines/curvilinear.py", [f"{BIN}/{tool}" for tool in ("vol-phantom", "curv-tricubic", "img-compare")]
    output: f"{OUT}/drawn/{{grid}}.json"
    params: asked=lambda w: [SWEEP["grids"][w.grid], *(SWEEP[k] for k in ("size", "rounds", "finest", "settings"))]
    threads: ALL_CORES
    shell: "{PYTHON} -B pipelines/curvilinear.py {SETTINGS} '{wildcards.grid}' --bin {BIN} -o {output}"

rule table:
    input: "pipelines/curvilinear_table.py", SETTINGS, found=expand(f"{OUT}/drawn/{{grid}}.json", grid=GRIDS)
    output: ENDS
    shell: "{PYTHON} -B pipelines/curvilinear_table.py {SETTINGS} -o {RESULTS} {input.found}"
