# Rules of the pictures of curvilinear grids (curvilinear.yaml).

_at_hand = yaml.safe_load(open("configs/data.yaml"))["grids"]
GRIDS = [name for name, grid in SWEEP["grids"].items() if "source" not in grid or sweep.locate(_at_hand[grid["source"]])]
TESTS = Path(BIN).parent / "tests/bench"
ENDS += [f"{RESULTS}/table.csv", f"{RESULTS}/table.md", f"{RESULTS}/pictures.png", f"{RESULTS}/throttle.png"]

PARTS = expand(f"{OUT}/drawn/{{grid}}.json", grid=GRIDS)
if SWEEP["rounds"]:
    PARTS += expand(f"{OUT}/times/{{grid}}.json", grid=[g for g in GRIDS if g not in SWEEP["untimed"]])
if not SHORT:
    PARTS += [f"{OUT}/drift.csv", f"{OUT}/homogeneous.csv", f"{OUT}/memory.json"]
    if sweep.locate(_at_hand[SWEEP["peer"]["grid"]]):
        PARTS += [f"{OUT}/peer.json"]

_tools = ["pipelines/curvilinear.py", *(f"{BIN}/{tool}" for tool in ("vol-phantom", "curv-tricubic", "img-compare"))]

rule grid:
    input: _tools
    output: f"{OUT}/drawn/{{grid}}.json"
    params: asked=lambda w: [SWEEP["grids"][w.grid], *(SWEEP[k] for k in ("sizes", "finest", "tolerance", "settings", "pictures"))]
    threads: ALL_CORES
    shell: "{PYTHON} -B pipelines/curvilinear.py pictures {SETTINGS} '{wildcards.grid}' --bin {BIN} -o {output}"

rule times:
    input: _tools
    output: f"{OUT}/times/{{grid}}.json"
    params: asked=lambda w: [SWEEP["grids"][w.grid], SWEEP["sizes"][0], *(SWEEP[k] for k in ("rounds", "tolerance", "settings"))]
    threads: ALL_CORES
    shell: "{PYTHON} -B pipelines/curvilinear.py times {SETTINGS} '{wildcards.grid}' --bin {BIN} -o {output}"

# Programs beside the tests.
rule drift:
    input: f"{TESTS}/forward_difference_drift"
    output: f"{OUT}/drift.csv"
    threads: ALL_CORES
    shell: "{input} > {output}"

rule homogeneous:
    input: f"{TESTS}/homogeneous_sheets"
    output: f"{OUT}/homogeneous.csv"
    threads: ALL_CORES
    shell: "{input} > {output}"

rule memory:
    input: "pipelines/curvilinear_memory.py", [f"{BIN}/{tool}" for tool in ("vol-phantom", "curv-tricubic")]
    output: f"{OUT}/memory.json"
    threads: ALL_CORES
    shell: "{PYTHON} -B pipelines/curvilinear_memory.py --bin {BIN} -o {output}"

_peer_tools = ["pipelines/curvilinear_peer.py", "pipelines/peers/vtk_grid.py", *(f"{BIN}/{tool}" for tool in ("curv-tricubic", "img-compare"))]

rule peer_truth:
    input: _peer_tools
    output: f"{OUT}/peer/truth.json"
    params: asked=[SWEEP["peer"].get(k) for k in ("grid", "view", "refined")]
    threads: ALL_CORES
    shell: "{PYTHON} -B pipelines/curvilinear_peer.py truth {SETTINGS} --bin {BIN} -o {output}"

rule peer:
    input: f"{OUT}/peer/truth.json", _peer_tools
    output: f"{OUT}/peer.json"
    params: asked=SWEEP["peer"]
    threads: ALL_CORES
    shell: "{PYTHON} -B pipelines/curvilinear_peer.py frames {SETTINGS} --bin {BIN} -o {output}"

rule table:
    input: "pipelines/curvilinear_table.py", SETTINGS, found=PARTS
    output: ENDS
    shell: "{PYTHON} -B pipelines/curvilinear_table.py {SETTINGS} -o {RESULTS} {input.found}"
