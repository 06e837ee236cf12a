# Rules of a sweep over wavelets and error bounds (he.yaml): series of pictures, their table, plots and contact sheet.

RUNS = {(run.group, run.name): run for run in sweep.runs(SWEEP, DATASETS)}

SERIES = {}
for _run in RUNS.values():
    SERIES.setdefault((_run.group, _run.series), []).append(_run)


def coefficients(run):
    return f"{OUT}/coefficients/{run.dataset}/{run.wavelet}.vdb"


def commands(run, folder):
    """The commands of one run: its index, where it has one, then its picture; each with its stats record."""
    if run.wavelet:
        options = SWEEP["methods"][run.method]["index"].format(step=run.step, scene=scene(run.group))
        yield (f"{BIN}/vol-index {coefficients(run)} -o {folder}/{run.name}.nrrd --epsilon {run.epsilon} --epsilon-scale byte"
               f" {options} --stats {folder}/{run.name}.index.json --quiet")
    yield (f"{BIN}/{sweep.raycast(run, SWEEP, OUT)} -o {folder}/{run.name}.exr --repeat {SWEEP['repeat']}"
           f" --stats {folder}/{run.name}.json --quiet")


ENDS += [f"{RESULTS}/table.csv", f"{RESULTS}/table.md"]
if PICTURES:
    ENDS += [f"{RESULTS}/{name}" for name in ("contact.png", "pairs/pairs.json", "error-samples.png", "error-time.png")]
if not SHORT:
    ENDS.append(f"{RESULTS}/decomposition.md")

# A series is what one method does with one wavelet: a few pictures, one after the other.
rule series:
    input:
        f"{BIN}/vol-raycast", f"{BIN}/vol-index",
        volume=lambda w: volume(w.group.split("/")[0]),
        scene=lambda w: scene(w.group),
        coefficients=lambda w: sorted({coefficients(run) for run in SERIES[w.group, w.series] if run.wavelet})
    output: directory(f"{OUT}/runs/{{group}}/{{series}}")
    params:
        script=lambda w, output: "\n".join(c for run in SERIES[w.group, w.series] for c in commands(run, output[0]))
    threads: ALL_CORES
    shell: "mkdir -p {output}\n{params.script}"

# For each quadrature the uniform picture at the standard distance.
rule uniform_reference:
    input:
        f"{BIN}/vol-raycast",
        volume=lambda w: volume(w.group.split("/")[0]),
        scene=lambda w: scene(w.group)
    output: f"{OUT}/truth/{{group}}/uniform-{{quadrature}}.exr"
    params: sweep=SWEEP
    threads: ALL_CORES
    shell:
        "{BIN}/vol-raycast {input.volume} -o {output} --scene {input.scene} --size {params.sweep[size]}"
        " --quadrature {wildcards.quadrature} --step {params.sweep[standard_distance]} --quiet"

# All pictures of a group against both references: many starts of a small program, so in one job.
rule compare:
    input:
        f"{BIN}/img-compare",
        "pipelines/compare.py",
        truth=f"{OUT}/truth/{{group}}/reference.exr",
        uniform=lambda w: sorted({f"{OUT}/truth/{w.group}/uniform-{run.quadrature}.exr" for run in RUNS.values() if run.group == w.group}),
        series=lambda w: [f"{OUT}/runs/{w.group}/{series}" for group, series in SERIES if group == w.group]
    output: f"{OUT}/errors/{{group}}.json"
    threads: ALL_CORES
    shell:
        "{PYTHON} pipelines/compare.py {BIN}/img-compare --truth {input.truth} --uniform {input.uniform}"
        " --series {input.series} --jobs {threads} -o {output}"

RECORDS = dict(
    errors=expand(f"{OUT}/errors/{{group}}.json", group=GROUPS),
    series=[f"{OUT}/runs/{group}/{series}" for group, series in SERIES],
    settings=SETTINGS)

rule table:
    input: "pipelines/table.py", **RECORDS
    output: csv=f"{RESULTS}/table.csv", md=f"{RESULTS}/table.md"
    shell: "{PYTHON} pipelines/table.py {SETTINGS} --csv {output.csv} --markdown {output.md}"

rule plot:
    input: "pipelines/plot.py", f"{RESULTS}/table.csv"
    output: [f"{RESULTS}/error-{what}.{kind}" for what in ("samples", "time") for kind in ("svg", "png")]
    shell: "{PYTHON} pipelines/plot.py {RESULTS}/table.csv -o {RESULTS}"

# The figure: renderings and difference pictures, rows wavelets, columns error bounds.
rule contact:
    input:
        "pipelines/contact.py", f"{BIN}/img-compare",
        records=RECORDS["errors"], table=f"{RESULTS}/table.csv", settings=SETTINGS
    output: f"{RESULTS}/contact.png", f"{RESULTS}/pairs/pairs.json"
    shell: "{PYTHON} pipelines/contact.py {SETTINGS} --bin {BIN} --table {input.table} -o {output[0]}"

# Where the saving comes from, step by step: its own script, its own runs.
rule decomposition:
    input: "pipelines/decomposition.py", f"{RESULTS}/table.csv", settings=SETTINGS
    output: f"{RESULTS}/decomposition.md"
    threads: ALL_CORES
    shell: "{PYTHON} pipelines/decomposition.py {SETTINGS} --bin {BIN} -o {output}"
