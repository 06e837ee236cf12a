# Rules of the observed orders (convergence.yaml).

CODE = ["pipelines/convergence.py", "pipelines/fourier_truth.py"]
TOOLS = [f"{BIN}/{tool}" for tool in ("vol-phantom", "vol-raycast", "vol-dwt", "wavelet-raycast", "vol-fft", "fvr-slice", "isosurf-mc",
                                      "isosurf-ray", "img-compare")]
ENDS += [f"{RESULTS}/{name}" for name in ("table.csv", "table.md", "orders.png", "orders.svg")]

rule errors:
    input: CODE, TOOLS, SETTINGS
    output: f"{OUT}/errors.json"
    threads: ALL_CORES
    shell: "{PYTHON} -B pipelines/convergence.py {SETTINGS} --bin {BIN} -o {output}"

rule table:
    input: "pipelines/convergence_table.py", "pipelines/orders.py", found=f"{OUT}/errors.json"
    output: ENDS
    shell: "{PYTHON} -B pipelines/convergence_table.py {input.found} -o {RESULTS}"
