# Rules of Fourier volume rendering (fourier.yaml).

ENDS += [f"{RESULTS}/table.csv", f"{RESULTS}/table.md", f"{RESULTS}/error-time.png", f"{RESULTS}/growth.png",
         f"{RESULTS}/pictures.png", f"{RESULTS}/models.png", f"{RESULTS}/pairs/pairs.json"]
TOOLS = [f"{BIN}/{tool}" for tool in ("vol-fft", "fvr-slice", "vol-convert", "vol-phantom", "vol-raycast")]
CODE = ["pipelines/fourier.py", "pipelines/fourier_truth.py"]

# Errors of every filter, and of the paper's tables.
rule errors:
    input: CODE, TOOLS, SETTINGS, volume=f"{OUT}/volumes/{{dataset}}.nrrd"
    output: f"{OUT}/errors/{{dataset}}.json"
    threads: ALL_CORES
    shell: "{PYTHON} -B pipelines/fourier.py {SETTINGS} errors --dataset {wildcards.dataset} --bin {BIN} -o {output}"

# Whatever is timed: tables, growth, rays, device.
rule times:
    input: CODE, TOOLS, SETTINGS, lambda w: [f"{OUT}/errors/{d}.json" for d in DATASETS]
    output: f"{OUT}/times.json"
    threads: ALL_CORES
    shell: "{PYTHON} -B pipelines/fourier.py {SETTINGS} times --bin {BIN} -o {output}"

rule table:
    input: "pipelines/fourier_table.py", f"{OUT}/times.json", [f"{OUT}/errors/{d}.json" for d in DATASETS]
    output: csv=f"{RESULTS}/table.csv", md=f"{RESULTS}/table.md"
    shell: "{PYTHON} -B pipelines/fourier_table.py {SETTINGS} --csv {output.csv} --markdown {output.md}"

rule plot:
    input: "pipelines/fourier_plot.py", f"{OUT}/times.json", [f"{OUT}/errors/{d}.json" for d in DATASETS]
    output: f"{RESULTS}/error-time.png", f"{RESULTS}/growth.png"
    shell: "{PYTHON} -B pipelines/fourier_plot.py {SETTINGS} -o {RESULTS}"

rule pictures:
    input: "pipelines/fourier_pictures.py", TOOLS, [volume(d) for d in DATASETS]
    output: f"{RESULTS}/pictures.png", f"{RESULTS}/models.png", f"{RESULTS}/pairs/pairs.json"
    threads: ALL_CORES
    shell: "{PYTHON} -B pipelines/fourier_pictures.py {SETTINGS} --bin {BIN} -o {RESULTS}"
