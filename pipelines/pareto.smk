# Rules of a sweep for error against time (pareto.yaml): a first pass over all settings, a second of interleaved rounds.

import pareto

TIMED = [g for g in GROUPS if SWEEP["rounds"] and SWEEP["datasets"][g.split("/")[0]].get("timed", True)]
ENDS += [f"{RESULTS}/table.csv", f"{RESULTS}/table.md"]
if PICTURES:
    ENDS.append(f"{RESULTS}/error-time.png")


def coefficients_of(dataset):
    wavelets = {w for _, m in pareto.families(SWEEP) if "index" in m for w in m["with"]["wavelet"]}
    return [f"{OUT}/coefficients/{dataset}/{w}.vdb" for w in sorted(wavelets)]


rule accuracy:
    input:
        "pipelines/pareto.py", f"{BIN}/vol-raycast", f"{BIN}/vol-index", f"{BIN}/img-compare",
        truth=f"{OUT}/truth/{{group}}/reference.exr",
        coefficients=lambda w: coefficients_of(w.group.split("/")[0])
    output: f"{OUT}/accuracy/{{group}}.json"
    params: asked=lambda w: [sweep.of_group(SWEEP, w.group).get(key) for key in ("methods", "of_methods", "targets")]
    threads: ALL_CORES
    shell: "{PYTHON} -B pipelines/pareto.py {SETTINGS} {wildcards.group} --bin {BIN} --truth {input.truth} -o {output}"

rule times:
    input: truth=f"{OUT}/truth/{{group}}/reference.exr", runs=f"{OUT}/accuracy/{{group}}.json"
    output: f"{OUT}/times/{{group}}.json"
    params: asked=[SWEEP[key] for key in ("rounds", "threads", "screened", "screenings", "contenders")]
    threads: ALL_CORES
    shell:
        "{PYTHON} -B pipelines/pareto.py {SETTINGS} {wildcards.group} --bin {BIN} --truth {input.truth} --runs {input.runs}"
        " -o {output}"

rule table:
    input:
        "pipelines/pareto_table.py", SETTINGS, expand(f"{OUT}/accuracy/{{group}}.json", group=GROUPS),
        expand(f"{OUT}/times/{{group}}.json", group=TIMED)
    output: csv=f"{RESULTS}/table.csv", md=f"{RESULTS}/table.md"
    shell: "{PYTHON} -B pipelines/pareto_table.py {SETTINGS} --csv {output.csv} --markdown {output.md}"

rule plot:
    input: "pipelines/pareto_plot.py", f"{RESULTS}/table.csv"
    output: [f"{RESULTS}/error-time.{kind}" for kind in ("svg", "png")]
    shell: "{PYTHON} -B pipelines/pareto_plot.py {RESULTS}/table.csv -o {RESULTS}"
