# Rules of the growth of a frame's time (growth.yaml).

ENDS += [f"{RESULTS}/table.csv", f"{RESULTS}/table.md"]

rule table:
    input:
        "pipelines/growth.py", SETTINGS, f"{BIN}/vol-raycast", volumes=[volume(d) for d in dict.fromkeys(g.split("/")[0] for g in GROUPS)]
    output: csv=f"{RESULTS}/table.csv", md=f"{RESULTS}/table.md"
    threads: ALL_CORES
    shell: "{PYTHON} -B pipelines/growth.py {SETTINGS} --bin {BIN} --csv {output.csv} --markdown {output.md}"
