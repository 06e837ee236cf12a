# Rules of the test of --max-error over random views (bounds.yaml).

ENDS += [f"{RESULTS}/table.csv", f"{RESULTS}/table.md"]

rule bounds:
    input:
        "pipelines/bounds.py", f"{BIN}/vol-raycast", f"{BIN}/img-compare",
        volume=lambda w: volume(w.group.split("/")[0]), scene=lambda w: scene(w.group)
    output: f"{OUT}/bounds/{{group}}.json"
    params: asked=[SWEEP[k] for k in ("size", "tolerance", "bounds", "views", "seed", "beside")]
    threads: ALL_CORES
    shell: "{PYTHON} -B pipelines/bounds.py {SETTINGS} {wildcards.group} --bin {BIN} -o {output}"

rule table:
    input: "pipelines/bounds_table.py", SETTINGS, expand(f"{OUT}/bounds/{{group}}.json", group=GROUPS)
    output: csv=f"{RESULTS}/table.csv", md=f"{RESULTS}/table.md"
    shell: "{PYTHON} -B pipelines/bounds_table.py {SETTINGS} --csv {output.csv} --markdown {output.md}"
